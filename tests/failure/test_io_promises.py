"""Headers that promise more than a file holds, and entries out of range, are refused with that reason."""

from pathlib import Path

import numpy as np
import pytest

from fuzz.targets import feed
from geomhw.io.artifacts.arrays import read_numpy
from geomhw.io.artifacts.checkpoints import write_checkpoint
from geomhw.mesh.primitives import icosphere
from support.messages import missing
from support.program import run, save_off

FOUND = Path(__file__).parents[1] / "fuzz" / "found"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("npy-a_terabyte", "137438953472 ... promised ... 128 bytes"),
        ("npz-a_terabyte", "137438953472 ... promised ... 128 bytes"),
        ("picture-81_million_pixels", "9000 x 9000 pixels ... 69 bytes"),
        ("mtx-an_entry_outside", "entry ... outside"),
        ("mtx-a_billion_entries", "3000000000 numbers ... promised"),
        ("vtp-offsets_that_wrap", "offsets ... do not ascend"),
        ("vtp-offsets_that_are_no_whole_numbers", "offsets ... not a list of whole numbers"),
        ("vtp-a_block_that_unpacks_to_more_than_it_says", "10 rows ... the file has 4"),
        ("vtp-a_document_type", "document type"),
        ("vtp-four_coordinates", "4 coordinates"),
        ("vtk-a_byte_of_300", "300 ... 1 bytes"),
    ],
)
def test_the_reason_is_named(name: str, words: str) -> None:
    """Each check raises before numpy or the system would."""
    assert not missing(feed(name.split("-")[0], (FOUND / name).read_bytes()) or "", words)


def test_objects_are_not_loaded(tmp_path: Path) -> None:
    """Arrays of Python objects are not loaded, since they could run code."""
    np.save(tmp_path / "a.npy", np.array([{}]), allow_pickle=True)
    with pytest.raises(ValueError, match="Python objects"):
        read_numpy((tmp_path / "a.npy").read_bytes())


def test_a_state_of_something_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A checkpoint that is no state of a fluid is refused."""
    monkeypatch.chdir(tmp_path)
    save_off(icosphere(1))
    write_checkpoint("other.npz", {"run": {}, "mesh": "x", "step": 1}, {"color": np.ones(3)})
    answer = run("fluid", "ball.off", "--restart", "other.npz")
    assert answer.exit_code == 1
    (line,) = answer.stderr.splitlines()
    assert not missing(line, "Error: other.npz ... no state of a fluid ... .restart.npz")
