"""A result with arrays of many types, as a VTK data set and as legacy VTK text."""

import numpy as np
import pyvista

from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

MESH = TriangleMesh(
    [[0, 0, 0], [1, 0, 0], [1 / 3, 1, 0], [0.1, 0.2, np.pi]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
)
RESULT = Result(
    MESH,
    [
        Field("heat", "vertex", np.array([1e-300, 0.1, -0.0, np.pi])),
        Field("id", "vertex", np.array([0, -1, 2**40, 3])),
        Field("moved", "vertex", np.arange(12.0).reshape(4, 3) / 7),
        Field("uv", "vertex", np.arange(8.0).reshape(4, 2) / 3),
        Field("label", "face", np.array([5, 6, 7, 8], dtype=np.int32)),
        Field("direction", "face", np.arange(12.0).reshape(4, 3) / 11),
        Field("velocity", "face", np.arange(12.0).reshape(4, 3) / 13),
        Field("frame", "face", np.arange(36.0).reshape(4, 9)),
        Field("dt", "mesh", np.array([0.1, 0.2])),
    ],
)


def as_vtk(extension: str) -> pyvista.DataSet:
    poly = pyvista.PolyData(MESH.vertices, np.insert(MESH.faces, 0, 3, axis=1))
    dataset = poly.cast_to_unstructured_grid() if extension == "vtu" else poly
    places = {"vertex": dataset.point_data, "face": dataset.cell_data, "mesh": dataset.field_data}
    for field in RESULT.fields:
        places[field.location][field.name] = field.values
    return dataset


BY_HAND = """# vtk DataFile Version 2.0
by hand
ASCII
DATASET POLYDATA
POINTS 4 float
0 0 0 1 0 0
0 1 0
0 0 1
POLYGONS 4 16
3 0 2 1 3 0 1 3
3 1 2 3
3 2 0 3
POINT_DATA 4
SCALARS heat double 1
LOOKUP_TABLE mine
1 2 3 4
LOOKUP_TABLE mine 1
0 0 0 1
NORMALS n float
0 0 1 0 0 1 0 0 1 0 0 1
CELL_DATA 4
COLOR_SCALARS rgb 3
0 0 1 0 0 1 0 0 1 0 0 1
TEXTURE_COORDINATES uv 2 float
0 0 1 0 0 1 0 0
"""
