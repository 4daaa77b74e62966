"""One geodesic distance by every solver of the field, as a child process of `distances.py` runs them.

``python solvers.py NAME MESH.npz OUT.npz`` computes what NAME says on the arrays vertices and faces, and writes the
distance from the vertex source, the seconds from arrays to distances, those of a second question, and peak memory. The
same question comes before, so that code is loaded when the clock starts.
"""

import re
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: From vertices and faces to a function from a source to distances.
Prepare = Callable[[Floats, NDArray[Any]], Callable[[int], Floats]]


def geomhw(solver: str = "auto", refine: bool = False, heat_for: str = "auto") -> Prepare:
    """This project, as ``geomhw geodesic --solver``; heat_for: its ``--time``."""
    from geomhw.geodesic.heat_method import HeatDistance
    from geomhw.mesh.triangle_mesh import TriangleMesh

    def prepare(V: Floats, F: NDArray[Any]) -> Callable[[int], Floats]:
        method: Any = HeatDistance(TriangleMesh(V, F), heat_for, solver=solver, refine=refine)  # type: ignore[arg-type]
        return lambda source: np.asarray(method.from_vertices([source])["distance"])

    return prepare


def potpourri3d(robust: bool) -> Prepare:
    """The heat method of geometry-central, on the mesh as it is or on its intrinsic Delaunay triangulation."""
    import potpourri3d as pp3d

    def prepare(V: Floats, F: NDArray[Any]) -> Callable[[int], Floats]:
        method: Any = pp3d.MeshHeatMethodDistanceSolver(V, F, use_robust=robust)
        return lambda source: np.asarray(method.compute_distance(source))

    return prepare


def fast_marching() -> Prepare:
    """That of potpourri3d."""
    import potpourri3d as pp3d

    def prepare(V: Floats, F: NDArray[Any]) -> Callable[[int], Floats]:
        method: Any = pp3d.MeshFastMarchingDistanceSolver(V, F)
        return lambda source: np.asarray(method.compute_distance([[(source, [])]]))

    return prepare


def libigl() -> Prepare:
    """Its heat method."""
    import igl

    def prepare(V: Floats, F: NDArray[Any]) -> Callable[[int], Floats]:
        data = igl.HeatGeodesicsData()
        igl.heat_geodesics_precompute(V, F.astype(np.int64), data)
        return lambda source: np.asarray(igl.heat_geodesics_solve(data, np.array([source])))

    return prepare


def pymeshlab() -> Prepare:
    """Its heat method, which prepares anew for each question."""
    import pymeshlab as ml

    def prepare(V: Floats, F: NDArray[Any]) -> Callable[[int], Floats]:
        meshes = ml.MeshSet()
        meshes.add_mesh(ml.Mesh(V, F))

        def ask(source: int) -> Floats:
            meshes.compute_selection_by_condition_per_vertex(condselect=f"vi == {source}")
            meshes.compute_scalar_by_heat_geodesic_distance_from_selection_per_vertex()
            return np.asarray(meshes.current_mesh().vertex_scalar_array())

        return ask

    return prepare


def transport(peer: bool) -> Prepare:
    """One vector transported, by this project or by potpourri3d: the lengths of the vectors that arrive."""
    if peer:
        import potpourri3d as pp3d

        def prepare(V: Floats, F: NDArray[Any]) -> Callable[[int], Floats]:
            method: Any = pp3d.MeshVectorHeatSolver(V, F)
            return lambda source: np.linalg.norm(method.transport_tangent_vector(source, [1.0, 0.0]), axis=1)

        return prepare
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.transport.vector_heat import VectorHeat

    def prepare_ours(V: Floats, F: NDArray[Any]) -> Callable[[int], Floats]:
        mesh = TriangleMesh(V, F)
        method = VectorHeat(mesh)

        def ask(source: int) -> Floats:
            arrived = method.from_vertices([source], mesh.tangent_frames[[source], 0])
            return np.linalg.norm(arrived["transported"], axis=1)

        return ask

    return prepare_ours


SOLVERS: dict[str, Callable[[], Prepare]] = {
    "geomhw": geomhw,
    "geomhw --time 2*h2": lambda: geomhw(heat_for="2*h2"),
    "geomhw --refine": lambda: geomhw(refine=True),
    "geomhw --solver direct": lambda: geomhw("direct"),
    "potpourri3d heat": lambda: potpourri3d(False),
    "potpourri3d heat, robust": lambda: potpourri3d(True),
    "libigl heat": libigl,
    "pymeshlab heat": pymeshlab,
    "potpourri3d fast marching": fast_marching,
    "geomhw vecdiffuse": lambda: transport(False),
    "potpourri3d vector heat": lambda: transport(True),
}


def main() -> None:
    """As the module says."""
    name, mesh, out = sys.argv[1:]
    arrays = np.load(mesh)
    V, F, source = arrays["vertices"], arrays["faces"], int(arrays["source"])
    prepare = SOLVERS[name]()
    prepare(V, F)(source)
    start = time.perf_counter()
    ask = prepare(V, F)
    found = ask(source)
    first = time.perf_counter()
    ask(len(V) // 3)
    again = time.perf_counter()
    np.savez(out, distance=found, seconds=first - start, again=again - first, megabytes=peak_megabytes())


def peak_megabytes() -> float:
    """Of this process alone; getrusage on Linux begins with what the parent had when it forked."""
    status = Path("/proc/self/status")
    if status.exists():
        return int(re.search(r"VmHWM:\s+(\d+)", status.read_text())[1]) / 1024  # type: ignore[index]
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main()
