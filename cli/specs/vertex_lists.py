"""Long lists of vertices in a file of source points, in few bytes each."""

import re
from bisect import bisect_left
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from geomhw.errors import FieldError

if TYPE_CHECKING:
    from geomhw.arrays import Ints
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh

#: What a line of digits, commas and blanks has if it is no list of vertices.
_NO_LIST = re.compile(r"^,|,\s*,|\d{19}")


@dataclass(frozen=True)
class VertexList:
    """Consecutive sources of a file that are single vertices, (k,), and the line of each."""

    vertices: "Ints"
    lines: "Ints"
    path: Path
    #: Parts by name, as other source specs have; a list has none.
    parts: ClassVar[Mapping[str, str | None]] = {}

    def resolve(self, mesh: "TriangleMesh") -> "SurfacePoints":
        """Find the points on a mesh. Raises FieldError for the first that does not exist."""
        from geomhw.mesh.named_points import region_points, vertex_points

        def error_of_first(count: int) -> FieldError | None:
            try:
                vertex_points(mesh, self.vertices[:count])
            except FieldError as error:
                return error
            return None

        k = len(self.vertices)
        if error_of_first(k) is None:
            return region_points(mesh, self.vertices)
        first = bisect_left(range(1, k + 1), True, key=lambda count: error_of_first(count) is not None)
        raise FieldError(f"{line_origin(self.path, int(self.lines[first]))}{error_of_first(first + 1)}")


def line_origin(path: Path, number: int) -> str:
    """Return the beginning of a message on a line of a file."""
    return f"{path}, line {number}: "


def is_vertex_list(line: str) -> bool:
    """Whether a line holds nothing but single vertices."""
    return not line.strip("0123456789, \t") and not _NO_LIST.search(line)


def vertices_on(line: str) -> Iterator[int]:
    """Iterate over the vertices on a line."""
    return (int(match[0]) for match in re.finditer(r"\d+", line))
