"""Vertex maps and coordinates of another metric, as written on the command line."""

from typing import TYPE_CHECKING

from geomhw_cli.specs.fields import array_files

if TYPE_CHECKING:
    from geomhw.arrays import Ints
    from geomhw.intrinsic import IntrinsicMesh
    from geomhw.mesh.triangle_mesh import TriangleMesh

MAP_HELP = "a text file with the image of each vertex on a line, counted from 0, or FILE:ARRAY"


def vertex_map(spec: str, mesh: "TriangleMesh", images: int | None = None) -> "Ints":
    """Read the image of each vertex, (n,).

    images: number of vertices of the other mesh, by default n. Raises FormatError for a line that is no number, and
    ArgumentError for another number of lines or an image that is not a vertex.
    """
    import numpy as np

    from geomhw.errors import FieldError, FormatError
    from geomhw.io import read_field, read_lines
    from geomhw.spectral.field_symmetry import checked_vertex_map

    path = array_files(spec)[0]
    if str(path) != spec or path.suffix.lower() == ".npy":
        field = read_field(spec, mesh)
        if field.location != "vertex":
            raise FieldError(f"'{spec}' is no vertex map: it needs one number per vertex")
        return checked_vertex_map(np.asarray(field.values), mesh.n_vertices, images)
    found = []
    for number, line in read_lines(path):
        if not line.isdecimal() or len(line) > 18:
            raise FormatError(f"{path}, line {number}: '{line[:60]}' is no vertex; give one number from 0 on each line")
        found.append(int(line))
    return checked_vertex_map(np.array(found), mesh.n_vertices, images)


def metric(spec: str, mesh: "TriangleMesh") -> "IntrinsicMesh":
    """Read coordinates of the vertices in space of any dimension, and return the faces with their edge lengths."""
    from dataclasses import replace

    import numpy as np

    from geomhw.errors import FieldError
    from geomhw.intrinsic import IntrinsicMesh
    from geomhw.io import read_field

    field = read_field(spec, mesh)
    points = np.asarray(field.values, dtype=float)
    if field.location != "vertex" or points.ndim != 2:
        raise FieldError(f"'{spec}' has no coordinates: it needs two or more numbers per vertex")
    i, j = mesh.edges.T
    lengths = np.linalg.norm(points[j] - points[i], axis=1)
    if (bad := np.flatnonzero(lengths == 0)).size:
        raise FieldError(f"'{spec}' has equal coordinates for both ends of edge {i[bad[0]]}-{j[bad[0]]}")
    return replace(IntrinsicMesh.of(mesh), lengths=lengths)
