"""Runs of ``geomhw geodesic`` from one set of sources: compute, write, draw and report."""

from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any

import click

from geomhw.background import submit
from geomhw.wording import counted
from geomhw_cli.options import is_given
from geomhw_cli.runtime.accuracy import accuracy_lines
from geomhw_cli.runtime.job import Job, robust_line, time_line
from geomhw_cli.specs.distance_methods import DistanceMethod
from geomhw_cli.specs.masks import MaskSpec, MeshPart
from geomhw_cli.specs.sources import MAX_IN_LINE, MAX_REPORTED, SourceSpecs, shortened, source_line

if TYPE_CHECKING:
    from concurrent.futures import Future

    from geomhw.mesh.surface_points import SurfacePoints
    from geomhw.results import Result


def front_distances(
    job: Job,
    mask: MaskSpec | None,
    sources: SourceSpecs,
    to: SourceSpecs,
    method: DistanceMethod,
    beyond: float,
    panels: tuple[str, ...],
) -> None:
    """Compute, write and report distances by a front."""
    if is_given("panels") and set(panels) != {"distance"}:
        raise click.UsageError(f"--method {method.name} draws --panel distance only.")
    mesh, limit = job.read(), method.settings["limit"]
    part, targets = MeshPart.of(mesh, mask), to.vertices(mesh) if to.specs else []
    points = part.sources(sources, job.remarks)
    with job.stage("connectivity"):
        solver = method.front(part.mesh)
    with job.stage("compute"):
        result = part.expand(solver.from_sources(points, limit, part.vertices(targets)))
    errors = None if job.quiet or method.name == "exact" else _errors(part, points, result)
    _write(job, result, beyond, ("distance",))
    answers = result.report
    lines = [source_line(answers["sources"])]
    if farthest := answers["farthest"]:
        lines.append(f"farthest: vertex {farthest['vertex']} at {farthest['distance']:.10g}")
    if len(targets):
        reached = [(v, float(result["distance"][v])) for v in targets[:MAX_REPORTED]]
        answers = {**answers, "targets": [{"vertex": v, "distance": d if d < inf else None} for v, d in reached]}
        lines += [f"target: vertex {v} at {d:.10g}" for v, d in reached[:MAX_IN_LINE]]
    if limit < inf:
        answers = {**answers, "limit": limit}
    if beyond_limit := answers.get("vertices_beyond"):
        lines.append(f"beyond: {beyond_limit} vertices, whose distance is {beyond:g}")
    if errors:
        answers = {**answers, "accuracy": {"exact": False, **errors.result()}}
        lines += accuracy_lines(answers)
    lines += _unreachable(answers, beyond)
    job.finish(mesh, shortened(answers), lines)


def heat_distances(
    job: Job,
    mask: MaskSpec | None,
    sources: SourceSpecs,
    method: DistanceMethod,
    beyond: float,
    panels: tuple[str, ...],
) -> None:
    """Compute, write and report distances by the heat method."""
    from geomhw.geodesic.heat_method import HeatDistance

    mesh = job.read()
    part = MeshPart.of(mesh, mask)
    with job.stage("compute"):
        solver, points = HeatDistance(part.mesh, **method.settings), part.sources(sources, job.remarks)
        result = part.expand(solver.from_sources(points))
    answers, seconds = result.report, solver.stages.seconds
    del solver  # the picture needs the memory
    errors = None if job.quiet or answers["refined"] else _errors(part, points, result)
    _write(job, result, beyond, panels)
    answers = {**answers, "accuracy": {"exact": answers["refined"], **(errors.result() if errors else {})}}
    farthest = answers["farthest"]
    lines = [
        source_line(answers["sources"]),
        time_line(answers["time"]),
        f"farthest: vertex {farthest['vertex']} at {farthest['distance']:.10g}",
    ]
    if "robust" in answers:
        lines.append(robust_line(answers["robust"]))
    lines += accuracy_lines(answers) + _unreachable(answers, beyond)
    job.finish(mesh, shortened(answers) | {"profile": {"seconds": seconds}}, lines)


def _errors(part: MeshPart, points: "SurfacePoints", result: "Result") -> "Future[dict[str, Any]]":
    """Compare distances with exact ones, in the background: for the report only."""
    from geomhw.geodesic.accuracy import distance_errors

    return submit(partial(distance_errors, part.mesh, points, result["distance"]))


def _write(job: Job, result: "Result", beyond: float, panels: tuple[str, ...]) -> None:
    """Write a result, with a value in place of infinite distances, and draw it as it is."""
    from dataclasses import replace

    from geomhw.render.pictures import geodesic_picture
    from geomhw.results import Field

    written = result
    if beyond != inf:
        distance = result["distance"].copy()
        distance[distance == inf] = beyond
        fields = [Field("distance", "vertex", distance) if f.name == "distance" else f for f in result.fields]
        written = replace(result, fields=fields)
    job.write(written, lambda _written, look: geodesic_picture(result, look, panels=panels))


def _unreachable(answers: dict[str, Any], beyond: float) -> list[str]:
    """The warning of vertices that no path reaches."""
    unreached = answers.get("unreachable_vertices", 0)
    where = f"{counted(unreached, 'vertex', 'vertices')} on components without a source"
    return [f"warning: {where}: distance {beyond:g}"] if unreached else []
