"""OBJ texts of one square in every dialect that is read."""

from pathlib import Path

import numpy as np

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
