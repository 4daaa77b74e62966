"""Properties of paths on a mesh: turns across edges, and the faces of segments."""

import numpy as np

from geomhw.geodesic import SurfacePath


def turns(path: SurfacePath) -> np.ndarray:
    """Return the turn at each inner point of an edge, in radians: π less the angles on both sides of the path."""
    x, found = path.positions, []
    for k in range(1, len(x) - 1):
        names = path.mesh.faces[path.faces[k]]
        if (path.weights[k] > 0).sum() == 2:
            low, high = path.mesh.vertices[names[path.weights[k] > 0]]
            angles = [angle(high - low, x[k + 1] - x[k]), angle(low - high, x[k - 1] - x[k])]
            found.append(angles[0] - angles[1])
    return np.array(found)


def angle(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def lies_in_faces(path: SurfacePath) -> bool:
    """Whether each point lies in the face of the segment before it, too."""
    faces = path.mesh.faces
    return all(
        set(faces[path.faces[k]][path.weights[k] > 0]) <= set(faces[path.faces[k - 1]])
        for k in range(1, len(path.faces))
    )
