from .delaunay import intrinsic_delaunay as intrinsic_delaunay
from .divided_faces import divided_faces as divided_faces
from .intrinsic_mesh import IntrinsicMesh as IntrinsicMesh
from .intrinsic_mesh import mollified as mollified
from .robust import RobustTriangulation as RobustTriangulation
from .tufted_cover import tufted_cover as tufted_cover
