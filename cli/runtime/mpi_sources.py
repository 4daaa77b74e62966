"""Source points as written on the command line, on a mesh that is distributed over MPI ranks."""

from typing import TYPE_CHECKING

from geomhw.errors import ArgumentError
from geomhw_cli.specs.near_points import near_remark, shortened_remarks, triple
from geomhw_cli.specs.sources import SourceSpecs, Spec
from geomhw_cli.specs.vertex_lists import VertexList

if TYPE_CHECKING:
    from geomhw.distributed import LocalMesh
    from geomhw.mesh.surface_points import SurfacePoints


def source_points(mesh: "LocalMesh", sources: SourceSpecs, remarks: list[str]) -> "SurfacePoints":
    """Return the sources as points with the numbers of the file; as `SourceSpecs.resolve` on one mesh.

    remarks: takes a line for each ``near:``. Raises ArgumentError for sources that do not exist over ranks.
    """
    from geomhw.distributed import near_sources
    from geomhw.mesh.surface_points import concatenate

    specs = sources.specs or [Spec({"end": "max", "axis": "y"})]
    texts = [text for spec in specs if (text := spec.parts.get("near"))]
    near = []
    if texts:
        points, distances, diagonal = near_sources(mesh, [triple(text) for text in texts])
        near = points.split()
        found = zip(texts, distances.tolist(), strict=True)
        remarks += shortened_remarks([near_remark(text, distance, diagonal) for text, distance in found])
    return concatenate([near.pop(0) if spec.parts.get("near") else _points(mesh, spec) for spec in specs])


def _points(mesh: "LocalMesh", spec: object) -> "SurfacePoints":
    """The points of one spec, other than ``near:``."""
    import numpy as np

    from geomhw.distributed import extreme_vertex, face_sources, vertex_sources

    if isinstance(spec, VertexList):
        return vertex_sources(mesh, np.asarray(spec.vertices, dtype=np.int64))
    if isinstance(spec, Spec) and (first := spec.parts.get("first")):
        last = int(spec.parts.get("last") or first)
        if last >= mesh.n_vertices:
            raise ArgumentError(f"source {last} is not a vertex: the mesh has {mesh.n_vertices}")
        return vertex_sources(mesh, np.arange(int(first), last + 1))
    if isinstance(spec, Spec) and (face := spec.parts.get("face")):
        weights = spec.parts.get("weights")
        return face_sources(mesh, np.array([int(face)]), [triple(weights) if weights else [1 / 3] * 3])
    if isinstance(spec, Spec) and (axis := spec.parts.get("axis")):
        sign = 1 if spec.parts["end"] == "max" else -1
        return vertex_sources(mesh, np.array([extreme_vertex(mesh, "xyz".index(axis), sign)]))
    raise ArgumentError(
        "--engine petsc has these sources: vertices such as 12 or 12,40-44, face:17, near:X,Y,Z, max-y and so on, "
        "@FILE of them"
    )
