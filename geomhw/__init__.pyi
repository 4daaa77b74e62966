from . import (
    compare as compare,
)
from . import (
    directions as directions,
)
from . import (
    errors as errors,
)
from . import (
    flow as flow,
)
from . import (
    fluid as fluid,
)
from . import (
    geodesic as geodesic,
)
from . import (
    intrinsic as intrinsic,
)
from . import (
    io as io,
)
from . import (
    mesh as mesh,
)
from . import (
    operators as operators,
)
from . import (
    options as options,
)
from . import (
    render as render,
)
from . import (
    results as results,
)
from . import (
    scalars as scalars,
)
from . import (
    solvers as solvers,
)
from . import (
    spectral as spectral,
)
from . import (
    transport as transport,
)
from .errors import (
    ArgumentError as ArgumentError,
)
from .errors import (
    ConvergenceError as ConvergenceError,
)
from .errors import (
    FieldError as FieldError,
)
from .errors import (
    FormatError as FormatError,
)
from .errors import (
    GeomhwError as GeomhwError,
)
from .errors import (
    MeshError as MeshError,
)
from .errors import (
    RenderError as RenderError,
)
from .flow import FlowMap as FlowMap
from .flow import HelmholtzDecomposition as HelmholtzDecomposition
from .flow import StreamlineTracer as StreamlineTracer
from .fluid import Diagnostics as Diagnostics
from .fluid import scheme_of as scheme_of
from .geodesic import HeatDistance as HeatDistance
from .geodesic import heat_distance as heat_distance
from .intrinsic import RobustTriangulation as RobustTriangulation
from .io import read as read
from .io import read_mesh as read_mesh
from .io import write as write
from .io import write_png as write_png
from .mesh import SurfacePoints as SurfacePoints
from .mesh import TriangleMesh as TriangleMesh
from .results import Cloud as Cloud
from .results import Field as Field
from .results import Result as Result
from .transport import VectorHeat as VectorHeat

__version__: str
