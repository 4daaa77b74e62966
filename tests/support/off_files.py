"""OFF texts of one square in every dialect that is read."""

from pathlib import Path

import numpy as np

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
BODY = "0 0 0\n1 0 0\n1 1 0\n0 1 5e-1\n3 0 1 2\n3 0 2 3\n"

SAME = {
    "plain": "OFF\n4 2 0\n" + BODY,
    "no keyword": "4 2 0\n" + BODY,
    "lower case": "off\n4 2 0\n" + BODY,
    "counts behind the keyword": "OFF 4 2 0\n" + BODY,
    "counts glued to the keyword": "OFF4 2 0\n" + BODY,
    "two counts": "OFF\n4 2\n" + BODY,
    "comments and blank lines": "# a\nOFF # b\n\n4 2 0#c # d\n\n" + BODY.replace("\n", " # 7 8 9\n\n") + "# end",
    "carriage returns": ("OFF\n4 2 0\n" + BODY).replace("\n", "\r\n"),
    "old Macintosh": ("OFF\n4 2 0\n" + BODY).replace("\n", "\r"),
    "byte-order mark": "\ufeffOFF\n4 2 0\n" + BODY,
    "tabs and indents": ("OFF\n4 2 0\n" + BODY).replace(" ", "\t  ").replace("\n", "\n\t"),
    "no last newline": ("OFF\n4 2 0\n" + BODY).rstrip(),
    "colors on vertices": "COFF\n4 2 0\n" + BODY.replace("0\n1", "0 255 0 0 255\n1", 1),
    "extra numbers under OFF": "OFF\n4 2 0\n0 0 0 .1 .2\n1 0 0 9\n" + BODY[12:],
    "normals and texture": "STCNOFF\n4 2 0\n0 0 0 0 0 1 1 1 1 1 .5 .5\n" + BODY[6:],
    "colors on faces": "OFF\n4 2 0\n" + BODY.replace("3 0 1 2", "3 0 1 2 0.25 0.5 0.75"),
    "quad": "OFF\n4 1 0\n" + BODY[: BODY.index("3 0 1 2")] + "4 0 1 2 3\n",
}


def load(tmp_path: Path, text: str, name: str = "moo.off") -> Path:
    path = tmp_path / name
    path.write_bytes(text.encode())
    return path
