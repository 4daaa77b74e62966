"""Films of flows, with the same view, color limits and arrow scale in all frames, and contact sheets."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geomhw.arrays import Floats
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import Arrows, Panel, Streaks, Surface
from geomhw.render.layout import STAGE_HEIGHT
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, open_drawing
from geomhw.render.view import choose_view, landmarks
from geomhw.results import Cloud, Result

ARROW_COLOR = "#14171c"
#: Frames on a contact sheet, at most, and the smallest width of its panels.
MOST_ON_SHEET, SMALLEST_PANEL = 12, 240
#: Times are even up to this share of their range.
EVEN = 1e-6
#: Part of the color map of the color: dark arrows are visible on all of it.
COLOR_SPAN = (0.25, 1.0)
#: Spacing of arrows as a fraction of the panel.
SPACING = 0.05
#: Quantiles of the speeds in a frame: the end of a color bar, and the speed of arrows as long as the spacing, which is
#: lower, since a jet leaves most of a surface far behind.
TYPICAL_SPEED, ARROW_SPEED = 0.95, 0.8
#: Length of a streak at typical speed, as a fraction of √area; tracers store longer paths.
STREAK = 0.1
#: Fraction of the vorticities beyond the ends of the color map.
OUTLIERS = 0.005
#: Vorticity below this multiple of typical speed over edge length is rounding; the speed is drawn instead. A flow that
#: moves by less than this share of an edge in all is at rest.
ROUNDING = 1e-9


def flow_film(results: Sequence[Result], clouds: Sequence[Cloud] = (), look: Look = AUTOMATIC) -> Iterator[Picture]:
    """Draw the frames of a film: the color with the velocity as arrows, and the vorticity if the results have it.

    Parameters
    ----------
    results : sequence of Result
        One per frame, with the field ``time``, and ``pushed`` per face, or ``color``, ``velocity`` and perhaps
        ``vorticity``. Where vorticity is rounding in all frames, the speed is drawn in its place, and nothing where
        the flow is at rest.
    clouds : sequence of Cloud
        Tracers of each frame; drawn as streaks of equal duration instead of arrows.
    look : Look
        View, width and colors; color map, range and isolines are those of the color.

    Yields
    ------
    (height, width, 3) array, uint8
        All of one size, with the view, color bars and arrow scale of the whole film.

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
    >>> len(list(flow_film(results, look=Look(width=120))))
    2
    """
    panels = _frames(results, clouds)
    with open_drawing(results[0].mesh, panels[0], look=look) as drawing:
        for each in panels:
            yield drawing(each)


def contact_sheet(
    results: Sequence[Result], clouds: Sequence[Cloud] = (), look: Look = AUTOMATIC, most: int = MOST_ON_SHEET
) -> Picture:
    """Draw frames at even times side by side, with one color bar for each quantity.

    Parameters
    ----------
    results, clouds, look
        As in `flow_film`; panels have half the width of ``look`` if there are more than two frames.
    most : int
        Number of frames that are drawn, at most.

    Returns
    -------
    (height, width, 3) array, uint8

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.
    """
    frames = _frames(results, clouds)
    chosen = even_times([_time(result) for result in results], most)
    panels = [panel for k in chosen for panel in frames[k]]
    group = len(frames[0])
    look = look if len(chosen) <= 2 else replace(look, width=max(look.width // 2, SMALLEST_PANEL))
    mesh = results[0].mesh
    view = choose_view(mesh, landmarks(mesh), look)
    tall = np.clip(1.08 / view.aspect, *STAGE_HEIGHT) + 0.1
    columns = group * int(np.clip(np.ceil(np.sqrt(len(chosen) * tall / group)), 1, len(chosen)))
    with open_drawing(mesh, panels, columns=columns, view=view, look=look, shared=group) as drawing:
        return drawing(panels)


def even_times(times: Sequence[float], most: int) -> list[int]:
    """Return the indices of at most ``most`` frames at even times, or nearest to them.

    A smaller number of frames, down to half, is taken if their times are even.

    >>> even_times([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 5)
    [0, 2, 4, 6]
    >>> even_times([0.0, 1.0, 1.5, 2.0, 3.0, 4.0], 3)
    [0, 3, 5]
    """
    if len(times) <= most:
        return list(range(len(times)))
    choices = []
    for count in range(most, max(most // 2, 1), -1):
        wanted = np.linspace(times[0], times[-1], count)
        apart = np.abs(np.subtract.outer(wanted, times))
        choices.append(np.unique(apart.argmin(axis=1)).tolist())
        if apart.min(axis=1).max() < EVEN * (times[-1] - times[0]):
            return choices[-1]
    return choices[0]


def _frames(results: Sequence[Result], clouds: Sequence[Cloud]) -> list[list[Panel]]:
    """Return the panels of each frame, with the limits and scales of all."""
    mesh = results[0].mesh
    if any(field.name == "pushed" for field in results[0].fields):
        return _pushed_frames(results)
    speeds = np.stack([np.linalg.norm(np.asarray(result["velocity"]), axis=1) for result in results])
    speed, arrow = (float(np.quantile(speeds, q, axis=1).max()) for q in (TYPICAL_SPEED, ARROW_SPEED))  # of all frames
    total = _time(results[-1]) - _time(results[0])
    if speed * total < ROUNDING * mesh.mean_edge_length and total:
        speed = 0.0  # nothing moves
    duration = STREAK * float(np.sqrt(mesh.face_areas.sum())) / (speed or 1.0)
    layers: list[dict[str, Any]] = [{"arrows": _arrows(result, arrow or speed)} if speed else {} for result in results]
    if clouds:
        note = f"streaks: the last {duration:.3g} of time" if speed else ""
        layers = [{"streaks": _streaks(mesh, cloud, duration), "note": note} for cloud in clouds]
    colors = _fixed([np.asarray(result["color"]) for result in results], Surface(span=COLOR_SPAN, label="color"))
    title = f"color and {'tracers' if clouds else 'velocity'}" if speed else "color, at rest"
    second = _second_surfaces(results, speeds, speed, ROUNDING / total if total else 0.0)
    panels = []
    for k, result in enumerate(results):
        time = f"t = {_time(result):.4g}"
        frame = [Panel(f"{title}, {time}", colors[k], **layers[k])]
        if second:
            of_second, surfaces = second
            frame.append(Panel(f"{of_second}, {time}", surfaces[k]))
        panels.append(frame)
    return panels


def _pushed_frames(results: Sequence[Result]) -> list[list[Panel]]:
    """Return the panels of frames of a face field ``pushed``: arrows over its length."""
    lengths = [np.linalg.norm(np.asarray(result["pushed"]), axis=1) for result in results]
    scale = float(np.quantile(lengths, TYPICAL_SPEED, axis=1).max()) or 1.0
    surface = Surface(location="face", span=COLOR_SPAN, limits=(0.0, scale), label="length of the field")
    return [
        [Panel(f"field, t = {_time(result):.4g}", each, arrows=_arrows(result, scale, "pushed"))]
        for result, each in zip(results, _fixed(lengths, surface), strict=True)
    ]


def _second_surfaces(
    results: Sequence[Result], speeds: Floats, speed: float, least: float
) -> tuple[str, list[Surface]] | None:
    """Return title and surfaces of the second panels: vorticity, or speed where vorticity is rounding.

    least : vorticity that turns nothing in all the time.
    """
    if not any(field.name == "vorticity" for field in results[0].fields):
        return None
    vorticities = [np.asarray(result["vorticity"]) for result in results]
    swirl = max(float(np.quantile(np.abs(vorticity), 1 - OUTLIERS)) for vorticity in vorticities)
    if swirl > max(ROUNDING * speed / results[0].mesh.mean_edge_length, least):
        plain = Surface(colormap="RdBu_r", limits=(-swirl, swirl), label="vorticity [1/time]", main=False)
        return "vorticity", _fixed(vorticities, plain)
    if not speed:
        return None
    plain = Surface(location="face", limits=(0.0, speed), label="speed [mesh units/time]", main=False)
    return "speed", _fixed(list(speeds), plain)


def _fixed(values: Sequence[Floats], surface: Surface) -> list[Surface]:
    """Return a surface for each array of values, with the same limits and the same ends of the color bar."""
    if values[0].ndim == 2:
        return [replace(surface, values=each) for each in values]
    limits = surface.limits or _limits(values)
    beyond = min(float(v.min()) for v in values) < limits[0], max(float(v.max()) for v in values) > limits[1]
    return [replace(surface, values=each, limits=limits, beyond=beyond) for each in values]


def _time(result: Result) -> float:
    """Return the time of a frame."""
    return float(np.asarray(result["time"]).ravel()[0])


def _arrows(result: Result, speed: float, name: str = "velocity") -> list[Arrows]:
    """Return a face field as arrows."""
    return [Arrows(np.asarray(result[name]), "face", ARROW_COLOR, scale=speed, spacing=SPACING)]


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


def _limits(colors: Sequence[Floats]) -> tuple[float, float]:
    """Return the range of the first frame, which bounds advected values; of all if it is constant."""
    low, high = float(colors[0].min()), float(colors[0].max())
    if low < high:
        return low, high
    return min(float(c.min()) for c in colors), max(float(c.max()) for c in colors)
