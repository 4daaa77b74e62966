"""The pictures of the commands, each from a Result alone."""

from dataclasses import replace

import numpy as np

from geomhw.mesh.arrays import Floats
from geomhw.render.layers import LIGHT, Arrows, Marker, Panel, Surface, Theme
from geomhw.render.panels import draw
from geomhw.render.scene import Image
from geomhw.render.source_marks import source_marks
from geomhw.results import Result

SOURCE_COLOR = "#c2185b"
FARTHEST_COLOR = "#0b57d0"
ISOLINES = 20


def geodesic_picture(result: Result, size: tuple[int, int] | None = None, theme: Theme = LIGHT) -> Image:
    """Three steps of the heat method: heat and the directions it flows away in, their divergence, the distance."""
    distance = np.asarray(result["distance"])
    sources, curves = source_marks(result, SOURCE_COLOR, labels=True)
    far = result.report["farthest"]
    farthest = Marker(far["vertex"], f"farthest {far['vertex']}: {far['distance']:.4g}", FARTHEST_COLOR)
    panels = [
        Panel(
            "heat u, and directions −∇u / |∇u|",
            Surface(result["heat"], colormap="inferno", span=(0.48, 1.0), log=True),
            arrows=[Arrows(result["direction"])],
            markers=[replace(marker, label="") for marker in sources],
            curves=curves,
        ),
        Panel(
            "divergence of the directions",
            Surface(result["divergence"], colormap="RdBu_r", symmetric=True, outliers=0.02),
        ),
        Panel(
            "geodesic distance",
            Surface(distance, colormap="viridis", limits=_from_zero(distance), isolines=ISOLINES),
            markers=[*sources, farthest],
            curves=curves,
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


def _from_zero(distance: Floats) -> tuple[float, float] | None:
    largest = float(distance[np.isfinite(distance)].max(initial=0.0))
    return (0.0, largest) if largest > 0 else None
