"""``geomhw merge``: the file of one run from its shards."""

import os
from pathlib import Path
from typing import Any

import click

from geomhw.wording import counted
from geomhw_cli.options import INPUT, OUTPUT, REPORT, OptionGroup, command, option
from geomhw_cli.runtime.distance_files import EXTENSIONS, join
from geomhw_cli.runtime.job import print_json
from geomhw_cli.runtime.mesh_batch import join_rows
from geomhw_cli.specs.files import require_writable

SHARDS = click.Argument(["shard_paths"], metavar="SHARD...", type=INPUT, nargs=-1, required=True)


@command(
    OptionGroup("Output", option("-o --output", "FILE", OUTPUT, "File to write: what one run writes.", required=True)),
    REPORT,
    arguments=[SHARDS],
)
def merge(shard_paths: tuple[Path, ...], output: Path, report: dict[str, Any]) -> None:
    """Join the shards that runs with --shard wrote to the file of one run, byte for byte.

    All parts of one run must be there, in any order, and none twice. Memory does not grow with the size of the file.

    \b
    Examples:
      geomhw geodesic data/sphere.off --all-pairs --shard 1/2 -o D.1.shard
      geomhw geodesic data/sphere.off --all-pairs --shard 2/2 -o D.2.shard
      geomhw merge -o D.npy D.1.shard D.2.shard
    """
    from geomhw.errors import FormatError
    from geomhw.io.artifacts.shards import read_shards
    from geomhw.io.locks import locked

    unique = {os.path.realpath(path): path for path in shard_paths}
    shards = read_shards(list(unique.values()))
    kind, joins = shards[0].kind, {**dict.fromkeys(EXTENSIONS, join), "table": join_rows}
    if kind not in joins:
        raise FormatError(f"{shards[0].path.name} is damaged: it holds '{kind}', which no command writes")
    require_writable([output], EXTENSIONS.get(kind, [".csv"]))
    try:
        with locked([output]):
            found = joins[kind](shards, output)
    except (KeyError, TypeError, ValueError) as error:  # the shards fit together, but not to their kind
        raise FormatError(f"{shards[0].path.name} is damaged: what it says of its data is not complete") from error
    if report["as_json"] and not report["quiet"]:
        run = dict(shards[0].run)
        print_json({"command": "merge", "shards": len(shards), "run": run, **found, "files": [str(output)]})
    elif not report["quiet"]:
        click.echo(f"shards    {counted(len(shards), 'shard')} of {shards[0].run.get('question', 'a run')}")
        click.echo(f"wrote     {output}")
