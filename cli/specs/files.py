"""Files that options name. Each file that is read is an input of the command, which no output may overwrite."""

from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any

import click

_INPUTS = "geomhw.inputs"


class InputFile(click.Path):
    """A file that the command reads."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path, which is an input from now on."""
        path = Path(str(super().convert(value, param, ctx)))
        if path.is_dir():
            self.fail(f"{path} is a folder; give a file in it.", param, ctx)
        add_input(path)
        return path


class OutputFile(click.Path):
    """A file that the command writes."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)


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

    try:
        check_outputs(paths, inputs(), extensions=extensions)
    except FormatError as error:
        if all(path.suffix.lower() in extensions for path in paths):
            raise
        raise ArgumentError(str(error)) from error
