"""Transport of one vector against potpourri3d's and, on spheres, against the truth: angles and times.

``make bench`` runs it. The folder that GEOMHW_REFERENCE names adds its meshes to those of data/. Prints Markdown.
"""

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import potpourri3d as pp3d

from geomhw.arrays import Complexes, Floats
from geomhw.io import read_mesh
from geomhw.mesh.named_points import default_source
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.mesh.vertex_angles import edge_directions
from geomhw.operators.parallel_transport import to_complex
from geomhw.results import Result
from geomhw.transport.vector_heat import VectorHeat, tangent_at

DATA = Path(__file__).parents[2] / "data"
OURS = ["creature.obj", "torus.off"]
REFERENCE = ["spot.obj", "kitten.obj", "armadillo.obj"]
#: Vertices of five neighbors (0) and of six.
SPHERE_SOURCES = (0, 12, 42, 100, 300, 641)
REPEATS = 3
#: Where no more than this share of the vectors that arrive is left when they are added up, paths disagree.
COHERENT = 0.5

Transport = Callable[[TriangleMesh, int, Floats], Floats]


def main() -> None:
    """Both tables."""
    meshes = [DATA / name for name in OURS]
    if folder := os.environ.get("GEOMHW_REFERENCE"):
        meshes += [Path(folder) / "meshes" / "closed" / name for name in REFERENCE]
    compare_on_meshes(meshes)
    print()
    compare_on_spheres()


def compare_on_meshes(paths: list[Path]) -> None:
    """Angles between the methods at all vertices, and times."""
    angles = ["normals", "coherent", "crossing", "intrinsic", "same angles"]
    table(["mesh", "vertices", "faces", "source", *angles, "s: normals", "s: intrinsic", "s: potpourri3d"])
    for path in paths:
        mesh = read_mesh(path)
        source = default_source(mesh)
        vector = tangent_at(mesh, source, 0)
        theirs, peer_time = timed(by_potpourri, mesh, source, vector)
        normals, normals_time = timed(by_normals, mesh, source, vector)
        intrinsic, intrinsic_time = timed(by_intrinsic, mesh, source, vector)
        apart = angle(normals, theirs)
        calm = coherence(mesh, source, vector) > COHERENT
        row(
            path.name,
            mesh.n_vertices,
            mesh.n_faces,
            source,
            spread(apart),
            spread(apart[calm]),
            spread(apart[~calm]),
            spread(angle(intrinsic, theirs)),
            f"{np.median(in_same_angles(mesh, source)):.0e}",
            *(f"{seconds:.2g}" for seconds in (normals_time, intrinsic_time, peer_time)),
        )


def compare_on_spheres() -> None:
    """Mean angle to transport along great circles, the 10° round the antipode left out."""
    table(["vertices", "faces", "normals", "intrinsic", "potpourri3d"])
    for level in (3, 4, 5):
        mesh = icosphere(level)
        errors = [
            [sphere_error(mesh, source, method) for source in SPHERE_SOURCES]
            for method in (by_normals, by_intrinsic, by_potpourri)
        ]
        row(mesh.n_vertices, mesh.n_faces, *(f"{np.mean(error):.3f}" for error in errors))


# -- the methods -------------------------------------------------------------------------------------------------


def by_normals(mesh: TriangleMesh, source: int, vector: Floats) -> Floats:
    """With the smallest rotations between vertex normals, (n, 3)."""
    return transported(VectorHeat(mesh, "h2", "normals").from_vertices([source], [vector]))


def by_intrinsic(mesh: TriangleMesh, source: int, vector: Floats) -> Floats:
    """With Levi-Civita on stretched angles, (n, 3)."""
    return transported(VectorHeat(mesh, "h2", "intrinsic").from_vertices([source], [vector]))


def by_potpourri(mesh: TriangleMesh, source: int, vector: Floats) -> Floats:
    """As potpourri3d does by default: Levi-Civita on an intrinsic Delaunay triangulation, t = h² on that, (n, 3)."""
    solver = pp3d.MeshVectorHeatSolver(mesh.vertices, mesh.faces)
    x, y, _ = solver.get_tangent_frames()
    parts = solver.transport_tangent_vector(source, [vector @ x[source], vector @ y[source]])
    return np.asarray(parts[:, :1] * x + parts[:, 1:] * y)


def transported(result: Result) -> Floats:
    """The transported vectors."""
    return np.asarray(result["transported"])


