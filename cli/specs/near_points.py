"""Places in space, ``near:X,Y,Z``: their closest points, found together, and remarks on their distances."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from geomhw.errors import FieldError

if TYPE_CHECKING:
    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.mesh.triangle_mesh import TriangleMesh

#: Most remarks that are printed.
MOST = 8
#: Distance from the surface, in diagonals of the mesh, beyond which a place in space is probably a mistake.
FAR = 0.1


def triple(text: str) -> list[float]:
    """Return the numbers of a text that are separated by commas."""
    return [float(number) for number in text.split(",")]


def near_points(mesh: "TriangleMesh", places: Sequence[str | None]) -> "dict[int, SurfacePoints]":
    """Find the closest points of several places at once, by their number; none if one of them has none."""
    from geomhw.mesh import nearest_points

    given = [(k, triple(place)) for k, place in enumerate(places) if place]
    if len(given) < 2:
        return {}
    try:
        found = nearest_points(mesh, [place for _, place in given])
    except FieldError:  # one by one, the message names its line
        return {}
    return dict(zip((k for k, _ in given), found.split(), strict=True))


def near_remarks(mesh: "TriangleMesh", places: Sequence[str | None], parts: "Sequence[SurfacePoints]") -> list[str]:
    """The distances of places in space from the surface, in order; those beyond `FAR` are warnings."""
    from math import dist

    from geomhw.mesh.nearest import bounding_box

    given = [(place, part) for place, part in zip(places, parts, strict=True) if place]
    if not given:
        return []
    diagonal = dist(*(corner.tolist() for corner in bounding_box(mesh)))
    return [
        near_remark(place, dist(triple(place), part.positions(mesh)[0].tolist()), diagonal) for place, part in given
    ]


def near_remark(place: str, distance: float, diagonal: float) -> str:
    """The distance of a place in space from a surface of some diagonal; beyond `FAR` a warning."""
    kind = "warning" if distance > FAR * diagonal else "note"
    share = f", {distance / diagonal:.2%} of the diagonal of the mesh" if diagonal else ""
    return f"{kind}: near:{place} is {distance:.4g} from the surface{share}"


def shortened_remarks(lines: Sequence[str]) -> list[str]:
    """The first remarks if there are many, warnings before notes, and the number of the others."""
    ranked = sorted(lines, key=lambda line: not line.startswith("warning"))
    rest = len(ranked) - MOST
    return [*ranked[:MOST], *([f"note: {rest} more remarks on near: are left out"] if rest > 0 else [])]
