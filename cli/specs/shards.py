"""Parts of a run as written on the command line: ``--shard 2/5``."""

import re
from dataclasses import dataclass
from typing import Any

import click

from geomhw_cli.options import option
from geomhw_cli.specs.numbers import excerpt

MAX_SHARDS = 1_000_000


@dataclass(frozen=True)
class ShardPart:
    """Part ``number``, from 1, of ``of`` parts of a run, or a run that is not divided."""

    number: int
    of: int
    is_whole: bool = False

    def report(self) -> dict[str, str]:
        """The part as an item of a report; none of a whole run."""
        return {"shard": f"{self.number}/{self.of}"} if not self.is_whole else {}

    def lines(self) -> list[str]:
        """The part as a line of a report; none of a whole run."""
        return [f"shard: {self.number} of {self.of}"] if not self.is_whole else []

    def extensions(self, of_run: list[str]) -> list[str]:
        """Extensions of the output, given those of a whole run."""
        return [".shard"] if not self.is_whole else of_run

    def range(self, count: int, block: int = 1) -> tuple[int, int]:
        """The first and the last + 1 of ``count`` units that belong to this part, whole blocks of a run."""
        blocks = -(-count // block)
        first, last = ((number * blocks // self.of) * block for number in (self.number - 1, self.number))
        return min(first, count), min(last, count)


#: A run that is not divided.
WHOLE = ShardPart(1, 1, is_whole=True)


class _Part(click.ParamType):  # type: ignore[type-arg]  # generic in later versions of click
    """K/N."""

    name = "part"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> ShardPart:
        """Return the part; a wrong one is a usage error."""
        if isinstance(value, ShardPart):
            return value
        match = re.fullmatch(r"\s*(\d{1,9})\s*/\s*(\d{1,9})\s*", str(value))
        if not match or not 1 <= int(match[1]) <= int(match[2]) <= MAX_SHARDS:
            self.fail(f"'{excerpt(str(value))}' is no part; give K/N with K from 1 to N, such as 2/5.", param, ctx)
        return ShardPart(int(match[1]), int(match[2]))


def shard_option(what: str, into: str) -> click.Option:
    """The option for one part of a run. what: the units that are divided among the parts. into: the file of a part."""
    return option(
        "--shard",
        "K/N",
        _Part(),
        f"Compute part K of N of the {what}, into a shard file, {into}. geomhw merge joins all N.",
    )
