"""Hypothesis strategies for decimal numbers as text, and meshes in text formats."""

import numpy as np
from hypothesis import strategies as st

from geomhw.mesh.triangle_mesh import TriangleMesh

DIGITS = st.text("0123456789", min_size=1, max_size=25)
#: Usual spellings: ``-0.5``, ``7``, ``12.``, ``.25``, ``1e-5``, and more than twenty digits.
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


def as_text(mesh: TriangleMesh, form: str) -> str:
    """Return a mesh in a text format, with all digits."""
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
