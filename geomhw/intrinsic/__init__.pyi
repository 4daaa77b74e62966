from .delaunay import intrinsic_delaunay as intrinsic_delaunay
from .intrinsic_mesh import IntrinsicMesh as IntrinsicMesh
from .intrinsic_mesh import mollified as mollified
from .robust import RobustTriangulation as RobustTriangulation
from .tufted_cover import tufted_cover as tufted_cover
