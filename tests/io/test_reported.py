"""Files of public bug reports and their relatives: each gives its mesh with its remark, or is refused in a sentence."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from geomhw.io import read
from geomhw.mesh import findings
from support.face_files import AREA, FACES, POINTS, WRITERS, check, obj, vtk
from support.messages import missing
from support.program import run
from support.reference import needs_reference, reference
from support.stl_files import facets

#: File of the reference folder: vertices, triangles, area, words of the remark (none: no remark), or of the refusal.
REPORTED: dict[str, tuple[int, int, float, str]] = {
    "01_stl_crack_1e-17.stl": (4, 2, 1.0, "joined 2 positions"),
    "03_obj_triangle_as_quad_with_repeated_corner.obj": (4, 4, 2.3660254, "4 repeated corners ... line 5"),
    "03_off_face_repeats_vertex.off": (4, 4, 2.3660254, "1 face ... line 11"),
    "03_ply_face_repeats_vertex.ply": (4, 4, 2.3660254, "1 face ... face 4"),
    "04_obj_concave_polygon_U.obj": (8, 6, 11.0, ""),
    "05_obj_polygon_collinear_corner.obj": (5, 3, 4.0, ""),
    "07_obj_backslash_ends_usemtl_and_group.obj": (4, 4, 2.3660254, ""),
    "08_ply_tristrips.ply": (4, 4, 2.3660254, ""),
    "09_off_quad_indices_on_own_lines.off": (4, 2, 1.0, ""),
    "10_off_NCOFF_as_meshlab_writes.off": (4, 4, 2.3660254, ""),
    "11_gmsh22_line_and_triangle_with_elementdata.msh": (4, 2, 1.0, "ElementData"),
    "13_vtk_string_array.vtk": (4, 4, 2.3660254, "array 'name' ... texts"),
    "14_vtk_numbers_on_keyword_line.vtk": (4, 4, 2.3660254, ""),
    "15_vtk_triangle_strips.vtk": (4, 4, 2.3660254, ""),
    "16_stl_upper_case.stl": (4, 4, 2.3660254, ""),
    "17_stl_leading_blank.stl": (4, 4, 2.3660254, ""),
    "18_stl_binary_one_trailing_byte.stl": (4, 4, 2.3660254, "1 byte"),
    "19_ply_binary_trailing_bytes.ply": (4, 4, 2.3660254, "1 byte"),
    "20_ply_more_numbers_on_line_than_declared.ply": (4, 4, 2.3660254, "8 numbers"),
    "21_obj_nul_after_end.obj": (4, 4, 2.3660254, "3 bytes"),
    "22_obj_face_of_two_corners.obj": (4, 4, 2.3660254, "1 face ... line 9"),
    "22_off_face_of_two_corners.off": (4, 4, 2.3660254, "1 face ... line 11"),
    "22_ply_face_of_no_corners.ply": (4, 4, 2.3660254, "1 face ... face 4"),
    "23_off_binary.off": (4, 4, 2.3660254, ""),
    "24_ply_unreferenced_nan_vertex.ply": (5, 4, 2.3660254, "vertex 4"),
    "25_vtp_lz4.vtp": (12, 20, 9.5745408, ""),
    "27_obj_two_coordinates.obj": (3, 1, 0.5, "z is 0"),
    "28_vtu_tetra_and_triangles.vtu": (4, 2, 1.0, "tetra"),
    "36_lzma_bomb.vtp": (0, 0, 0.0, "77594624 rows ... 3"),
}


@needs_reference
@pytest.mark.parametrize("name", REPORTED)
def test_reported(name: str) -> None:
    """Each reported file gives its values."""
    check(reference(f"meshes/reported/{name}"), *REPORTED[name])


U = ["0 0 0", "5 0 0", "5 4 0", "4 4 0", "4 1 0", "1 1 0", "1 4 0", "0 4 0"]
#: A square with a square hole, joined to the outline by a bridge.
FRAME = ["0 0 0", "4 0 0", "4 4 0", "0 4 0", "1 1 0", "1 3 0", "3 3 0", "3 1 0"]
#: Faces and points, and the number of vertices and triangles, area and remark.
SHAPES: dict[str, tuple[list[str], list[str], tuple[int, int, float, str]]] = {
    "repeated at the end": (POINTS, [*FACES[:3], "1 2 3 1"], (4, 4, AREA, "1 repeated corner")),
    "repeated at the start": (POINTS, ["0 0 2 1", *FACES[1:]], (4, 4, AREA, "1 repeated corner")),
    "repeated three times": (POINTS, [*FACES, "1 1 1"], (4, 4, AREA, "1 face")),
    "forth and back": (POINTS, [*FACES, "0 1 0 1"], (4, 4, AREA, "1 face")),
    "a spike": (POINTS, [*FACES[:3], "1 2 3 0 3"], (4, 4, AREA, "2 repeated corners")),
    "one corner": (POINTS, ["2", *FACES], (4, 4, AREA, "1 face ... the first")),
    "many": (POINTS, [*FACES, "0 1", "2 2 3", "1"], (4, 4, AREA, "3 faces")),
    "not a number": ([*POINTS, "nan 0 inf"], FACES, (5, 4, AREA, "vertex 4")),
    "not a number, first": (["nan 0 0", *POINTS], ["1 3 2", "1 2 4", "1 4 3", "2 3 4"], (5, 4, AREA, "vertex 0")),
    **{f"U from corner {i}": (U, [" ".join(str((i + k) % 8) for k in range(8))], (8, 6, 11.0, "")) for i in range(8)},
    "U clockwise": (U, ["3 2 1 0 7 6 5 4"], (8, 6, 11.0, "")),
    "arrow": (["0 0 0", "2 -2 0", "0 3 0", "-2 -2 0"], ["1 2 3 0"], (4, 2, 6.0, "")),
    "arrow, concave second": (["0 0 0", "2 -2 0", "0 3 0", "-2 -2 0"], ["3 0 1 2"], (4, 2, 6.0, "")),
    "bridged hole": (FRAME, ["0 1 2 3 0 4 5 6 7 4"], (8, 8, 12.0, "")),
    "bridged hole, turned": (FRAME, ["5 6 7 4 0 1 2 3 0 4"], (8, 8, 12.0, "")),
    "flat corners everywhere": (
        ["0 0 0", "1 0 0", "2 0 0", "2 1 0", "2 2 0", "1 2 0", "0 2 0", "0 1 0"],
        ["0 1 2 3 4 5 6 7"],
        (8, 6, 4.0, ""),
    ),
    "a triangle with flat corners": (
        ["0 0 0", "1 0 0", "2 0 0", "1 1 0", "0 2 0", "0 1 0"],
        ["1 2 3 4 5 0"],
        (6, 4, 2.0, ""),
    ),
    "folded quad": (["0 0 0", "1 0 0", "1 1 1", "0 1 0"], ["0 1 2 3"], (4, 2, 0.5 + 3**0.5 / 2, "")),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("end", ["\n", "\r\n"], ids=["LF", "CRLF"])
@pytest.mark.parametrize("kind", WRITERS)
def test_shapes_in_every_format(tmp_path: Path, kind: str, end: str, shape: str) -> None:
    """Repeated corners, faces of two corners, unused vertices and polygons give one mesh in OFF, OBJ, PLY and VTK."""
    points, faces, right = SHAPES[shape]
    path = tmp_path / f"m.{kind}"
    path.write_bytes(WRITERS[kind](points, faces).replace("\n", end).encode())
    check(path, *right)


@pytest.mark.parametrize("faces", [FACES, ["0 1", *FACES], [*FACES[:2], "0 3 3 2 2", FACES[3]], [*FACES, "0"]])
def test_arrays_follow_their_faces(tmp_path: Path, faces: list[str]) -> None:
    """Values on faces stay with their faces when others are left out."""
    path = tmp_path / "m.vtk"
    values = [10 * i for i in range(len(faces))]
    path.write_text(vtk(faces=faces, tail=f"CELL_DATA {len(faces)}\nSCALARS a int\n{' '.join(map(str, values))}\n"))
    kept = [value for face, value in zip(faces, values, strict=True) if len(set(face.split())) > 2]
    assert read(path)["a"].tolist() == kept


def test_convex_polygons_stay_fans(tmp_path: Path) -> None:
    """The triangles of a convex polygon are the fan around its first corner."""
    angles = np.arange(12) / 6 * np.pi
    path = tmp_path / "m.obj"
    path.write_text(
        obj(
            [f"{x!r} {y!r} 0" for x, y in zip(np.cos(angles).tolist(), np.sin(angles).tolist(), strict=True)],
            [" ".join(map(str, range(12)))],
        )
    )
    assert read(path).mesh.faces.tolist() == [[0, i, i + 1] for i in range(1, 11)]


def test_a_large_spiral(tmp_path: Path) -> None:
    """A spiral band of 10,000 corners keeps its area."""
    angle = np.linspace(0, 40 * np.pi, 5000)
    ring = [np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1) for r in (1 + angle, 0.7 + angle)]
    points = np.concatenate([ring[0], ring[1][::-1]])
    x, y = points.T
    area = abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))) / 2
    path = tmp_path / "m.obj"
    rows = [f"{a!r} {b!r} 0" for a, b in points.tolist()]
    path.write_text(obj(rows, [" ".join(map(str, range(10_000)))]))
    check(path, 10_000, 9_998, area, "")


def test_crossing_sides_are_named(tmp_path: Path) -> None:
    """A polygon whose sides cross is divided from its first corner, with a remark."""
    path = tmp_path / "m.obj"
    path.write_text(obj(["0 0 0", "1 1 0", "1 0 0", "0 1 0"], ["0 1 2 3"]))
    assert not missing(read(path).report["remarks"][0], "1 polygon ... crossing sides ... line 5")


@pytest.mark.parametrize(("lift", "joined"), [("1e-17", True), ("-3e-9", True), ("1e-7", True), ("1e-3", False)])
@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("size", [1.0, 1e-6, 1e6])
def test_cracks_of_rounding_are_closed(tmp_path: Path, lift: str, joined: bool, binary: bool, size: float) -> None:
    """Corners of STL within the rounding of the file are one vertex, at any size; wider cracks stay."""
    z = float(lift)
    corners = size * np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 0, z], [1, 1, 0], [0, 1, z]]])
    path = tmp_path / "m.stl"
    if binary:
        path.write_bytes(facets(*corners))
    else:
        rows = "".join(
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {x:.7g} {y:.7g} {w:.7g}\n" for x, y, w in corner)
            + "endloop\nendfacet\n"
            for corner in corners.tolist()
        )
        path.write_text(f"solid a\n{rows}endsolid\n")
    result = read(path)
    assert result.mesh.n_vertices == (4 if joined else 6)
    assert result.mesh.n_components == (1 if joined else 2)
    assert ("joined 2 positions" in " ".join(result.report.get("remarks", ()))) == joined


def test_vertices_nearly_in_one_place_are_found(tmp_path: Path) -> None:
    """``info --check`` names vertices nearly in one place in formats that are not welded."""
    path = tmp_path / "m.obj"
    path.write_text(obj(["0 0 0", "1 0 0", "0 1 0", "1 1e-9 0", "1 1 0", "-1e-9 1 0"], ["0 1 2", "3 4 5"]))
    found = {item.name: item.places.tolist() for item in findings(read(path).mesh)}
    assert found["nearly_coincident_vertices"] == [[3, 1], [5, 2]]
    answer = run("info", str(path), "--check")
    assert not missing(answer.stdout, "nearly ... 2 (3 of 1, 5 of 2)")


PROGRAM = "import re, sys; from geomhw.io import read\ntry: read(sys.argv[1])\nexcept Exception: pass\n"
PROGRAM += "print(re.search(r'VmHWM:\\s+(\\d+)', open('/proc/self/status').read())[1])"


@needs_reference
@pytest.mark.skipif(sys.platform != "linux", reason="memory of a process")
def test_a_bomb_takes_little_memory() -> None:
    """130 kB that unpack to gigabytes are refused before that."""
    path = reference("meshes/reported/36_lzma_bomb.vtp")
    answer = subprocess.run([sys.executable, "-c", PROGRAM, str(path)], capture_output=True, text=True, check=True)
    assert int(answer.stdout) < 150_000


@pytest.mark.skipif(sys.platform != "linux", reason="memory of a process")
def test_many_points_in_one_place_take_little_memory(tmp_path: Path) -> None:
    """100,000 different corners within the tolerance are joined in memory in proportion to the file."""
    chance = np.random.default_rng(5)
    soup = np.concatenate([1e-8 * chance.random((40_000, 3, 3)), np.tile(np.eye(3), (60_000, 1, 1))])
    path = tmp_path / "m.stl"
    path.write_bytes(facets(*soup.tolist()))
    answer = subprocess.run([sys.executable, "-c", PROGRAM, str(path)], capture_output=True, text=True, check=True)
    assert int(answer.stdout) < 400_000
