"""Views, ranges and isolines of pictures as written on the command line, and the `Look` that they make."""

import re
from math import isfinite
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli.specs.numbers import excerpt

if TYPE_CHECKING:
    from geomhw.render.look import Look

#: Options of a command that a `Look` takes.
_CHOICES = ("view", "up", "zoom", "width", "colormap", "limits", "isolines", "draw", "transparent")


class ViewName(click.ParamType):  # type: ignore[type-arg]  # generic in later versions of click
    """A named view, or azimuth and elevation in degrees."""

    name = "view"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the view as `Look` takes it."""
        from geomhw.errors import ArgumentError
        from geomhw.render.look import Look

        view = str(value).strip().lower()
        try:
            assert Look(view).angles
        except ArgumentError:
            self.fail(
                f"'{excerpt(view)}' is no view: front, back, left, right, top, bottom or AZIMUTH,ELEVATION in degrees."
            )
        return view


class Limits(click.ParamType):  # type: ignore[type-arg]
    """Two numbers, the lower first, separated by a comma."""

    name = "range"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the numbers."""
        if isinstance(value, tuple):
            return value
        try:
            low, high = (float(part) for part in str(value).split(","))
        except ValueError:
            low = high = 0.0
        if not (isfinite(low) and isfinite(high) and low < high):
            self.fail(f"'{excerpt(str(value))}' is no range; give two numbers LO,HI such as 0,2.5.")
        return low, high


class Isolines(click.ParamType):  # type: ignore[type-arg]
    """A number of isolines (no decimal point), their spacing (with one), or ``none``."""

    name = "isolines"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return an int or a float."""
        text = str(value).strip().lower()
        if text == "none":
            return 0
        if re.fullmatch(r"\d{1,3}", text):
            return int(text)
        try:
            spacing = float(text)
        except ValueError:
            spacing = 0.0
        if not (isfinite(spacing) and spacing > 0):
            self.fail(
                f"'{excerpt(text)}' is no isolines; give a number up to 999 such as 12, a spacing such as 0.5, or none."
            )
        return spacing


class ColorMap(click.ParamType):  # type: ignore[type-arg]
    """The name of a color map of matplotlib."""

    name = "colormap"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name."""
        import matplotlib

        if value not in matplotlib.colormaps:
            self.fail(
                f"'{excerpt(str(value))}' is no color map; viridis, cividis, magma, RdBu_r and twilight are some."
            )
        return str(value)


def take_look(settings: dict[str, Any]) -> "Look":
    """Take the choices of a picture out of the values of options."""
    from geomhw.render.look import Look

    chosen = {name: settings.pop(name) for name in _CHOICES if name in settings}
    return Look(**{name: value for name, value in chosen.items() if value is not None})
