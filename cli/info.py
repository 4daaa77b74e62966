"""``geomhw info``: what a mesh is, and what is wrong with it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw.errors import GeomhwError
from geomhw_cli import options
from geomhw_cli.trouble import Trouble

if TYPE_CHECKING:
    from geomhw.mesh.diagnostics import Finding

#: Places named in a line; --json has all.
FIRST = 5
#: What the commands do at each kind of finding, by its name.
CONSEQUENCES = {
    "zero_area_faces": "geodesic and vecdiffuse need --robust, other commands refuse them.",
    "duplicate_faces": "geodesic and vecdiffuse ignore them, advect and operators count them; fluid and helmholtz "
    "refuse more than two faces at an edge.",
    "isolated_vertices": "They stay in outputs, with distance inf, and cannot be sources.",
    "non_manifold_edges": "geodesic and advect pass to all of the faces, vecdiffuse uses the mean of their normals; "
    "fluid, helmholtz, tracers and the intrinsic connection refuse them.",
    "non_manifold_vertices": "Distances and colors pass through, flow does not; the intrinsic connection refuses them.",
    "inconsistent_edges": "vecdiffuse, fluid and helmholtz reverse the smaller part of the faces; geodesic and advect "
    "need no orientation.",
    "one_sided_pieces": "geodesic, vecdiffuse and advect accept them; fluid and helmholtz refuse them.",
    "coincident_vertices": "The surface is not connected across them.",
    "negative_edges": "Heat may become negative there and distances beside slivers inaccurate; --robust avoids both.",
    "boundary_loops": "No flow crosses them.",
    "components": "Distance is inf on a component without a source.",
}


@click.command(no_args_is_help=True, short_help="Sizes, topology and defects of a mesh.")
@options.mesh_argument
@click.option("--check", is_flag=True, help="Say what is wrong where, and what the commands make of it.")
@options.json_option
@options.quiet_option
def info(mesh_path: Path, check: bool, as_json: bool, quiet: bool) -> None:
    """Sizes, topology and defects of MESH.

    With --check, a line for each kind of defect, with how many there are and the first of them (counted from 0; all
    with --json); then notes on what may spoil results, and facts. Exit code 0 if there is no defect, 1 if there is,
    2 if MESH cannot be read; -q prints nothing.

    \b
    Example:
      geomhw info data/creature.obj --check
    """
    import json

    from geomhw.io import read
    from geomhw.mesh import findings, mesh_summary

    try:
        found = read(mesh_path)
        given, mesh = {"path": str(mesh_path), **found.report}, mesh_summary(found.mesh)
        checked = findings(found.mesh) if check else []
    except GeomhwError as error:
        raise (Trouble(str(error)) if check else error) from error
    if as_json and not quiet:
        report: dict[str, Any] = {"command": "info", "input": given, "mesh": mesh}
        if check:
            report["check"] = [_plain(finding) for finding in checked]
        click.echo(json.dumps(report, indent=2, allow_nan=False))
    elif not quiet:
        for name, value in [*given.items(), *mesh.items()]:
            click.echo(f"{name.replace('_', ' '):<24}{_text(value)}")
        for item in found.fields:
            click.echo(f"{'array per ' + item.location:<24}{item.name} {item.values.shape[1:] or ''}".rstrip())
        for finding in checked:
            click.echo(f"{finding.kind:<24}{_line(finding)}")
    defects = any(finding.kind == "defect" for finding in checked)
    if check and not defects and not (as_json or quiet):
        click.echo(f"{'defect':<24}none")
    click.get_current_context().exit(int(defects))


def _plain(finding: "Finding") -> dict[str, Any]:
    return {
        "name": finding.name,
        "kind": finding.kind,
        "what": finding.what,
        "count": len(finding.places),
        "places": finding.places.tolist(),
        "consequence": CONSEQUENCES[finding.name],
    }


def _line(finding: "Finding") -> str:
    """What, how many, the first of them, and the sentence; pairs are edges, or copies of what comes after."""
    joint = "-" if finding.name.endswith("edges") else " of "
    places = [
        joint.join(map(str, place)) if isinstance(place, list) else str(place)
        for place in finding.places[:FIRST].tolist()
    ]
    more = ", ..." if len(finding.places) > FIRST else ""
    return f"{finding.what}: {len(finding.places)} ({', '.join(places)}{more}). {CONSEQUENCES[finding.name]}"


def _text(value: object) -> str:
    if value is None:
        return "undefined"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.10g}"
    return str(value)
