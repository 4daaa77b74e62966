"""What a report says of a mesh."""

from typing import Any

from geomhw.mesh.triangle_mesh import TriangleMesh


def mesh_summary(mesh: TriangleMesh) -> dict[str, Any]:
    """Sizes, topology and defects as plain values; lengths in the units of the file."""
    return {
        "vertices": mesh.n_vertices,
        "faces": mesh.n_faces,
        "edges": mesh.n_edges,
        "components": mesh.n_components,
        "boundary_loops": len(mesh.boundary_loops),
        "euler_characteristic": mesh.euler_characteristic,
        "genus": mesh.genus,
        "oriented": mesh.is_oriented,
        "edge_manifold": mesh.is_edge_manifold,
        "unreferenced_vertices": len(mesh.unreferenced_vertices),
        "zero_area_faces": len(mesh.degenerate_faces),
        "mean_edge_length": mesh.mean_edge_length,
        "area": float(mesh.face_areas.sum()),
        "bounds": [mesh.vertices.min(axis=0).tolist(), mesh.vertices.max(axis=0).tolist()],
    }
