"""Field files of every format, on a mesh of 4 vertices and 2 faces."""

from pathlib import Path

import numpy as np

from geomhw.io import write
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

#: A mesh of 4 vertices and 2 faces, and one of 3 vertices and 3 faces.
MESH = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
EVEN = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1, 2], [0, 2, 1], [1, 0, 2]])
U, W = np.array([0.5, 1, 2, 3]), np.array([[1.0, 2, 3], [4, 5, 6]])


def save_fields() -> None:
    """Write the fields U and W, and others, in every format to the working folder."""
    fields = [Field("u", "vertex", U), Field("w", "face", W), Field("a:b", "vertex", U + 1), Field("dt", "mesh", U)]
    for name in ["moo.vtp", "moo.vtu", "moo.vtk", "moo.ply"]:
        write(Result(MESH, fields), name)
    np.save("u.npy", U)
    np.savez("all.npz", u=U, w=W, flag=np.array([True, False]), half=np.arange(4, dtype=np.float16))
    rows = "\n".join(f"{a},{b},{c},{d}" for a, (b, c, d) in zip(U, np.arange(12).reshape(4, 3), strict=True))
    Path("t.csv").write_text(f'u,x, y ,"z"\n{rows}\n')
