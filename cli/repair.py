"""``geomhw repair``: a mesh without cracks, degenerate or duplicate faces, consistently oriented."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli.options import OUTPUT, REPORT, OptionGroup, command, option
from geomhw_cli.output_options import MESH_FORMATS, OUTPUT_FORMAT
from geomhw_cli.runtime.job import mesh_line, print_json
from geomhw_cli.specs.files import STANDARD, read_input, require_writable, write_outputs
from geomhw_cli.specs.numbers import LARGEST, SMALLEST, Number

if TYPE_CHECKING:
    from geomhw.mesh.repair import Repair
    from geomhw.results import Field

#: What a step has changed, by its name; {tolerance} is a length.
STEPS = {
    "welded_vertices": "vertices joined with an earlier one within {tolerance:.3g}",
    "degenerate_faces": "faces of zero area or of fewer than three vertices removed",
    "duplicate_faces": "faces with the vertices of an earlier face removed",
    "reversed_faces": "faces reversed to orient the mesh consistently",
    "unreferenced_vertices": "vertices of no face removed",
}


@command(
    OptionGroup(
        "Repair",
        option(
            "--tolerance",
            "LENGTH",
            Number(SMALLEST, LARGEST, or_zero=True),
            "Distance up to which vertices are joined; 0 joins equal positions only.  [default: 1e-5 of the extent, at "
            "most a tenth of the median edge]",
        ),
    ),
    OptionGroup(
        "Output",
        option(
            "-o --output outputs",
            "FILE",
            OUTPUT,
            f"Repaired mesh with the arrays of MESH: {MESH_FORMATS}. May be repeated.",
            multiple=True,
            required=True,
        ),
        OUTPUT_FORMAT,
    ),
    REPORT,
)
def repair(mesh_path: Path, tolerance: float | None, outputs: tuple[Path, ...], report: dict[str, Any]) -> None:
    """Join vertices, remove and reverse faces of MESH where it is defective.

    The steps, in this order: join vertices of one position; remove faces of zero area; remove duplicate faces; orient
    consistently; remove vertices of no face. Prints a line per step. Vertices and faces keep their order. Joined
    vertices have the position and values of the first.

    \b
    Example:
      geomhw repair data/creature.obj -o creature.ply
    """
    from geomhw.io import WRITABLE
    from geomhw.mesh import mesh_summary
    from geomhw.mesh.repair import repair as repaired
    from geomhw.results import Field, Result

    require_writable(outputs, WRITABLE)
    content = read_input(mesh_path)
    done = repaired(content.mesh, tolerance)
    rows = {"vertex": done.vertices, "face": done.faces}
    fields = [
        Field(item.name, item.location, item.values[rows[item.location]]) if item.location in rows else item
        for item in content.fields
    ]
    write_outputs(Result(done.mesh, fields), outputs)
    summary, remarks = (
        mesh_summary(done.mesh),
        [*content.report.get("remarks", ()), *_differences(done, content.fields)],
    )
    written = [str(path) for path in outputs]
    if report["as_json"] and not report["quiet"]:
        print_json(
            {
                "command": "repair",
                "input": {"path": str(mesh_path), **content.report},
                "mesh": summary,
                "steps": done.steps,
                "tolerance": done.tolerance,
                "remarks": remarks,
                "files": written,
            },
            outputs,
        )
    elif not report["quiet"]:
        lines = [("note", remark) for remark in remarks]
        lines += [("step", f"{done.steps[name]} {STEPS[name].format(tolerance=done.tolerance)}") for name in STEPS]
        lines += [("mesh", mesh_line(summary)), *(("wrote", path) for path in written)]
        click.echo("\n".join(f"{label + ':':<10}{text}" for label, text in lines), err=STANDARD in outputs)


def _differences(done: "Repair", fields: "Sequence[Field]") -> list[str]:
    """Remarks on arrays whose values differ at joined vertices."""
    import numpy as np

    joined = np.flatnonzero(done.first_vertices != np.arange(len(done.first_vertices)))
    remarks = []
    for item in fields:
        if item.location == "vertex":
            differ = item.values[joined] != item.values[done.first_vertices[joined]]
            if count := int(np.count_nonzero(differ.any(axis=tuple(range(1, differ.ndim))))):
                remarks.append(f"array '{item.name}' has other values at {count} of the joined vertices")
    return remarks
