from .log_map import LogarithmicMap as LogarithmicMap
from .source_vectors import source_frames as source_frames
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
