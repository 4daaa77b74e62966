"""Offscreen VTK window: add triangles and lines, read pixels and depths.

Only the VTK modules that draw are imported; all of VTK, or pyvista, takes a second to load.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.render import offscreen

#: Color of highlights on surfaces colored by values.
GLINT = "#add8e6"
#: Position and intensity of the lights.
LIGHTS = (((-0.5, 0.8, 1.2), 0.7), ((0.8, -0.1, 1.0), 0.35))
#: Coefficients of the Phong reflection model.
AMBIENT, DIFFUSE, SPECULAR, SHININESS = 0.52, 0.55, 0.08, 20.0


@dataclass(frozen=True)
class Paint:
    """Colors of triangles: one ``color``, or ``values`` per point or, with ``per_face``, per triangle.

    values: numbers from 0 to 1 along ``table`` (RGBA rows, uint8); without a table, RGB or RGBA rows, uint8.
    """

    color: str = GLINT
    values: NDArray[Any] | None = None
    table: NDArray[np.uint8] | None = None
    per_face: bool = False


class Window:
    """A window of ``size`` pixels, off screen; y runs from -1 to 1 over the height, the viewer looks along -z.

    depth: largest distance of a point from the plane z = 0. samples: number of samples per pixel.
    """

    def __init__(self, size: tuple[int, int], background: str, depth: float, samples: int) -> None:
        offscreen.prepare()
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  registers the OpenGL classes
        from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer, vtkRenderWindow

        self.size = size
        self._renderer = vtkRenderer()
        self._renderer.SetBackground(*_rgb(background))
        self._renderer.SetAutomaticLightCreation(False)
        self._renderer.SetUseOIT(False)  # translucent layers are drawn in the order of addition
        for position, intensity in LIGHTS:
            light = vtkLight()
            light.SetLightTypeToSceneLight()
            light.SetPosition(*position)
            light.SetIntensity(intensity)
            self._renderer.AddLight(light)
        self._window = vtkRenderWindow()
        self._window.SetOffScreenRendering(True)
        self._window.SetMultiSamples(samples)
        self._window.SetSize(*size)
        self._window.AddRenderer(self._renderer)
        self._depth = depth
        camera = self._renderer.GetActiveCamera()
        camera.SetPosition(0, 0, 2 * depth)
        camera.SetFocalPoint(0, 0, 0)
        camera.SetViewUp(0, 1, 0)
        camera.SetParallelProjection(True)
        camera.SetParallelScale(1.0)
        camera.SetClippingRange(depth * 0.5, depth * 3.5)

    def close(self) -> None:
        """Close the window."""
        self.clear()
        self._window.Finalize()

    def clear(self) -> None:
        """Remove everything that was added."""
        self._renderer.RemoveAllViewProps()

    def add_triangles(self, points: Floats, triangles: Ints, paint: Paint, normals: Floats | None = None) -> None:
        """Add triangles, (k, 3), of points, (p, 3); with point normals, (p, 3), they are smoothly lit."""
        from vtkmodules.util.numpy_support import numpy_to_vtk

        data = _poly_data(points)
        data.SetPolys(_cells(triangles))
        mapper = _mapper(data, paint)
        actor = _actor(mapper, paint.color)
        look = actor.GetProperty()
        if normals is None:
            look.LightingOff()
        else:
            data.GetPointData().SetNormals(numpy_to_vtk(normals.astype(np.float32)))
            look.SetInterpolationToPhong()
            look.SetAmbient(AMBIENT)
            look.SetDiffuse(DIFFUSE)
            look.SetSpecular(SPECULAR)
            look.SetSpecularPower(SHININESS)
        self._renderer.AddActor(actor)

    def add_lines(self, segments: Floats, color: str, width: float) -> None:
        """Add unlit line segments, (s, 2, 3), of the given width in pixels."""
        data = _poly_data(segments.reshape(-1, 3))
        data.SetLines(_cells(np.arange(2 * len(segments), dtype=np.int32).reshape(-1, 2)))
        actor = _actor(_mapper(data, Paint()), color)
        actor.GetProperty().LightingOff()
        actor.GetProperty().SetLineWidth(width)
        self._renderer.AddActor(actor)

    def pixels(self) -> NDArray[np.uint8]:
        """Draw and return the picture, (h, w, 3), top row first."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        self._window.Render()
        width, height = self.size
        read = vtkUnsignedCharArray()
        self._window.GetPixelData(0, 0, width - 1, height - 1, 0, read, 0)
        return np.asarray(vtk_to_numpy(read).reshape(height, width, 3)[::-1])

    def nearest(self) -> Floats:
        """Return the z of the visible point at each pixel of the last picture, (h, w), bottom row first."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkFloatArray

        width, height = self.size
        read = vtkFloatArray()
        self._window.GetZbufferData(0, 0, width - 1, height - 1, read)
        return np.asarray(
            self._depth * (1.5 - 3.0 * vtk_to_numpy(read).reshape(height, width))
        )  # the buffer is 0 to 1 over the clipping range


def _poly_data(points: Floats) -> Any:
    """Make a vtkPolyData with points only."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    places = vtkPoints()
    places.SetData(numpy_to_vtk(points.astype(np.float32)))
    data = vtkPolyData()
    data.SetPoints(places)
    return data


def _cells(corners: Ints) -> Any:
    """Make a vtkCellArray of cells with the same number of corners, (k, d)."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    cells = vtkCellArray()
    cells.SetData(corners.shape[1], numpy_to_vtk(corners.astype(np.int32).ravel()))
    return cells


def _mapper(data: Any, paint: Paint) -> Any:
    """Make a mapper with the colors of ``paint``."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkLookupTable
    from vtkmodules.vtkRenderingCore import vtkPolyDataMapper

    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetScalarVisibility(paint.values is not None)
    if paint.values is None:
        return mapper
    place = data.GetCellData() if paint.per_face else data.GetPointData()
    place.SetScalars(numpy_to_vtk(np.ascontiguousarray(paint.values)))
    if paint.per_face:
        mapper.SetScalarModeToUseCellData()
    else:
        mapper.SetScalarModeToUsePointData()
    if paint.table is None:
        mapper.SetColorModeToDirectScalars()
        return mapper
    colors = vtkLookupTable()
    colors.SetTable(numpy_to_vtk(np.ascontiguousarray(paint.table)))
    colors.SetTableRange(0.0, 1.0)
    mapper.SetLookupTable(colors)
    mapper.SetScalarRange(0.0, 1.0)
    mapper.SetColorModeToMapScalars()
    mapper.SetInterpolateScalarsBeforeMapping(True)
    return mapper


def _actor(mapper: Any, color: str) -> Any:
    """Make an actor of one color."""
    from vtkmodules.vtkRenderingCore import vtkActor

    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*_rgb(color))
    return actor


def _rgb(color: str) -> tuple[float, float, float]:
    """Convert "#rrggbb" to numbers from 0 to 1."""
    red, green, blue = bytes.fromhex(color[1:])
    return red / 255, green / 255, blue / 255
