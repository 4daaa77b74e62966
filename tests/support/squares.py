"""Texts of a unit square in OFF, OBJ, PLY and STL."""

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
