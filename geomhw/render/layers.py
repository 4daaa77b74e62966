"""Description of a picture as data: panels with a colored surface, arrows, streaks, curves and markers."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from geomhw.arrays import Floats
from geomhw.options import DrawName

if TYPE_CHECKING:
    from geomhw.flow.streamline_polylines import Streamlines

Color = str  # "#rrggbb"
#: Color of a surface without values: light, so that shading shows its relief.
PLAIN = "#cfd4dc"


@dataclass(frozen=True)
class Surface:
    """The colored mesh.

    values: one number per vertex or face, or RGB (0 to 1, or uint8); None: ``color`` everywhere. The surface is gray
        where a value is not finite.
    colormap: a matplotlib name; ``span`` is the part of it to use.
    limits: values at the ends of the color map; None: the range of the data without the fraction ``outliers`` at each
        end. ``symmetric``: zero is in the middle.
    beyond: whether the ends of the bar are pointed, for data below and above the limits; None: as these data need it.
    log: logarithmic colors, down to ``decades`` below the largest value.
    isolines: number of evenly spaced isolines (int), or their spacing (float).
    label: quantity and unit, under the color bar; ``bar``: whether to draw the color bar.
    main: whether the color map, range and isolines of a `Look` apply here.
    """

    values: ArrayLike | None = None
    location: Literal["vertex", "face"] = "vertex"
    colormap: str = "viridis"
    span: tuple[float, float] = (0.0, 1.0)
    limits: tuple[float, float] | None = None
    beyond: tuple[bool, bool] | None = None
    outliers: float = 0.0
    symmetric: bool = False
    log: bool = False
    decades: float = 300.0
    isolines: int | float = 0
    label: str = ""
    bar: bool = True
    color: Color = PLAIN
    main: bool = True


@dataclass(frozen=True)
class Arrows:
    """Arrows on the surface, thinned to an even spacing.

    vectors: (m, 3) or (n, 3). scale: magnitude of an arrow as long as the spacing; None: all arrows of one length.
    spacing: distance between arrows, a fraction of the shorter side of the panel.
    points: places of the arrows, (m, 3) or (n, 3); by default the face centers or the vertices.
    style: what is drawn instead of arrows; arrows at given points stay arrows. lines: the streamlines, if they are
        known already.
    """

    vectors: Floats
    location: Literal["vertex", "face"] = "face"
    color: Color = "#14171c"
    scale: float | None = None
    spacing: float = 0.034
    points: Floats | None = None
    style: DrawName = "arrows"
    lines: "Streamlines | None" = None


def arrow_scale(vectors: Floats) -> float:
    """Return a magnitude that few of the vectors that are not zero exceed, for `Arrows`."""
    lengths = np.linalg.norm(vectors, axis=1)
    return float(np.quantile(lengths[lengths > 0], 0.9)) if (lengths > 0).any() else 1.0


@dataclass(frozen=True)
class Streaks:
    """Particles as comets: a head at the position of each, and a fading tail along its past path.

    paths: (p, k, 3) of k particles, the latest position last. normals: (k, 3), unit, of the surface at the heads.
    width: of a head, a fraction of the shorter side of the panel; smaller where the surface is seen at a grazing angle.
    casing: color of the outline.
    """

    paths: Floats
    normals: Floats
    color: Color = "#ffffff"
    casing: Color = "#14171c"
    width: float = 0.0075


@dataclass(frozen=True)
class Curves:
    """Segments on the surface, (s, 2, 3), ``width`` pixels wide in a panel of 600, hidden behind the surface."""

    segments: Floats
    color: Color = "#d62728"
    width: float = 3.0


@dataclass(frozen=True)
class Marker:
    """A vertex marked by a disc, or by a ring if the surface hides it, with a label on top.

    point: (3,), a point in a face of the vertex, marked instead of the vertex.
    vector: (3,), an arrow from the mark, in front of everything; length 1 is the shorter side of the panel.
    disc: whether to draw the disc; without it, the label is in its place, unless the surface hides it.
    """

    vertex: int
    label: str = ""
    color: Color = "#d62728"
    point: Floats | None = None
    vector: Floats | None = None
    disc: bool = True

    def position(self, vertices: Floats) -> Floats:
        """Return the marked position, (3,), on a mesh with these vertices."""
        return np.asarray(vertices[self.vertex] if self.point is None else self.point)


@dataclass(frozen=True)
class Panel:
    """One picture of the mesh: a title, the surface and the layers on it.

    note: a line below the color bar; by default the key of arrows drawn to scale.
    """

    title: str = ""
    surface: Surface = field(default_factory=Surface)
    arrows: Sequence[Arrows] = ()
    markers: Sequence[Marker] = ()
    note: str = ""
    streaks: Sequence[Streaks] = ()
    curves: Sequence[Curves] = ()


@dataclass(frozen=True)
class Theme:
    """Colors of background, text and lines."""

    background: Color = "#ffffff"
    ink: Color = "#1b1f24"
    faint: Color = "#8b929c"
    line: Color = "#14171c"
    unknown: Color = "#b9bdc4"
    halo: Color = "#ffffff"


LIGHT = Theme()
DARK = Theme(background="#14171c", ink="#eceff4", faint="#7d8592", line="#eceff4", unknown="#555b66", halo="#14171c")
