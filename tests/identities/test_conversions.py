"""Meshes and results to and from pyvista and meshio: exact round trips, and what is refused."""

from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista

from geomhw.errors import MeshError
from geomhw.mesh.primitives import grid, icosphere
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Cloud, Field, Result
from support.pictures import needs_opengl

RNG = np.random.default_rng(5)


def with_fields(mesh: TriangleMesh) -> Result:
    """Fields of each location, shape and type."""
    n, m = mesh.n_vertices, mesh.n_faces
    fields = [
        Field("heat", "vertex", RNG.normal(size=n) * 1e-200),
        Field("color", "vertex", RNG.integers(0, 255, (n, 3)).astype(np.uint8)),
        Field("id", "vertex", np.arange(n) + 2**40),
        Field("velocity", "face", RNG.normal(size=(m, 3))),
        Field("label", "face", np.arange(m, dtype=np.int32)),
        Field("time", "mesh", np.float64(0.125)),
        Field("dt", "mesh", RNG.normal(size=4)),
    ]
    return Result(mesh, fields, {"farthest": {"vertex": 1234567, "distance": 1 / 3}, "refined": True, "name": "x"})


def same_mesh(one: TriangleMesh, other: TriangleMesh) -> None:
    np.testing.assert_array_equal(one.vertices, other.vertices, strict=True)
    np.testing.assert_array_equal(one.faces, other.faces, strict=True)


def test_arrays(mesh: TriangleMesh) -> None:
    same_mesh(TriangleMesh.from_arrays(mesh.vertices, mesh.faces), mesh)


def test_pyvista_and_back(mesh: TriangleMesh) -> None:
    """Vertices, faces and all fields, to the last bit and with their types."""
    result = with_fields(mesh)
    surface = result.to_pyvista()
    same_mesh(TriangleMesh.from_pyvista(surface), mesh)
    places = {"vertex": surface.point_data, "face": surface.cell_data, "mesh": surface.field_data}
    for field in result.fields:
        np.testing.assert_array_equal(
            np.asarray(places[field.location][field.name]), np.atleast_1d(field.values), strict=True
        )
    assert sum(map(len, places.values())) == len(result.fields)


def test_meshio_and_back(mesh: TriangleMesh) -> None:
    """Vertices, faces and all fields, to the last bit and with their types."""
    result = with_fields(mesh)
    converted = result.to_meshio()
    same_mesh(TriangleMesh.from_meshio(converted), mesh)
    for field in result.fields:
        place = {"vertex": converted.point_data, "mesh": converted.field_data}.get(field.location, {})
        found = converted.cell_data[field.name][0] if field.location == "face" else place[field.name]
        np.testing.assert_array_equal(found, field.values, strict=True)


def test_through_files(tmp_path: Path) -> None:
    """Files that pyvista and meshio write of a result hold the same mesh and fields."""
    result = with_fields(icosphere(1))
    result.to_pyvista().save(tmp_path / "m.vtp")
    read = pyvista.read(tmp_path / "m.vtp")
    same_mesh(TriangleMesh.from_pyvista(read), result.mesh)
    np.testing.assert_array_equal(np.asarray(read.cell_data["velocity"]), result["velocity"])
    result.to_meshio().write(tmp_path / "m.vtu")
    again = meshio.read(tmp_path / "m.vtu")
    same_mesh(TriangleMesh.from_meshio(again), result.mesh)
    np.testing.assert_array_equal(again.point_data["heat"], result["heat"])


def test_nothing_is_shared() -> None:
    """Changing what was converted changes neither the mesh nor the fields; arrays of a mesh are its own."""
    result = with_fields(grid(2, 2))
    before = result.mesh.vertices.copy(), np.array(result["heat"])
    surface, converted = result.to_pyvista(), result.to_meshio()
    mesh = TriangleMesh.from_pyvista(surface)
    surface.points[:] = 7
    surface.point_data["heat"][:] = 7
    converted.points[:] = 7
    converted.point_data["heat"][:] = 7
    for one in (result.mesh, mesh):
        np.testing.assert_array_equal(one.vertices, before[0])
    np.testing.assert_array_equal(result["heat"], before[1])


def test_single_precision_and_flat_points() -> None:
    """Single precision becomes double, unchanged; two coordinates get z = 0; blocks of triangles are joined."""
    sphere = pyvista.Sphere(theta_resolution=8, phi_resolution=6)
    assert sphere.points.dtype == np.float32
    np.testing.assert_array_equal(TriangleMesh.from_pyvista(sphere).vertices, sphere.points.astype(float))
    points = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    blocks = [("vertex", [[0]]), ("triangle", [[0, 1, 2]]), ("line", [[0, 1]]), ("triangle", [[0, 2, 3]])]
    mesh = TriangleMesh.from_meshio(meshio.Mesh(points, blocks))
    np.testing.assert_array_equal(mesh.vertices, np.pad(points, ((0, 0), (0, 1))))
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]])


