"""Accuracy of distances in reports: the errors of matrices, and lines of text."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from geomhw.wording import counted

if TYPE_CHECKING:
    from geomhw.mesh.triangle_mesh import TriangleMesh
    from geomhw_cli.specs.queries import ResolvedQueries, Rows

#: Mean and largest relative errors of distances from which the report warns.
MEAN_WARNED, LARGEST_WARNED = 0.05, 0.1
#: Sets of sources of a matrix from which distances are compared with exact ones.
_COMPARED_SETS = 5


def accuracy_lines(answers: Mapping[str, Any]) -> list[str]:
    """Return the lines of a report about the errors of distances, and where they were clamped."""
    accuracy, lines = answers["accuracy"], []
    if accuracy["exact"]:
        return ["accuracy: exact on the polyhedral surface, up to rounding"]
    if "mean" in accuracy:
        where = f" from {counted(accuracy['sets'], 'source')}" if "sets" in accuracy else ""
        where += f" within {accuracy['within']:.6g} of the source" if "within" in accuracy else ""
        text = f"{accuracy['mean']:.2%} off on average{where}, {accuracy['largest']:.1%} at vertex {accuracy['vertex']}"
        text += f" from {_named(accuracy['of_sources'])}" if "sets" in accuracy else ""
        off = accuracy["mean"] > MEAN_WARNED or accuracy["largest"] > LARGEST_WARNED
        remedy = "--refine makes them exact" if "refined" in answers else "--method exact computes them exactly"
        lines.append(f"warning: distances are {text}; {remedy}" if off else f"accuracy: {text}")
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


def _named(sources: list[Any]) -> str:
    """The one source of a set, or their number."""
    return str(sources[0]) if len(sources) == 1 and isinstance(sources[0], int) else counted(len(sources), "point")


def sampled_errors(mesh: "TriangleMesh", rows: "Rows", resolved: "ResolvedQueries") -> dict[str, Any]:
    """The errors of the distances from a few sets of sources, evenly spread over all sets."""
    import numpy as np

    from geomhw.geodesic.accuracy import distance_errors
    from geomhw.mesh.named_points import vertex_points

    used = np.unique(mesh.faces)
    count = len(resolved.sets) if resolved.sets else len(used)
    chosen = np.unique(np.linspace(0, count - 1, _COMPARED_SETS).astype(int)).tolist()
    sets = [resolved.sets[k] if resolved.sets else vertex_points(mesh, used[[k]]) for k in chosen]
    found = [distance_errors(mesh, points, row) for points, row in zip(sets, rows(sets, None), strict=True)]
    compared = sum(errors["vertices"] for errors in found if errors)
    if not compared:
        return {"exact": False}
    k = max(range(len(found)), key=lambda k: found[k].get("largest", -1.0))
    mean = sum(errors["mean"] * errors["vertices"] for errors in found if errors) / compared
    return {"exact": False, "sets": len(sets), "of_sources": sets[k].report(), **found[k], "mean": mean}
