"""A sphere of any number of vertices, written ring by ring: meshes larger than memory."""

from pathlib import Path
from typing import Any

import numpy as np

#: Rings that are written at a time.
BATCH = 64
_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def ring_size(k: int, n: int) -> int:
    """Return the number of vertices of ring k, from the pole, ring 0, to the other pole, ring 2n."""
    return max(4 * min(k, 2 * n - k), 1)


def write_ring_sphere(path: Path, n: int) -> int:
    """Write a unit sphere of 4 n² + 2 vertices and 8 n² triangles as binary PLY; return the number of vertices."""
    sizes = np.array([ring_size(k, n) for k in range(2 * n + 1)])
    starts = np.concatenate([[0], np.cumsum(sizes)])
    count = int(starts[-1])
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty double x\nproperty double y\n"
    header += f"property double z\nelement face {8 * n * n}\nproperty list uchar int vertex_indices\nend_header\n"
    with path.open("wb") as stream:
        stream.write(header.encode())
        for first in range(0, 2 * n + 1, BATCH):
            rings = range(first, min(first + BATCH, 2 * n + 1))
            stream.write(np.concatenate([_points(k, n) for k in rings]).astype("<f8").tobytes())
        for first in range(0, 2 * n, BATCH):
            bands = range(first, min(first + BATCH, 2 * n))
            stream.write(np.concatenate([_band(starts[k], sizes[k], sizes[k + 1]) for k in bands]).tobytes())
    return count


def _points(k: int, n: int) -> Any:
    """Coordinates of ring k."""
    size = ring_size(k, n)
    height, angle = np.pi / 2 * k / n, 2 * np.pi * np.arange(size) / size
    return np.stack([np.sin(height) * np.cos(angle), np.sin(height) * np.sin(angle), np.full(size, np.cos(height))], 1)


def _band(start: int, inner: int, outer: int) -> Any:
    """Triangles between a ring and the next, each of four quadrants with one vertex more, or less, on the next."""
    if outer < inner:  # toward the other pole: the mirror image
        rows = _band(0, outer, inner)
        corners = rows["corners"]
        mirrored = np.where(corners < outer, corners + inner, corners - outer)
        rows["corners"] = start + mirrored[:, ::-1]
        return rows
    k = outer // 4  # edges of a quadrant on the outer ring; the inner one has k - 1
    quadrant, step = np.divmod(np.arange(outer), k)
    after = quadrant * k + step
    inside = (quadrant * (k - 1) + step) % inner
    tips = np.stack([inside, inner + after, inner + (after + 1) % outer], axis=1)
    quadrant, step = np.divmod(np.arange(inner if inner > 1 else 0), max(k - 1, 1))
    base = quadrant * (k - 1) + step
    backs = np.stack([base, inner + quadrant * k + step + 1, (base + 1) % inner], axis=1)
    corners = np.concatenate([tips, backs.reshape(-1, 3)])
    rows = np.empty(len(corners), dtype=_FACE)
    rows["count"], rows["corners"] = 3, start + corners
    return rows
