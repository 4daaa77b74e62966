"""Source points as written on the command line, on a mesh that is distributed over MPI ranks."""

from typing import TYPE_CHECKING

from geomhw.errors import ArgumentError
from geomhw_cli.specs.sources import SourceSpecs, Spec
from geomhw_cli.specs.vertex_lists import VertexList

if TYPE_CHECKING:
    from geomhw.arrays import Ints
    from geomhw.distributed import LocalMesh


def source_vertices(mesh: "LocalMesh", sources: SourceSpecs) -> "Ints":
    """Return the source vertices as numbers of the file. Raises ArgumentError for sources that are no vertices."""
    import numpy as np

    from geomhw.distributed import extreme_vertex

    found = []
    for spec in sources.specs or [Spec({"end": "max", "axis": "y"})]:
        if isinstance(spec, VertexList):
            found.append(np.asarray(spec.vertices, dtype=np.int64))
        elif first := spec.parts.get("first"):
            last = int(spec.parts.get("last") or first)
            if last >= mesh.n_vertices:
                raise ArgumentError(f"source {last} is not a vertex: the mesh has {mesh.n_vertices}")
            found.append(np.arange(int(first), last + 1))
        elif axis := spec.parts.get("axis"):
            sign = 1 if spec.parts["end"] == "max" else -1
            found.append(np.array([extreme_vertex(mesh, "xyz".index(axis), sign)]))
        else:
            raise ArgumentError(
                "--engine petsc has vertices as sources: 12 or 12,40-44, max-y and so on, @FILE of them"
            )
    return np.concatenate(found)
