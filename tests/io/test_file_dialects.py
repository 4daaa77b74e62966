"""A unit square in many dialects of OFF, OBJ, PLY and STL gives the same distances."""

from pathlib import Path

import numpy as np
import pytest

from geomhw.io import read
from support.program import run
from support.squares import OBJ, OFF, PLY, SQUARE, STL

pytestmark = pytest.mark.usefixtures("folder")


#: File names, and contents that give a unit square.
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
    "dimension": ("m.off", OFF.replace("OFF\n", "nOFF # of\n3 # dimensions\n").encode()),
    "exponents": ("m.off", OFF.replace("1 1 0", "1.0E+0 .1e1 -0.").encode()),
}


@pytest.mark.parametrize("name", READ)
def test_read(name: str) -> None:
    """The distance between opposite corners is √2, in each dialect."""
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
