"""Closest faces of a mesh to points in space, by a tree of bounding boxes along a Hilbert curve."""

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled, compiled_inline
from geomhw.mesh.hilbert_curve import hilbert_keys
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Bits per coordinate of the Hilbert curve.
BITS = 10


def closest_faces(mesh: TriangleMesh, points: Floats) -> tuple[Ints, Floats]:
    """Return the closest face to each point, (k,), and the barycentric coordinates, (k, 3), of its closest point.

    The closest point of a face is the foot of the perpendicular if that lies inside, else the closest point of an edge.
    On a tie, the face is the lowest.
    """
    corners = mesh.vertices[mesh.faces]
    order = np.argsort(hilbert_keys(corners.mean(axis=1), BITS), kind="stable")
    first = (1 << (mesh.n_faces - 1).bit_length()) - 1
    boxes = np.full((2 * first + 1, 2, 3), np.inf)
    boxes[first : first + mesh.n_faces] = np.stack([corners.min(axis=1), -corners.max(axis=1)], axis=1)[order]
    end = first
    while end:
        begin = (end - 1) // 2
        boxes[begin:end] = boxes[2 * begin + 1 : 2 * end + 1].reshape(-1, 2, 2, 3).min(axis=1)
        end = begin
    return _search(np.ascontiguousarray(points), boxes, first, corners, mesh.face_normals, order)


@compiled
def _search(
    points: Floats, boxes: Floats, first: int, corners: Floats, normals: Floats, order: Ints
) -> tuple[Ints, Floats]:
    """Descend to the nearer of two boxes first. boxes: least and negative largest coordinates; node i has the children
    2i+1 and 2i+2, and node ``first`` + j is the face ``order[j]``."""
    faces, weights = np.zeros(len(points), dtype=np.int64), np.zeros((len(points), 3))
    waiting, bounds = np.zeros(128, dtype=np.int64), np.zeros(128)
    trial = np.zeros(3)
    for k in range(len(points)):
        best, count = np.inf, 1
        waiting[0], bounds[0] = 0, 0.0
        while count:
            count -= 1
            node = waiting[count]
            if bounds[count] > best:
                continue
            if node >= first:
                face = order[node - first]
                squared = _closest_in_face(points[k], corners[face], normals[face], trial)
                if squared < best or (squared == best and face < faces[k]):
                    best, faces[k] = squared, face
                    weights[k] = trial
                continue
            near, far = 2 * node + 1, 2 * node + 2
            to_near, to_far = _to_box(points[k], boxes[near]), _to_box(points[k], boxes[far])
            if to_far < to_near:
                near, far, to_near, to_far = far, near, to_far, to_near
            for child, bound in ((far, to_far), (near, to_near)):
                if bound <= best:
                    waiting[count], bounds[count] = child, bound
                    count += 1
    return faces, weights


@compiled_inline
def _to_box(p: Floats, box: Floats) -> float:
    """The squared distance of a point from a box, inf from an empty one."""
    total = 0.0
    for x in range(3):
        outside = max(0.0, box[0, x] - p[x], p[x] + box[1, x])
        total += outside * outside
    return total


@compiled_inline
def _closest_in_face(p: Floats, corners: Floats, normal: Floats, b: Floats) -> float:
    """Return the squared distance of a point from a face; set the barycentric coordinates b of the closest point."""
    best, edge, share = np.inf, 0, 0.0
    total, inside, height = 0.0, True, 0.0
    for c in range(3):
        n = (c + 1) % 3
        x, y, z = corners[c, 0] - p[0], corners[c, 1] - p[1], corners[c, 2] - p[2]
        u, v, w = corners[n, 0] - p[0], corners[n, 1] - p[1], corners[n, 2] - p[2]
        area = normal[0] * (y * w - z * v) + normal[1] * (z * u - x * w) + normal[2] * (x * v - y * u)
        b[(c + 2) % 3] = area
        inside &= area >= 0
        total += area
        if c == 0:
            height = x * normal[0] + y * normal[1] + z * normal[2]
        u, v, w = u - x, v - y, w - z
        length = u * u + v * v + w * w
        s = min(1.0, max(0.0, -(x * u + y * v + z * w) / length)) if length > 0 else 0.0
        x, y, z = x + s * u, y + s * v, z + s * w
        squared = x * x + y * y + z * z
        if squared < best:
            best, edge, share = squared, c, s
    if inside and total > 0 and height * height <= best:
        b /= total
        return height * height
    b[edge], b[(edge + 1) % 3], b[(edge + 2) % 3] = 1 - share, share, 0.0
    return best
