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
    lines, passed = [], answers["connection"] == "intrinsic" and answers.get("vertices_without_normal", 0)
    if passed:
        answers = {**answers, "vertices_without_normal": 0}
        lines.append(f"note: vectors are zero at {counted(passed, 'vertex whose', 'vertices whose')} faces cancel")
    if barriers := [counted(answers[name], *words) for name, words in NOT_PASSED.items() if answers.get(name, 0)]:
        lines.append(f"note: vectors do not pass {', '.join(barriers)}")
    if unreached := answers["unreachable_vertices"]:
        lines.append(f"warning: no vector reaches {counted(unreached, 'vertex', 'vertices')}: 0 there")
    return lines
