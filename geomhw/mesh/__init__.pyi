from .curvature import angle_defects as angle_defects
from .curve_points import curve_points as curve_points
from .curve_points import edge_points as edge_points
from .curve_points import even_samples as even_samples
from .cut import cut_along_edges as cut_along_edges
from .cut import cut_at_pinched_vertices as cut_at_pinched_vertices
from .diagnostics import Finding as Finding
from .diagnostics import findings as findings
from .diagnostics import mesh_summary as mesh_summary
from .implicit_surfaces import genus_two as genus_two
from .implicit_surfaces import implicit_surface as implicit_surface
from .inserted_curves import InsertedCurves as InsertedCurves
from .inserted_curves import insert_curves as insert_curves
from .inserted_points import InsertedPoints as InsertedPoints
from .inserted_points import insert_points as insert_points
from .named_points import (
    boundary_points as boundary_points,
)
from .named_points import (
    face_point as face_point,
)
from .named_points import (
    region_points as region_points,
)
from .named_points import (
    vertex_points as vertex_points,
)
from .named_points import (
    vertex_range as vertex_range,
)
from .nearest import nearest_point as nearest_point
from .nearest import nearest_points as nearest_points
from .orientation import (
    orientation_cover as orientation_cover,
)
from .orientation import (
    oriented as oriented,
)
from .orientation import (
    without_duplicate_faces as without_duplicate_faces,
)
from .polyhedral import PolyhedralSurface as PolyhedralSurface
from .primitives import (
    cylinder_band as cylinder_band,
)
from .primitives import (
    grid as grid,
)
from .primitives import (
    icosphere as icosphere,
)
from .primitives import (
    moebius_band as moebius_band,
)
from .primitives import (
    strip as strip,
)
from .primitives import (
    torus as torus,
)
from .repair import Repair as Repair
from .repair import repair as repair
from .surface_points import (
    SurfacePoints as SurfacePoints,
)
from .surface_points import (
    concatenate as concatenate,
)
from .triangle_mesh import TriangleMesh as TriangleMesh
