"""Reports on several meshes in a file, of a whole run or of its parts. A report is a document and labeled texts."""

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geomhw.io.artifacts.shards import Shard

#: Extensions of files of reports.
REPORT_EXTENSIONS = (".json", ".txt")
Report = tuple[dict[str, Any], Sequence[Sequence[str]]]


def report_text(lines: Iterable[Sequence[str]]) -> str:
    """Labels and texts as lines."""
    return "\n".join(f"{label:<24}{text}" for label, text in lines)


def write_reports(path: Path, reports: Sequence[Report], several: bool) -> None:
    """Write reports as JSON, a list if they are of several meshes, or as text."""
    from geomhw.io import replacing

    if path.suffix.lower() == ".json":
        documents = [document for document, _ in reports]
        text = json.dumps(documents if several or not documents else documents[0], indent=2, allow_nan=False)
    else:
        text = "\n\n".join(report_text(lines) for _, lines in reports)
    with replacing([path]) as (temporary,):
        temporary.write_text(f"{text}\n", encoding="utf-8")


def report_data(reports: Iterable[Report]) -> Iterator[bytes]:
    """Reports as the data of a shard."""
    return (json.dumps(report).encode() + b"\n" for report in reports)


def join_reports(shards: "Sequence[Shard]", path: Path) -> dict[str, Any]:
    """Write the reports of all shards in order; return what the report of the command says of them."""
    reports = [(document, lines) for shard in shards for document, lines in map(json.loads, shard.lines())]
    write_reports(path, reports, several=shards[0].about["several"])
    return {"meshes": len(reports)}
