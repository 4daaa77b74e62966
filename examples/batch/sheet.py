"""The contact sheet of a batch: ``python3 sheet.py DIR`` writes DIR/sheet.html from the results of ``geomhw batch``.

A card for each mesh has its picture, or the reason why it failed.
"""

import csv
import json
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote

STYLE = """
:root { --ink: #1d2433; --faint: #667085; --line: #dfe3ea; --ground: #f3f5f8; --bad: #b3261e; --doubt: #8a5a00; }
* { box-sizing: border-box; }
body { margin: 0; padding: 2.5rem clamp(1rem, 3vw, 3rem); background: var(--ground); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; }
header { margin-bottom: 2rem; }
h1 { margin: 0 0 .3rem; font-size: 1.7rem; font-weight: 650; letter-spacing: -.01em; }
header p { margin: .2rem 0; color: var(--faint); }
code { font: .92em ui-monospace, "SF Mono", "DejaVu Sans Mono", monospace; }
header ul { margin: 1rem 0 0; padding: .8rem 1.2rem .8rem 2.2rem; border-left: 4px solid var(--bad); background: #fff;
  border-radius: 0 8px 8px 0; }
main { display: grid; gap: 1.4rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 36rem), 1fr)); }
article { display: flex; flex-direction: column; overflow: hidden; background: #fff; border: 1px solid var(--line);
  border-radius: 10px; box-shadow: 0 1px 3px rgb(16 24 40 / .07); }
.picture { display: flex; align-items: center; justify-content: center; flex: 1; padding: .6rem; min-height: 12rem; }
.picture img { display: block; width: 100%; max-height: 26rem; object-fit: contain; }
.reason { flex: 1; display: flex; align-items: center; min-height: 12rem; padding: 1.5rem 2rem; background: #fdf3f2;
  color: var(--bad); font-size: 1.05rem; overflow-wrap: anywhere; }
.caption { padding: .8rem 1.1rem 1rem; border-top: 1px solid var(--line); }
.caption p { margin: .15rem 0; color: var(--faint); font-size: .9rem; }
h2 { display: flex; justify-content: space-between; gap: 1rem; margin: 0; font-size: 1.05rem; font-weight: 620; }
h2 small { color: var(--faint); font-weight: 400; }
.caption .doubt { color: var(--doubt); }
a { color: #175cd3; text-decoration: none; } a:hover { text-decoration: underline; }
.bad a, .bad strong { color: var(--bad); }
details { margin-top: .4rem; font-size: .88rem; } summary { cursor: pointer; color: var(--faint); }
table { margin-top: .4rem; border-collapse: collapse; } td { padding: .05rem 1.2rem .05rem 0; vertical-align: top; }
td + td { font-variant-numeric: tabular-nums; }
"""
#: Topology that is shown where there is more of it than usual: names of one and of many.
UNUSUAL = {
    "components": (1, "component", "components"),
    "boundary_loops": (0, "boundary loop", "boundary loops"),
    "unreferenced_vertices": (0, "unreferenced vertex", "unreferenced vertices"),
    "zero_area_faces": (0, "face without area", "faces without area"),
}
#: Answers shown beside the picture.
HEADLINES = ("farthest.distance", "mean_distance", "energy_shares.harmonic", "last.time", "last.energy")


@dataclass(frozen=True)
class Mesh:
    """A mesh of the batch. row: of results.csv. report: of the command, empty if it printed none. files: beside it."""

    row: dict[str, str]
    report: dict[str, Any]
    files: list[str]

    @classmethod
    def read(cls, out: Path, row: dict[str, str]) -> "Mesh":
        """Read the folder of a mesh."""
        folder = out / row["name"]
        try:
            report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            report = {}
        files = sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []
        return cls(row, report if isinstance(report, dict) else {}, files)

    @property
    def name(self) -> str:
        """Its folder in that of the batch."""
        return self.row["name"]

    @property
    def failed(self) -> bool:
        """Whether it failed."""
        return self.row["status"] == "failed"

    @property
    def picture(self) -> str | None:
        """The file with the picture."""
        return next((file for file in self.files if file.endswith(".png")), None)

    @property
    def data(self) -> list[str]:
        """The other files that the report names."""
        named = {Path(file).name for file in self.report.get("files", ())}
        return [file for file in self.files if file in named and file != self.picture]

    @property
    def answers(self) -> dict[str, str]:
        """The single values of the report, except sizes and topology."""
        own = ("name", "mesh", "status", "exit_code", "reason")
        return {key: text for key, text in self.row.items() if text and key not in own and not key.startswith("mesh.")}


