"""Films of flows, with the same view, color limits and arrow scale in all frames, and contact sheets."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.options import PANEL_WIDTH
from geomhw.render.layers import LIGHT, Arrows, Panel, Streaks, Surface, Theme
from geomhw.render.panels import Drawing
from geomhw.render.scene import Image
from geomhw.render.view import choose_view
from geomhw.results import Cloud, Result

ARROW_COLOR = "#14171c"
#: Spacing of arrows as a fraction of the panel.
SPACING = 0.05
#: Quantile of the speeds in a frame that is drawn as long as the spacing.
TYPICAL_SPEED = 0.95
#: Length of a streak at typical speed, as a fraction of √area; tracers store longer paths.
STREAK = 0.1
#: Number of fastest faces that the view shows if possible.
WATCHED = 20
#: Fraction of the vorticities beyond the ends of the color map.
OUTLIERS = 0.005
#: Vorticity below this multiple of typical speed over edge length is rounding, and drawn as zero.
ROUNDING = 1e-9


def flow_film(
    results: Sequence[Result], clouds: Sequence[Cloud] = (), theme: Theme = LIGHT, width: int = PANEL_WIDTH
) -> Iterator[Image]:
    """Draw the frames of a film: the color with the velocity as arrows, and the vorticity if the results have it.

    Parameters
    ----------
    results : sequence of Result
        One per frame, with the fields ``color``, ``velocity``, ``time`` and perhaps ``vorticity``.
    clouds : sequence of Cloud
        Tracers of each frame; drawn as streaks of equal duration instead of arrows.
    theme, width
        As in `geodesic_picture`.

    Yields
    ------
    (height, width, 3) array, uint8
        All of one size, with the view, color limits and scale of the whole film.

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.

    Examples
    --------
    >>> import numpy as np
    >>> from geomhw.mesh import icosphere
    >>> from geomhw.results import Field, Result
    >>> mesh = icosphere(2)
    >>> velocity = np.cross([0.0, 0.0, 1.0], mesh.face_centers)
    >>> arrays = [Field("color", "vertex", mesh.vertices[:, 0]), Field("velocity", "face", velocity)]
    >>> results = [Result(mesh, [*arrays, Field("time", "mesh", np.array([t]))], {}) for t in (0.0, 0.1)]
    >>> len(list(flow_film(results, width=120)))
    2
    """
    mesh = results[0].mesh
    colors = _limits([np.asarray(result["color"]) for result in results])
    speeds = np.stack([np.linalg.norm(np.asarray(result["velocity"]), axis=1) for result in results])
    speed = float(np.quantile(speeds, TYPICAL_SPEED, axis=1).max())  # of the fastest frame
    with_vorticity = any(field.name == "vorticity" for field in results[0].fields)
    vorticities = [np.abs(np.asarray(result["vorticity"])) for result in results] if with_vorticity else []
    swirl = max((float(np.quantile(vorticity, 1 - OUTLIERS)) for vorticity in vorticities), default=0.0)
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
    """Arrange pictures of one size in rows; more than two are scaled down by half.

    Parameters
    ----------
    pictures : sequence of (h, w, 3) arrays, uint8
    columns : int, optional
        Number of pictures in a row; by default the sheet is about square.

    Returns
    -------
    (height, width, 3) array, uint8

    Examples
    --------
    >>> contact_sheet([np.zeros((20, 40, 3), dtype=np.uint8)] * 6, columns=3).shape
    (20, 60, 3)
    """
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
    """Return the fastest faces, (k,); rounded speeds keep the order of equal ones independent of rounding errors."""
    shares = np.round(speeds / (speeds.max() or 1.0), 6)
    return np.argsort(-shares, kind="stable")[:WATCHED]


def _arrows(result: Result, speed: float) -> list[Arrows]:
    """Return the velocity as arrows."""
    return [Arrows(np.asarray(result["velocity"]), "face", ARROW_COLOR, scale=speed, spacing=SPACING)]


def _streaks(mesh: TriangleMesh, cloud: Cloud, duration: float) -> list[Streaks]:
    """Return the paths of tracers over the last ``duration``, as far as they are stored."""
    now = float(np.asarray(cloud["time"]).ravel()[0])
    times = np.append(np.asarray(cloud["past_times"]).ravel(), now)
    past = np.asarray(cloud["past"], dtype=float).reshape(len(cloud.points), -1, 3).transpose(1, 0, 2)
    places = np.concatenate([cloud.points + past, cloud.points[None]])
    start = now - duration
    kept = int(np.searchsorted(times, start, side="right"))
    if kept:  # the start lies between two stored positions
        share = (start - times[kept - 1]) / (times[kept] - times[kept - 1])
        between = (1 - share) * places[kept - 1] + share * places[kept]
        places = np.concatenate([between[None], places[kept:]])
    return [Streaks(places, mesh.face_normals[np.asarray(cloud["face"])])]


def _panels(result: Result, colors: tuple[float, float] | None, swirl: float, layers: dict[str, Any]) -> list[Panel]:
    """Return the panels of a frame: the color with layers, and the vorticity."""
    values = np.asarray(result["color"])
    time = float(np.asarray(result["time"]).ravel()[0])
    surface = Surface(values) if values.ndim == 2 else Surface(values, colormap="viridis", limits=colors)
    first = Panel(f"color and {'tracers' if 'streaks' in layers else 'velocity'}, t = {time:.4g}", surface, **layers)
    if not swirl:
        return [first]
    vorticity = Surface(result["vorticity"], colormap="RdBu_r", limits=(-swirl, swirl))
    return [first, Panel("vorticity", vorticity)]


def _limits(colors: Sequence[Floats]) -> tuple[float, float] | None:
    """Return the range of the first frame, which bounds advected values; of all if it is constant; None for RGB."""
    if colors[0].ndim == 2:
        return None
    low, high = float(colors[0].min()), float(colors[0].max())
    if low < high:
        return low, high
    return min(float(c.min()) for c in colors), max(float(c.max()) for c in colors)
