"""The contact sheet as a page: a card a mesh, with its picture or the reason why there is none."""

import re
from collections.abc import Sequence
from html import escape
from pathlib import PurePath
from typing import Any
from urllib.parse import quote

from outcome import Outcome

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
#: Topology that is worth a word where there is more of it than usual: names of one and of many.
UNUSUAL = {
    "components": (1, "component", "components"),
    "boundary_loops": (0, "boundary loop", "boundary loops"),
    "unreferenced_vertices": (0, "unreferenced vertex", "unreferenced vertices"),
    "zero_area_faces": (0, "face without area", "faces without area"),
}
#: Answers that are worth a place beside the picture.
HEADLINES = ("farthest.distance", "mean_distance", "energy_shares.harmonic", "last.time", "last.energy")


def page(outcomes: Sequence[Outcome], settings: str) -> str:
    """The whole of it; settings: version and command line."""
    version, _, command = settings.partition(" version ")[2].partition(" ")
    failed = [item for item in outcomes if item.code]
    count = f"{len(outcomes)} meshes, " + (f"<strong>{len(failed)} failed</strong>" if failed else "none failed")
    reasons = "".join(
        f'<li><a href="#{link(item.name)}">{escape(item.name)}</a>: {escape(item.reason)}</li>' for item in failed
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
<h1>geomhw {escape(command.split(" ")[0])}</h1>
<p><code>geomhw {escape(command)}</code></p>
<p>{count} &middot; geomhw {escape(version)} &middot; <a href="table.csv">table.csv</a></p>
{f"<ul>{reasons}</ul>" if reasons else ""}
</header>
<main>
{"".join(map(card, outcomes))}</main>
</body>
</html>
"""


def card(item: Outcome) -> str:
    """One mesh."""
    folder, file = item.name.rpartition("/")[0], PurePath(item.path).name
    return f"""<article id="{escape(item.name)}">
{top(item)}
<div class="caption">
<h2><span title="{escape(item.path)}">{escape(file)}</span><small>{escape(folder)}</small></h2>
{"".join(lines(item))}</div>
</article>
"""


def top(item: Outcome) -> str:
    """The picture, or the reason why there is none; nothing if the command draws none."""
    if item.code:
        return f'<div class="reason">{escape(item.reason)}</div>'
    if not item.picture:
        return ""
    address = link(f"{item.name}/{item.picture}")
    image = f'<img src="{address}" alt="{escape(item.name)}" loading="lazy">'
    return f'<a class="picture" href="{address}">{image}</a>'


def lines(item: Outcome) -> list[str]:
    """Sizes and time, the chief answers, what to be careful of, the files, all answers."""
    found = []
    if facts := item.facts:
        parts = [f"{facts['vertices']:,} vertices", f"{facts['faces']:,} faces"]
        parts.append("genus undefined" if facts["genus"] is None else f"genus {facts['genus']}")
        for name, (usual, one, many) in UNUSUAL.items():
            if (count := facts[name]) > usual:
                parts.append(f"{count:,} {one if count == 1 else many}")
        found.append(f"<p>{' &middot; '.join([*parts, f'{item.seconds:.2g} s'])}</p>\n")
    answers = item.answers
    chief = [f"{re.sub('[._]', ' ', name)} {shown(answers[name])}" for name in HEADLINES if name in answers]
    if chief:
        found.append(f"<p>{' &middot; '.join(chief)}</p>\n")
    found += [f'<p class="doubt">{escape(remark)}</p>\n' for remark in item.report.get("remarks", [])]
    if item.data:
        links = [f'<a href="{link(f"{item.name}/{file}")}">{escape(file)}</a>' for file in item.data]
        found.append(f"<p>{' &middot; '.join(links)}</p>\n")
    if answers:
        rows = "".join(f"<tr><td>{escape(name)}</td><td>{shown(value)}</td></tr>" for name, value in answers.items())
        found.append(f"<details><summary>answers</summary><table>{rows}</table></details>\n")
    return found


def shown(value: Any) -> str:
    """A value in a few digits."""
    return f"{value:.6g}" if isinstance(value, float) else escape(str(value))


def link(name: str) -> str:
    """As an address."""
    return escape(quote(name))
