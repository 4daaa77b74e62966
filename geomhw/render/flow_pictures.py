"""Films of flows: one view, one window, and limits that hold from the first frame to the last."""

from collections.abc import Iterator, Sequence

import numpy as np

from geomhw.mesh.arrays import Floats
from geomhw.render.layers import LIGHT, Arrows, Panel, Surface, Theme
from geomhw.render.panels import Drawing
from geomhw.render.scene import Image
from geomhw.render.view import choose_view
from geomhw.results import Result

ARROW_COLOR = "#14171c"
#: Spacing of arrows as a fraction of the panel.
SPACING = 0.05
#: The share of the speeds, over the film, that are drawn no longer than the spacing.
TYPICAL_SPEED = 0.95
#: So many of the fastest faces are, if possible, in view.
WATCHED = 20
#: Share of the largest vorticities that may lie beyond the ends of the color map.
OUTLIERS = 0.005


def flow_film(results: Sequence[Result], theme: Theme = LIGHT) -> Iterator[Image]:
    """A picture a frame: the color with the velocity as arrows and, where there is one, the vorticity.

    All have the size, view, limits and scale of arrows of the first frame and the whole film.
    """
    mesh = results[0].mesh
    colors = _limits([np.asarray(result["color"]) for result in results])
    speeds = np.stack([np.linalg.norm(np.asarray(result["velocity"]), axis=1) for result in results])
    speed = float(np.quantile(speeds, TYPICAL_SPEED))
    with_vorticity = any(field.name == "vorticity" for field in results[0].fields)
    swirl = max((_swirl(result) for result in results), default=0.0) if with_vorticity else 0.0
    panels = [_panels(result, colors, speed or 1.0, swirl) for result in results]
    view = choose_view(mesh, mesh.faces[np.argsort(speeds.mean(axis=0))[-WATCHED:], 0].tolist())
    with Drawing(mesh, panels[0], view=view, theme=theme) as drawing:
        for each in panels:
            yield drawing(each)


def contact_sheet(pictures: Sequence[Image], columns: int | None = None) -> Image:
    """Pictures of one size in rows, from left to right and down; half their size where there are many."""
    count = len(pictures)
    columns = columns or int(np.ceil(np.sqrt(count * pictures[0].shape[0] / pictures[0].shape[1])))
    rows = -(-count // columns)
    blank = np.full_like(pictures[0], 255)
    full = [*pictures, *[blank] * (rows * columns - count)]
    sheet = np.concatenate([np.concatenate(full[r * columns : (r + 1) * columns], axis=1) for r in range(rows)])
    if count <= 2:
        return sheet
    from PIL import Image as Pillow

    height, width = sheet.shape[:2]
    return np.asarray(Pillow.fromarray(sheet).resize((width // 2, height // 2), Pillow.Resampling.BOX))


def _panels(result: Result, colors: tuple[float, float] | None, speed: float, swirl: float) -> list[Panel]:
    values = np.asarray(result["color"])
    arrows = [Arrows(np.asarray(result["velocity"]), "face", ARROW_COLOR, scale=speed, spacing=SPACING)]
    time = float(np.asarray(result["time"]).ravel()[0])
    surface = Surface(values) if values.ndim == 2 else Surface(values, colormap="viridis", limits=colors)
    first = Panel(f"color and velocity, t = {time:.4g}", surface, arrows=arrows)
    if not swirl:
        return [first]
    vorticity = Surface(result["vorticity"], colormap="RdBu_r", limits=(-swirl, swirl))
    return [first, Panel("vorticity", vorticity)]


def _swirl(result: Result) -> float:
    return float(np.quantile(np.abs(np.asarray(result["vorticity"])), 1 - OUTLIERS))


def _limits(colors: Sequence[Floats]) -> tuple[float, float] | None:
    """Least and largest of all frames; None for RGB."""
    if colors[0].ndim == 2:
        return None
    return min(float(c.min()) for c in colors), max(float(c.max()) for c in colors)
