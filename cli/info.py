"""``geomhw info``: sizes, topology and defects of a mesh."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli.options import MESHES, OUTPUT, REPORT, OptionGroup, command, flag, option
from geomhw_cli.runtime.job import print_json
from geomhw_cli.runtime.mesh_reports import REPORT_EXTENSIONS, Report, report_data, report_text, write_reports
from geomhw_cli.specs.files import read_input, require_writable
from geomhw_cli.specs.shards import WHOLE, ShardPart, shard_option

if TYPE_CHECKING:
    from geomhw.mesh.diagnostics import Finding
    from geomhw.results import Result

#: Places named in a line; --json has all.
MAX_PLACES = 5
#: What the commands do at each kind of finding, by its name.
CONSEQUENCES = {
    "zero_area_faces": "geodesic and vecdiffuse need --robust, other commands refuse them.",
    "duplicate_faces": "geodesic and vecdiffuse ignore them, advect and operators count them; fluid and helmholtz "
    "refuse more than two faces at an edge.",
    "isolated_vertices": "They stay in outputs, with distance inf, and cannot be sources.",
    "non_manifold_edges": "geodesic and advect pass to all of the faces, transported vectors and derivatives to none; "
    "fluid, helmholtz and tracers refuse them.",
    "non_manifold_vertices": "Distances and colors pass through, flows and transported vectors do not.",
    "inconsistent_edges": "vecdiffuse, fluid and helmholtz reverse the smaller part of the faces; geodesic and advect "
    "need no orientation.",
    "one_sided_pieces": "geodesic, vecdiffuse and advect accept them; fluid and helmholtz refuse them.",
    "coincident_vertices": "The surface is not connected across them.",
    "nearly_coincident_vertices": "The surface is not connected across them; geomhw repair joins them.",
    "negative_edges": "Heat may become negative there and distances beside slivers inaccurate; --robust avoids both.",
    "boundary_loops": "No flow crosses them.",
    "components": "Distance is inf on a component without a source.",
}


@command(
    OptionGroup("Input", flag("--check", "List defects, and what they mean for the commands.")),
    OptionGroup(
        "Output",
        option("-o --output", "FILE", OUTPUT, "Write the report to this file, .json or .txt, in place of printing it."),
        shard_option("meshes", "such as -o info.K.shard"),
    ),
    REPORT,
    arguments=[MESHES],
)
def info(
    mesh_paths: tuple[Path, ...], check: bool, output: Path | None, shard: ShardPart | None, report: dict[str, Any]
) -> None:
    """Show sizes, topology and defects of each MESH.

    With --check, prints one line per kind of defect, with the number of places and the first of them (counted from 0;
    --json lists all). Notes on what may impair results, and facts, come after the defects. Exit codes: 0 no defects,
    1 defects, 2 a MESH cannot be read. With -q, prints nothing. Of several meshes, those that can be read are shown;
    --json prints a list.

    \b
    Examples:
      geomhw info data/creature.obj --check
      geomhw info data/sphere.off data/torus.off --json
    """
    from geomhw.errors import ArgumentError, GeomhwError
    from geomhw.mesh import findings

    if shard and not output:
        raise click.UsageError("--shard writes a file; give -o info.K.shard.")
    part = shard or WHOLE
    if output:
        require_writable([output], [".shard"] if shard else REPORT_EXTENSIONS)
    context = click.get_current_context()
    several, code, reports = len(mesh_paths) > 1, 0, list[Report]()
    is_text = not (report["as_json"] or report["quiet"] or output)
    first, last = part.range(len(mesh_paths))
    for path in mesh_paths[first:last]:
        try:
            content = read_input(path)
        except GeomhwError as error:
            if not several or isinstance(error, ArgumentError):
                raise
            click.echo(f"Error: {error}", err=True)
            code = context.obj
            continue
        found = findings(content.mesh) if check else []
        code = code or int(any(finding.kind == "defect" for finding in found))
        lines = _lines(path, content, found, check) if is_text or output else []
        if is_text:
            click.echo(report_text(lines) + ("\n" if several and path is not mesh_paths[-1] else ""))
        else:
            reports.append((_document(path, content, found, check), lines))
    if output:
        _write(output, reports, mesh_paths, check, shard)
    elif reports and not report["quiet"]:
        documents = [document for document, _ in reports]
        print_json(documents if several else documents[0])
    context.exit(code)


def _write(
    output: Path, reports: Sequence[Report], mesh_paths: Sequence[Path], check: bool, shard: ShardPart | None
) -> None:
    """Write the reports to a file, or those of a part to a shard."""
    from geomhw import __version__
    from geomhw.io.artifacts.shards import write_shard
    from geomhw.io.locks import locked

    several = len(mesh_paths) > 1
    with locked([output]):
        if not shard:
            write_reports(output, reports, several)
            return
        run = {"version": __version__, "question": "info", "meshes": [str(path) for path in mesh_paths], "check": check}
        data = partial(report_data, reports)
        write_shard(output, run, shard.number, shard.of, "reports", {"several": several}, data)


def _document(path: Path, content: "Result", found: Sequence["Finding"], check: bool) -> dict[str, Any]:
    """The report on one mesh as JSON."""
    from geomhw.mesh import mesh_summary

    document = {"command": "info", "input": {"path": str(path), **content.report}, "mesh": mesh_summary(content.mesh)}
    return document | ({"check": [_as_json(finding) for finding in found]} if check else {})


def _lines(path: Path, content: "Result", found: Sequence["Finding"], check: bool) -> list[tuple[str, str]]:
    """The report on one mesh as labels and texts."""
    document = _document(path, content, found, check)
    remarks = document["input"].pop("remarks", ())
    lines = [(key.replace("_", " "), _text(item)) for part in ("input", "mesh") for key, item in document[part].items()]
    lines += [("remark", text) for text in remarks]
    lines += [(f"array per {a.location}", f"{a.name} {a.values.shape[1:] or ''}".rstrip()) for a in content.fields]
    lines += [(finding.kind, _line(finding)) for finding in found]
    return lines + ([("defect", "none")] if check and all(finding.kind != "defect" for finding in found) else [])


def _as_json(finding: "Finding") -> dict[str, Any]:
    return {
        "name": finding.name,
        "kind": finding.kind,
        "what": finding.what,
        "count": len(finding.places),
        "places": finding.places.tolist(),
        "consequence": CONSEQUENCES[finding.name],
    }


def _line(finding: "Finding") -> str:
    """The kind of places, their number, the first of them, and the consequence.

    A pair of indices is an edge, or a copy and its original.
    """
    joint = "-" if finding.name.endswith("edges") else " of "
    places = [
        joint.join(map(str, place)) if isinstance(place, list) else str(place)
        for place in finding.places[:MAX_PLACES].tolist()
    ]
    more = ", ..." if len(finding.places) > MAX_PLACES else ""
    return f"{finding.what}: {len(finding.places)} ({', '.join(places)}{more}). {CONSEQUENCES[finding.name]}"


def _text(value: object) -> str:
    if value is None:
        return "undefined"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.10g}" if isinstance(value, float) else str(value)
