"""Films of flows: one view, one window, and limits that hold from the first frame to the last."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import LIGHT, Arrows, Panel, Streaks, Surface, Theme
from geomhw.render.panels import PANEL_WIDTH, Drawing
from geomhw.render.scene import Image
from geomhw.render.view import choose_view
from geomhw.results import Cloud, Result

ARROW_COLOR = "#14171c"
#: Spacing of arrows as a fraction of the panel.
SPACING = 0.05
#: The share of the speeds, in each frame, that are drawn no longer than the spacing.
TYPICAL_SPEED = 0.95
#: How far a typical speed takes a streak, as a share of √area; tracers remember more than that.
STREAK = 0.1
#: So many of the fastest faces are, if possible, in view.
WATCHED = 20
#: Share of the largest vorticities that may lie beyond the ends of the color map.
OUTLIERS = 0.005
#: Vorticity below this share of a typical speed over an edge is rounding, and drawn as none.
ROUNDING = 1e-9


def flow_film(
    results: Sequence[Result], clouds: Sequence[Cloud] = (), theme: Theme = LIGHT, width: int = PANEL_WIDTH
) -> Iterator[Image]:
    """A picture a frame: the color with the velocity as arrows and, where there is one, the vorticity.

    clouds: the tracers of each frame, which are drawn instead of arrows: as streaks of the last of the time, as much of
    it in all frames. All pictures have one size and view, and the limits and scale of the whole film.
    """
    mesh = results[0].mesh
    colors = _limits([np.asarray(result["color"]) for result in results])
    speeds = np.stack([np.linalg.norm(np.asarray(result["velocity"]), axis=1) for result in results])
    speed = float(np.quantile(speeds, TYPICAL_SPEED, axis=1).max())  # of the fastest frame: a flow may fade, or grow
    with_vorticity = any(field.name == "vorticity" for field in results[0].fields)
    swirl = max((_swirl(result) for result in results), default=0.0) if with_vorticity else 0.0
    swirl = max(swirl, ROUNDING * speed / mesh.mean_edge_length) if swirl else 0.0
    view = choose_view(mesh, mesh.faces[_fastest(speeds.mean(axis=0)), 0].tolist())
    duration = STREAK * float(np.sqrt(mesh.face_areas.sum())) / (speed or 1.0)
    layers: list[dict[str, Any]] = [{"arrows": _arrows(result, speed or 1.0)} for result in results]
    if clouds:
        note = f"streaks: the last {duration:.3g} of time" if speed else ""
        layers = [{"streaks": _streaks(mesh, cloud, duration), "note": note} for cloud in clouds]
    panels = [_panels(result, colors, swirl, layer) for result, layer in zip(results, layers, strict=True)]
    with Drawing(mesh, panels[0], view=view, theme=theme, width=width) as drawing:
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


def _fastest(speeds: Floats) -> Ints:
    """The faces to be watched, (k,); of those equally fast, the first: a view must not turn with their rounding."""
    shares = np.round(speeds / (speeds.max() or 1.0), 6)
    return np.argsort(-shares, kind="stable")[:WATCHED]


def _arrows(result: Result, speed: float) -> list[Arrows]:
    return [Arrows(np.asarray(result["velocity"]), "face", ARROW_COLOR, scale=speed, spacing=SPACING)]


def _streaks(mesh: TriangleMesh, cloud: Cloud, duration: float) -> list[Streaks]:
    """Where the tracers were from so long ago on, as far back as they remember."""
    now = float(np.asarray(cloud["time"]).ravel()[0])
    times = np.append(np.asarray(cloud["past_times"]).ravel(), now)
    past = np.asarray(cloud["past"], dtype=float).reshape(len(cloud.points), -1, 3).transpose(1, 0, 2)
    places = np.concatenate([cloud.points + past, cloud.points[None]])
    start = now - duration
    kept = int(np.searchsorted(times, start, side="right"))
    if kept:  # the place at the very start lies between two
        share = (start - times[kept - 1]) / (times[kept] - times[kept - 1])
        between = (1 - share) * places[kept - 1] + share * places[kept]
        places = np.concatenate([between[None], places[kept:]])
    return [Streaks(places, mesh.face_normals[np.asarray(cloud["face"])])]


def _panels(result: Result, colors: tuple[float, float] | None, swirl: float, layers: dict[str, Any]) -> list[Panel]:
    values = np.asarray(result["color"])
    time = float(np.asarray(result["time"]).ravel()[0])
    surface = Surface(values) if values.ndim == 2 else Surface(values, colormap="viridis", limits=colors)
    first = Panel(f"color and {'tracers' if 'streaks' in layers else 'velocity'}, t = {time:.4g}", surface, **layers)
    if not swirl:
        return [first]
    vorticity = Surface(result["vorticity"], colormap="RdBu_r", limits=(-swirl, swirl))
    return [first, Panel("vorticity", vorticity)]


def _swirl(result: Result) -> float:
    return float(np.quantile(np.abs(np.asarray(result["vorticity"])), 1 - OUTLIERS))


def _limits(colors: Sequence[Floats]) -> tuple[float, float] | None:
    """Least and largest at the start, for what is carried along has no other values; None for RGB.

    Of a constant, those of all frames.
    """
    if colors[0].ndim == 2:
        return None
    low, high = float(colors[0].min()), float(colors[0].max())
    if low < high:
        return low, high
    return min(float(c.min()) for c in colors), max(float(c.max()) for c in colors)
