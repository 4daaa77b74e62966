"""Damaged mesh files give one line with the file name and an exit code."""

from pathlib import Path

import pytest

from support.program import run
from support.squares import OBJ, OFF, PLY, SQUARE

pytestmark = pytest.mark.usefixtures("folder")


#: File name, contents, and a keyword of the line on stderr.
REFUSED: dict[str, tuple[str, bytes, str]] = {
    "empty": ("m.off", b"", "is an empty file"),
    "empty_obj": ("m.obj", b"", "is an empty file"),
    "blank": ("m.obj", b"\n\n  \n", "m.obj"),
    "magic_only": ("m.off", b"OFF\n", "m.off"),
    "header_only": ("m.off", b"OFF\n4 2 0\n", "m.off"),
    "ply_header_only": ("m.ply", PLY.split("0 0 0")[0].encode(), "m.ply"),
    "no_faces": ("m.off", f"OFF\n4 0 0\n{SQUARE}".encode(), "0 faces"),
    "no_faces_obj": ("m.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "m.obj"),
    "no_vertices": ("m.off", b"OFF\n0 1 0\n3 0 1 2\n", "m.off"),
    "beyond": ("m.off", OFF.replace("3 0 2 3", "3 0 2 4").encode(), "line 8"),
    "far_beyond": ("m.off", OFF.replace("3 0 2 3", "3 0 2 99999999999999999999").encode(), "m.off"),
    "negative": ("m.off", OFF.replace("3 0 2 3", "3 0 2 -1").encode(), "line 8"),
    "obj_zero": ("m.obj", OBJ.replace("f 1 3 4", "f 0 1 2").encode(), "line 6"),
    "obj_beyond": ("m.obj", OBJ.replace("f 1 3 4", "f 1 3 5").encode(), "line 6"),
    "twice": ("m.off", OFF.replace("3 0 2 3", "3 0 0 3").replace("3 0 1 2", "2 0 1").encode(), "line 7"),
    "nan": ("m.off", OFF.replace("1 1 0", "1 nan 0").encode(), "nan"),
    "inf": ("m.obj", OBJ.replace("1 1 0", "1 inf 0").encode(), "m.obj"),
    "overflow": ("m.off", OFF.replace("1 1 0", "1e999 1 0").encode(), "m.off"),
    "word": ("m.off", OFF.replace("1 1 0", "1 one 0").encode(), "one"),
    "cut_off": ("m.off", OFF[:30].encode(), "m.off"),
    "cut_ply": ("m.ply", PLY[:-8].encode(), "m.ply"),
    "counts_too_large": ("m.off", OFF.replace("4 2 0", "4000000000 2 0").encode(), "m.off"),
    "counts_negative": ("m.off", OFF.replace("4 2 0", "-4 2 0").encode(), "m.off"),
    "two_coordinates": ("m.obj", OBJ.replace("v 1 1 0", "v 1 1").encode(), "m.obj"),
    "binary_noise": ("m.off", bytes(range(256)) * 4, "m.off"),
    "other_format": ("m.off", OBJ.encode(), "m.off"),
    "unknown": ("m.step", b"ISO-10303-21;", "'.step'"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name: str) -> None:
    """One line on stderr with the file name, nothing on stdout, no file; exit code 2 with ``--check``."""
    file, contents, words = REFUSED[name]
    Path(file).write_bytes(contents)
    for arguments, code in ((["geodesic", file], 1), (["info", file], 1), (["info", file, "--check"], 2)):
        answer = run(*arguments)
        assert (answer.exit_code, answer.stdout) == (code, "")
        assert len(answer.stderr.splitlines()) == 1
        assert file in answer.stderr
        assert words in answer.stderr
    assert [path.name for path in Path().iterdir()] == [file]