@pytest.mark.parametrize(
    "dataset",
    [
        pyvista.Plane(i_resolution=2, j_resolution=2),
        pyvista.PolyData(POINTS, faces=[3, 0, 1, 2, 4, 0, 1, 2, 3]),
        pyvista.PolyData(POINTS, faces=[3, 0, 1, 2], lines=[2, 3, 4]),
        pyvista.PolyData(POINTS, faces=[3, 0, 1, 2], verts=[1, 4]),
        pyvista.PolyData(POINTS, faces=[3, 0, 1, 4], strips=[4, 0, 1, 3, 2]),
        pyvista.PolyData(POINTS, strips=[4, 0, 1, 3, 2]),
        pyvista.PolyData(POINTS),
        pyvista.Sphere().cast_to_unstructured_grid(),
    ],
    ids=["quads", "mixed", "lines", "vertices", "strips", "strips_only", "points", "grid"],
)
def test_pyvista_refusals(dataset: pyvista.DataSet) -> None:
    """Whatever is no surface of triangles only; the error says what to call."""
    with pytest.raises(MeshError, match=r"triangles only; .*triangulate\(\)"):
        TriangleMesh.from_pyvista(dataset)


def test_the_remedy_works() -> None:
    """What the error names turns a plane of quads into a mesh."""
    plane = pyvista.Plane(i_resolution=2, j_resolution=2)
    assert TriangleMesh.from_pyvista(plane.triangulate()).n_faces == 8


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ([("quad", [[0, 1, 2, 3]]), ("triangle", [[0, 1, 4]])], "cells of type quad;"),
        ([("tetra", [[0, 1, 2, 4]]), ("triangle6", [[0, 1, 2, 3, 4, 0]])], "cells of type tetra, triangle6;"),
        ([("line", [[0, 1]])], "no faces"),
        ([], "no faces"),
    ],
)
def test_meshio_refusals(cells: list, words: str) -> None:
    """Cells other than triangles, lines and vertices are named; without triangles there is no mesh."""
    with pytest.raises(MeshError, match=words):
        TriangleMesh.from_meshio(meshio.Mesh(POINTS, cells))


def test_results_print_themselves() -> None:
    """The size of the mesh, each field with its location and shape, each number of the report; no arrays."""
    lines = str(with_fields(grid(3, 2))).splitlines()
    assert lines[0] == "Result on TriangleMesh(12 vertices, 12 faces)"
    assert "  velocity: per face, shape (12, 3)" in lines
    assert "  time: per mesh, shape ()" in lines
    assert lines[-2:] == ["  farthest.vertex = 1234567", "  farthest.distance = 0.333333"]
    cloud = Cloud(np.zeros((2, 3)), [Field("age", "vertex", np.zeros(2))])
    assert repr(cloud).splitlines() == ["Cloud of 2 points", "  age: per vertex, shape (2,)"]


def test_trimesh_and_back(mesh: TriangleMesh) -> None:
    """Vertices, faces and fields go to trimesh and come back to the last bit; a scene is refused."""
    trimesh = pytest.importorskip("trimesh")
    result = with_fields(mesh)
    surface = result.to_trimesh()
    same_mesh(TriangleMesh.from_trimesh(surface), mesh)
    places = {"vertex": surface.vertex_attributes, "face": surface.face_attributes, "mesh": surface.metadata}
    for field in result.fields:
        np.testing.assert_array_equal(np.asarray(places[field.location][field.name]), field.values)
    with pytest.raises(MeshError, match="Scene"):
        TriangleMesh.from_trimesh(trimesh.Scene())


def test_tables_of_pandas() -> None:
    """Columns are named by components, in the types of the fields."""
    pytest.importorskip("pandas")
    result = with_fields(grid(2, 2))
    table = result.to_pandas()
    assert list(table) == ["heat", "color_x", "color_y", "color_z", "id"]
    np.testing.assert_array_equal(table["id"], result["id"])
    assert list(result.to_pandas("face")) == ["velocity_x", "velocity_y", "velocity_z", "label"]


@needs_opengl
def test_plot_shows_the_answer() -> None:
    """Without a name, the field that answers the question is shown."""
    ball = icosphere(1)
    fields = [Field("id", "vertex", np.arange(ball.n_vertices)), Field("distance", "vertex", ball.vertices[:, 2])]
    result = Result(ball, fields)
    settings = {
        "off_screen": True,
        "return_img": False,
        "return_cpos": False,
        "screenshot": True,
        "window_size": (60, 60),
    }
    pictures = [result.plot(name, **settings) for name in (None, "distance", "id")]
    np.testing.assert_array_equal(pictures[0], pictures[1])
    assert (np.asarray(pictures[0]) != np.asarray(pictures[2])).any()
