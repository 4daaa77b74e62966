"""Headers that promise more than a file holds, and entries that lie outside: refused for that reason, by name."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from fuzz.targets import feed
from test_commands import run, save_off

from geomhw.io import read_numpy, write_checkpoint
from geomhw.io.artifacts.matrix_market import read_matrix_market
from geomhw.mesh.primitives import icosphere

FOUND = Path(__file__).parent / "fuzz" / "found"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("npy-a_terabyte", "an array of 137438953472 is promised, but there are 128 bytes"),
        ("npz-a_terabyte", "an array of 137438953472 is promised, but there are 128 bytes"),
        ("picture-81_million_pixels", "9000 x 9000 pixels do not fit into 69 bytes"),
        ("mtx-an_entry_outside", "an entry lies outside of the matrix"),
        ("mtx-a_billion_entries", "3000000000 numbers are promised"),
        ("vtp-offsets_that_wrap", "the offsets of the cells do not ascend"),
        ("vtp-offsets_that_are_no_whole_numbers", "the offsets of the cells are not a list of whole numbers"),
        ("vtp-a_block_that_unpacks_to_more_than_it_says", "a compressed block does not hold the 120 bytes"),
        ("vtp-a_document_type", "it has a document type"),
        ("vtp-four_coordinates", "has points of 4 coordinates"),
        ("vtk-a_byte_of_300", "300 is not an integer of 1 bytes"),
    ],
)
def test_the_reason_is_named(name: str, words: str) -> None:
    """Each check says its own sentence, before numpy or the system says another."""
    assert words in (feed(name.split("-")[0], (FOUND / name).read_bytes()) or "")


@pytest.mark.parametrize("packing", [np.savez, np.savez_compressed])
def test_arrays_of_numpy(tmp_path: Path, packing: object) -> None:
    """By rows and by columns, of any number type, of no entries, packed or not."""
    made = {
        "u": np.arange(6.0).reshape(2, 3),
        "by columns": np.asfortranarray(np.arange(6, dtype=">i4").reshape(2, 3)),
        "none": np.empty((0, 3)),
        "one": np.array(7.0),
        "zeros": np.zeros(100_000),
    }
    packing(tmp_path / "a.npz", **made)  # type: ignore[operator]
    found = read_numpy((tmp_path / "a.npz").read_bytes())
    assert isinstance(found, dict)
    assert found.keys() == made.keys()
    for name, array in made.items():
        assert found[name].dtype == array.dtype
        np.testing.assert_array_equal(found[name], array)


def test_objects_are_not_loaded(tmp_path: Path) -> None:
    """An array of Python objects could run a program."""
    np.save(tmp_path / "a.npy", np.array([{}]), allow_pickle=True)
    with pytest.raises(ValueError, match="Python objects"):
        read_numpy((tmp_path / "a.npy").read_bytes())


@pytest.mark.parametrize(
    ("field", "symmetry"),
    [
        *product(["real", "integer", "complex"], ["general", "symmetric", "skew-symmetric"]),
        ("complex", "hermitian"),
        *product(["pattern"], ["general", "symmetric"]),  # which has no sign
    ],
)
def test_market_as_scipy_reads_it(tmp_path: Path, field: str, symmetry: str) -> None:
    """Every kind of Matrix Market file, beside scipy's reader."""
    values = {"real": "0.5 -1e-3 7", "integer": "5 -1 7", "complex": "1;2 0;-1 3;0", "pattern": ". . ."}[field].split()
    places = ["2 1", "3 1", "3 2"] if symmetry == "skew-symmetric" else ["1 1", "2 1", "3 2"]
    if field == "complex" and symmetry == "hermitian":
        values[0] = "1;0"
    rows = [f"{place} {value.replace(';', ' ').strip('.')}\n" for place, value in zip(places, values, strict=True)]
    text = f"%%MatrixMarket matrix coordinate {field} {symmetry}\n% a comment\n\n3 3 3\n{''.join(rows)}"
    (tmp_path / "a.mtx").write_text(text)
    np.testing.assert_array_equal(
        read_matrix_market(text.encode()).toarray(), sp.coo_array(scipy.io.mmread(tmp_path / "a.mtx")).toarray()
    )


def test_market_with_all_entries(tmp_path: Path) -> None:
    """Column by column."""
    made = np.arange(6.0).reshape(2, 3) / 7
    scipy.io.mmwrite(tmp_path / "a.mtx", made, precision=17)
    np.testing.assert_array_equal(read_matrix_market((tmp_path / "a.mtx").read_bytes()), made)


def test_a_state_of_something_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Written as a state is, but not of a fluid."""
    monkeypatch.chdir(tmp_path)
    save_off(icosphere(1))
    write_checkpoint("other.npz", {"run": {}, "mesh": "x", "step": 1}, {"color": np.ones(3)})
    answer = run("fluid", "ball.off", "--restart", "other.npz")
    assert answer.exit_code == 1
    assert answer.stderr == ("Error: other.npz holds no state of a fluid; give the .restart.npz of an earlier run\n")
