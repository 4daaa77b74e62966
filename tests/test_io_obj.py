"""OBJ files: dialects of one square, relative indices, and what is wrong with its line."""

from pathlib import Path

import numpy as np
import pytest
from conftest import needs_reference, reference

from geomhw.errors import FormatError
from geomhw.io import read, read_mesh
from geomhw.mesh.primitives import icosphere

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
V = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 .5\n"
T = "vt 0 0\nvt 1 1\nvn 0 0 1\n"

SAME = {
    "plain": V + "f 1 2 3\nf 1 3 4\n",
    "texture": V + T + "f 1/1 2/2 3/1\nf 1/1 3/1 4/2\n",
    "texture and normal": V + T + "f 1/1/1 2/2/1 3/1/1\nf 1/1/1 3/1/1 4/2/1\n",
    "normal": V + T + "f 1//1 2//1 3//1\nf 1//1 3//1 4//1\n",
    "mixed": V + T + "f 1 2/2 3//1\nf 1/1/1 3/ 4\n",
    "relative": V + "f -4 -3 -2\nf -4 -2 -1\n",
    "relative to the face's place": "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 .5\nf -4 -2 -1\n",
    "relative, with attributes": V + T + "f -4/-1/-1 -3/-2/-1 -2/-1/-1\nf -4/-1 -2 -1//-1\n",
    "faces first": "f 1 2 3\nf 1 3 4\n" + V,
    "weights and colors": V.replace(" 0\n", " 0 1.0\n", 1).replace(".5", ".5 255 0 0") + "f 1 2 3\nf 1 3 4\n",
    "continued lines": V.replace("1 1", "1 \\\n 1") + "f 1 \\\n2 \\\r\n3\nf\\\n 1 3 4\n",
    "objects, groups, materials": "mtllib a/b.mtl\no one\n" + V + "g x y\nusemtl s/7\ns off\nf 1 2 3\no two\nf 1 3 4\n",
    "points and lines": V + "p 1 2\nl 1 2 3\nf 1 2 3\nf 1 3 4\n",
    "comments": "# head\n" + V.replace("\n", " # tail\n") + "\n#\nf 1 2 3 # f 9 9 9\nf 1 3 4",
    "carriage returns": (V + "f 1 2 3\nf 1 3 4\n").replace("\n", "\r\n"),
    "indents": (V + "f 1 2 3\nf 1 3 4\n").replace("\n", "\n \t").replace(" 1", "\t 1"),
    "quad": V + "f 1 2 3 4\n",
}


def load(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "moo.obj"
    path.write_bytes(text.encode())
    return path


@pytest.mark.parametrize("dialect", SAME)
def test_dialects_give_the_same_mesh(tmp_path, dialect):
    result = read(load(tmp_path, SAME[dialect]))
    np.testing.assert_array_equal(result.mesh.vertices, SQUARE)
    np.testing.assert_array_equal(result.mesh.faces, [[0, 1, 2], [0, 2, 3]])
    quad = {"polygons": 1} if dialect == "quad" else {}
    assert result.report == {"file": "moo.obj", "format": "OBJ", **quad}


WRONG = {
    "": ["empty"],
    "f 1 2 3\n": ["no vertices"],
    V: ["no faces"],
    "v 0 0\n" + V + "f 1 2 3\n": ["line 1", "3 coordinates, not 2"],
    V + "v\nf 1 2 3\n": ["line 5", "3 coordinates, not 0"],
    V + "v 0 inf 0\nf 1 2 3\n": ["line 5", "not a finite number"],
    V + "v 0 zero 0\nf 1 2 3\n": ["line 5", "'zero' is not a number"],
    V + "v 1/2 0 0 0\nf 1 2 3\n": ["line 5", "'1/2' is not a number"],
    V + "f 1 2\n": ["line 5", "at least 3 corners, not 2"],
    V + "f\n": ["line 5", "at least 3 corners, not 0"],
    V + "f 1 2 3\nf 0 1 2\n": ["line 6", "vertex 0", "counts from 1"],
    V + "\r\nf 1 2 9\n": ["line 6", "vertex 9", "there are 4 (1 to 4)"],
    V + "f 1 2 -5\n": ["line 5", "vertex -5", "only 4 come before"],
    "v 0 0 0\nv 1 0 0\nf -3 -2 -1\nv 0 1 0\nv 0 0 1\nf 1 2 3\n": ["line 3", "vertex -3", "only 2 come before"],
    V + "f 1 2 2\n": ["line 5", "vertex 2 twice"],
    V + "f 1 2 -3\n": ["line 5", "vertex 2 twice"],
    V + "f 1 2 3 4 1\n": ["line 5", "vertex 1 twice"],
    V + "f 1 2 x/1\n": ["line 5", "'x/1' is not a number"],
    V + "f 1 /2 3\n": ["line 5", "'/2' is not a number"],
    V + "f 1/2 2/- 3\n": ["line 5", "'2/-' is not a number"],
    V + "f 1 2 2.5\n": ["line 5", "'2.5' is not a whole number"],
    V + "f 1 2 \\\n 3 \\\n x\n": ["line 7", "'x' is not a number"],
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_named_with_its_line(tmp_path, text):
    with pytest.raises(FormatError) as caught:
        read(load(tmp_path, text))
    for part in ["moo.obj", *WRONG[text]]:
        assert part in str(caught.value)


@needs_reference
@pytest.mark.parametrize(
    ("name", "n", "m"), [("hostile/stanford-bunny.obj", 35947, 69451), ("hostile/moebius.obj", 280, 448)]
)
def test_reference_meshes(name, n, m):
    mesh = read_mesh(reference(f"meshes/{name}"))
    assert (mesh.n_vertices, mesh.n_faces) == (n, m)


@pytest.mark.parametrize("corner", ["{0}", "{0}//{0}", "{0}/{0}/{0}"])
def test_many_faces_with_attributes(tmp_path, corner):
    """A sphere to the bit, whatever stands beside the vertex of a corner."""
    mesh = icosphere(2)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    lines += ["f " + " ".join(corner.format(i + 1) for i in face) for face in mesh.faces.tolist()]
    found = read(load(tmp_path, "\n".join(lines))).mesh
    assert found.vertices.tobytes() == mesh.vertices.tobytes()
    np.testing.assert_array_equal(found.faces, mesh.faces)
