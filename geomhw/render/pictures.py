"""The pictures of the commands, each from a Result alone."""

import numpy as np

from geomhw.mesh.arrays import Floats
from geomhw.render.layers import LIGHT, Arrows, Marker, Panel, Surface, Theme
from geomhw.render.panels import draw
from geomhw.render.scene import Image
from geomhw.results import Result

SOURCE_COLOR = "#c2185b"
FARTHEST_COLOR = "#0b57d0"
#: More sources than this are marked without a label each.
MOST_LABELS = 4
ISOLINES = 20


def geodesic_picture(result: Result, size: tuple[int, int] | None = None, theme: Theme = LIGHT) -> Image:
    """Three steps of the heat method: heat and the directions it flows away in, their divergence, the distance."""
    distance = np.asarray(result["distance"])
    marks = _source_and_farthest(result)
    panels = [
        Panel(
            "heat u, and directions −∇u / |∇u|",
            Surface(result["heat"], colormap="inferno", span=(0.48, 1.0), log=True),
            arrows=[Arrows(result["direction"])],
            markers=[Marker(marker.vertex, color=marker.color) for marker in marks[:-1]],
        ),
        Panel(
            "divergence of the directions",
            Surface(result["divergence"], colormap="RdBu_r", symmetric=True, outliers=0.02),
        ),
        Panel(
            "geodesic distance",
            Surface(distance, colormap="viridis", limits=_from_zero(distance), isolines=ISOLINES),
            markers=marks,
        ),
    ]
    return draw(result.mesh, panels, size, theme=theme)


def helmholtz_picture(result: Result, size: tuple[int, int] | None = None, theme: Theme = LIGHT) -> Image:
    """A field and its three parts, all arrows to one scale: curl-free over its potential, coexact, harmonic."""
    fields = {name: np.asarray(result[name]) for name in ("field", "curl_free", "coexact", "harmonic")}
    lengths = np.linalg.norm(fields["field"], axis=1)
    scale = float(np.quantile(lengths[lengths > 0], 0.9)) if (lengths > 0).any() else 1.0
    plain = Surface(color="#e6e8ec")
    potential = Surface(result["potential"], colormap="PiYG", symmetric=True)
    stream = Surface(result["stream_function"], colormap="PuOr", symmetric=True)
    parts = [
        ("vector field", "field", plain),
        ("curl-free part, over its potential", "curl_free", potential),
        ("coexact part, over its stream function", "coexact", stream),
        ("harmonic part", "harmonic", plain),
    ]
    panels = [
        Panel(title, surface, arrows=[Arrows(fields[name], scale=scale, spacing=0.04)])
        for title, name, surface in parts
    ]
    return draw(result.mesh, panels, size, columns=2, theme=theme)


def _source_and_farthest(result: Result) -> list[Marker]:
    """Markers of the sources and, last, of the vertex farthest away."""
    sources = [int(source) for source in result.report["sources"]]
    few = len(sources) <= MOST_LABELS
    marks = [Marker(source, f"source {source}" if few else "", SOURCE_COLOR) for source in sources]
    farthest = result.report["farthest"]
    return [
        *marks,
        Marker(farthest["vertex"], f"farthest {farthest['vertex']}: {farthest['distance']:.4g}", FARTHEST_COLOR),
    ]


def _from_zero(distance: Floats) -> tuple[float, float] | None:
    largest = float(distance[np.isfinite(distance)].max(initial=0.0))
    return (0.0, largest) if largest > 0 else None
