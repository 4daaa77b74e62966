"""Texts of numbers read by the compiled loops for long texts, as by numpy."""

from pathlib import Path

import numpy as np
import pytest

from geomhw.errors import FormatError
from geomhw.io import read
from geomhw.io.formats import number_parsing, text_file
from geomhw.io.formats.decimal_numbers import parse_long

CORPUS = Path(__file__).resolve().parent.parent / "fuzz" / "corpus"
KINDS = ("off", "obj", "ply", "stl", "vtk", "vtp", "gii")


@pytest.mark.parametrize(
    "path", [pytest.param(path, id=path.name) for kind in KINDS for path in (CORPUS / kind).iterdir()]
)
def test_same_mesh_or_message(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each file of the fuzzer's corpus gives the same mesh or the same message."""
    outcomes = []
    for length in (0, 1 << 62):
        monkeypatch.setattr(number_parsing, "LONG", length)
        monkeypatch.setattr(text_file, "LONG", length)
        try:
            mesh = read(path).mesh
            outcomes.append((mesh.vertices.tobytes(), mesh.faces.tobytes()))
        except FormatError as error:
            outcomes.append((str(error),))
    assert outcomes[0] == outcomes[1]


def test_random_doubles() -> None:
    """Doubles of all exponents, and decimals of up to 19 digits near halfway between two, are nearest to the bit."""
    rng = np.random.default_rng(5)
    doubles = rng.integers(0, 2**64, 20000, np.uint64).view(np.float64)
    tokens = [repr(x) for x in doubles[np.isfinite(doubles) & (abs(doubles) > 1e-300)].tolist()]
    tokens += [f"{m}e{q}" for m, q in zip(rng.integers(2**53, 2**63, 20000), rng.integers(-40, 40, 20000), strict=True)]
    values = parse_long(" ".join(tokens).encode(), np.float64)
    assert values is not None
    assert values.tobytes() == np.array([float(token) for token in tokens]).tobytes()


@pytest.mark.parametrize("token", ["nan", "1e400", "5e-324", "12345678901234567890.5", "1e", "0x1"])
def test_tokens_for_the_other_parser(token: str) -> None:
    """Tokens that are no plain decimal, or beyond normal doubles or 19 digits, are left to numpy."""
    assert parse_long(f"1 {token} 2".encode(), np.float64) is None
