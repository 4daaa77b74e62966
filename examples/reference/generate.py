"""Write options.md, the tables of all options, from the click commands.

python examples/reference/generate.py
"""

from collections.abc import Iterator
from pathlib import Path

import click

from geomhw_cli.main import program

INTRODUCTION = """\
# Options

Written by `python examples/reference/generate.py` from the commands. `geomhw COMMAND --help` prints the same text, with
the arrays of the output and examples. The notation of sources, fields, colors and times is in [specs](specs.md).
"""


def options_page() -> str:
    """Return the page as Markdown, one table a command."""
    tables = [line for command in program.commands.values() for line in table(command)]
    return "\n".join([INTRODUCTION, *tables])


def table(command: click.Command) -> Iterator[str]:
    """Yield the heading of a command, its summary and a row for each option."""
    context = command.make_context(command.name, [], resilient_parsing=True)
    arguments = " ".join(item.human_readable_name for item in command.params if isinstance(item, click.Argument))
    yield f"## geomhw {command.name} {arguments}\n\n{command.get_short_help_str(200)}\n"
    yield "| option | meaning |\n|---|---|"
    for option in command.params:
        if isinstance(option, click.Option) and (record := option.get_help_record(context)):
            yield "| `{}` | {} |".format(record[0].replace("|", r"\|"), escaped(record[1]))
    yield ""


def escaped(text: str) -> str:
    """Return text with the characters that Markdown interprets escaped, and single spaces."""
    for character in r"\|*<":
        text = text.replace(character, rf"\{character}")
    return " ".join(text.split())


if __name__ == "__main__":
    Path(__file__).with_name("options.md").write_text(options_page(), encoding="utf-8")
