from .averaging import faces_to_vertices as faces_to_vertices
from .averaging import vertices_to_faces as vertices_to_faces
from .boundary_loops import loop_constant_basis as loop_constant_basis
from .boundary_loops import loop_representatives as loop_representatives
from .connection_laplacian import (
    complex_connection_stiffness as complex_connection_stiffness,
)
from .connection_laplacian import (
    connection_stiffness as connection_stiffness,
)
from .crouzeix_raviart import crouzeix_raviart_gradient as crouzeix_raviart_gradient
from .curl import curl as curl
from .curl import curl_of as curl_of
from .curl import quarter_turn as quarter_turn
from .deformation_energy import deformation_energy as deformation_energy
from .deformation_energy import field_unknowns as field_unknowns
from .directional_derivative import (
    DirectionalDerivative as DirectionalDerivative,
)
from .directional_derivative import (
    directional_derivative as directional_derivative,
)
from .directional_derivative import (
    face_derivative as face_derivative,
)
from .divergence import divergence as divergence
from .divergence import divergence_of as divergence_of
from .edge_directions import carried_to_faces as carried_to_faces
from .edge_directions import edge_ends as edge_ends
from .edge_directions import plane_frames as plane_frames
from .edge_vectors import edge_connection_stiffness as edge_connection_stiffness
from .gradient import gradient as gradient
from .gradient import gradient_of as gradient_of
from .gradient import hat_gradients as hat_gradients
from .laplacian import backward_euler as backward_euler
from .laplacian import stiffness as stiffness
from .local_fit import LocalFit as LocalFit
from .mass import consistent_mass as consistent_mass
from .mass import lumped_mass as lumped_mass
from .mass import mean_mass as mean_mass
from .parallel_transport import (
    edge_rotations as edge_rotations,
)
from .parallel_transport import (
    edge_transport as edge_transport,
)
from .parallel_transport import (
    from_complex as from_complex,
)
from .parallel_transport import (
    to_complex as to_complex,
)
