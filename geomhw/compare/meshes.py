"""Comparison of meshes with their arrays, and of time series of meshes."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from geomhw.compare.arrays import compare_arrays, compare_named, missing
from geomhw.compare.findings import Finding
from geomhw.compare.rules import Ignored, Tolerance
from geomhw.errors import FormatError
from geomhw.options import Location
from geomhw.results import Result


def compare_meshes(one: Result, other: Result, tolerance: Tolerance, ignored: Ignored) -> list[Finding]:
    """Compare positions, faces, and each array per vertex, per face and of the whole mesh.

    The scale of positions is the diagonal of the bounding box, so it does not depend on the place of the mesh. STL
    files have no vertex numbers: if one mesh comes from STL, the corners of faces replace positions and faces.
    """
    single = frozenset(name for result in (one, other) for name in result.report.get("single_precision", ()))
    findings = [*_counts(one, other), *_shape(one, other, tolerance, ignored, "positions" in single)]
    rows = {"vertex": one.mesh.n_vertices == other.mesh.n_vertices, "face": one.mesh.n_faces == other.mesh.n_faces}
    locations: tuple[Location, ...] = ("vertex", "face", "mesh")
    for location in locations:
        a, b = _fields(one, location), _fields(other, location)
        if rows.get(location, True):
            findings += compare_named(location, a, b, tolerance, ignored, single)
        else:  # the unequal numbers are a finding already
            findings += missing(location, a, b, ignored)
    return findings


def compare_series(one: Path, other: Path, tolerance: Tolerance, ignored: Ignored) -> list[Finding]:
    """Compare times and frames; return the worst frame of each array. Each frame has its own scale.

    Series of unequal length are compared over their common frames. Tracers are left out. Raises FormatError if a frame
    cannot be read.
    """
    from geomhw.io import read, read_series

    a, b = read_series(one), read_series(other)
    if not a or not b:
        raise FormatError(f"{(other if a else one).name} is a series without frames")
    shared = min(len(a), len(b))
    times, others = ([frame.time for frame in frames[:shared]] for frames in (a, b))
    findings = []
    if len(a) != len(b):
        findings.append(Finding("frames", "series", False, note=f"{len(a)} in A, {len(b)} in B"))
    if "times" not in ignored:
        findings.append(compare_arrays("times", "series", times, others, tolerance))
    worst: dict[tuple[str, str], Finding] = {}
    for number, (p, q) in enumerate(zip(a, b, strict=False)):
        results = read(one.parent / p.file), read(other.parent / q.file)
        for finding in compare_meshes(*results, tolerance, ignored):
            key = finding.location, finding.name
            if key not in worst or finding.badness > worst[key].badness:
                worst[key] = replace(finding, frame=number)
    return [*findings, *worst.values()]


def _counts(one: Result, other: Result) -> list[Finding]:
    """Return findings for unequal numbers of vertices and faces. They cannot be ignored: arrays depend on them."""
    a, b = one.mesh, other.mesh
    counts = [("faces", a.n_faces, b.n_faces)]
    if _numbered(one, other):
        counts.insert(0, ("vertices", a.n_vertices, b.n_vertices))
    return [Finding(what, "mesh", False, note=f"{p} in A, {q} in B") for what, p, q in counts if p != q]


def _shape(one: Result, other: Result, tolerance: Tolerance, ignored: Ignored, single: bool) -> list[Finding]:
    """Compare positions and faces if their numbers are equal."""
    a, b = one.mesh, other.mesh
    if _numbered(one, other):
        name, location, p, q = "positions", "vertex", a.vertices, b.vertices
    else:
        name, location, p, q = "corners", "face", a.vertices[a.faces], b.vertices[b.faces]
    findings = []
    if len(p) == len(q) and name not in ignored:
        scale = max(_diagonal(one), _diagonal(other))
        findings.append(compare_arrays(name, location, p, q, tolerance, scale=scale, single=single))
    if name == "positions" and a.n_faces == b.n_faces and "faces" not in ignored:
        findings.append(compare_arrays("faces", "face", a.faces, b.faces, tolerance))
    return findings


def _numbered(*results: Result) -> bool:
    """Return whether all files number their vertices; STL files do not."""
    return all(result.report.get("format") != "STL" for result in results)


def _diagonal(result: Result) -> float:
    """Return the diagonal of the bounding box."""
    points = result.mesh.vertices
    return float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))


def _fields(result: Result, location: Location) -> dict[str, Any]:
    """Return the values of the fields at a location by name."""
    return {field.name: field.values for field in result.fields if field.location == location}
