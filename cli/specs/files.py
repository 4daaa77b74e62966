"""Files that options name. Each file that is read is an input of the command, which no output may overwrite."""

import os
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import copyfileobj
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

if TYPE_CHECKING:
    from geomhw.results import Result

_INPUTS = "geomhw.inputs"
#: Standard input or output in place of a file.
STANDARD = Path("-")
_TO_STREAM = "geomhw.to_stream"
_FORMAT, _OUTPUT_FORMAT = "geomhw.format", "geomhw.output_format"


class InputFile(click.Path):
    """A file that the command reads."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path, which is an input from now on."""
        path = Path(str(super().convert(value, param, ctx)))
        if os.path.isdir(path):
            self.fail(f"{path} is a folder; give a file in it.", param, ctx)
        if path != STANDARD:
            add_input(path)
        return path


class OutputFile(click.Path):
    """A file that the command writes."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path."""
        path = Path(str(super().convert(value, param, ctx)))
        if ctx and path == STANDARD:
            ctx.meta[_TO_STREAM] = True
        return path


class FormatName(click.ParamType):  # type: ignore[type-arg]  # generic in later versions of click
    """The name of a format, as an extension."""

    name = "format"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the extension, in lower case with its dot."""
        return f".{str(value).lower().removeprefix('.')}"


class Spec(click.ParamType):  # type: ignore[type-arg]  # generic in later versions of click
    """A text that may name files to read. files: finds them in the text."""

    name = "text"

    def __init__(self, files: Callable[[str], Sequence[Path]]) -> None:
        self.files = files

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the text; its files are inputs from now on."""
        for path in self.files(str(value)):
            add_input(path)
        return str(value)


def add_input(path: Path) -> None:
    """Count a file as an input of the current command, if there is one."""
    if context := click.get_current_context(silent=True):
        context.meta.setdefault(_INPUTS, []).append(path)


def inputs() -> list[Path]:
    """The inputs of the current command so far."""
    return list(click.get_current_context().meta.get(_INPUTS, []))


def require_writable(paths: Sequence[Path], extensions: Collection[str]) -> None:
    """Check, before any computation, that files can be written and are no inputs.

    Raises ArgumentError for an unknown extension, else FormatError.
    """
    from geomhw.errors import ArgumentError, FormatError
    from geomhw.io import check_outputs

    files = [path for path in paths if path != STANDARD]
    if len(files) < len(paths):
        _require_stream_format(extensions)
    if len(files) < len(paths) - 1:
        raise ArgumentError("cannot write -: two of the outputs would be standard output")
    try:
        check_outputs(files, inputs(), extensions=extensions)
    except FormatError as error:
        if all(path.suffix.lower() in extensions for path in files):
            raise
        options = {option for item in click.get_current_context().command.params for option in item.opts}
        named = {f"--{path.suffix.lower()[1:]}" for path in files if path.suffix.lower() not in extensions} & options
        raise ArgumentError("; ".join([str(error), *(f"the option for it is {name}" for name in named)])) from error
    if part := click.get_current_context().params.get("shard"):
        _require_no_other_part(files, part.number)


def _require_no_other_part(paths: Sequence[Path], number: int) -> None:
    """Raise ArgumentError where a file is another part of a run: parts with one -o would replace each other."""
    from geomhw.errors import ArgumentError, FormatError
    from geomhw.io.artifacts.shards import read_shard

    for path in paths:
        with suppress(FormatError, OSError):  # no shard, or not a whole one
            found = read_shard(path)
            if found.number != number:
                raise ArgumentError(
                    f"{path} holds part {found.number} of {found.of}, and this is part {number}: remove it, or "
                    "give each part a file of its own, such as D.1.shard, D.2.shard"
                )


def set_format(context: click.Context, option: click.Parameter, value: str | None) -> None:
    """Keep the extension that ``--format`` or ``--output-format`` names."""
    if value:
        key = _FORMAT if option.name == "format" else _OUTPUT_FORMAT
        context.meta[key] = value


def _require_stream_format(extensions: Collection[str]) -> None:
    """Raise ArgumentError unless standard output has a format, one of meshes."""
    from geomhw.errors import ArgumentError
    from geomhw.io import WRITABLE

    if not set(WRITABLE) <= set(extensions):
        raise ArgumentError(f"cannot write -: only meshes go to standard output; give a {' or '.join(extensions)} file")
    extension = _stream_format()
    if extension not in WRITABLE:
        kind = f"'{extension[1:]}' is not written; " if extension else ""
        raise ArgumentError(f"cannot write -: {kind}give --output-format {'|'.join(end[1:] for end in WRITABLE)}")


def _stream_format() -> str:
    meta = click.get_current_context().meta
    return str(meta.get(_OUTPUT_FORMAT, meta.get(_FORMAT, "")))


def read_input(path: Path) -> "Result":
    """Read a mesh from a file or standard input; ``--format`` names the format of what has no known extension."""
    from geomhw.errors import ArgumentError
    from geomhw.io import READABLE, read

    context = click.get_current_context()
    extension = context.meta.get(_FORMAT, "")
    if path != STANDARD and path.suffix.lower() in READABLE:
        given = context.get_parameter_source("format") is ParameterSource.COMMANDLINE
        if given and not context.meta.get(_TO_STREAM):
            raise ArgumentError(f"--format is for - and unknown extensions; the extension of {path} names its format")
        return read(path)
    if extension and extension not in READABLE:
        known = " ".join(end[1:] for end in READABLE)
        raise ArgumentError(f"--format: '{extension[1:]}' is not a mesh format that is read; known are {known}")
    if path != STANDARD:
        return read(path, extension)
    if not extension:
        raise ArgumentError("standard input has no extension; name its format, such as --format off")
    if sys.stdin.isatty():
        raise ArgumentError("standard input is a terminal; give a file, or a mesh through a pipe")
    return read(sys.stdin.buffer, extension)


def format_extension(path: Path) -> str:
    """The extension that ``--format`` names for a file without a known one, else nothing."""
    from geomhw.io import READABLE

    is_known = path.suffix.lower() in READABLE
    return "" if is_known else str(click.get_current_context().meta.get(_FORMAT, ""))


@contextmanager
def input_as_file(path: Path, extension: str) -> Iterator[Path]:
    """Give a path, or a temporary file with what standard input holds, with ``--format`` or else this extension."""
    from geomhw.errors import ArgumentError, GeomhwError

    if path != STANDARD:
        yield path
        return
    if sys.stdin.isatty():
        raise ArgumentError("standard input is a terminal; give a file, or one through a pipe")
    suffix = click.get_current_context().meta.get(_FORMAT, extension)
    with TemporaryDirectory(prefix="geomhw-") as folder:
        copy = Path(folder) / f"stdin{suffix}"
        with copy.open("wb") as file:
            copyfileobj(sys.stdin.buffer, file)
        try:
            yield copy
        except GeomhwError as error:
            raise type(error)(str(error).replace(str(copy), "standard input")) from error


def write_outputs(result: "Result", paths: Sequence[Path]) -> None:
    """Write a mesh with its fields to files, all or none, then to standard output if it is among them."""
    from geomhw.io import write, write_stream

    write(result, [path for path in paths if path != STANDARD])
    if STANDARD in paths:
        write_stream(result, sys.stdout.buffer, _stream_format())
        sys.stdout.buffer.flush()


def file_stem(path: Path) -> str:
    """The name from which default names of outputs are made."""
    return "stdin" if path == STANDARD else path.stem
