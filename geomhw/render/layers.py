"""What a picture is made of, in words: panels with a colored surface, arrows and markers. Plain data."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats

Color = str  # "#rrggbb"


@dataclass(frozen=True)
class Surface:
    """The mesh, colored.

    values: one number per vertex or face, or three (RGB, 0..1 or uint8); None paints all in ``color``.
        Where a number is not finite, the surface is gray.
    colormap: a name known to matplotlib; ``span`` is the part of it to use.
    limits: the values at the ends of the color map; None takes those of the data, without the ``outliers`` (a
        fraction) at each end. ``symmetric`` puts zero in the middle.
    log: color by the logarithm, at most ``decades`` below the largest value.
    isolines: how many evenly spaced lines of equal value to draw.
    label: what the numbers are, written next to the color bar; ``bar`` turns that off.
    """

    values: ArrayLike | None = None
    location: Literal["vertex", "face"] = "vertex"
    colormap: str = "viridis"
    span: tuple[float, float] = (0.0, 1.0)
    limits: tuple[float, float] | None = None
    outliers: float = 0.0
    symmetric: bool = False
    log: bool = False
    decades: float = 300.0
    isolines: int = 0
    label: str = ""
    bar: bool = True
    color: Color = "#d9dce1"


@dataclass(frozen=True)
class Arrows:
    """Arrows on the surface, thinned to an even spacing.

    vectors: (m, 3) or (n, 3). scale: the magnitude drawn as long as the spacing; None draws directions only, all
        of one length.
    spacing: distance between arrows as a fraction of the panel's shorter side.
    points: where the middle of each arrow is, (m, 3) or (n, 3), by default the face centers or the vertices.
    """

    vectors: Floats
    location: Literal["vertex", "face"] = "face"
    color: Color = "#14171c"
    scale: float | None = None
    spacing: float = 0.034
    points: Floats | None = None


@dataclass(frozen=True)
class Streaks:
    """Particles as comets: a head where each is, and a tail that thins and fades along the way it came.

    paths: (p, k, 3), of k particles, the latest place last. normals: (k, 3), unit, of the surface at the heads.
    width: of a head, a fraction of the panel's shorter side; less where the surface is seen from its edge.
    casing: the color of the line round them, which sets them off from whatever is below.
    """

    paths: Floats
    normals: Floats
    color: Color = "#ffffff"
    casing: Color = "#14171c"
    width: float = 0.0075


@dataclass(frozen=True)
class Curves:
    """Segments on the surface, (s, 2, 3), drawn ``width`` pixels wide; what is behind the surface is not seen."""

    segments: Floats
    color: Color = "#d62728"
    width: float = 3.0


@dataclass(frozen=True)
class Marker:
    """A vertex marked by a disc, a ring where it is behind the surface, and a label that is always on top.

    point: (3,), in a face of that vertex, marked in its place.
    """

    vertex: int
    label: str = ""
    color: Color = "#d62728"
    point: Floats | None = None

    def position(self, vertices: Floats) -> Floats:
        """Where it is, (3,), on a mesh with these vertices."""
        return np.asarray(vertices[self.vertex] if self.point is None else self.point)


@dataclass(frozen=True)
class Panel:
    """One picture of the mesh: a title, a surface and what lies on it; ``note`` is a line under the color bar
    (without one, arrows drawn to scale put their key there)."""

    title: str = ""
    surface: Surface = field(default_factory=Surface)
    arrows: Sequence[Arrows] = ()
    markers: Sequence[Marker] = ()
    note: str = ""
    streaks: Sequence[Streaks] = ()
    curves: Sequence[Curves] = ()


@dataclass(frozen=True)
class Theme:
    """Colors of paper and ink."""

    background: Color = "#ffffff"
    ink: Color = "#1b1f24"
    faint: Color = "#8b929c"
    line: Color = "#14171c"
    unknown: Color = "#b9bdc4"


LIGHT = Theme()
DARK = Theme(background="#14171c", ink="#eceff4", faint="#7d8592", line="#eceff4", unknown="#555b66")
