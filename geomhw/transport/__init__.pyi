from .log_map import LogarithmicMap as LogarithmicMap
from .mean_search import SurfaceMean as SurfaceMean
from .relaxed_sites import relaxed_sites as relaxed_sites
from .source_vectors import source_frames as source_frames
from .surface_means import geometric_median as geometric_median
from .surface_means import karcher_mean as karcher_mean
from .vector_heat import (
    VectorHeat as VectorHeat,
)
from .vector_heat import (
    random_tangent as random_tangent,
)
from .vector_heat import (
    tangent_at as tangent_at,
)
from .vector_heat import (
    transport_over_times as transport_over_times,
)
