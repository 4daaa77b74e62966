"""Where transported vectors do not arrive, as lines of a report."""

from collections.abc import Mapping
from typing import Any

from geomhw.wording import counted

#: Where no tangent plane joins the faces, by the name in the report.
NOT_PASSED = {
    "non_manifold_edges": ("edge of more than two faces", "edges of more than two faces"),
    "non_manifold_vertices": ("vertex where several fans of faces meet", "vertices where several fans of faces meet"),
    "vertices_without_normal": (
        "vertex whose faces cancel or have no area, where they are zero",
        "vertices whose faces cancel or have no area, where they are zero",
    ),
}


def lines_on_reach(answers: Mapping[str, Any]) -> list[str]:
    """Return lines on what vectors do not pass, and on how many vertices none reaches."""
    counts, lines = {name: answers.get(name, 0) for name in NOT_PASSED}, []
    if answers["connection"] == "intrinsic" and (passed := counts.pop("vertices_without_normal")):
        lines.append(f"note: vectors are zero at {counted(passed, 'vertex whose', 'vertices whose')} faces cancel")
    if barriers := [counted(count, *NOT_PASSED[name]) for name, count in counts.items() if count]:
        lines.append(f"note: vectors do not pass {', '.join(barriers)}")
    if unreached := answers["unreachable_vertices"]:
        lines.append(f"warning: no vector reaches {counted(unreached, 'vertex', 'vertices')}: 0 there")
    return lines
