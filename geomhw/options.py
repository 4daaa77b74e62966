"""Names from which a user may choose, the default first, and default values of the program."""

from typing import Literal

#: What holds at the boundary of an open mesh while heat flows: no flux, temperature zero, or the mean of both
#: [GIH, sec. 3.4].
Boundary = Literal["neumann", "dirichlet", "average"]
#: What holds for an eigenfunction at the boundary of an open mesh: no flux, or the value zero.
EndCondition = Literal["neumann", "dirichlet"]
#: What a spectrum is of: functions by the Laplacian, tangent vectors at vertices by the connection Laplacian, tangent
#: fields on faces by the Hodge Laplacian.
SpectrumName = Literal["functions", "vectors", "fields"]
#: What holds for the fields of `killing` at a boundary: they do not cross it, or nothing.
FieldBoundary = Literal["tangent", "free"]
#: What the fields of `killing` are combined from: a vector at each vertex, or divergence-free eigenfields.
FieldBasis = Literal["vertices", "coexact"]
#: Descriptors of vertices from eigenfunctions: heat kernel, wave kernel.
SignatureName = Literal["hks", "wks"]
#: Distances from eigenfunctions.
SpectralDistanceName = Literal["biharmonic", "diffusion"]
#: What happens where geodesic disks meet: they overlap, a vertex is in the nearest one, or in none.
OverlapName = Literal["allow", "closest", "exclude"]
#: Shells with completion by the Tab key.
ShellName = Literal["bash", "zsh", "fish"]
#: How ``sample`` spreads points over a surface.
SampleMethod = Literal["farthest", "poisson"]
#: How geodesic distances are computed: by the heat method, exactly on the polyhedral surface, or nearly so and faster.
DistanceMethodName = Literal["heat", "exact", "fast-marching"]
#: What computes distances: this process, or PETSc on the ranks that mpirun starts.
EngineName = Literal["embedded", "petsc"]
#: What a table of distances between labels contains, over the pairs of their vertices.
TableStatistic = Literal["mean", "min", "max"]
#: How linear systems are solved: by what is faster for the size and the number of solutions, by iteration, or by
#: factorization.
SolverName = Literal["auto", "multigrid", "direct"]
#: Parallel transport along an edge: the smallest rotation between vertex normals, or Levi-Civita.
Connection = Literal["normals", "intrinsic"]
#: exp(tA): three terms of the series, as in the handout, or the series to rounding.
FlowSeries = Literal["taylor3", "expm"]
#: How a color is advected: by a scheme that keeps its range, or by exp(-tD). ``auto`` is ``taylor3`` on the handout's
#: sphere, and ``bounded`` elsewhere.
Integrator = Literal["auto", "bounded", "taylor3", "expm"]
#: How a flow transports a field: as vectors, as 1-forms, or parallel.
TransportName = Literal["vector", "form", "parallel"]
#: Time stepping of incompressible flow.
SchemeName = Literal["conservative", "rk4", "stable-fluids"]
#: What the stable-fluids scheme averages to vertices and back: the velocity, or its change.
Advection = Literal["full", "increment"]
#: What drives a flow.
ForceName = Literal["jet", "none"]
#: What a field has one row for; ``mesh``: values of the whole, such as a time.
Location = Literal["vertex", "face", "mesh"]
#: How pictures draw vectors: arrows, evenly spaced streamlines, or line integral convolution.
DrawName = Literal["arrows", "streamlines", "lic"]
#: The axis that points up in a picture.
UpAxis = Literal["x", "y", "z"]
#: What the picture of `geodesic` shows.
GeodesicPanel = Literal["heat", "gradient", "divergence", "distance"]
#: Panels in that picture by default.
HEAT_METHOD: tuple[GeodesicPanel, ...] = ("heat", "divergence", "distance")
#: Width of a panel of a picture, in pixels, and frames of a film per second.
PANEL_WIDTH, FRAMES_PER_SECOND = 600, 10
#: Initial color of a flow.
DEFAULT_COLOR = "waves"
#: Time step, number of the last step, and steps from frame to frame, as in the handout.
DEFAULT_DT, DEFAULT_STEPS, DEFAULT_EVERY = 0.0005, 1980, 66
#: Most steps of a run.
MAX_STEPS = 10**9
