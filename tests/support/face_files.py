"""A tetrahedron or other faces as text in OFF, OBJ, PLY and VTK, a square as STL, and a check of a file."""

from pathlib import Path

import pytest

from geomhw.errors import GeomhwError
from geomhw.io import read
from support.messages import missing

POINTS = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"]
FACES = ["0 2 1", "0 1 3", "0 3 2", "1 2 3"]
AREA = 2.3660254037844386


def off(points: list[str] = POINTS, faces: list[str] = FACES, head: str = "OFF", tail: str = "") -> str:
    rows = [head, f"{len(points)} {len(faces)} 0", *points, *(f"{len(face.split())} {face}" for face in faces)]
    return "\n".join(rows) + "\n" + tail


def obj(points: list[str] = POINTS, faces: list[str] = FACES, head: str = "", tail: str = "") -> str:
    rows = [*(f"v {point}" for point in points)]
    rows += ["f " + " ".join(str(int(i) + 1) for i in face.split()) for face in faces]
    return head + "\n".join(rows) + "\n" + tail


def ply(points: list[str] = POINTS, faces: list[str] = FACES, tail: str = "") -> str:
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}", *(f"property float {x}" for x in "xyz")]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    return "\n".join([*head, *points, *(f"{len(face.split())} {face}" for face in faces)]) + "\n" + tail


def vtk(points: list[str] = POINTS, faces: list[str] = FACES, tail: str = "") -> str:
    rows = ["# vtk DataFile Version 3.0", "t", "ASCII", "DATASET POLYDATA", f"POINTS {len(points)} float", *points]
    rows += [f"POLYGONS {len(faces)} {len(faces) + sum(len(face.split()) for face in faces)}"]
    return "\n".join([*rows, *(f"{len(face.split())} {face}" for face in faces)]) + "\n" + tail


WRITERS = {"off": off, "obj": obj, "ply": ply, "vtk": vtk}


def stl(lift: str = "0", text: str = "") -> str:
    """Two facets of a unit square with a crack of some width along their common side."""
    facet = "facet normal 0 0 1\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n"
    body = facet.format("0 0 0", "1 0 0", "0 1 0") + facet.format(f"1 0 {lift}", "1 1 0", f"0 1 {lift}")
    return text or f"solid a\n{body}endsolid a\n"


def check(path: Path, vertices: int, triangles: int, area: float, words: str) -> None:
    """Compare a file with its right values."""
    if not vertices:
        with pytest.raises(GeomhwError) as caught:
            read(path)
        assert not missing(str(caught.value), f"{path.name} ... {words}")
        return
    result = read(path)
    assert (result.mesh.n_vertices, result.mesh.n_faces) == (vertices, triangles)
    assert result.mesh.face_areas.sum() == pytest.approx(area, rel=1e-6)
    assert not len(result.mesh.degenerate_faces)
    remarks = " ".join(result.report.get("remarks", ()))
    assert not missing(remarks, words) if words else remarks == ""
