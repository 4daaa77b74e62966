"""``geomhw spectrum``: arrays, report and refusals."""

import json

import numpy as np
import pytest

from geomhw.io import read
from geomhw.mesh.primitives import icosphere
from support.program import run, save_off

pytestmark = pytest.mark.usefixtures("folder")


def test_arrays_and_report() -> None:
    """The report has eigenvalues and residuals; each eigenfunction is an array; two runs agree to the byte."""
    save_off(icosphere(2))
    for name in ("a", "b"):
        line = ["-k", "9", "--signature", "wks", "--scales", "3", "--distance", "diffusion", "--time", "1"]
        answer = run("spectrum", "ball.off", *line, "--source", "5", "-o", f"{name}.vtp", "--json")
        report = json.loads(answer.stdout)
    np.testing.assert_allclose(report["eigenvalues"], [0, 2, 2, 2, 6, 6, 6, 6, 6], rtol=3e-2, atol=1e-12)
    assert max(report["residuals"]) < 1e-10
    result = read("a.vtp")
    names = [f"eigenfunction_{i}" for i in range(9)] + ["wks_0", "wks_1", "wks_2", "diffusion_distance"]
    assert [field.name for field in result.fields if field.location == "vertex"] == names
    assert result["diffusion_distance"][5] == 0
    assert np.argmax(result["diffusion_distance"]) == np.argmax(
        np.linalg.norm(result.mesh.vertices - result.mesh.vertices[5], axis=1)
    )
    assert run("compare", "a.vtp", "b.vtp", "--rtol", "0").exit_code == 0
    answer = run("spectrum", "ball.off", "-k", "3", "--of", "fields", "-o", "f.vtp")
    assert "values    2.0" in answer.stdout
    assert [field.location for field in read("f.vtp").fields] == ["face"] * 3


@pytest.mark.parametrize(
    ("line", "code", "word"),
    [
        ("-k 0", 2, "1"),
        ("-k 43", 2, "42 eigenpairs"),
        ("--of vectors --robust", 2, "--robust"),
        ("--of fields --signature hks", 2, "--signature"),
        ("--time 3", 2, "diffusion"),
        ("-k 5 --distance biharmonic --source 1 --source 2", 2, "one source"),
        ("-k 1 --signature hks", 2, "ask for more"),
        ("-k 42 --boundary dirichlet", 0, ""),
    ],
)
def test_refusals(line: str, code: int, word: str) -> None:
    """What cannot be computed is one sentence."""
    save_off(icosphere(1))
    answer = run("spectrum", "ball.off", *line.split(), "-o", "x.vtp")
    assert answer.exit_code == code
    assert word in answer.stderr
    assert answer.stderr.count("Error") <= 1
