"""Numbers out of text: what ``float`` says of each, to the bit; and memory in proportion to the text."""

import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from geomhw.errors import FormatError
from geomhw.io import read, write
from geomhw.io.formats import decimal_numbers, number_parsing, text_file
from geomhw.io.formats.number_parsing import parse_numbers
from geomhw.io.formats.text_file import TextFile
from geomhw.mesh.primitives import icosphere
from geomhw.results import Field, Result
from support.number_texts import FIXED, FLOATS, WRITTEN, as_text, bits


@pytest.fixture(scope="module", params=["numpy", "compiled"], autouse=True)
def parser(request: pytest.FixtureRequest) -> Iterator[None]:
    """Both parsers: the compiled one, which is for long texts, for all."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "compiled":
            decimal_numbers.parse_long(b"1 0.5", np.float64)  # loaded before memory is measured
            decimal_numbers.parse_long(b"1 2", np.int64)
            decimal_numbers.token_lines(np.frombuffer(b"1 2\n", np.uint8))
            patch.setattr(number_parsing, "LONG", 0)
            patch.setattr(text_file, "LONG", 0)
        yield


@settings(max_examples=300, deadline=None)
@given(st.lists(WRITTEN | FLOATS | FIXED, min_size=1, max_size=40))
@example(["-0.0", "-0", "0.000"])
@example(["4503599627370497.5", "4503599627370496.5", "9007199254740993.0", "9007199254740995", "-2251799813685249.25"])
@example(["9223372036854775807", "9223372036854775808.5", "-9223372036854775808", "1." + "3" * 30, "1e999"])
@example(["0." + "0" * 22 + "123", "0." + "0" * 30 + "7"])
@example([".5", "-.5", "5.", "nan", "-inf", "1e5", "12"])
@example(["9223372036854775807", "-1"])
@example(["9223372036854775808", "1"])
@example(["1000000000000000001", "9007199254740993"])
def test_every_number_is_the_nearest_double(tokens: list[str]) -> None:
    """Also halfway between two doubles, where the even one is meant."""
    values = parse_numbers(" \n".join(tokens).encode(), np.float64)
    assert values is not None
    expected = np.array([float(token) for token in tokens])
    assert values[~np.isnan(expected)].tobytes() == expected[~np.isnan(expected)].tobytes()
    assert np.isnan(values[np.isnan(expected)]).all()


def test_ties_round_to_even() -> None:
    """Odd multiples of a quarter of a unit in the last place: the hardest decimals to round, by the thousand."""
    odd = 2**53 + 1 + 2 * np.arange(1000)
    tokens = [f"{m // 4}.{m % 4 * 25:02d}" for m in odd.tolist()]
    assert parse_numbers(" ".join(tokens).encode(), np.float64).tobytes() == bits(tokens)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "token", ["1_0", "2-3", "1.2.3", ".-5", "1.-5", ".+5", "0x10", "1e", "e5", "1e5.0", "1e_5", "1_0e5", "one", "\x015"]
)
def test_what_is_no_number(token: str) -> None:
    """Alone and among numbers that make up for it."""
    many = " 1.25" * 20
    for text in (token, f"0.5 {token} 0.25", f"0.5 {token} - 2", f"7 {token}", f"{many} {token}{many}"):
        assert parse_numbers(text.encode(), np.float64) is None
    assert parse_numbers(f"7 {token} 8".encode(), np.int64) is None


@pytest.mark.parametrize("text", ["- 2", "1 + 2", "1 -\n2", "7 -", "7 --", "-"])
def test_a_sign_alone_is_no_number(text: str) -> None:
    """C's integer parser would read a sign, a gap and digits as one number."""
    assert parse_numbers(text.encode(), np.int64) is None
    assert parse_numbers(text.encode(), np.float64) is None


@pytest.mark.parametrize("token", [".", "-", "+", "-.", "1_0", "2-3", "1.2.3", ".-5"])
def test_a_line_with_one_is_named(token: str) -> None:
    """Far into a file, past the batches that parse."""
    text = "0.5 0.25 1\n" * 20000 + f"1 {token} 2\n"
    lines = TextFile("m.off", text.encode())
    with pytest.raises(FormatError, match=r"line 20001: '.*' is not a number"):
        lines.numbers(np.arange(20001))


@pytest.mark.parametrize("form", ["off", "obj", "attributes", "ply"])
def test_text_takes_six_times_its_size_at_most(tmp_path: Path, form: str) -> None:
    """A sphere of 40962 vertices, read to the bit; the text itself is one of the six."""
    mesh = icosphere(6)
    path = tmp_path / f"ball.{'obj' if form == 'attributes' else form}"
    path.write_text(as_text(mesh, form))
    tracemalloc.start()
    found = read(path).mesh
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.vertices.tobytes() == mesh.vertices.tobytes()
    np.testing.assert_array_equal(found.faces, mesh.faces)
    assert peak < 6 * path.stat().st_size


@pytest.mark.parametrize("form", ["vtk", "vtp", "vtu", "ply"])
def test_writing_takes_little_memory(tmp_path: Path, form: str) -> None:
    """Less than half of what is written, piece by piece, and all of it is there."""
    mesh = icosphere(6)
    path = tmp_path / f"ball.{form}"
    fields = [Field("u", "vertex", mesh.vertices[:, 0].copy()), Field("v", "face", mesh.face_normals)]
    result = Result(mesh, fields)
    write(result, path)  # what is loaded once counts no more
    tracemalloc.start()
    write(result, path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < path.stat().st_size / 2
    found = read(path)
    for ours, theirs in ((found.mesh.vertices, mesh.vertices), (found["u"], result["u"]), (found["v"], result["v"])):
        assert ours.tobytes() == theirs.tobytes()
    np.testing.assert_array_equal(found.mesh.faces, mesh.faces)