# -- what is measured --------------------------------------------------------------------------------------------


def angle(one: Floats, other: Floats) -> Floats:
    """Degrees between vectors, (n,)."""
    across = np.linalg.norm(np.cross(one, other), axis=1)
    return np.asarray(np.degrees(np.arctan2(across, np.einsum("vx,vx->v", one, other))))


def coherence(mesh: TriangleMesh, source: int, vector: Floats) -> Floats:
    """How much of the heat's vectors is left where all paths have blended, 1 to 0, (n,): |Y| over the scalar heat."""
    from geomhw.geodesic.heat_step import HeatStep

    impulse = np.zeros(mesh.n_vertices)
    impulse[source] = np.linalg.norm(vector)
    heat = HeatStep(mesh, "h2").from_impulse(impulse).plain
    diffused = VectorHeat(mesh, "h2").from_vertices([source], [vector])["diffused"]
    return np.asarray(np.linalg.norm(diffused, axis=1) / heat)


def in_same_angles(mesh: TriangleMesh, source: int) -> Floats:
    """Degrees between the intrinsic transport and potpourri3d's without edge flips, angles counted alike, (n,).

    Its frames start at an edge; taking theirs to that edge's direction compares angles within the surface, whatever
    plane each method lays them in.
    """
    i, j = mesh.edges.T
    start, end = np.concatenate([i, j]), np.concatenate([j, i])
    direction = np.concatenate(edge_directions(mesh))
    solver = pp3d.MeshVectorHeatSolver(mesh.vertices, mesh.faces, use_intrinsic_delaunay=False)
    x, _, normal = solver.get_tangent_frames()
    edge = mesh.vertices[end] - mesh.vertices[start]
    edge -= np.einsum("ex,ex->e", edge, normal[start])[:, None] * normal[start]
    along = np.einsum("ex,ex->e", edge, x[start]) / np.linalg.norm(edge, axis=1)
    order = np.lexsort([along, start])
    last = order[np.flatnonzero(np.diff(start[order], append=-1))]
    zero: Complexes = np.exp(1j * direction[last])  # of the edge nearest to x, at each vertex
    turned = zero[source].conj()
    parts = solver.transport_tangent_vector(source, [turned.real, turned.imag])
    theirs = (parts[:, 0] + 1j * parts[:, 1]) * zero
    ours = to_complex(mesh, by_intrinsic(mesh, source, tangent_at(mesh, source, 0)))
    return np.asarray(np.abs(np.degrees(np.angle(theirs / ours))))


def sphere_error(mesh: TriangleMesh, source: int, method: Transport) -> float:
    """Mean degrees to the exact answer on the unit sphere, (the rotation that takes the source to each vertex)."""
    vector = tangent_at(mesh, source, 57)
    a, x = mesh.vertices[source], mesh.vertices
    axis, cosine = np.cross(a, x), x @ a
    exact = vector * cosine[:, None] + np.cross(axis, vector)
    exact += axis * (axis @ vector)[:, None] / np.maximum(1 + cosine, 1e-12)[:, None]
    exact -= np.einsum("vx,vx->v", exact, mesh.vertex_normals)[:, None] * mesh.vertex_normals
    kept = cosine > -np.cos(np.radians(10))
    return float(angle(method(mesh, source, vector), exact)[kept].mean())


def timed(method: Transport, mesh: TriangleMesh, source: int, vector: Floats) -> tuple[Floats, float]:
    """The answer, and the median of the seconds for set-up and one transport, on a mesh that knows nothing yet."""
    seconds = []
    for _ in range(REPEATS):
        fresh = TriangleMesh(mesh.vertices, mesh.faces)
        start = time.perf_counter()
        answer = method(fresh, source, vector)
        seconds.append(time.perf_counter() - start)
    return answer, float(np.median(seconds))


# -- the table ---------------------------------------------------------------------------------------------------


def spread(angles: Floats) -> str:
    """Mean and 95th percentile."""
    return f"{angles.mean():.2f} / {np.quantile(angles, 0.95):.2f}" if len(angles) else "-"


def table(heads: list[str]) -> None:
    """The head of a Markdown table."""
    row(*heads)
    row(*["---"] * len(heads))


def row(*cells: Any) -> None:
    """A line of it."""
    print("|", " | ".join(map(str, cells)), "|", flush=True)


if __name__ == "__main__":
    main()
