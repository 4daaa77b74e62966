"""The one place where VTK draws: a window off screen, triangles and lines put into it, and its pixels taken out.

VTK is imported by the few of its modules that draw; all of it, or a library over it, would take a second to load.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.render import offscreen

#: Color of the glint on surfaces that take their colors from values.
GLINT = "#add8e6"
#: Where light comes from, and how strong it is.
LIGHTS = (((-0.5, 0.8, 1.2), 0.7), ((0.8, -0.1, 1.0), 0.35))
#: Share of a color that is seen without light, and how the rest answers to light.
AMBIENT, DIFFUSE, SPECULAR, SHININESS = 0.52, 0.55, 0.08, 20.0


@dataclass(frozen=True)
class Paint:
    """Colors of triangles: one ``color`` for all, or ``values`` per point or, with ``per_face``, per triangle.

    values: numbers 0..1 along ``table``, RGBA rows of uint8; without a table, rows of uint8, RGB or RGBA.
    """

    color: str = GLINT
    values: NDArray[Any] | None = None
    table: NDArray[np.uint8] | None = None
    per_face: bool = False


class Window:
    """So many pixels, a background, and what was added since ``clear``; x, y from -1 to 1 over the height.

    depth: nothing is farther from the plane z = 0, in the direction of sight, than that. samples: of the edges, within
    each pixel.
    """

    def __init__(self, size: tuple[int, int], background: str, depth: float, samples: int) -> None:
        offscreen.prepare()
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  what draws, of the classes below
        from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer, vtkRenderWindow

        self.size = size
        self._renderer = vtkRenderer()
        self._renderer.SetBackground(*_rgb(background))
        self._renderer.SetAutomaticLightCreation(False)
        self._renderer.SetUseOIT(False)  # translucent layers lie on each other in the order they are added
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
        self._aim(depth)

    def _aim(self, depth: float) -> None:
        camera = self._renderer.GetActiveCamera()
        camera.SetPosition(0, 0, 2 * depth)
        camera.SetFocalPoint(0, 0, 0)
        camera.SetViewUp(0, 1, 0)
        camera.SetParallelProjection(True)
        camera.SetParallelScale(1.0)
        camera.SetClippingRange(depth * 0.5, depth * 3.5)

    def close(self) -> None:
        """Give the window back."""
        self.clear()
        self._window.Finalize()

    def clear(self) -> None:
        """Take out all that was added."""
        self._renderer.RemoveAllViewProps()

    def add_triangles(self, points: Floats, triangles: Ints, paint: Paint, normals: Floats | None = None) -> None:
        """Triangles, (k, 3), between points, (p, 3); lit, smoothly, if these have normals, (p, 3)."""
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
        """Segments, (s, 2, 3), so many pixels wide, not lit."""
        data = _poly_data(segments.reshape(-1, 3))
        data.SetLines(_cells(np.arange(2 * len(segments), dtype=np.int32).reshape(-1, 2)))
        actor = _actor(_mapper(data, Paint()), color)
        actor.GetProperty().LightingOff()
        actor.GetProperty().SetLineWidth(width)
        self._renderer.AddActor(actor)

    def pixels(self) -> NDArray[np.uint8]:
        """The picture, (h, w, 3), from the top row down."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        self._window.Render()
        width, height = self.size
        read = vtkUnsignedCharArray()
        self._window.GetPixelData(0, 0, width - 1, height - 1, 0, read, 0)
        return np.asarray(vtk_to_numpy(read).reshape(height, width, 3)[::-1])

    def nearest(self) -> Floats:
        """The z of what is seen at each pixel of the last picture, (h, w), from the bottom row up."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkFloatArray

        width, height = self.size
        read = vtkFloatArray()
        self._window.GetZbufferData(0, 0, width - 1, height - 1, read)
        return np.asarray(
            self._depth * (1.5 - 3.0 * vtk_to_numpy(read).reshape(height, width))
        )  # 0..1 in clipping range


def _poly_data(points: Floats) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    places = vtkPoints()
    places.SetData(numpy_to_vtk(points.astype(np.float32)))
    data = vtkPolyData()
    data.SetPoints(places)
    return data


def _cells(corners: Ints) -> Any:
    """Rows of points, all of one length."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    cells = vtkCellArray()
    cells.SetData(corners.shape[1], numpy_to_vtk(corners.astype(np.int32).ravel()))
    return cells


def _mapper(data: Any, paint: Paint) -> Any:
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
    from vtkmodules.vtkRenderingCore import vtkActor

    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*_rgb(color))
    return actor


def _rgb(color: str) -> tuple[float, float, float]:
    red, green, blue = bytes.fromhex(color[1:])
    return red / 255, green / 255, blue / 255
