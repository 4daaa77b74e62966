"""What a method returns on a mesh, and on the same mesh scaled, moved, turned, mirrored, renumbered or flipped."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from attack.families import FAMILIES, random_mesh

from geomhw.errors import GeomhwError, MeshError
from geomhw.flow.helmholtz import HelmholtzDecomposition
from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.geodesic.exact import ExactDistance
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Result
from support import methods
from support.hostile import flipped, renumbered, rotated_corners
from support.methods import COMMANDS, Answer, Case, case_of, scaled

OTHERS = (
    *(methods.robust, methods.exact, methods.path, methods.trace, methods.logmap, methods.spectrum),
    *(methods.isolines, methods.smooth, methods.gradient, methods.killing, methods.bracket, methods.derive),
    *(methods.push, methods.design, methods.signed, methods.split, methods.voronoi, methods.center),
)
METHODS: dict[str, Callable[[Case], Answer]] = {**COMMANDS, **{method.__name__: method for method in OTHERS}}
#: Largest relative differences: between the same numbers in another order, and numbers that were rounded anew.
SAME, ROUNDED = 1e-8, 1e-6
#: Families of faces so thin that sums in another order differ as much as rounding.
THIN = ("slivers",)
#: Methods that solve normal equations without directions below 1e-10 of the largest: rounding grows by its inverse.
FITS, FITTED = ("gradient", "bracket", "derive", "push"), 1e-5
#: Families with edges of more than two faces, and what depends there on the order of corners: pieces at coincident
#: faces, which one diagonal or two divide.
NOT_MANIFOLD = ("pages", "touching")
BY_CORNERS = {"split": ("flipped", "corners", "renumbered")}


@dataclass(frozen=True)
class Change:
    """A changed case, the former numbers of its vertices and faces, the map of its vectors, and a tolerance."""

    case: Case
    vertices: np.ndarray
    faces: np.ndarray
    turn: np.ndarray
    tolerance: float


def changes(case: Case, seed: int) -> Iterator[tuple[str, Case, Change]]:
    """Yield the name of a change, a case, and what it becomes."""
    rng = np.random.default_rng(seed)
    mesh = np.asarray(case.mesh.vertices), np.asarray(case.mesh.faces)
    same = np.arange(len(mesh[0])), np.arange(len(mesh[1]))
    unturned = np.eye(3)
    other, places, order = renumbered(mesh, seed)
    source, target, *corners = np.argsort(places)[[case.source, case.target, *case.corners]].tolist()
    new = replace(case, mesh=TriangleMesh(*other), source=source, target=target, corners=tuple(corners))
    new = replace(new, field=case.field[order], color=case.color[places])
    yield "renumbered", case, Change(new, places, order, unturned, SAME)
    for name, change in (("corners", rotated_corners), ("flipped", flipped)):
        yield name, case, Change(replace(case, mesh=TriangleMesh(*change(mesh, seed))), *same, unturned, SAME)
    for name, factor in (("doubled", 2.0 ** rng.integers(-40, 40)), ("scaled", 10 ** rng.uniform(-9, 9))):
        yield name, case, Change(scaled(case, float(factor)), *same, unturned, SAME if name == "doubled" else ROUNDED)
    mirror = np.diag(np.where(np.arange(3) == rng.integers(3), -1.0, 1.0))
    yield "mirrored", case, Change(turned(case, mirror), *same, mirror, SAME)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    yield "turned", case, Change(turned(case, turn), *same, turn, ROUNDED)
    # Moved back, the rounded coordinates are the same numbers: the difference is that of the method, not of rounding.
    offset = 1e6 * case.size * rng.normal(size=3)
    far = mesh[0] + offset
    back = replace(case, mesh=TriangleMesh(far - offset, mesh[1]))
    yield "moved", back, Change(replace(case, mesh=TriangleMesh(far, mesh[1])), *same, unturned, SAME)


def turned(case: Case, turn: np.ndarray) -> Case:
    """Return a case whose points and vectors are multiplied by an orthogonal matrix."""
    mesh = TriangleMesh(case.mesh.vertices @ turn.T, case.mesh.faces)
    return replace(case, mesh=mesh, field=case.field @ turn.T, vector=tuple(np.array(case.vector) @ turn.T))


def answer_of(method: str, case: Case) -> Answer | str:
    """Return the answer of a method, or the kind of its refusal."""
    try:
        return METHODS[method](case)
    except GeomhwError as error:
        return type(error).__name__


def difference(expected: Answer, found: Answer, change: Change) -> float:
    """Return the largest relative difference, infinite where one of the two values is."""
    largest = 0.0
    for name, (values, location, size) in expected.items():
        former = values[{"vertex": change.vertices, "face": change.faces}.get(location, slice(None))]
        if values.ndim == 2:
            former = former @ change.turn.T
        new, new_size = found[name][0], found[name][2]
        finite = np.isfinite(former)
        if not np.array_equal(np.isfinite(new), finite):
            return float("inf")
        largest = max(largest, float(np.abs(new[finite] / new_size - former[finite] / size).max(initial=0.0)))
    return largest


def identities(case: Case) -> Iterator[str]:
    """Yield what is wrong about the answers on one mesh, without a second mesh."""
    mesh, source = case.mesh, case.source
    solver = ExactDistance(mesh)
    distance = solver.from_vertices([source])["distance"]
    along = edge_path_distance(mesh, np.array([source]))
    chord = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    size = along[np.isfinite(along)].max()
    reached = np.isfinite(along)
    for name, values in (("exact", distance), *((m, METHODS[m](case)["distance"][0]) for m in ("geodesic", "robust"))):
        if not np.array_equal(np.isfinite(values), reached):
            yield f"{name}: reaches other vertices than edge paths do"
        elif (values[reached] > along[reached] + 1e-9 * size).any():
            yield f"{name}: longer than an edge path"
        elif (values[reached] < chord[reached] - 1e-9 * size).any() and name != "geodesic":
            yield f"{name}: shorter than the chord"
    if reached[case.target] and abs(methods.path(case)["length"][0][0] - distance[case.target]) > 1e-9 * size:
        yield "path: its length is not the exact distance"
    rng = np.random.default_rng(0)
    some = rng.choice(np.flatnonzero(reached), size=min(4, int(reached.sum())), replace=False)
    for vertex in some.tolist():
        if abs(solver.from_vertices([vertex])["distance"][source] - distance[vertex]) > 1e-9 * size:
            yield f"exact: distance to {vertex} is not symmetric"
    color = METHODS["advect"](case)["color"][0]
    if color.min() < case.color.min() - 1e-9 or color.max() > case.color.max() + 1e-9:
        yield "advect: color out of its range"
    result = decomposition(case)
    if result is None:
        return
    shares = [np.square(result[part]).sum(axis=1) @ mesh.face_areas for part in ("curl_free", "coexact", "harmonic")]
    whole = np.square(result["field"]).sum(axis=1) @ mesh.face_areas
    if abs(sum(shares) / whole - 1) > 1e-6:
        yield f"helmholtz: shares sum to {sum(shares) / whole:.9f}"


def decomposition(case: Case) -> Result | None:
    """Return the parts of the field, or None on a surface that is not an oriented manifold."""
    try:
        return HelmholtzDecomposition(case.mesh)(case.field)
    except MeshError:
        return None


def attack(seed: int, count: int, first: int = 0, without: tuple[str, ...] = ()) -> Iterator[list[str]]:
    """Check this number of meshes, family by family; yield what is wrong with each check.

    without : methods that are left out.
    """
    for number in range(first, first + count):
        family, of_mesh = list(FAMILIES)[number % len(FAMILIES)], seed + number // len(FAMILIES)
        case = case_of(random_mesh(family, of_mesh))
        yield [f"{family} {of_mesh}: {words}" for words in identities(case)]
        for change, former, changed in changes(case, seed + number):
            for method in METHODS:
                if method in without or (family in NOT_MANIFOLD and change in BY_CORNERS.get(method, ())):
                    continue
                rough = FITTED if method in FITS else ROUNDED if family in THIN else changed.tolerance
                words = compared(method, former, replace(changed, tolerance=rough))
                yield [f"{family} {of_mesh}: {method}, {change}: {words}"] if words else []


def compared(method: str, former: Case, changed: Change) -> str:
    """Return what is wrong with the answer on a changed mesh, or an empty text."""
    expected, found = answer_of(method, former), answer_of(method, changed.case)
    if isinstance(expected, str) or isinstance(found, str):
        # At the longest step with which an iteration converges, rounding decides.
        return "" if expected == found or "ConvergenceError" in (expected, found) else f"{found}, was {expected}"
    size = difference(expected, found, changed)
    return f"differs by {size:.2g}" if size > changed.tolerance else ""
