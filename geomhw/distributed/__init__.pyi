from .heat_method import distributed_distance as distributed_distance
from .local_mesh import LocalMesh as LocalMesh
from .local_mesh import distribute as distribute
from .ranks import Ranks as Ranks
from .ranks import connect as connect
from .slices import open_sliced as open_sliced
