"""Numbers out of text: what ``float`` says of each, to the bit; and memory in proportion to the text."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from geomhw.errors import FormatError
from geomhw.io import read, write
from geomhw.io.formats.number_parsing import parse_numbers
from geomhw.io.formats.text_file import TextFile
from geomhw.mesh.primitives import icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

DIGITS = st.text("0123456789", min_size=1, max_size=25)
#: As people and programs write them: ``-0.5``, ``7``, ``12.``, ``.25``, ``1e-5``, twenty digits and more.
WRITTEN = st.builds(
    lambda sign, whole, rest, power: f"{sign}{whole}{rest}{power}",
    st.sampled_from(["", "", "-", "+"]),
    DIGITS,
    st.just("") | st.builds(lambda digits: f".{digits}", st.just("") | DIGITS),
    st.sampled_from(["", "", "", "", "", "", "", "", "", "e5", "E-12", "e+300", "e-320"]),
)
FLOATS = st.floats(allow_nan=False, allow_infinity=False).map(repr)
FIXED = st.builds(lambda x, places: f"{x:.{places}f}", st.floats(-1e6, 1e6), st.integers(0, 24))


def bits(tokens: list[str]) -> bytes:
    return np.array([float(token) for token in tokens]).tobytes()


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


def as_text(mesh: TriangleMesh, form: str) -> str:
    """A mesh in a text format, all digits."""
    points = [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
    faces = mesh.faces.tolist()
    n, m = mesh.n_vertices, mesh.n_faces
    if form == "off":
        return "\n".join([f"OFF\n{n} {m} 0", *points, *(f"3 {a} {b} {c}" for a, b, c in faces)])
    if form == "obj":
        return "\n".join([f"v {point}" for point in points] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces])
    if form == "attributes":
        lines = [f"v {point}\nvt 0 0\nvn {point}" for point in points]
        return "\n".join(lines + ["f " + " ".join(f"{i + 1}/{i + 1}/{i + 1}" for i in face) for face in faces])
    head = ["ply", "format ascii 1.0", f"element vertex {n}", *(f"property double {axis}" for axis in "xyz")]
    head += [f"element face {m}", "property list uchar int vertex_indices", "end_header"]
    return "\n".join([*head, *points, *(f"3 {a} {b} {c}" for a, b, c in faces)])


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
