"""Makes the man pages from the commands: ``python man_pages.py [FOLDER]``, by default build/man. See ``make man``."""

import re
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

import click

from geomhw import __version__
from geomhw_cli.main import program

ROOT = Path(__file__).resolve().parents[2]


def man_pages() -> dict[str, str]:
    """Return the text of each page by its file name."""
    commands = {f"geomhw-{name}": command for name, command in sorted(program.commands.items())}
    others = "\n".join(f".BR {escaped(name)} (1)," for name in commands).rstrip(",")
    pages = {"geomhw.1": page("geomhw", program, others)}
    return pages | {f"{name}.1": page(name, command, ".BR geomhw (1)") for name, command in commands.items()}


def page(name: str, command: click.Command, others: str) -> str:
    """Return one page in the man macros."""
    context = command.make_context(name.replace("-", " ", 1), [], resilient_parsing=True)
    first, _, rest = textwrap.dedent(command.help or "").strip().partition("\n")
    usage = " ".join(command.collect_usage_pieces(context))
    lines = [
        f'.TH "{name.upper()}" "1" "" "geomhw {__version__}" "geomhw"',
        ".SH NAME",
        rf"{escaped(name)} \- {escaped(first.rstrip('.'))}",
        ".SH SYNOPSIS",
        f".B {escaped(context.command_path)}",
        escaped(usage),
        ".SH DESCRIPTION",
        *description(rest),
        *options(command, context),
        ".SH SEE ALSO",
        others,
    ]
    return "\n".join(lines) + "\n"


def description(text: str) -> Iterator[str]:
    """Yield paragraphs; those that click does not wrap stay as they are."""
    for paragraph in re.split(r"\n\s*\n", textwrap.dedent(text).strip()):
        if paragraph.startswith("\b"):
            yield from (".PP", ".nf", *map(escaped, paragraph.split("\n")[1:]), ".fi")
        elif paragraph:
            yield from (".PP", escaped(" ".join(paragraph.split())))


def options(command: click.Command, context: click.Context) -> Iterator[str]:
    """Yield the options in their groups, and the commands of the program."""
    titles = {option: group.title for group in getattr(command, "groups", ()) for option in group.options}
    sections: dict[str, list[tuple[str, str]]] = {}
    for parameter in command.get_params(context):
        if isinstance(parameter, click.Option) and (record := parameter.get_help_record(context)):
            sections.setdefault(titles.get(parameter, "Other"), []).append(record)
    if isinstance(command, click.Group):
        records = [(name, one.get_short_help_str(200)) for name, one in sorted(command.commands.items())]
        sections["Commands"] = records
    yield ".SH OPTIONS"
    for title, records in sections.items():
        yield f".SS {escaped(title)}"
        for names, text in records:
            yield from (".TP", f".B {escaped(names)}", escaped(" ".join(text.split())))


def escaped(text: str) -> str:
    """Return text in which roff finds no commands; hyphens stay hyphens that can be copied."""
    text = text.replace("\\", r"\e").replace("-", r"\-")
    return rf"\&{text}" if text.startswith((".", "'")) else text


def main() -> None:
    """Write all pages to the folder."""
    folder = Path(sys.argv[1]) if sys.argv[1:] else ROOT / "build" / "man"
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in man_pages().items():
        (folder / name).write_text(text, encoding="utf-8")
    print(f"wrote {len(man_pages())} pages to {folder}")


if __name__ == "__main__":
    main()
