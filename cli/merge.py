"""``geomhw merge``: the file of one run from its shards."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import click

from geomhw.wording import counted
from geomhw_cli.options import INPUT, OUTPUT, REPORT, OptionGroup, command, option
from geomhw_cli.runtime.curves import CURVE_EXTENSIONS, join_curves
from geomhw_cli.runtime.distance_files import EXTENSIONS, join
from geomhw_cli.runtime.job import print_json
from geomhw_cli.runtime.mesh_batch import join_rows
from geomhw_cli.runtime.mesh_reports import REPORT_EXTENSIONS, join_reports
from geomhw_cli.specs.files import require_writable

SHARDS = click.Argument(["shard_paths"], metavar="SHARD...", type=INPUT, nargs=-1, required=True)

#: Functions that join shards, and extensions of the files that they write, by the kind of data.
JOINS: dict[str, tuple[Callable[..., dict[str, Any]], Sequence[str]]] = {
    **{kind: (join, ends) for kind, ends in EXTENSIONS.items()},
    "table": (join_rows, [".csv"]),
    "curves": (join_curves, CURVE_EXTENSIONS),
    "reports": (join_reports, REPORT_EXTENSIONS),
}


@command(
    OptionGroup("Output", option("-o --output", "FILE", OUTPUT, "File to write: what one run writes.", required=True)),
    REPORT,
    arguments=[SHARDS],
)
def merge(shard_paths: tuple[Path, ...], output: Path, report: dict[str, Any]) -> None:
    """Join the shards that runs with --shard wrote to the file of one run, byte for byte.

    All parts of one run must be there, in any order, and none twice. Memory does not grow with the size of a file of
    distances.

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
    kind = shards[0].kind
    if kind not in JOINS:
        raise FormatError(f"{shards[0].path.name} is damaged: it holds '{kind}', which no command writes")
    joined, extensions = JOINS[kind]
    require_writable([output], extensions)
    try:
        with locked([output]):
            found = joined(shards, output)
    except (
        KeyError,
        IndexError,
        TypeError,
        ValueError,
        BadZipFile,
    ) as error:  # the shards fit together, but not to their kind
        raise FormatError(f"{shards[0].path.name} is damaged: what it says of its data is not complete") from error
    if report["as_json"] and not report["quiet"]:
        run = dict(shards[0].run)
        print_json({"command": "merge", "shards": len(shards), "run": run, **found, "files": [str(output)]})
    elif not report["quiet"]:
        click.echo(f"shards    {counted(len(shards), 'shard')} of {shards[0].run.get('question', 'a run')}")
        click.echo(f"wrote     {output}")
