"""The contact sheet and the table of a batch: ``python3 sheet.py OUT`` writes OUT/sheet.html and OUT/table.csv.

Every mesh has its picture, or the reason why there is none. Exit code 1 if a mesh failed.
"""

import csv
import json
import sys
from pathlib import Path

from outcome import Outcome, read_outcome
from page import page


def main() -> None:
    """Write both, and say how many failed."""
    out = Path(sys.argv[1])
    meshes = json.loads((out / "meshes.json").read_text())
    outcomes = [read_outcome(out, name, path) for name, path in meshes.items()]
    (out / "sheet.html").write_text(page(outcomes, (out / "settings").read_text().strip()), encoding="utf-8")
    write_table(out / "table.csv", outcomes)
    failed = [item for item in outcomes if item.code]
    print(f"{len(outcomes)} meshes, {len(failed)} failed: {out / 'sheet.html'}, {out / 'table.csv'}")
    for item in failed:
        print(f"  {item.name}: {item.reason}")
    sys.exit(bool(failed))


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
