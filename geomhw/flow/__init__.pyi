from .advection import ColorRange as ColorRange
from .advection import flow_of as flow_of
from .advection import frames as frames
from .bounded_flow import BoundedFlow as BoundedFlow
from .even_streamlines import even_streamlines as even_streamlines
from .field_derivatives import FieldDerivatives as FieldDerivatives
from .field_derivatives import derivatives_of as derivatives_of
from .flow_map import FlowMap as FlowMap
from .harmonic import harmonic_basis as harmonic_basis
from .helmholtz import HelmholtzDecomposition as HelmholtzDecomposition
from .initial_fields import (
    blob as blob,
)
from .initial_fields import (
    hue_stripes as hue_stripes,
)
from .initial_fields import (
    random_field as random_field,
)
from .initial_fields import (
    rigid_field as rigid_field,
)
from .initial_fields import (
    rotation_field as rotation_field,
)
from .initial_fields import (
    waves as waves,
)
from .passive_scalar import PassiveScalar as PassiveScalar
from .pathlines import PathlineTracer as PathlineTracer
from .pushforward import Pushforward as Pushforward
from .stream_function import StreamFunctionSolver as StreamFunctionSolver
from .streamline_polylines import Streamlines as Streamlines
from .streamlines import FacePoints as FacePoints
from .streamlines import StreamlineTracer as StreamlineTracer
from .tangent_fields import energy as energy
from .tangent_fields import face_vectors as face_vectors
from .tangent_fields import tangential as tangential
