"""What became of one mesh of a batch."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

#: Of a report, what is no answer.
OTHERS = ("command", "input", "mesh", "files", "seconds", "remarks", "check")
#: Exit codes of a program that is ended by others, and can give no reason.
KNOWN = {124: "stopped at the time limit", 137: "killed: too little memory, perhaps", 143: "stopped by a signal"}


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


def read_outcome(out: Path, name: str, path: str) -> Outcome:
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
