"""Hostile meshes through every command: each computes a valid result, or names what is missing.

The table of meshes is in support/hostile.py, that of files in test_hostile_files.py.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.io import read, read_csv
from geomhw.mesh.cut import cut_into_sheets
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.hostile import HOSTILE, save, source_of
from support.messages import missing
from support.program import run
from support.reference import needs_reference, reference

pytestmark = pytest.mark.usefixtures("folder")


TURNING = ["advect", "m.off", "--field", "rigid:z", "--color", "x", "--dt", "0.05", "--steps", "2"]
FLOWING = ["fluid", "m.off", "--init", "random:1", "--force", "none", "--dt", "0.01"]
#: The arguments of each command, without pictures.
COMMANDS = {
    "geodesic": ["geodesic", "m.off", "-o", "out.vtu"],
    "multigrid": ["geodesic", "m.off", "-o", "out.vtu", "--solver", "multigrid"],
    "refine": ["geodesic", "m.off", "-o", "out.vtu", "--refine"],
    "robust": ["geodesic", "m.off", "-o", "out.vtu", "--robust"],
    "exact": ["geodesic", "m.off", "-o", "out.vtu", "--method", "exact"],
    "marching": ["geodesic", "m.off", "-o", "out.vtu", "--method", "fast-marching"],
    "vecdiffuse": ["vecdiffuse", "m.off", "-o", "out.vtu"],
    "intrinsic": ["vecdiffuse", "m.off", "-o", "out.vtu", "--connection", "intrinsic"],
    "vecrobust": ["vecdiffuse", "m.off", "-o", "out.vtu", "--robust"],
    "advect": [*TURNING, "--every", "2", "-o", "out.pvd", "--csv", "out.csv"],
    "tracers": [*TURNING, "-o", "out.pvd", "--tracers", "9"],
    "fluid": [*FLOWING, "--steps", "2", "-o", "out.pvd", "--csv", "out.csv"],
    "helmholtz": ["helmholtz", "m.off", "--field", "wind.npy", "-o", "out.vtu"],
}
DISTANCES = ("geodesic", "multigrid", "refine", "robust", "exact", "marching")
VECTORS = ("vecdiffuse", "intrinsic", "vecrobust")
FACE_FIELDS = ("advect", "tracers", "fluid", "helmholtz")
NOT_ROBUST = ("geodesic", "multigrid", "refine", "vecdiffuse", "intrinsic", *FACE_FIELDS)


def refused(words: str, *commands: str) -> dict[str, str]:
    """Return a table: these keywords for each of the commands."""
    return dict.fromkeys(commands, words)


THREE = refused("faces meet at edge", "fluid", "helmholtz", "tracers")

ONE_SIDED = refused("this surface is one-sided", "fluid", "helmholtz")
FLAT = refused("zero area", *NOT_ROBUST)
POINT = FLAT | refused("in one point", "robust", "vecrobust")
#: At t = h² sweeps do not converge with negative weights, very unequal edges, or a component that is warm everywhere.
SWEEPS = refused("compute with --solver direct", "multigrid")
STEP = refused("take a shorter step", "advect", "tracers")
COPIES = {name: THREE for name in HOSTILE if name.startswith("doubled") or name == "tripled"}
#: The commands that refuse each mesh, with keywords of the message; all others compute.
REFUSALS: dict[str, dict[str, str]] = COPIES | {
    "touching_edge": THREE,
    "book_3": THREE,
    "book_5": THREE,
    "moebius": ONE_SIDED,
    "klein": ONE_SIDED,
    "huge_150": refused("vertex 12 ... 1e+150 ... 1e+30", *COMMANDS),
    "tiny_150": refused("mesh ... 2e-150 across", *COMMANDS),
    "tiny_310": refused("mesh ... 2e-310 across", *COMMANDS),
    "far": STEP,  # a field of speed 10⁸
    "far_lost": POINT,
    "one_point": POINT,
    "mixed_scales": STEP | refused("take a shorter step", "fluid") | SWEEPS,
    "needle_15": FLAT,
    "needle_0": FLAT,
    "flat_vertex": FLAT,
    "needle_6": SWEEPS,
    "needle_12": SWEEPS,
    "needle_below": SWEEPS,
    "sheared": STEP | SWEEPS,
    "sheared_6": STEP | SWEEPS,
    "fan_1000": SWEEPS,
    "tube": SWEEPS,
}
#: Cases where rounding decides whether sweeps converge.
ROUNDING = {("mixed_scales", "multigrid")}
#: The defects that --check finds, with their numbers.
DEFECTS: dict[str, dict[str, int]] = {
    "bow_tie": {"non_manifold_vertices": 1},
    "hourglass": {"non_manifold_vertices": 1},
    "touching_edge": {"non_manifold_edges": 1},
    "book_3": {"non_manifold_edges": 6},
    "book_5": {"non_manifold_edges": 3},
    "moebius": {"one_sided_pieces": 1},
    "klein": {"one_sided_pieces": 1},
    "turned_sphere": {"inconsistent_edges": 199},
    "turned_torus": {"inconsistent_edges": 864},  # all of them
    "turned_grid": {"inconsistent_edges": 88},
    "doubled": {"duplicate_faces": 35, "non_manifold_edges": 67},
    "doubled_flipped": {"duplicate_faces": 35, "non_manifold_edges": 67},
    "doubled_all": {"duplicate_faces": 320, "non_manifold_edges": 480},
    "doubled_all_flipped": {"duplicate_faces": 320, "non_manifold_edges": 480},
    "pillow": {"duplicate_faces": 1},
    "tripled": {"duplicate_faces": 2, "non_manifold_edges": 3},
    **{name: {"isolated_vertices": 1} for name in HOSTILE if name.startswith("loose")},
    "far_lost": {"zero_area_faces": 320},
    "one_point": {"zero_area_faces": 320},
    "needle_15": {"zero_area_faces": 1},
    "needle_0": {"zero_area_faces": 1},
    "flat_vertex": {"zero_area_faces": 2},
}
#: The notes and facts on some meshes.
REMARKS: dict[str, dict[str, int]] = {
    "tetrahedron": {},
    "soup": {"coincident_vertices": 240 - 42, "boundary_loops": 80, "components": 80},
    "same_place": {"coincident_vertices": 162, "components": 2},
    "flat_vertex": {"coincident_vertices": 1, "negative_edges": 2, "boundary_loops": 1},
    "needle_12": {"negative_edges": 1, "boundary_loops": 1},
    "nested": {"components": 3},
    "tube": {"boundary_loops": 2},
}
REFERENCE_REFUSALS: dict[str, dict[str, str]] = {
    "fan3.obj": THREE,
    "hourglass_ico.obj": {},
    "lego.ply": {},
    "moebius.obj": ONE_SIDED,
    "ogre.obj": FLAT,
    "platonic_shelf.obj": {},
    "stanford-bunny.obj": {},
    "tet.obj": {},
    "triple_vierbein.obj": THREE,
    "woody.obj": {},
}
#: Too large to go through every command here.
LARGE = {
    "camelhead.off": ("geodesic", "multigrid", "robust", "vecdiffuse", "helmholtz"),
    "ogre.obj": ("geodesic", "robust"),
    "stanford-bunny.obj": ("geodesic",),
}


def holds(command: str, mesh: TriangleMesh, words: str) -> None:
    """Check what holds for the result of a command on any mesh."""
    if command in DISTANCES:
        right_distances(mesh, command, words)
    elif command in VECTORS:
        result = read("out.vtu")
        length = np.linalg.norm(result["transported"], axis=1)
        cut, original = cut_into_sheets(mesh)  # vectors stay on the sheets of their source
        copies = np.flatnonzero(original == source_of(words))
        reached = np.zeros(mesh.n_vertices, dtype=bool)
        reached[original[np.isfinite(edge_path_distance(cut, copies))]] = True
        if len(copies) == 1:
            np.testing.assert_allclose(length, reached, atol=1e-12)
        else:  # each sheet has its part of the vector
            np.testing.assert_array_equal(length > 0, reached)
            assert length.max() == pytest.approx(1, abs=1e-12)
        assert np.isfinite(result["diffused"]).all()
    elif command == "helmholtz":
        parts = read("out.vtu")
        np.testing.assert_allclose(parts["curl_free"] + parts["coexact"] + parts["harmonic"], parts["field"], atol=1e-9)
        shares = [energy(mesh, parts[name]) for name in ("curl_free", "coexact", "harmonic")]
        assert sum(shares) == pytest.approx(energy(mesh, parts["field"]), rel=1e-9)  # they are orthogonal
    elif command != "tracers":
        table = read_csv(Path("out.csv"))
        assert all(np.isfinite(column).all() for column in table.values())
        if command == "fluid":
            np.testing.assert_allclose(table["energy"], table["energy"][0], rtol=1e-8)


def right_distances(mesh: TriangleMesh, command: str, words: str) -> None:
    """Check distances: 0 at the source, inf where unreachable, at most the edge path; refined at least straight.

    Where the method fails, as on slivers, the report must say so.
    """
    distance, source = np.asarray(read("out.vtu")["distance"]), source_of(words)
    along = edge_path_distance(mesh, np.array([source]))
    straight = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    reached = np.isfinite(along)
    assert distance[source] == 0
    np.testing.assert_array_equal(np.isfinite(distance), reached)

    assert (distance[reached] <= along[reached] * (1 + 1e-12)).all()
    plain = command in ("geodesic", "multigrid")
    if plain and "distances are" not in words:
        assert (distance >= 0.5 * straight)[reached].all()
    if not plain:
        assert (distance >= straight * (1 - 1e-12))[reached].all()


def energy(mesh: TriangleMesh, field: np.ndarray) -> float:
    return float(mesh.face_areas @ np.einsum("fx,fx->f", field, field))


@pytest.mark.parametrize("name", HOSTILE)
def test_every_command(name: str) -> None:
    """Each command on each mesh computes a valid result, or gives one line and writes no file."""
    vertices, faces = HOSTILE[name]()
    save(vertices, faces)
    for command, arguments in COMMANDS.items():
        answer = run(*arguments)
        words = REFUSALS.get(name, {}).get(command)
        if words is None or ((name, command) in ROUNDING and answer.exit_code == 0):
            words = None
            assert answer.exit_code == 0, (command, answer.output)
            assert answer.stderr == ""
            holds(command, TriangleMesh(vertices, faces), answer.stdout)
        else:
            assert (answer.exit_code, answer.stdout) == (1, ""), command
            assert len(answer.stderr.splitlines()) == 1
            assert not missing(answer.stderr, words), command
        for path in [path for path in Path().iterdir() if path.name.startswith("out")]:
            assert words is None or path.suffix != ".vtu"
            path.unlink()


@pytest.mark.parametrize("name", [name for name in HOSTILE if "150" not in name and "310" not in name])
def test_check(name: str) -> None:
    """``info --check`` lists each defect with its number and places, and exits with 1 if there is one."""
    save(*HOSTILE[name]())
    expected = DEFECTS.get(name, {})
    answer = run("info", "m.off", "--check", "--json")
    found = {item["name"]: item for item in json.loads(answer.stdout)["check"] if item["kind"] == "defect"}
    assert {name: item["count"] for name, item in found.items()} == expected
    assert all(len(item["places"]) == item["count"] for item in found.values())
    assert answer.exit_code == run("info", "m.off", "--check", "-q").exit_code == bool(expected)
    words = run("info", "m.off", "--check").stdout
    assert [line for line in words.splitlines() if line.startswith("defect")] == (
        [f"{'defect':<24}{item['what']}: {item['count']} {rest(item)}" for item in found.values()]
        or [f"{'defect':<24}none"]
    )


def rest(item: dict) -> str:
    """Return the end of a line of ``--check``: the first five places and the consequence."""
    joint = "-" if item["name"].endswith("edges") else " of "
    places = [joint.join(map(str, np.atleast_1d(place))) for place in item["places"]]
    return f"({', '.join(places[:5])}{', ...' if len(places) > 5 else ''}). {item['consequence']}"


@pytest.mark.parametrize("name", REMARKS)
def test_check_remarks(name: str) -> None:
    """Notes and facts follow the defects; duplicates name their originals."""
    save(*HOSTILE[name]())
    found = json.loads(run("info", "m.off", "--check", "--json").stdout)["check"]
    assert {item["name"]: item["count"] for item in found if item["kind"] != "defect"} == REMARKS[name]
    kinds = [item["kind"] for item in found]
    assert kinds == sorted(kinds, key=["defect", "note", "fact"].index)
    if name == "same_place":
        assert found[0]["places"] == [[v + 162, v] for v in range(162)]


@needs_reference
@pytest.mark.parametrize("name", REFERENCE_REFUSALS)
def test_reference_meshes(name: str) -> None:
    """The hostile meshes of the reference folder give valid results, or one line."""
    path = reference(f"meshes/hostile/{name}")
    mesh = read(path).mesh
    np.save("wind.npy", np.random.default_rng(0).normal(size=(mesh.n_faces, 3)))
    for command in LARGE.get(name, COMMANDS):
        arguments = [str(path) if word == "m.off" else word for word in COMMANDS[command]]
        answer = run(*arguments)
        words = REFERENCE_REFUSALS[name].get(command)
        assert answer.exit_code == (words is not None), (command, answer.output)
        if words is None:
            holds(command, mesh, answer.stdout)
        else:
            assert not missing(answer.stderr, words)


def test_wrong_distances_are_called_so() -> None:
    """Where slivers break the method, a line and the report say how far off it is, and name ``--refine``."""
    save(*HOSTILE["sheared_6"]())
    answer = run("geodesic", "m.off", "--no-png", "--json")
    accuracy = json.loads(answer.stdout)["accuracy"]
    assert accuracy["mean"] > 0.5
    assert not missing(run("geodesic", "m.off", "--no-png").stdout, f"warning ... {accuracy['mean']:.2%} ... --refine")
    assert json.loads(run("geodesic", "m.off", "--no-png", "--refine", "--json").stdout)["accuracy"] == {"exact": True}


@pytest.mark.parametrize("name", ["huge_150", "tiny_150", "tiny_310"])
def test_sizes_beyond_numbers(name: str) -> None:
    """Meshes beyond the range of squares are read and compared exactly, but not measured."""
    save(*HOSTILE[name]())
    np.testing.assert_array_equal(read("m.off").mesh.vertices, HOSTILE[name]()[0])
    assert [run("info", "m.off", *check).exit_code for check in ([], ["--check"])] == [1, 2]
    assert run("compare", "m.off", "m.off").exit_code == 0


def test_remarks() -> None:
    """Duplicate faces, flipped faces and vertices without a tangent plane are remarked beside the results."""
    save(*HOSTILE["doubled"]())
    assert "35 copies of other faces" in run("geodesic", "m.off", "--no-png").stdout
    save(*HOSTILE["turned_sphere"]())
    answer = run(*COMMANDS["fluid"])
    assert "107 faces turned" in answer.stdout
    assert read("out.00000.vtp").mesh.is_oriented
    save(*HOSTILE["sheared_6"]())
    assert not missing(run(*COMMANDS["helmholtz"]).stdout, "warning ... harmonic part ... no handles ... slivers")
    save(*HOSTILE["bow_tie"]())
    assert "do not pass 1 vertex" in run("vecdiffuse", "m.off", "--no-png").stdout
    save(*HOSTILE["touching_edge"]())
    assert "do not pass 1 edge of more than two faces" in run("vecdiffuse", "m.off", "--no-png").stdout
