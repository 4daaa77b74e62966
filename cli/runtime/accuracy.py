"""Lines of a report about the accuracy of distances."""

from collections.abc import Mapping
from typing import Any

from geomhw.wording import counted

#: Mean and largest relative errors of distances from which the report warns.
MEAN_WARNED, LARGEST_WARNED = 0.05, 0.1


def accuracy_lines(answers: Mapping[str, Any]) -> list[str]:
    """Return the lines of a report about the errors of distances, and where they were clamped."""
    accuracy, lines = answers["accuracy"], []
    if accuracy["exact"]:
        return ["accuracy: exact on the polyhedral surface, up to rounding"]
    if "mean" in accuracy:
        where = " from the first source" if "of_sources" in accuracy else ""
        where += f" within {accuracy['within']:.6g} of the source" if "within" in accuracy else ""
        text = f"{accuracy['mean']:.2%} off on average{where}, {accuracy['largest']:.1%} at vertex {accuracy['vertex']}"
        off = accuracy["mean"] > MEAN_WARNED or accuracy["largest"] > LARGEST_WARNED
        lines.append(f"warning: distances are {text}; --refine makes them exact" if off else f"accuracy: {text}")
    if cold := answers.get("non_positive_heat"):
        where = counted(cold, "vertex", "vertices")
        lines.append(f"warning: heat is not positive at {where}, because of obtuse faces; compute with --robust")
    bounded = answers.get("bounded")
    if long := answers.get("beyond_edge_paths"):
        found = f"{counted(long['vertices'], 'distance')} up to {long['most']:.1%} longer than a path along edges"
        lines.append(f"bound: {found}, {'clamped to that' if bounded else 'left as they are'}")
    if raised := answers.get("below_zero"):
        found = f"{counted(raised['vertices'], 'distance')} not positive, the lowest at {raised['lowest']:.4g}"
        instead = "clamped to the straight line to the source" if bounded else "left as they are"
        lines.append(f"warning: {found}, {instead}")
    return lines
