"""Color mapping: limits, logarithms, color maps, ticks and number formats of a color bar."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.errors import FieldError
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import Surface

Table = NDArray[np.uint8]
MOST_ISOLINES = 1000


@dataclass(frozen=True)
class Shades:
    """Colors of a surface, ready to draw.

    values: 0 to 1 along the color map, or uint8 RGB rows. known: mask of the finite values. limits: values, or their
    logarithms, at the ends of the map. clipped: whether data lie below and above the limits. levels: isolines, 0 to 1.
    spacing: of the isolines, in values.
    """

    values: NDArray[Any]
    known: NDArray[np.bool_]
    location: Literal["vertex", "face"]
    table: Table
    limits: tuple[float, float] = (0.0, 1.0)
    clipped: tuple[bool, bool] = (False, False)
    log: bool = False
    levels: Floats = ()  # type: ignore[assignment]
    spacing: float = 0.0

    @property
    def rgb(self) -> bool:
        """Whether the values are RGB colors."""
        return self.values.ndim == 2

    @property
    def per_face(self) -> bool:
        """Whether there is one value per face."""
        return self.location == "face"


def shade(surface: Surface, mesh: TriangleMesh) -> Shades | None:
    """Map the values of a surface to colors; None if it has no values."""
    if surface.values is None:
        return None
    values = np.asarray(surface.values)
    rows = mesh.n_faces if surface.location == "face" else mesh.n_vertices
    if len(values) != rows or values.ndim > 2 or (values.ndim == 2 and values.shape[1] != 3):
        raise FieldError(f"colors of shape {values.shape} do not fit {rows} rows, one per {surface.location}")
    if surface.isolines and (surface.location != "vertex" or values.ndim > 1):
        raise FieldError("isolines need one number per vertex")
    table = color_table(surface.colormap, surface.span)
    if values.ndim == 2:
        rgb = (
            values if values.dtype == np.uint8 else np.clip(np.nan_to_num(values) * 255 + 0.5, 0, 255).astype(np.uint8)
        )
        return Shades(rgb, np.isfinite(values).all(axis=1), surface.location, table)
    values = values.astype(float)
    known = np.isfinite(values)
    below = False
    if surface.log:
        values, below = _logarithm(values, known, surface.decades)
    low, high = limits = _limits(values[known], surface)
    scaled = np.clip((np.where(known, values, low) - low) / (high - low), 0, 1)
    levels, spacing = _levels(surface, low, high)
    clipped = surface.beyond or (below or bool(np.any(values[known] < low)), bool(np.any(values[known] > high)))
    return Shades(scaled, known, surface.location, table, limits, clipped, surface.log, levels, spacing)


def color_table(name: str, span: tuple[float, float] = (0.0, 1.0), colors: int = 256) -> Table:
    """Return the RGBA rows of a matplotlib color map, (colors, 4) uint8."""
    import matplotlib

    if name not in matplotlib.colormaps:
        raise FieldError(f"there is no color map '{name}'; viridis, cividis, magma and twilight are some")
    table: Table = matplotlib.colormaps[name](np.linspace(*span, colors), bytes=True)
    return table


def _levels(surface: Surface, low: float, high: float) -> tuple[Floats, float]:
    """Return isolines, 0 to 1 along the color map, and their spacing."""
    lines = surface.isolines
    if isinstance(lines, int):
        return np.arange(1, lines + 1) / (lines + 1), (high - low) / (lines + 1)
    if (high - low) / lines > MOST_ISOLINES:
        raise FieldError(f"isolines every {lines:g} are more than {MOST_ISOLINES} between {low:g} and {high:g}")
    values = lines * np.arange(np.floor(low / lines) + 1, np.ceil(high / lines))
    return (values - low) / (high - low), lines


def round_spacing(extent: float, most: int = 20) -> float:
    """Return the smallest round number, one or two digits, of which ``most`` cover an extent."""
    steps = 10.0 ** np.floor(np.log10(extent / most)) * np.array([1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10])
    return float(steps[steps >= extent / most * (1 - 1e-9)][0])


def round_below(value: float) -> float:
    """Return the largest round number, 1, 2 or 5 times a power of ten, up to a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(factor * power for factor in (0.5, 1, 2, 5) if factor * power <= value * (1 + 1e-9)))


def _logarithm(values: Floats, known: NDArray[np.bool_], decades: float) -> tuple[Floats, bool]:
    """Return log10, raised to at least ``decades`` below the largest, and whether any value was raised."""
    positive = known & (values > 0)
    logs = np.full(values.shape, np.inf)
    np.log10(values, out=logs, where=positive)
    top = logs[positive].max(initial=-np.inf)
    floor = max(top - decades, logs.min(initial=np.inf)) if positive.any() else 0.0
    raised = known & (~positive | (logs < floor))
    return np.where(raised, floor, logs), bool(raised.any())


def _limits(values: Floats, surface: Surface) -> tuple[float, float]:
    """Return the values at the ends of the color map."""
    if surface.limits is not None:
        low, high = surface.limits
    elif not len(values):
        low, high = 0.0, 1.0
    elif surface.symmetric:
        high = float(np.quantile(np.abs(values), 1 - surface.outliers))
        low = -(high := high or float(np.abs(values).max()))
    else:
        low, high = np.quantile(values, [surface.outliers, 1 - surface.outliers]).tolist()
    if high - low > 1e-12 * max(abs(low), abs(high)):  # more than rounding
        return low, high
    pad = abs(low) or 1.0  # the limits of a constant are arbitrary
    return low - pad / 2, high + pad / 2


def ticks(low: float, high: float, most: int = 5, whole: bool = False) -> Floats:
    """Return at most ``most`` round numbers in [low, high], spaced by 1, 2, 2.5 or 5 times a power of ten.

    whole: integers only; a short interval may contain none.
    """
    span = high - low
    power = 10.0 ** np.floor(np.log10(span / most))
    power = max(power, 1.0) if whole else power
    for factor in (1, 2, 2.5, 5, 10, 20, 25, 50):
        step = factor * power
        if whole and step != round(step):
            continue
        first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
        if last - first + 1 <= most:
            break
    return np.asarray(np.arange(first, last + 1) * step)


def tick_labels(values: Floats) -> tuple[list[str], str]:
    """Return short texts for round numbers and their common power of ten, such as "×10⁻⁶"."""
    largest = np.abs(values).max(initial=0.0)
    power = int(np.floor(np.log10(largest))) if largest > 0 else 0
    if -3 <= power < 5:
        power = 0
    texts = [f"{value:.6g}".replace("-", "−") for value in values / 10.0**power + 0.0]  # no -0
    return texts, f"×10{superscript(power)}" if power else ""


def plain_number(value: float, digits: int) -> str:
    """Format a number with the given significant digits; a power of ten below 0.001 and from 1,000,000.

    >>> plain_number(4264.87, 4), plain_number(1000.0, 3), plain_number(2e-5, 3)
    ('4265', '1000', '2×10⁻⁵')
    """
    rounded = float(f"{value:.{digits}g}")
    if rounded == 0 or 1e-3 <= abs(rounded) < 1e6:
        return f"{rounded:.{max(digits, 6)}g}".replace("-", "−")
    mantissa, power = f"{rounded:.{digits - 1}e}".split("e")
    return f"{float(mantissa):g}×10{superscript(int(power))}".replace("-", "−")


def superscript(number: int) -> str:
    """Format an integer in superscript digits."""
    return str(number).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
