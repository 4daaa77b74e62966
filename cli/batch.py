"""``geomhw batch``: one command over many meshes."""

import os
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache, partial
from pathlib import Path
from typing import Any

import click

from geomhw.errors import FormatError, GeomhwError
from geomhw.wording import counted
from geomhw_cli.options import REPORT, Command, OptionGroup, option
from geomhw_cli.output_options import CURVE_FILES, FIELD_FILES, POINT_FILES, SERIES_FILES, VECTOR_FILES
from geomhw_cli.runtime.dask_cluster import SCHEDULER
from geomhw_cli.runtime.job import print_json
from geomhw_cli.runtime.mesh_batch import (
    Runner,
    RunTasks,
    Task,
    mesh_names,
    row_lines,
    run_batch,
    run_here,
    write_rows,
)
from geomhw_cli.specs.files import OutputFile, Spec, add_input
from geomhw_cli.specs.numbers import Number
from geomhw_cli.specs.shards import WHOLE, ShardPart, shard_option

#: Commands that take no single mesh.
NOT_FOR = ("batch", "compare", "merge")
#: Outputs of a command, by its group of options, or by its name.
OUTPUTS = {FIELD_FILES: ".vtp", VECTOR_FILES: ".vtp", CURVE_FILES: ".vtp", POINT_FILES: ".vtp", SERIES_FILES: ".pvd"}
OTHER_OUTPUTS = {"operators": ".npz", "repair": ".ply", "view": ".html"}
_OPTIONS = "geomhw.batch_options"


class _Batch(Command):
    """A command whose words after ``--`` are options of another command."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Keep these words."""
        end = args.index("--") if "--" in args else len(args)
        ctx.meta[_OPTIONS] = args[end + 1 :]
        return super().parse_args(ctx, args[:end])

    def collect_usage_pieces(self, ctx: click.Context) -> list[str]:
        """End the usage with the words after ``--``."""
        return [*super().collect_usage_pieces(ctx), "[-- COMMAND_OPTIONS]"]


_GROUPS = (
    OptionGroup(
        "Output",
        option("--out", "DIR", click.Path(path_type=Path, file_okay=False), "Folder of all results.", required=True),
        shard_option("meshes", "DIR/results.K-of-N.shard"),
    ),
    OptionGroup(
        "Processes",
        option(
            "--jobs",
            "N",
            Number(1, 1024, whole=True),
            "Meshes at a time.  [default: number of cores]",
            show_default=False,
        ),
        SCHEDULER,
    ),
    REPORT,
)


@click.command(
    cls=_Batch,
    groups=_GROUPS,
    params=[
        click.Argument(["command_name"], metavar="COMMAND"),
        click.Argument(["meshes"], metavar="MESH...", nargs=-1, required=True),
        *(item for group in _GROUPS for item in group.options),
    ],
)
def batch(
    command_name: str,
    meshes: tuple[str, ...],
    out: Path,
    shard: ShardPart | None,
    jobs: int | None,
    scheduler: str | None,
    report: dict[str, Any],
) -> None:
    """Run COMMAND on each MESH, with the options after --.

    Files, report and messages of each mesh go to DIR/<name>/, and DIR/results.csv has a row for each: done or failed,
    the reason, and the single values of the report. A mesh that fails does not stop the others. The same command line
    goes on where an interrupted batch ended, and tries failed meshes again.

    MESH may be a folder of meshes, or @FILE, a text file of paths. In the options, {out} is the folder of a mesh,
    {name} its name and {mesh} its path. Without -o among them, COMMAND writes <COMMAND>.vtp (.pvd, .npz ...) there,
    and a picture except with --no-png. Exit code 1 if a mesh failed.

    \b
    Examples:
      geomhw batch geodesic data/sphere.off data/torus.off --out out -- --source 0 --no-png
      geomhw batch info data --out check -- --check
      geomhw batch geodesic data/sphere.off --out all -- --all-pairs -o {out}/D.npy
    """
    from geomhw.io.artifacts.shards import write_shard
    from geomhw.io.locks import locked

    context = click.get_current_context()
    options = context.meta[_OPTIONS]
    tasks = _tasks(context, command_name, _listed(meshes), out, options)
    part = shard or WHOLE
    first, last = part.range(len(tasks))
    table = out / "results.csv" if part.is_whole else out / f"results.{part.number}-of-{part.of}.shard"
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FormatError(f"cannot write to {out}: {(error.strerror or str(error)).lower()}") from error
    with locked([table]):
        try:
            with _runner(scheduler, jobs) as run_tasks:
                rows, kept = run_batch(tasks[first:last], run_tasks)
        except KeyboardInterrupt as stop:
            stop.args = ("the same command goes on from here",)
            raise
        if part.is_whole:
            write_rows(table, rows)
        else:
            run = {"question": "batch", "tasks": [[task.name, *task.words] for task in tasks]}
            write_shard(table, run, part.number, part.of, "table", {}, partial(row_lines, rows))
    failed = [row for row in rows if row["exit_code"]]
    if report["as_json"] and not report["quiet"]:
        found = {"meshes": len(rows), "failed": len(failed), "kept": kept, **part.report(), "files": [str(table)]}
        print_json({"command": "batch", "of": command_name, **found})
    elif not report["quiet"]:
        click.echo(f"{'meshes':<10}{len(rows)}" + (f", of which {kept} were there" if kept else ""))
        click.echo(f"{'wrote':<10}{table}")
    for row in failed[:20]:
        click.echo(f"{row['name']}: {row['reason']}", err=True)
    if failed:
        click.echo(f"Error: {counted(len(failed), 'mesh', 'meshes')} of {len(rows)} failed; see {table}", err=True)
    context.exit(int(bool(failed)))


