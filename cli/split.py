"""``geomhw split``: a mesh cut along isolines, curves or edges."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.wording import counted
from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command, option
from geomhw_cli.output_options import FIELD_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.curve_specs import CURVE_HELP, curve_files, curves_on
from geomhw_cli.specs.files import Spec, file_stem
from geomhw_cli.specs.numbers import excerpt
from geomhw_cli.specs.sources import MAX_IN_LINE, MAX_REPORTED

if TYPE_CHECKING:
    from geomhw.arrays import Floats, Ints
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw.results import Field

#: Files of single pieces, at most.
MAX_FILES = 10_000


def level_files(text: str) -> list[Path]:
    """The file of FILE:ARRAY=LEVEL."""
    from geomhw.io import field_file

    return [field_file(text.rpartition("=")[0])] if "=" in text else []


@command(
    OptionGroup(
        "Input",
        option(
            "--along levels",
            "FILE:ARRAY=LEVEL",
            Spec(level_files),
            "Cut along the isolines of a vertex array. May be repeated.",
            multiple=True,
        ),
        option(
            "--curve curves",
            "SPEC",
            Spec(curve_files),
            f"Cut along a curve: {CURVE_HELP}. May be repeated.",
            multiple=True,
        ),
        option(
            "--pieces",
            "DIR|FILE",
            click.Path(path_type=Path),
            "One file for each piece: in a folder, or FILE with the number before its extension.",
        ),
    ),
    FIELD_FILES,
    options.REPORT,
)
def split(
    mesh_path: Path,
    levels: tuple[str, ...],
    curves: tuple[str, ...],
    pieces: Path | None,
    files: dict[str, Any],
    report: dict[str, Any],
) -> None:
    """Cut MESH along isolines or curves, with new vertices on edges, and label the pieces.

    Vertex arrays of MESH and of --along are interpolated at new vertices, those of integers take the nearest corner.
    Face arrays are copied. Vertices keep their numbers; new ones, then copies at the cut follow. Without -o, writes
    <stem>.split.vtk and .png to the current directory. With -o, writes those files, and a picture only with --png.

    \b
    Arrays per face: piece (number from 0), parent (face of MESH), and those of MESH.

    \b
    Examples:
      geomhw geodesic data/creature.obj --source 0 --no-png -o d.vtp
      geomhw split d.vtp --along d.vtp:distance=1 -o halves.vtp --png halves.png
      geomhw split data/creature.obj --curve "edges:angle>60" --no-png --json -o parts.vtk
    """
    import numpy as np

    from geomhw.curves.split import split_mesh
    from geomhw.io import write
    from geomhw.render.cell_pictures import pieces_picture

    if not levels and not curves:
        raise click.UsageError("A cut needs --along or --curve.")
    job = Job.plan("split", mesh_path, **files, **report)
    mesh = job.read()
    carried = [field for field in job.fields if field.location != "mesh"]
    with job.stage("compute"):
        found: list[tuple[Ints, Floats]] = []
        edges = np.empty(0, dtype=np.int64)
        exact: dict[str, float] = {}
        for text in levels:
            curves_at, field, level = _isolines(mesh, text)
            found += curves_at
            exact[field.name] = level
            carried = [*(item for item in carried if (item.name, item.location) != (field.name, "vertex")), field]
        for text in curves:
            on_mesh = curves_on(mesh, text, job.remarks)
            found += on_mesh.curves
            edges = np.union1d(edges, on_mesh.edges(mesh))
        if len(levels) > 1:
            exact = {}
        result = split_mesh(mesh, found, edges)
        whole = result.result(carried, exact)
    targets = _piece_files(pieces, file_stem(mesh_path), result.n_pieces) if pieces else []

    def write_piece(path: Path) -> None:
        write(result.piece(targets.index(path), whole), path)

    job.write(whole, pieces_picture, beside=[(target, write_piece) for target in targets])
    answers = result.report()
    parts = answers["pieces"]
    lines = [
        f"piece: {item['piece']}, {item['faces']} faces, area {item['area']:.10g}, "
        f"Euler characteristic {item['euler_characteristic']}"
        for item in parts[:MAX_IN_LINE]
    ]
    if len(parts) > MAX_IN_LINE:
        lines.append(f"pieces: {len(parts)}, of area {sum(item['area'] for item in parts):.10g} together")
    cut = answers["cut"]
    lines.append(f"cut: {counted(cut['edges'], 'edge')} of length {cut['length']:.10g}")
    if len(parts) == mesh.n_components:
        lines.append("note: the cut separates nothing: no piece is apart from another that was not before")
    job.finish(mesh, {**answers, "piece_count": len(parts), "pieces": parts[:MAX_REPORTED]}, lines)


def _isolines(mesh: "TriangleMesh", text: str) -> "tuple[list[tuple[Ints, Floats]], Field, float]":
    """The isolines of FILE:ARRAY=LEVEL, the array, and the level."""
    import numpy as np

    from geomhw.curves.isolines import isolines
    from geomhw.errors import FieldError
    from geomhw.io import read_field

    spec, _, value = text.rpartition("=")
    try:
        level = float(value)
        if not spec or not np.isfinite(level):
            raise ValueError
    except ValueError:
        raise click.UsageError(f"'{excerpt(text)}' is no level; give FILE:ARRAY=NUMBER, as d.vtp:distance=1.") from None
    field = read_field(spec, mesh, finite=False)
    values = np.asarray(field.values, dtype=float)
    if field.location != "vertex" or values.ndim != 1:
        raise FieldError(f"'{field.name}' does not have one number per vertex, so no isolines")
    lines = isolines(mesh, values, [level])
    if not len(lines):
        known = values[np.isfinite(values)]
        raise FieldError(
            f"{field.name} has no isoline at {level:.10g}"
            + (f"; it is from {known.min():.10g} to {known.max():.10g}" if len(known) else "")
        )
    from dataclasses import replace

    return lines.curves, replace(field, values=values), level


def _piece_files(pieces: Path, stem: str, count: int) -> Sequence[Path]:
    """The files of single pieces."""
    from geomhw.errors import ArgumentError
    from geomhw.io import WRITABLE
    from geomhw_cli.specs.files import require_writable

    if count > MAX_FILES:
        raise ArgumentError(f"there are {count} pieces, more than {MAX_FILES} files")
    base = pieces / f"{stem}.vtp" if pieces.is_dir() or not re.fullmatch(r"\.\w+", pieces.suffix) else pieces
    targets = [base.with_name(f"{base.stem}.{k}{base.suffix}") for k in range(count)]
    require_writable(targets, WRITABLE)
    return targets
