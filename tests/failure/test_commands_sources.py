"""``--source`` refuses wrong specs, files and indices."""

import subprocess
import sys
from pathlib import Path

import pytest
from click import UsageError

from geomhw.errors import FieldError, FormatError
from geomhw.mesh.primitives import grid, icosphere
from geomhw_cli.specs.sources import SourceSpecs
from support.messages import missing
from support.program import run, save_off

BALL, SHEET = icosphere(2), grid(6, 6)


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a ball and a sheet in it."""
    save_off(BALL, "ball.off")
    save_off(SHEET, "sheet.off")
    return folder


@pytest.mark.parametrize(
    "text",
    [
        "",
        "top",
        "1.5",
        "1,,2",
        "face:",
        "face:1:0.5,0.5",
        "face:1:0.2,0.3,0.4,0.1",
        "near:0,1",
        "near:nan,0,0",
        "max-w",
        "12-",
        "boundary2",
        "12,@f.txt",
    ],
)
def test_no_source(text: str) -> None:
    """Text that is no source is refused before the mesh is read."""
    with pytest.raises(UsageError, match="is no source; give"):
        SourceSpecs.parse([text])


def test_range_runs_forward() -> None:
    """A range from larger to smaller is refused."""
    with pytest.raises(UsageError, match="'44-40' runs backward"):
        SourceSpecs.parse(["44-40"])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "no such file"),
        (b"", "empty file"),
        (b"# nothing\n\n", "nothing but blank lines"),
        (b"1\n2 # two\n\n3 three\n", "line 4 ... 'three'"),
        (b"1\n@other.txt\n", "line 2 ... '@other.txt' is no source"),
        (b"1\n9-3\n", "line 2 ... '9-3' ... backward"),
        (b"\xff\xfe1\n", "UTF-16 ... UTF-8"),
        (b"\xff1\n", "not a text file"),
    ],
)
def test_bad_file(content: bytes | None, words: str) -> None:
    """The message names the file and the line."""
    if content is not None:
        Path("s.txt").write_bytes(content)
    with pytest.raises(FormatError) as caught:
        SourceSpecs.parse(["@s.txt"])
    assert not missing(str(caught.value), f"s.txt ... {words}")


@pytest.mark.parametrize("command", ["geodesic", "vecdiffuse"])
@pytest.mark.parametrize(
    ("mesh", "arguments", "code", "words"),
    [
        ("ball.off", ["boundary"], 2, "the mesh has no boundary"),
        ("ball.off", ["162"], 2, "source 162 is not a vertex ... 0 to 161"),
        ("ball.off", ["3-99999999999999"], 2, "source 99999999999999 is not a vertex"),
        ("ball.off", ["face:320"], 2, "face 320 ... 320 faces ... 0 to 319"),
        ("ball.off", ["face:1:0.5,0.6,-0.1"], 2, "none may be negative"),
        ("ball.off", ["face:1:0.5,0.6,0.1"], 2, "sum to 1.2"),
        ("ball.off", ["@far.txt"], 1, "far.txt, line 3 ... source 900"),
        ("ball.off", ["@none.txt"], 1, "none.txt ... no such file"),
        ("ball.off", ["3;4"], 2, "'3;4' is no source"),
    ],
)
def test_refused(command: str, mesh: str, arguments: list[str], code: int, words: str, folder: Path) -> None:
    """Each wrong source gives one line and the right exit code, and no file is written."""
    Path("far.txt").write_text("1\n\n900 # far\n")
    before = sorted(path.name for path in folder.iterdir())
    answer = run(command, mesh, "--source", *arguments)
    assert answer.exit_code == code
    assert answer.stdout == ""
    assert not missing(answer.stderr.strip().splitlines()[-1], words)
    assert code == 2 or len(answer.stderr.strip().splitlines()) == 1
    assert sorted(path.name for path in folder.iterdir()) == before


PEAK = """
import tracemalloc
from geomhw.mesh.primitives import grid
from geomhw_cli.specs.sources import SourceSpecs

mesh = grid(330, 330)
SourceSpecs.parse(["@one.txt"]).resolve(mesh).distinct()  # loads modules
tracemalloc.start()
points = SourceSpecs.parse(["@many.txt"]).resolve(mesh)
first, group = points.distinct()
peak = tracemalloc.get_traced_memory()[1]
assert len(first) == 5_000
assert (points.vertices[first][group] == points.vertices).all()
print(peak)
"""


@pytest.mark.parametrize("separator", ["\n", " ", ","])
def test_many_vertices(separator: str, folder: Path) -> None:
    """A list of vertices takes at most 20 bytes of memory a byte; measured in a process without other threads."""
    text = separator.join(str(100_000 + k % 5_000) for k in range(200_000))
    Path("many.txt").write_text(text)
    Path("one.txt").write_text("1")
    done = subprocess.run([sys.executable, "-c", PEAK], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 20 * len(text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1\n2,3 4\nface:1\n5\n900", "line 5: source 900 is not a vertex"),
        ("1\n2,3 4 900 5\n-7", "line 2: source 900 is not a vertex"),
        ("900\n", "line 1: source 900 is not a vertex"),
        ("1\n-7", "line 2: source -7 is not a vertex"),
        ("1\n1,,2", "line 2: ',2' is no source"),
        ("1\n,2", "line 2: ',2' is no source"),
        ("1\n1234567890123456789", "line 2: '1234567890123456789' is no source"),
    ],
)
def test_line_of_a_wrong_source(text: str, words: str, folder: Path) -> None:
    """A message on a file names the line of the first wrong source."""
    Path("some.txt").write_text(text)
    with pytest.raises((FormatError, FieldError), match=words):
        SourceSpecs.parse(["@some.txt"]).resolve(SHEET)