@contextmanager
def _runner(scheduler: str | None, jobs: int | None) -> Iterator[RunTasks]:
    """The function that runs tasks, here or on the workers of a scheduler."""
    if scheduler is None:
        yield partial(run_here, jobs=jobs or os.cpu_count() or 1)
        return
    from geomhw_cli.runtime.dask_cluster import as_they_end, connected

    with connected(scheduler, jobs) as client:
        yield lambda tasks: as_they_end(client, Runner(), tasks)


def _listed(meshes: tuple[str, ...]) -> list[str]:
    """The meshes that files of paths, folders and paths name, each once."""
    from geomhw.io import READABLE, read_lines

    found: list[str] = []
    for word in meshes:
        if word.startswith("@"):
            add_input(Path(word[1:]))
            found += [line for _, line in read_lines(word[1:])]
        elif os.path.isdir(word):
            inside = sorted(entry.path for entry in os.scandir(word) if not entry.name.startswith("."))
            in_folder = [path for path in inside if Path(path).suffix.lower() in READABLE and os.path.isfile(path)]
            if not in_folder:
                raise FormatError(f"{word} holds no mesh")
            found += in_folder
        else:
            found.append(word)
    return list({os.path.abspath(path): path for path in found}.values())


def _tasks(context: click.Context, name: str, meshes: list[str], out: Path, options: list[str]) -> list[Task]:
    """A task for each mesh. Raises UsageError for a command or options that cannot be run."""
    from geomhw import __version__

    parent = context.parent.command if context.parent else None
    commands = parent.commands if isinstance(parent, click.Group) else {}
    if name not in commands or name in NOT_FOR:
        known = ", ".join(sorted(set(commands) - set(NOT_FOR)))
        raise click.UsageError(f"'{name}' is no command for a batch; give one of {known}.")
    command = commands[name]
    given = _given(context, command, options)
    written = [text for item, texts in given.items() if isinstance(item.type, OutputFile) for text in texts]
    if len(meshes) > 1 and any(not re.search("{(out|name|mesh)}", text) for text in written):
        raise click.UsageError("All meshes would write the same files; put {out} or {name} into the options.")
    words = [name, "{mesh}", *options, *_further(command, {text for item in given for text in item.opts})]
    digest = cache(_content)
    tasks = []
    for mesh, label in zip(meshes, mesh_names(meshes), strict=True):
        folder, path = Path(os.path.abspath(out / label)), os.path.abspath(mesh)
        values = {"out": str(folder), "name": label, "mesh": path}
        filled = [_filled(word, values) for word in words]
        read = {file for item, texts in given.items() for text in texts for file in _files(item, _filled(text, values))}
        inputs = {file: digest(file) for file in sorted(read)}
        key = {"version": __version__, "command": filled, "mesh": digest(path), "inputs": inputs}
        tasks.append(Task(label, mesh, folder, filled, key))
    return tasks


def _given(context: click.Context, command: click.Command, words: list[str]) -> dict[click.Option, list[str]]:
    """The options that words give to a command, with their values as texts. Raises UsageError for other words."""
    parser = command.make_parser(click.Context(command, context.parent, command.name))
    values, _, order = parser.parse_args(["{mesh}", *words])
    return {item: list(_texts(values[str(item.name)])) for item in order if isinstance(item, click.Option)}


def _texts(value: object) -> Iterator[str]:
    """All texts in nested sequences."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, tuple | list):
        for item in value:
            yield from _texts(item)


def _filled(word: str, values: Mapping[str, str]) -> str:
    """Replace the placeholders of a word, once each."""
    return re.sub("{(out|name|mesh)}", lambda found: values[found[1]], word)


def _files(item: click.Option, text: str) -> set[str]:
    """The files that the value of an option names for reading."""
    if isinstance(item.type, OutputFile):
        return set()
    found = [text.lstrip("@")]
    with suppress(GeomhwError, click.UsageError, ValueError):  # the command itself will say what is wrong
        found += map(str, item.type.files(text) if isinstance(item.type, Spec) else [])
    return {path for path in found if os.path.isfile(path)}


def _content(path: str) -> str:
    """The digest of a file, or why it cannot be read."""
    from geomhw.io import file_digest

    try:
        return file_digest(path)
    except FormatError as error:
        return str(error)


def _further(command: click.Command, given: Collection[str]) -> list[str]:
    """Options for the report and for the files of a command unless some are given: all of one name in a folder."""
    name = str(command.name)
    ends = [OUTPUTS[group] for group in getattr(command, "groups", ()) if group in OUTPUTS]
    end = ends[0] if ends else OTHER_OUTPUTS.get(name, "")
    found = [] if "--json" in given else ["--json"]
    if not end or "--output" in given:
        return found
    found += ["-o", f"{{out}}/{name}{end}"]
    if end == ".pvd" and "--csv" not in given:
        found += ["--csv", f"{{out}}/{name}.csv"]
    draws = bool(ends) and not {"--no-png", "--png", "--all-pairs", "--pairs", "--sources"} & set(given)
    return found + (["--png", f"{{out}}/{name}.png"] if draws else [])
