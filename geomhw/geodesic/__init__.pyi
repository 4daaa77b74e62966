from .diffusion_time import TimeStep as TimeStep
from .diffusion_time import time_step as time_step
from .edge_paths import edge_path_distance as edge_path_distance
from .heat_method import HeatDistance as HeatDistance
from .heat_method import heat_distance as heat_distance
from .heat_step import HeatStep as HeatStep
from .unfolding import Unfolding as Unfolding
