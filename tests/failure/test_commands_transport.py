"""``vecdiffuse`` and ``operators`` refuse wrong vectors, options and outputs."""

from pathlib import Path

import pytest

from geomhw.mesh.primitives import icosphere
from support.program import files, run, save_off

BALL = icosphere(1)
OPERATORS = ["gradient", "divergence", "stiffness", "mass", "consistent-mass", "faces-to-vertices", "vertices-to-faces"]
OPERATORS += ["connection", "complex-connection"]


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a small sphere in it."""
    save_off(BALL)
    return folder


NORMAL = [*map(repr, BALL.vertex_normals[4].tolist())]
TWICE = ["--source", "4", "--source", "4"]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ([*TWICE, "--vector", "1", "0", "0", "--vector", "0", "1", "0"], 2, "source 4 is given twice"),
        (["--vector", "0", "0", "0"], 2, "zero"),
        (["--vector", "nan", "0", "0"], 2, "'nan' is not a number"),
        (["--angle", "inf"], 2, "'inf' is not a number"),
        (["--source", "4", "--vector", *NORMAL], 2, "normal to the surface"),
        (["--dt", "0"], 2, "positive"),
        (["--dt", "-1"], 2, "positive"),
        (["--dt", "h2", "--dt", "soon"], 2, "'soon' is no time step"),
        (["--source", "42"], 2, "source 42 is not a vertex"),
        (["--connection", "levi-civita"], 2, "levi-civita"),
        (["--seed", "-1"], 2, "--seed"),
        (["--vector", "1", "0", "0", "--angle", "3"], 2, "exclude"),
        (["--angle", "3", "--seed", "3"], 2, "exclude"),
        (["--robust", "--connection", "intrinsic"], 2, "exclude"),
        (["--source", "1", "--source", "2", "--source", "3", *["--vector", "1", "0", "0"] * 2], 2, "2 times for 3"),
        (["-o", "ball.off"], 2, "'.off'"),
    ],
)
def test_vecdiffuse_refusals(arguments: list[str], code: int, words: str, folder: Path) -> None:
    """Wrong vectors, times and options give one line after the usage, and no file is written."""
    answer = run("vecdiffuse", "ball.off", *arguments)
    assert answer.exit_code == code
    assert answer.stdout == ""
    *usage, sentence = answer.stderr.strip().splitlines()
    assert words in sentence
    assert len([line for line in usage if line and not line.startswith(("Usage", "Try"))]) == 0
    assert usage == [] or code == 2
    assert files(folder) == ["ball.off"]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["-o", "a.npz"], 2, [f"--{name}" for name in OPERATORS]),
        (["--mass", "--stiffness", "-o", "a.npz"], 2, ["one operator", "--stiffness, --mass."]),
        (["--mass"], 2, ["--output"]),
        (["--mass", "-o", "a.csv"], 2, ["'.csv'", ".npz .mtx"]),
        (["--mass", "-o", "none/a.npz"], 1, ["no folder none"]),
        (["--curl", "-o", "a.npz"], 2, ["No such option"]),
    ],
)
def test_operators_refusals(arguments: list[str], code: int, words: list[str], folder: Path) -> None:
    """No operator, two, no output and unknown formats are refused, and no file is written."""
    answer = run("operators", "ball.off", *arguments)
    assert answer.exit_code == code
    for word in words:
        assert word in answer.stderr.strip().splitlines()[-1]
    assert files(folder) == ["ball.off"]
