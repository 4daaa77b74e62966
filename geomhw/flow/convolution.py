"""Line integral convolution of noise on a surface along the exact streamlines of a face field.

Each face is divided into a lattice of equal triangles, its cells. Each cell has a random number. Its value is the mean
of these numbers along the streamline through its center (Cabral and Leedom 1993).
"""

from math import cos, inf, pi, sqrt

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.compiled import compiled, compiled_in_place
from geomhw.flow.flat_faces import FlatFaces, flat_faces
from geomhw.flow.streamlines import ON_EDGE, FaceFlow, StreamlineTracer, enter_face
from geomhw.mesh.triangle_mesh import TriangleMesh

#: Length of a streamline on each side of a cell, and distance of samples on it, in sizes of cells.
LENGTH, SAMPLE = 12.0, 0.7
#: Size of the table of random numbers, and edges that a streamline crosses at most.
NOISE, MOST_CROSSINGS = 1 << 20, 1000


def cell_counts(mesh: TriangleMesh, size: float) -> Ints:
    """Return the number of cells along each side of each face, (m,), for cells of a size."""
    longest = np.linalg.norm(mesh.opposite_edges, axis=2).max(axis=1)
    return np.maximum(np.ceil(longest / size), 1).astype(np.int64)


def convolved_noise(mesh: TriangleMesh, velocity: Floats, counts: Ints, size: float) -> Floats:
    """Return the values of all cells, face by face, each face with ``counts ** 2`` cells.

    In a face with N cells along each side, cell i² + 2j + k of row i, counted from corner 0, is the triangle with the
    lattice points (i, j), (i + 1, j), (i + 1, j + 1) for k = 0, and (i, j), (i + 1, j + 1), (i, j + 1) for k = 1. Point
    (i, j) has barycentric coordinates (N - i, i - j, j) / N.

    Parameters
    ----------
    velocity : (m, 3) array; its normal part is ignored.
    counts : (m,) array, of `cell_counts`.
    size : of cells, a length.

    Returns
    -------
    (sum of counts²,) array of mean 0 and variance about 1; 0 where the field is zero.

    Raises
    ------
    MeshError
        If an edge has more than two faces, or a face has zero area.

    References
    ----------
    Cabral, Leedom: Imaging Vector Fields Using Line Integral Convolution. SIGGRAPH 1993.
    """
    tracer = StreamlineTracer(mesh)
    forward = tracer.flow(velocity)
    backward = forward._replace(V=-forward.V, rates=-forward.rates)
    noise = np.random.default_rng(0).normal(size=NOISE)
    values = np.empty(int((counts**2).sum()))
    _convolve(forward, backward, flat_faces(mesh), counts, size, noise, values)
    return values


@compiled
def _convolve(
    forward: FaceFlow, backward: FaceFlow, flat: FlatFaces, counts: Ints, size: float, noise: Floats, values: Floats
) -> None:
    """Set the values of all cells."""
    b, start, ahead, rates, sums = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(2)
    cell = 0
    for face in range(len(counts)):
        n = counts[face]
        for i in range(n):
            for rest in range(2 * i + 1):
                j, k = rest // 2, rest % 2
                # The center of the cell.
                rows, columns = 3 * i + 2 - k, 3 * j + 1 + k
                start[0], start[1], start[2] = (3 * n - rows) / (3 * n), (rows - columns) / (3 * n), columns / (3 * n)
                here = _noise(noise, counts, face, start)
                sums[0], sums[1] = here, 1.0
                for x in range(3):
                    b[x] = start[x]
                _gather(forward, flat, counts, face, b, ahead, rates, size, noise, sums)
                for x in range(3):
                    b[x] = start[x]
                _gather(backward, flat, counts, face, b, ahead, rates, size, noise, sums)
                values[cell] = sums[0] / sqrt(sums[1]) if sums[1] > 1 else 0.0
                cell += 1


@compiled_in_place
def _noise(noise: Floats, counts: Ints, face: int, b: Floats) -> float:
    """Return the random number of the cell of a point."""
    n = counts[face]
    i, j, k = int(b[0] * n), int(b[1] * n), int(b[2] * n)
    return noise[(face * 7919 + i * 104729 + j * 1299709 + k * 15485863) % NOISE]


@compiled
def _gather(
    flow: FaceFlow,
    flat: FlatFaces,
    counts: Ints,
    face: int,
    b: Floats,
    ahead: Floats,
    rates: Floats,
    size: float,
    noise: Floats,
    sums: Floats,
) -> None:
    """Add the weighted numbers along a streamline from b to the sums, and the squares of weights."""
    arc, following, most = 0.0, SAMPLE * size, LENGTH * size
    for _ in range(MOST_CROSSINGS):
        face, _ = enter_face(flow, face, b, rates)
        time, edge = inf, -1
        for k in range(3):
            if rates[k] < 0 and b[k] / -rates[k] < time:
                time, edge = b[k] / -rates[k], k
        if edge < 0 or not time < inf:
            return
        total = x = y = 0.0
        for k in range(3):
            ahead[k] = b[k] + time * rates[k]
            if ahead[k] < ON_EDGE or k == edge:
                ahead[k] = 0.0
            total += ahead[k]
        for k in range(3):
            ahead[k] /= total
            x += (ahead[k] - b[k]) * flat.places[face, k, 0]
            y += (ahead[k] - b[k]) * flat.places[face, k, 1]
        length = sqrt(x * x + y * y)
        while following <= arc + length:
            share = (following - arc) / length
            weight = 0.5 + 0.5 * cos(pi * following / most)
            for k in range(3):
                rates[k] = b[k] + share * (ahead[k] - b[k])
            sums[0] += weight * _noise(noise, counts, face, rates)
            sums[1] += weight * weight
            following += SAMPLE * size
            if following >= most:
                return
        arc += length
        for k in range(3):
            b[k] = ahead[k]
