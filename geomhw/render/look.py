"""What a user may choose about a picture: view, size, colors and isolines."""

import re
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geomhw.errors import ArgumentError
from geomhw.options import PANEL_WIDTH, DrawName
from geomhw.render.layers import LIGHT, Surface, Theme

#: Azimuth and elevation of named views, in degrees.
NAMED_VIEWS = {
    "front": (0.0, 0.0),
    "right": (90.0, 0.0),
    "back": (180.0, 0.0),
    "left": (-90.0, 0.0),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
}


@dataclass(frozen=True)
class Look:
    """Choices for a picture; the defaults leave them to the program.

    Attributes
    ----------
    view : str
        ``front``, ``back``, ``left``, ``right``, ``top``, ``bottom``, or "AZIMUTH,ELEVATION" in degrees; "": automatic.
    up : {"", "x", "y", "z"}
        The axis that points up; "": that of the file, or guessed from the mesh.
    file_up : {"", "x", "y", "z"}
        The axis that points up by the format of the mesh's file, of `upward_axis`; "": the format has none.
    zoom : float
        Magnification about the center.
    width : int
        Width of a panel in pixels. Text, lines and arrows scale with it.
    colormap : str
        Name of a matplotlib color map for the main quantity.
    limits : (low, high), optional
        Values at the ends of its color map.
    isolines : int or float, optional
        Their number (int) or spacing (float); 0: none.
    draw : {"arrows", "streamlines", "lic"}
        How vectors are drawn.
    transparent : bool
        Make the background transparent; pictures then have four channels.
    theme : Theme
        Colors of background and text.
    """

    view: str = ""
    up: str = ""
    file_up: str = ""
    zoom: float = 1.0
    width: int = PANEL_WIDTH
    colormap: str = ""
    limits: tuple[float, float] | None = None
    isolines: int | float | None = None
    draw: DrawName = "arrows"
    transparent: bool = False
    theme: Theme = LIGHT

    @property
    def angles(self) -> tuple[float, float]:
        """Azimuth and elevation of ``view``, in degrees."""
        if self.view in NAMED_VIEWS:
            return NAMED_VIEWS[self.view]
        number = r"[-+]?(?:\d+\.?\d*|\.\d+)"
        found = re.fullmatch(rf"({number}),({number})", self.view)
        if found and abs(float(found[2])) <= 90 and abs(float(found[1])) <= 360:
            return float(found[1]), float(found[2])
        names = ", ".join(NAMED_VIEWS)
        raise ArgumentError(f"'{self.view}' is no view; choose {names}, or AZIMUTH,ELEVATION in degrees")

    def apply(self, surface: Surface) -> Surface:
        """Return a surface with these colors, range and isolines."""
        changes: dict[str, Any] = {}
        if self.colormap:
            changes |= {"colormap": self.colormap, "span": (0.0, 1.0)}
        if self.limits:
            changes["limits"] = self.limits
        if self.isolines is not None and surface.location == "vertex" and np.ndim(np.asarray(surface.values)) == 1:
            changes["isolines"] = self.isolines
        return replace(surface, **changes) if changes else surface


AUTOMATIC = Look()
