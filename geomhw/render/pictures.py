"""Pictures of geodesic distance and of the Helmholtz-Hodge decomposition."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geomhw.errors import ArgumentError
from geomhw.options import HEAT_METHOD
from geomhw.render.colors import plain_number, round_spacing
from geomhw.render.layers import Arrows, Marker, Panel, Surface, arrow_scale
from geomhw.render.look import AUTOMATIC, Look
from geomhw.render.panels import Picture, draw
from geomhw.render.source_marks import FARTHEST_COLOR, SOURCE_COLOR, source_marks
from geomhw.results import Result

#: Isolines of distance, at most.
ISOLINES = 20
#: Eigenfunctions in a picture.
_SHOWN = 6


def geodesic_picture(
    result: Result,
    look: Look = AUTOMATIC,
    size: tuple[int, int] | None = None,
    panels: Sequence[str] = HEAT_METHOD,
) -> Picture:
    """Draw the steps of the heat method, one panel each.

    Parameters
    ----------
    result : Result
        Of `HeatDistance`.
    look : Look
        View, width, colors and isolines. With several panels, colors and isolines are those of the distance.
    size : (width, height), optional
        Of the picture in pixels; by default panels have the width of ``look`` and the height that the mesh needs.
    panels : sequence of str
        Any of ``heat`` (with directions -∇u/|∇u|), ``gradient``, ``divergence`` and ``distance``.

    Returns
    -------
    (height, width, 3) array, uint8

    Raises
    ------
    ArgumentError
        If a panel has another name.
    RenderError
        If there is no OpenGL on this machine.

    Examples
    --------
    >>> from geomhw.geodesic import HeatDistance
    >>> from geomhw.mesh import icosphere
    >>> result = HeatDistance(icosphere(3)).from_vertices([0])
    >>> picture = geodesic_picture(result, panels=["distance"])
    """
    sources, curves = source_marks(result, SOURCE_COLOR, labels=True)
    points = [replace(marker, label="") for marker in sources]
    drawn = []
    for name in panels:
        if name == "heat":
            drawn.append(replace(_heat(result), markers=points, curves=curves))
        elif name == "gradient":
            drawn.append(replace(_gradient(result), markers=points, curves=curves))
        elif name == "divergence":
            drawn.append(_divergence(result))
        elif name == "distance":
            drawn.append(replace(_distance(result), markers=[*sources, _farthest(result)], curves=curves))
        else:
            raise ArgumentError(f"there is no panel '{name}'; choose from heat, gradient, divergence, distance")
    return draw(result.mesh, drawn, size, look=look, sources=[marker.vertex for marker in sources])


def _heat(result: Result) -> Panel:
    """Return the panel of the heat, logarithmic, with the directions in which it falls."""
    surface = Surface(
        result["heat"], colormap="inferno", span=(0.48, 1.0), log=True, label="heat, logarithmic", main=False
    )
    return Panel("heat u, and directions −∇u / |∇u|", surface, arrows=[Arrows(np.asarray(result["direction"]))])


def _gradient(result: Result) -> Panel:
    """Return the panel of the gradient of the heat: logarithm of its length, and its direction."""
    slope = np.asarray(result["heat_gradient"])
    length = np.hypot(np.hypot(slope[:, 0], slope[:, 1]), slope[:, 2])  # squares may underflow
    surface = Surface(
        length, "face", colormap="inferno", span=(0.48, 1.0), log=True, label="|∇u|, logarithmic", main=False
    )
    return Panel("gradient of the heat ∇u, and its length", surface, arrows=[Arrows(-np.asarray(result["direction"]))])


def _divergence(result: Result) -> Panel:
    """Return the panel of the divergence of the directions."""
    surface = Surface(
        result["divergence"],
        colormap="RdBu_r",
        symmetric=True,
        outliers=0.02,
        label="divergence, integrated per vertex [mesh units]",
        main=False,
    )
    return Panel("divergence of the directions", surface)


def _distance(result: Result) -> Panel:
    """Return the panel of the distance with isolines."""
    distance = np.asarray(result["distance"])
    largest = float(distance[np.isfinite(distance)].max(initial=0.0))
    limits = (0.0, largest) if largest > 0 else None
    lines = round_spacing(largest, ISOLINES) if largest > 0 else 0
    surface = Surface(distance, colormap="viridis", limits=limits, isolines=lines, label="distance [mesh units]")
    return Panel("geodesic distance", surface)


def _farthest(result: Result) -> Marker:
    """Return the marker of the farthest vertex."""
    far = result.report["farthest"]
    return Marker(far["vertex"], f"farthest {far['vertex']}: {far['distance']:.4g}", FARTHEST_COLOR)


def helmholtz_picture(result: Result, look: Look = AUTOMATIC, size: tuple[int, int] | None = None) -> Picture:
    """Draw a field and its Helmholtz-Hodge components, with arrows of one scale.

    Parameters
    ----------
    result : Result
        Of `HelmholtzDecomposition`.
    look, size
        As in `geodesic_picture`.

    Returns
    -------
    (height, width, 3) array, uint8
        Four panels: the field, its curl-free part over the potential, the coexact part over the stream function, and
        the harmonic part.

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.

    Examples
    --------
    >>> import numpy as np
    >>> from geomhw.flow import HelmholtzDecomposition
    >>> from geomhw.mesh import torus
    >>> mesh = torus(24, 12)
    >>> result = HelmholtzDecomposition(mesh)(np.ones((mesh.n_faces, 3)))
    >>> picture = helmholtz_picture(result)
    """
    fields = {name: np.asarray(result[name]) for name in ("field", "curl_free", "coexact", "harmonic")}
    scale = arrow_scale(fields["field"])
    plain = Surface()
    potential = Surface(result["potential"], colormap="PiYG", symmetric=True, label="potential [field × mesh units]")
    stream = Surface(
        result["stream_function"], colormap="PuOr", symmetric=True, label="stream function [field × mesh units]"
    )
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
    return draw(result.mesh, panels, size, columns=2, look=look)


def spectrum_picture(result: Result, look: Look = AUTOMATIC, size: tuple[int, int] | None = None) -> Picture:
    """Draw the first eigenfunctions, with positive and negative values in two colors, or the first eigenfields.

    Parameters
    ----------
    result : Result
        Of `geomhw.spectral.laplacian_spectrum` or one of its relatives.
    look, size
        As in `geodesic_picture`.

    Returns
    -------
    (height, width, 3) array, uint8

    Raises
    ------
    RenderError
        If there is no OpenGL on this machine.

    Examples
    --------
    >>> from geomhw.mesh import icosphere
    >>> from geomhw.spectral import laplacian_spectrum
    >>> picture = spectrum_picture(laplacian_spectrum(icosphere(2), 4))
    """
    panels = []
    for i, value in enumerate(result.report["eigenvalues"][:_SHOWN]):
        field = next(field for field in result.fields if field.name == f"eigenfunction_{i}")
        title = f"eigenfunction {i}, λ = {plain_number(value, 4)}"
        values = np.asarray(field.values)
        if values.ndim == 1:
            surface = Surface(values, colormap="RdBu_r", symmetric=True, label="eigenfunction [1 / mesh unit]")
            panels.append(Panel(title, surface))
        else:
            arrows = Arrows(values, "face" if field.location == "face" else "vertex", spacing=0.04)
            panels.append(Panel(title, Surface(), arrows=[arrows]))
    return draw(result.mesh, panels, size, columns=3, look=look)
