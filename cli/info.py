"""``geomhw info``: what a mesh is."""

from pathlib import Path

import click

from geomhw_cli import options


@click.command(no_args_is_help=True)
@options.mesh_argument
@options.json_option
def info(mesh_path: Path, as_json: bool) -> None:
    """Sizes, topology and defects of MESH.

    \b
    Example: geomhw info moomoo.off --json
    """
    import json

    from geomhw.io import read
    from geomhw.mesh.summary import mesh_summary

    found = read(mesh_path)
    given, mesh = {"path": str(mesh_path), **found.report}, mesh_summary(found.mesh)
    if as_json:
        click.echo(json.dumps({"command": "info", "input": given, "mesh": mesh}, indent=2, allow_nan=False))
        return
    for name, value in [*given.items(), *mesh.items()]:
        click.echo(f"{name.replace('_', ' '):<24}{_text(value)}")
    for item in found.fields:
        click.echo(f"{'array per ' + item.location:<24}{item.name} {item.values.shape[1:] or ''}".rstrip())


def _text(value: object) -> str:
    if value is None:
        return "undefined"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.10g}"
    return str(value)
