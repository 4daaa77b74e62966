"""Offscreen pyvista plotter with a fixed camera: add triangles, read pixels and depths."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats, Ints
from geomhw.render import offscreen

#: Direction of the light. Its intensity shows the color of the bar unchanged where the surface faces the viewer.
LIGHT_FROM = (-0.4, 0.6, 1.0)
#: Ambient share of the light on surfaces colored by values, and on plain ones.
AMBIENT_COLORED, AMBIENT_PLAIN = 0.6, 0.4
#: Dihedral angle, in degrees, above which an edge is shaded as a crease.
CREASE = 55.0


@dataclass(frozen=True)
class Paint:
    """Colors of triangles: one ``color``, or ``values`` per point or, with ``per_face``, per triangle.

    values: numbers from 0 to 1 along ``table`` (RGBA rows, uint8); without a table, RGB or RGBA rows, uint8.
    """

    color: str = "#ffffff"
    values: NDArray[Any] | None = None
    table: NDArray[np.uint8] | None = None
    per_face: bool = False


class Window:
    """A plotter of ``size`` pixels, off screen; y runs from -1 to 1 over the height, the viewer looks along -z.

    depth: largest distance of a point from the plane z = 0. samples: number of samples per pixel.
    """

    def __init__(self, size: tuple[int, int], background: str, depth: float, samples: int) -> None:
        offscreen.prepare()
        import pyvista

        self._depth = depth
        self._plotter = plotter = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="none")
        plotter.background_color = background
        plotter.render_window.SetMultiSamples(samples)
        plotter.renderer.SetUseOIT(False)  # pyvista has no name for this: translucent layers in the order of addition
        length = float(np.linalg.norm(LIGHT_FROM))
        plotter.add_light(
            pyvista.Light(position=LIGHT_FROM, light_type="scene light", intensity=length / LIGHT_FROM[2])
        )
        plotter.enable_parallel_projection()
        plotter.camera_position = [(0, 0, 2 * depth), (0, 0, 0), (0, 1, 0)]
        plotter.camera.parallel_scale = 1.0
        plotter.camera.clipping_range = (0.5 * depth, 3.5 * depth)

    def close(self) -> None:
        """Close the plotter."""
        self._plotter.close()

    def clear(self) -> None:
        """Remove everything that was added."""
        self._plotter.clear_actors()

    def add_surface(self, surface: Any, paint: Paint) -> None:
        """Add lit triangles with normals, as `smooth_surface` makes them."""
        ambient = AMBIENT_PLAIN if paint.values is None else AMBIENT_COLORED
        self._add(surface, paint, lighting=True, ambient=ambient, diffuse=1 - ambient, interpolation="Phong")

    def add_textured(self, points: Floats, normals: Floats, triangles: Ints, colors: NDArray[np.uint8]) -> None:
        """Add lit triangles, (k, 3), with a color each, (k, 3), and a normal at each point."""
        surface = _triangles(points, triangles)
        surface.point_data.active_normals = normals.astype(np.float32)
        self.add_surface(surface, Paint(values=colors, per_face=True))

    def add_triangles(self, points: Floats, triangles: Ints, paint: Paint) -> None:
        """Add unlit triangles, (k, 3), of points, (p, 3)."""
        self._add(_triangles(points, triangles), paint, lighting=False)

    def pixels(self) -> NDArray[np.uint8]:
        """Draw and return the picture, (h, w, 3), top row first."""
        import pyvista

        # pyvista's screenshot and get_image_depth draw the picture once more each.
        window = self._plotter.render_window
        width, height = window.GetSize()
        read = pyvista.convert_array(np.zeros(3 * width * height, dtype=np.uint8))
        window.Render()
        window.GetPixelData(0, 0, width - 1, height - 1, 0, read, 0)
        return np.asarray(pyvista.convert_array(read).reshape(height, width, 3)[::-1])

    def nearest(self) -> Floats:
        """Return the z of the visible point at each pixel of the last picture, (h, w), top row first.

        It is nan at the background.
        """
        import pyvista

        window = self._plotter.render_window
        width, height = window.GetSize()
        read = pyvista.convert_array(np.zeros(width * height, dtype=np.float32))
        window.GetZbufferData(0, 0, width - 1, height - 1, read)
        buffer = pyvista.convert_array(read).reshape(height, width)[::-1]  # 0 to 1 over the clipping range
        return np.where(buffer < 1, self._depth * (1.5 - 3.0 * buffer), np.nan)

    def _add(self, data: Any, paint: Paint, **look: Any) -> None:
        """Add a mesh with the colors of ``paint``."""
        import pyvista

        if paint.values is None:
            look["color"] = paint.color
        elif paint.table is None:
            look |= {"scalars": paint.values, "rgb": True}
        else:
            table = pyvista.LookupTable(values=paint.table, scalar_range=(0.0, 1.0))
            look |= {"scalars": paint.values, "cmap": table, "clim": (0.0, 1.0), "interpolate_before_map": True}
        look["preference"] = "cell" if paint.per_face else "point"
        self._plotter.add_mesh(
            data, show_scalar_bar=False, reset_camera=False, render=False, pickable=False, copy_mesh=False, **look
        )


def smooth_surface(points: Floats, faces: Ints, crease: float = CREASE) -> Any:
    """Return a pyvista surface with point normals, with vertices split along edges sharper than ``crease`` degrees.

    Its point array ``origin`` holds the index of the copied vertex. Faces keep their order. Vertices without faces have
    no point.
    """
    used = np.flatnonzero(np.bincount(np.asarray(faces).ravel(), minlength=len(points)))
    number = np.zeros(len(points), dtype=np.int32)
    number[used] = np.arange(len(used))
    surface = _triangles(points[used], number[faces])
    surface.point_data["origin"] = used
    return surface.compute_normals(
        cell_normals=False,
        split_vertices=True,
        feature_angle=crease,
        consistent_normals=False,
        auto_orient_normals=False,
        inplace=False,
    )


def isolines(surface: Any, values: Floats, levels: Floats) -> Floats:
    """Return the segments, (s, 2, 3), where values per point of a surface equal a level."""
    lines = surface.contour(levels, scalars=values, compute_normals=False)
    if not lines.n_cells:
        return np.zeros((0, 2, 3))
    return np.asarray(lines.points[lines.lines.reshape(-1, 3)[:, 1:]], dtype=float)


def _triangles(points: Floats, triangles: Ints) -> Any:
    """Return a pyvista surface of triangles."""
    import pyvista

    return pyvista.PolyData.from_regular_faces(points.astype(np.float32), np.asarray(triangles))
