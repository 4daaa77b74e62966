from .extrema import Extrema as Extrema
from .extrema import local_extrema as local_extrema
from .regions import geodesic_disks as geodesic_disks
from .regions import signed_distance as signed_distance
from .smoothing import HeatSmoothing as HeatSmoothing
from .smoothing import diffusion_time as diffusion_time
from .smoothing import smooth as smooth
from .vertex_gradient import vertex_gradient as vertex_gradient
