"""The contact sheet and the table of a batch: ``python3 sheet.py OUT`` writes OUT/sheet.html and OUT/table.csv.

Every mesh has its picture, or the reason why there is none. Exit code 1 if a mesh failed.
"""

import csv
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from page import page

#: Of a report, what is no answer.
OTHERS = ("command", "input", "mesh", "files", "seconds", "remarks", "check")


@dataclass(frozen=True)
class Outcome:
    """What became of a mesh: name in the batch, path, exit code, last line of stderr, report, files in its folder."""

    name: str
    path: str
    code: int
    error: str
    report: dict[str, Any]
    files: list[str]

    @property
    def reason(self) -> str:
        """Why it failed, in a line; nothing if it did not."""
        if self.code == 0:
            return ""
        defects = [
            f"{item['what']}: {item['count']}" for item in self.report.get("check", []) if item["kind"] == "defect"
        ]
        return self.error or "; ".join(defects) or KNOWN.get(self.code, f"exit code {self.code}")

    @property
    def picture(self) -> str | None:
        """The file with the picture."""
        return next((file for file in self.files if file.endswith(".png")), None)

    @property
    def data(self) -> list[str]:
        """The other files, but for the frames of a series, which its index has."""
        named = {Path(file).name for file in self.report.get("files", self.files)}
        return [file for file in self.files if file in named and file != self.picture]

    @property
    def seconds(self) -> float:
        """Time taken in all stages."""
        return float(sum(self.report.get("seconds", {}).values()))

    @property
    def facts(self) -> dict[str, Any]:
        """Sizes and topology."""
        return dict(flat(self.report.get("mesh", {})))

    @property
    def answers(self) -> dict[str, Any]:
        """What was computed, and with what parameters: all single values of the report."""
        return dict(flat({name: value for name, value in self.report.items() if name not in OTHERS}))


#: Exit codes of a program that is ended by others, and can give no reason.
KNOWN = {124: "stopped at the time limit", 137: "killed: too little memory, perhaps", 143: "stopped by a signal"}


def main() -> None:
    """Write both, and say how many failed."""
    out = Path(sys.argv[1])
    meshes = json.loads((out / "meshes.json").read_text())
    outcomes = [outcome(out, name, path) for name, path in meshes.items()]
    (out / "sheet.html").write_text(page(outcomes, (out / "settings").read_text().strip()), encoding="utf-8")
    write_table(out / "table.csv", outcomes)
    failed = [item for item in outcomes if item.code]
    print(f"{len(outcomes)} meshes, {len(failed)} failed: {out / 'sheet.html'}, {out / 'table.csv'}")
    for item in failed:
        print(f"  {item.name}: {item.reason}")
    sys.exit(bool(failed))


def outcome(out: Path, name: str, path: str) -> Outcome:
    """What the folder of a mesh holds."""
    folder = out / name
    printed = (folder / "report").read_text(encoding="utf-8", errors="replace")
    errors = (folder / "errors").read_text(encoding="utf-8", errors="replace").split("\n")
    last = next((line for line in reversed(errors) if line.strip()), "")
    return Outcome(
        name,
        path,
        int((folder / "status").read_text()),
        last.removeprefix("Error: "),
        json.loads(printed) if printed.startswith("{") else {},
        sorted(file.name for file in folder.iterdir() if file.name not in ("report", "errors", "status")),
    )


def flat(values: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Single values of nested objects, as ``farthest.distance``; lists are left out."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}.")
        elif not isinstance(value, list):
            yield f"{prefix}{name}", value


def write_table(path: Path, outcomes: list[Outcome]) -> None:
    """A line a mesh: what became of it, its sizes, the answers."""
    lines = [
        {
            "name": item.name,
            "path": item.path,
            "exit_code": item.code,
            "reason": item.reason,
            "seconds": round(item.seconds, 4),
            **item.facts,
            **item.answers,
        }
        for item in outcomes
    ]
    with path.open("w", newline="", encoding="utf-8") as file:
        columns = dict.fromkeys(name for line in lines for name in line)
        table = csv.DictWriter(file, list(columns), lineterminator="\n")
        table.writeheader()
        table.writerows(lines)


if __name__ == "__main__":
    main()
