"""Vector fields, colors and axes as written on the command line."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geomhw_cli.specs.numbers import LARGEST, excerpt, whole_number
from geomhw_cli.specs.sources import SourceSpecs, source_files

if TYPE_CHECKING:
    from geomhw.arrays import Floats
    from geomhw.fluid.vorticity import VorticityModel
    from geomhw.mesh.triangle_mesh import TriangleMesh

FIELD_HELP = (
    "rotation:AXIS (tangential, unit length, times 10 h), rigid:AXIS (rotation by one radian per unit of time), where "
    "AXIS is x, y, z or X,Y,Z; or FILE:ARRAY, per face or per vertex"
)
COLOR_HELP = (
    "waves (cells of an eighth of the bounding box), handout (hue cos²(3z)), hue:AXIS (the same along an axis, from -1 "
    "to 1 over the mesh), stripes, x, y, z, blob:SOURCE (at a vertex, face:17, max-y, near:X,Y,Z, ...), or FILE:ARRAY "
    "per vertex"
)
FLOW_HELP = "random:SEED[:WAVES], rossby-haurwitz:DEGREE, vortices:V1=+1,V2=-1, harmonic:K"
FLOW_FIELD_HELP = f"{FIELD_HELP}; or {FLOW_HELP}"
#: Distance, in mean edge lengths, below which nothing seems to move.
STILL = 1e-9
_KINDS = ("hue", "rotation", "rigid", "random", "blob", "rossby-haurwitz", "vortices", "harmonic")
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def array_files(spec: str) -> list[Path]:
    """The file of FILE:ARRAY."""
    from geomhw.io import field_file

    return [field_file(spec)]


def field_files(spec: str) -> list[Path]:
    """The files that a vector field or flow is read from."""
    return array_files(spec) if _is_file(spec) else []


def color_files(spec: str) -> list[Path]:
    """The files that a color is read from; that of the source of a blob, too."""
    kind, _, source = spec.partition(":")
    return source_files(source) if kind == "blob" else field_files(spec)


def field(spec: str, mesh: "TriangleMesh", known: str = FIELD_HELP) -> "Floats":
    """A vector field per face, (m, 3). known: what the message about another spec lists."""
    from geomhw.flow.initial_fields import rigid_field, rotation_field
    from geomhw.flow.tangent_fields import face_vectors
    from geomhw.io import read_field

    kind, _, rest = spec.partition(":")
    if kind == "rotation":
        return rotation_field(mesh, axis(rest))
    if kind == "rigid":
        return rigid_field(mesh, axis(rest))
    if _is_file(spec):
        return face_vectors(mesh, read_field(spec, mesh))
    raise click.UsageError(f"'{excerpt(spec)}' is no field; give {known}.")


def flow(spec: str, mesh: "TriangleMesh", model: "VorticityModel | None" = None) -> "Floats":
    """An initial velocity per face, (m, 3): a vector field, or a flow.

    model: that of the mesh, if it exists; else it is made when needed.
    """
    from geomhw.flow.initial_fields import random_field
    from geomhw.fluid import initial
    from geomhw.fluid.vorticity import VorticityModel

    kind, _, rest = spec.partition(":")
    if kind == "random":
        seed, _, waves = rest.partition(":")
        return random_field(mesh, _integer(seed, spec), _integer(waves or "8", spec))
    if kind == "rossby-haurwitz":
        return initial.rossby_haurwitz(model or VorticityModel(mesh), _integer(rest, spec))
    if kind == "harmonic":
        return initial.harmonic(model or VorticityModel(mesh), _integer(rest, spec))
    if kind == "vortices":
        return initial.vortices(model or VorticityModel(mesh), _circulations(rest, spec))
    return field(spec, mesh, FLOW_FIELD_HELP)


def color(spec: str, mesh: "TriangleMesh", remarks: list[str] | None = None) -> "Floats":
    """A color per vertex: one number, (n,), or RGB, (n, 3). remarks: as of `SourceSpecs.resolve`."""
    import numpy as np

    from geomhw.errors import ArgumentError, FieldError
    from geomhw.flow.initial_fields import bump, hue_stripes, waves
    from geomhw.io import read_field

    kind, _, rest = spec.partition(":")
    if spec in _AXES:
        return np.array(mesh.vertices[:, "xyz".index(spec)])
    if spec == "waves":
        return waves(mesh)
    if spec == "handout" or kind == "hue":
        return hue_stripes(mesh, None if spec in ("handout", "hue") else axis(rest))
    if spec == "stripes":
        return np.cos(5 * mesh.vertices[:, 2])
    if kind == "blob":
        points = SourceSpecs.parse([rest]).resolve(mesh, remarks)
        if len(points) != 1:
            raise ArgumentError(f"'{excerpt(spec)}' names {len(points)} points; a blob has one")
        return bump(mesh, points.positions(mesh)[0])
    if _is_file(spec):
        array = read_field(spec, mesh)
        values = np.asarray(array.values, dtype=float)
        if values.ndim == 2 and array.values.dtype == np.uint8:
            values = values / 255  # RGB as bytes
        if array.location != "vertex" or values.ndim > 2 or (values.ndim == 2 and values.shape[1] not in (1, 3)):
            raise FieldError(f"'{excerpt(spec)}' is no color: it needs one or three numbers per vertex")
        return values.squeeze()
    raise click.UsageError(f"'{excerpt(spec)}' is no color; give {COLOR_HELP}.")


def axis(text: str) -> "Floats":
    """The direction x, y, z, or of three numbers separated by commas, (3,)."""
    import numpy as np

    try:
        values = np.array(_AXES[text] if text in _AXES else [float(part) for part in text.split(",")])
    except ValueError:
        values = np.empty(0)
    if values.shape != (3,) or not np.isfinite(values).all() or not values.any():
        raise click.UsageError(f"'{excerpt(text)}' is no axis; give x, y, z, or a direction such as 1,0,2.")
    return values


def _integer(text: str, spec: str) -> int:
    """A number without a sign in a spec."""
    try:
        return whole_number(text if text.isdecimal() else "")
    except ValueError:
        raise click.UsageError(f"'{excerpt(spec)}' needs a whole number after the colon.") from None


def _circulations(text: str, spec: str) -> dict[int, float]:
    """The vertices and circulations of ``V1=+1,V2=-1``."""
    try:
        pairs = [pair.split("=") for pair in text.split(",")]
        circulations = {_integer(vertex, spec): float(value) for vertex, value in pairs}
        if not all(abs(value) <= LARGEST for value in circulations.values()):
            raise ValueError
        return circulations
    except ValueError:
        raise click.UsageError(
            f"'{excerpt(spec)}' names no vortices; give VERTEX=CIRCULATION,... such as 3=1,80=-1."
        ) from None


def _is_file(spec: str) -> bool:
    kind, path = spec.partition(":")[0], spec.rpartition(":")[0]
    return kind not in _KINDS and ("." in spec or (path != "" and os.path.exists(path)))


def still_lines(mesh: "TriangleMesh", moved: float, what: str, option: str) -> list[str]:
    """A warning if a flow that moves the color by some distance moves nothing. option: that names another flow."""
    if moved >= STILL * mesh.mean_edge_length:
        return []
    return [
        f"warning: nothing moves: the {what} carries the color by {moved:.3g}; for a flat mesh, choose an axis "
        f"perpendicular to it, such as {option} rotation:z"
    ]
