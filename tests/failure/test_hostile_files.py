"""Files that are not what they should be, or hardly: what each gives, as one line and an exit code, or as numbers."""

from pathlib import Path

import numpy as np
import pytest
from test_commands import in_empty_folder, run  # noqa: F401 - the fixture works on every test here

from geomhw.io import read

SQUARE = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
OFF = f"OFF\n4 2 0\n{SQUARE}3 0 1 2\n3 0 2 3\n"
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    f"element face 2\nproperty list uchar int vertex_indices\nend_header\n{SQUARE}3 0 1 2\n3 0 2 3\n"
)
STL = "solid s\n" + "".join(
    f"facet normal 0 0 1\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n"
    for a, b, c in (("0 0 0", "1 0 0", "1 1 0"), ("0 0 0", "1 1 0", "0 1 0"))
)
#: File name, contents, and what the one line on stderr says.
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
    "twice": ("m.off", OFF.replace("3 0 2 3", "3 0 0 3").encode(), "line 8"),
    "segment": ("m.off", OFF.replace("3 0 2 3", "2 0 2").encode(), "m.off"),
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
    "one_line": ("m.off", OFF.replace("\n", " ").encode(), "m.off"),
    "unknown": ("m.step", b"ISO-10303-21;", "'.step'"),
}
#: File name and contents that are a unit square.
READ: dict[str, tuple[str, bytes]] = {
    "off": ("m.off", OFF.encode()),
    "crlf": ("m.off", OFF.replace("\n", "\r\n").encode()),
    "crlf_obj": ("m.obj", OBJ.replace("\n", "\r\n").encode()),
    "bom": ("m.off", b"\xef\xbb\xbf" + OFF.encode()),
    "bom_obj": ("m.obj", b"\xef\xbb\xbf" + OBJ.encode()),
    "no_last_newline": ("m.off", OFF.rstrip().encode()),
    "comments": ("m.off", OFF.replace("OFF\n", "# of\nOFF # yes\n\n").replace("3 0 1", "# a face\n3 0 1").encode()),
    "quad": ("m.off", f"OFF\n4 1 0\n{SQUARE}4 0 1 2 3\n".encode()),
    "pentagon": ("m.off", f"OFF\n5 1 0\n0 0.5 0\n{SQUARE}5 0 1 2 3 4\n".encode()),
    "obj_from_behind": ("m.obj", OBJ.replace("f 1 3 4", "f -4 -2 -1").encode()),
    "obj_with_all": (
        "m.obj",
        ("mtllib x\no a\n" + OBJ.replace("f 1 3 4", "vt 0 0\nvn 0 0 1\nf 1/1/1 3//1 4/1")).encode(),
    ),
    "obj_face_first": ("m.obj", ("\n".join(reversed(OBJ.split("\n")[:4])) + "\nf 4 3 2\nf 4 2 1\n").encode()),
    "ply": ("m.ply", PLY.encode()),
    "ply_crlf": ("m.ply", PLY.replace("\n", "\r\n").encode()),
    "stl": ("m.stl", STL.encode()),
    "colors": ("m.off", ("COFF\n4 2 0\n" + SQUARE.replace("\n", " 255 0 0 255\n") + "3 0 1 2\n3 0 2 3\n").encode()),
    "exponents": ("m.off", OFF.replace("1 1 0", "1.0E+0 .1e1 -0.").encode()),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name: str) -> None:
    """One line on stderr with the file's name, nothing on stdout, no file written; from --check exit code 2."""
    file, contents, words = REFUSED[name]
    Path(file).write_bytes(contents)
    for arguments, code in ((["geodesic", file], 1), (["info", file], 1), (["info", file, "--check"], 2)):
        answer = run(*arguments)
        assert (answer.exit_code, answer.stdout) == (code, "")
        assert len(answer.stderr.splitlines()) == 1
        assert file in answer.stderr
        assert words in answer.stderr
    assert [path.name for path in Path().iterdir()] == [file]


@pytest.mark.parametrize("name", READ)
def test_read(name: str) -> None:
    """The square is the square, however it is written: from corner (1, 1) to (0, 0) it is √2."""
    file, contents = READ[name]
    Path(file).write_bytes(contents)
    answer = run("geodesic", file, "--refine", "-o", "out.vtu")
    assert (answer.exit_code, answer.stderr) == (0, "")
    mesh, distance = (result := read("out.vtu")).mesh, np.asarray(result["distance"])
    assert mesh.face_areas.sum() == pytest.approx(1, rel=1e-7)
    source = int(np.flatnonzero(distance == 0)[0])
    straight = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    assert distance.max() == pytest.approx(2**0.5, rel=1e-7)
    np.testing.assert_allclose(distance, straight, rtol=1e-7)
    assert run("info", file, "--check", "-q").exit_code == 0
