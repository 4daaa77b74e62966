"""Evenly spaced streamlines with heads, which a picture draws instead of arrows."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from geomhw.arrays import Floats, Ints, ranges
from geomhw.errors import GeomhwError, RenderError
from geomhw.mesh.geometry import unit
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.colors import plain_number
from geomhw.render.layers import Arrows, Panel, Surface, arrow_scale
from geomhw.render.look import Look
from geomhw.results import Cloud, Result

if TYPE_CHECKING:
    from geomhw.flow.streamline_polylines import Streamlines

#: Distance of streamlines, in spacings of arrows, and of heads on a streamline, in distances of streamlines.
DENSITY, HEADS = 0.5, 6.0
#: Width of a streamline at the scale of its arrows, in pixels in a panel of 600, and the smallest and largest share.
WIDTH, THINNEST, WIDEST = 2.2, 0.35, 1.6
#: Length of a head, in distances of streamlines.
HEAD = 0.8
#: Vectors below this share of the scale are not drawn.
FAINT = 0.01
#: Streamlines of a page, side by side on a square of the area of the mesh.
ON_PAGE = 30
#: Part of the color map of lengths below a texture.
COLOR_SPAN = (0.25, 1.0)


@dataclass(frozen=True)
class FlowLines:
    """Streamlines of a face field, ready to draw.

    points: (k, 3). segments: (s,), the first point of each. widths: (k,), as shares of the full width. heads: (h, 3),
    places of heads. ahead, normals: (h, 3), unit. sizes: (h,), as shares of the full size.
    """

    points: Floats
    segments: Ints
    widths: Floats
    heads: Floats
    ahead: Floats
    normals: Floats
    sizes: Floats


def styled(panel: Panel, look: Look) -> Panel:
    """Return a panel whose arrows are drawn in the style of a look; a texture shows lengths as colors."""
    if look.draw == "arrows" or not panel.arrows:
        return panel
    arrows = [replace(item, style=look.draw) if item.points is None else item for item in panel.arrows]
    first, surface, note = arrows[0], panel.surface, panel.note
    if look.draw == "streamlines" and first.scale is not None and not note:
        note = f"streamlines, widest at length {plain_number(WIDEST * first.scale, 2)}"
    if look.draw == "lic" and surface.values is None and first.scale is not None:
        lengths = np.linalg.norm(first.vectors, axis=1)
        surface = Surface(lengths, first.location, span=COLOR_SPAN, limits=(0.0, WIDEST * first.scale), label="length")
    return replace(panel, arrows=arrows, surface=surface, note=note)


def face_field(mesh: TriangleMesh, arrows: Arrows) -> Floats:
    """Return the vectors of a layer per face, (m, 3); zero where they are not finite or too short to be drawn."""
    vectors = np.nan_to_num(np.asarray(arrows.vectors, dtype=float), nan=0.0, posinf=0.0, neginf=0.0)
    if arrows.location == "vertex":
        vectors = vectors[mesh.faces].mean(axis=1)
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(lengths > FAINT * (arrows.scale or 0.0), vectors, 0.0)


def traced(mesh: TriangleMesh, arrows: Arrows, spacing: float) -> "Streamlines":
    """Return the streamlines of a layer of arrows; RenderError if the mesh has none."""
    from geomhw.flow.even_streamlines import even_streamlines

    try:
        return even_streamlines(mesh, face_field(mesh, arrows), spacing)
    except GeomhwError as error:
        raise RenderError(f"streamlines cannot be drawn: {error}") from error


def flow_lines(lines: "Streamlines", scale: float | None) -> FlowLines:
    """Return streamlines as they are drawn. scale: the speed of full width; None: all have the same width."""
    x, faces = lines.positions, lines.faces
    segments = np.setdiff1d(np.arange(len(x)), lines.lines[1:] - 1)
    width = np.clip(lines.speed / scale, THINNEST, WIDEST) if scale else np.ones(len(x))
    widths = width.copy()
    inner = np.setdiff1d(segments, lines.lines[:-1])
    widths[inner] = (width[inner - 1] + width[inner]) / 2  # of the segments on both sides
    counts = np.maximum(np.floor(lines.lengths / (HEADS * lines.spacing)), 1).astype(np.int64)
    # Places along all streamlines joined one after the other.
    line = np.repeat(np.arange(len(lines)), counts)
    share = (ranges(np.zeros_like(counts), counts) + 0.5) / counts[line]
    joined = lines.arc_length + np.repeat(np.cumsum(lines.lengths) - lines.lengths, np.diff(lines.lines))
    along = (np.cumsum(lines.lengths) - lines.lengths)[line] + share * lines.lengths[line]
    at = segments[np.clip(np.searchsorted(joined[segments], along, side="right") - 1, 0, None)]
    ahead = unit(x[at + 1] - x[at])
    places = x[at] + (along - joined[at])[:, None] * ahead
    return FlowLines(x, segments, widths, places, ahead, lines.mesh.face_normals[faces[at]], width[at])


def streamlines_of(result: Result) -> dict[str, Cloud]:
    """Return the streamlines of each vector field of a result, for a page."""
    spacing = float(np.sqrt(result.mesh.face_areas.sum())) / ON_PAGE
    found = {}
    for field in result.fields:
        if field.location != "mesh" and np.shape(field.values)[1:] == (3,):
            vectors = np.asarray(field.values, dtype=float)
            layer = Arrows(vectors, field.location, scale=arrow_scale(vectors))
            found[f"streamlines of {field.name}"] = traced(result.mesh, layer, spacing).polylines()
    return {name: cloud for name, cloud in found.items() if len(cloud.points)}
