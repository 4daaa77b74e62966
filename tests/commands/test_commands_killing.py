"""``geomhw killing``: arrays, report, picture and refusals."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.io import read
from geomhw.mesh.primitives import cylinder_band, icosphere, torus
from support.program import run, save_off

pytestmark = pytest.mark.usefixtures("folder")


def test_arrays_and_report() -> None:
    """The report has ascending energies and the gap; each field is a tangent array per face; runs agree."""
    ball = icosphere(2)
    save_off(ball)
    for name in ("a", "b"):
        report = json.loads(run("killing", "ball.off", "-k", "4", "-o", f"{name}.vtp", "--json").stdout)
    assert report["energies"] == sorted(report["energies"])
    assert report["gap"]["fields"] == 3
    assert report["gap"]["ratio"] > 1e4
    result = read("a.vtp")
    assert [(field.name, field.location) for field in result.fields] == [(f"killing_{i}", "face") for i in range(4)]
    for field in result.fields:
        assert np.abs(np.einsum("fx,fx->f", field.values, ball.face_normals)).max() < 1e-12
        assert np.einsum("fx,fx,f->", field.values, field.values, ball.face_areas) == pytest.approx(1)
    assert run("compare", "a.vtp", "b.vtp", "--rtol", "0").exit_code == 0


def test_symmetry_from_a_text_file_and_an_array() -> None:
    """A mirror preserves one rotation of the sphere and reverses two."""
    ball = icosphere(1)
    save_off(ball)
    mirror = np.linalg.norm(ball.vertices[:, None] * [1, 1, -1] - ball.vertices, axis=2).argmin(axis=1)
    np.savetxt("mirror.txt", mirror, fmt="%d", header="images")
    np.savez("maps.npz", mirror=mirror)
    for spec in ("mirror.txt", "maps.npz:mirror"):
        for option, count in (("--symmetric", 1), ("--antisymmetric", 2)):
            answer = run("killing", "ball.off", option, spec, "-k", "1", "-o", "x.vtp", "--json")
            report = json.loads(answer.stdout)
            assert report["gap"]["fields"] == count
            assert report[option[2:]] == spec


def test_metric_in_four_dimensions() -> None:
    """A torus with the metric of the flat one has two Killing fields, in space one."""
    ring = torus(16, 12)
    save_off(ring, "ring.off")
    x, y, z = ring.vertices.T
    u, v = np.arctan2(y, x), np.arctan2(z, np.hypot(x, y) - 1)
    np.save("flat.npy", np.stack([np.cos(u), np.sin(u), np.cos(v), np.sin(v)], axis=1))
    answer = run("killing", "ring.off", "--metric", "flat.npy", "-o", "x.vtp")
    assert "gap       2 Killing fields" in answer.stdout
    assert "gap       1 Killing field;" in run("killing", "ring.off", "-o", "x.vtp").stdout


@pytest.mark.parametrize(
    ("line", "code", "word"),
    [
        ("-k 0", 2, "1"),
        ("-k 85", 2, "84 independent fields"),
        ("--symmetric a.txt --antisymmetric a.txt", 2, "exclude"),
        ("--symmetric missing.txt", 1, "no such file"),
        ("--symmetric short.txt", 2, "42 images"),
        ("--symmetric words.txt", 1, "line 2"),
        ("--symmetric large.txt", 2, "vertex 3 is 42"),
        ("--antisymmetric a.txt", 2, "0 such fields"),
        ("--basis coexact --boundary free", 2, "tangent"),
        ("--basis coexact --connection intrinsic", 2, "intrinsic"),
        ("--eigenfields 5", 2, "coexact"),
        ("--metric flat.npy --connection normals", 2, "--metric"),
        ("--metric flat.npy", 1, "equal coordinates"),
        ("--basis coexact --eigenfields 3 -k 4", 2, "3 such fields"),
        ("--basis coexact --eigenfields 3 -k 3", 0, ""),
    ],
)
def test_refusals(line: str, code: int, word: str) -> None:
    """What cannot be computed is one sentence."""
    save_off(icosphere(1))
    np.savetxt("short.txt", np.arange(41), fmt="%d")
    np.savetxt("a.txt", np.arange(42), fmt="%d")
    np.savetxt("large.txt", np.where(np.arange(42) == 3, 42, 0), fmt="%d")
    np.save("flat.npy", np.zeros((42, 2)))
    Path("words.txt").write_text("0\none\n")
    answer = run("killing", "ball.off", *line.split(), "-o", "x.vtp")
    assert answer.exit_code == code, answer.stderr
    assert word in answer.stderr
    assert answer.stderr.count("Error") <= 1


def test_open_and_non_manifold_meshes() -> None:
    """An edge of three faces is one sentence; a boundary is allowed."""
    save_off(cylinder_band(12, 4), "band.off")
    assert run("killing", "band.off", "-k", "2", "-o", "x.vtp").exit_code == 0
    Path("fan.off").write_text("OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n0 -1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 1 4\n")
    answer = run("killing", "fan.off", "-o", "x.vtp")
    assert answer.exit_code == 1
    assert "3 faces meet at edge 0-1" in answer.stderr