def main() -> None:
    """Write the page."""
    out = Path(sys.argv[1])
    with (out / "results.csv").open(newline="", encoding="utf-8") as stream:
        meshes = [Mesh.read(out, row) for row in csv.DictReader(stream)]
    command = next((mesh.report["command"] for mesh in meshes if "command" in mesh.report), "batch")
    (out / "sheet.html").write_text(page(meshes, command), encoding="utf-8")
    print(out / "sheet.html")


def page(meshes: Sequence[Mesh], command: str) -> str:
    """The whole page."""
    failed = [mesh for mesh in meshes if mesh.failed]
    count = f"{len(meshes)} meshes, " + (f"<strong>{len(failed)} failed</strong>" if failed else "none failed")
    reasons = "".join(
        f'<li><a href="#{link(mesh.name)}">{escape(mesh.name)}</a>: {escape(mesh.row["reason"])}</li>'
        for mesh in failed
    )
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>geomhw {escape(command)}</title>
<style>{STYLE}</style>
</head>
<body>
<header class="bad">
<h1>geomhw {escape(command)}</h1>
<p>{count} &middot; <a href="results.csv">results.csv</a></p>
{f"<ul>{reasons}</ul>" if reasons else ""}
</header>
<main>
{"".join(map(card, meshes))}</main>
</body>
</html>
"""


def card(mesh: Mesh) -> str:
    """One mesh."""
    path = Path(mesh.row["mesh"])
    return f"""<article id="{escape(mesh.name)}">
{top(mesh)}
<div class="caption">
<h2><span title="{escape(str(path))}">{escape(path.name)}</span><small>{escape(path.parent.name)}</small></h2>
{"".join(lines(mesh))}</div>
</article>
"""


def top(mesh: Mesh) -> str:
    """The picture, or the reason why there is none; nothing if the command draws none."""
    if mesh.failed:
        return f'<div class="reason">{escape(mesh.row["reason"])}</div>'
    if not mesh.picture:
        return ""
    address = link(f"{mesh.name}/{mesh.picture}")
    image = f'<img src="{address}" alt="{escape(mesh.name)}" loading="lazy">'
    return f'<a class="picture" href="{address}">{image}</a>'


def lines(mesh: Mesh) -> list[str]:
    """Sizes and time, main answers, warnings, files, all answers."""
    found = []
    if facts := mesh.report.get("mesh"):
        parts = [f"{facts['vertices']:,} vertices", f"{facts['faces']:,} faces"]
        parts.append("genus undefined" if facts["genus"] is None else f"genus {facts['genus']}")
        for name, (usual, one, many) in UNUSUAL.items():
            if (count := facts[name]) > usual:
                parts.append(f"{count:,} {one if count == 1 else many}")
        if seconds := mesh.report.get("seconds"):
            parts.append(f"{sum(seconds.values()):.2g} s")
        found.append(f"<p>{' &middot; '.join(parts)}</p>\n")
    answers = mesh.answers
    chief = [f"{re.sub('[._]', ' ', name)} {shown(answers[name])}" for name in HEADLINES if name in answers]
    if chief:
        found.append(f"<p>{' &middot; '.join(chief)}</p>\n")
    found += [f'<p class="doubt">{escape(remark)}</p>\n' for remark in mesh.report.get("remarks", [])]
    if mesh.data:
        links = [f'<a href="{link(f"{mesh.name}/{file}")}">{escape(file)}</a>' for file in mesh.data]
        found.append(f"<p>{' &middot; '.join(links)}</p>\n")
    if answers:
        rows = "".join(f"<tr><td>{escape(name)}</td><td>{shown(text)}</td></tr>" for name, text in answers.items())
        found.append(f"<details><summary>answers</summary><table>{rows}</table></details>\n")
    return found


def shown(text: str) -> str:
    """Return a number in a few digits, or the text itself."""
    try:
        return text if text.lstrip("-").isdigit() else f"{float(text):.6g}"
    except ValueError:
        return escape(text)


def link(name: str) -> str:
    """Return a name as an address."""
    return escape(quote(name))


if __name__ == "__main__":
    main()
