"""Streamlines on a mesh as polylines, with the places and reasons of their ends."""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.mesh.sampling import points_on
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Cloud, Field

#: Names of the reasons why a streamline ends, by their number in the array ``stop``.
STOPS = ("", "closed", "boundary", "critical point", "near another", "near itself", "too many edges")


@dataclass(frozen=True, eq=False, repr=False)
class Streamlines:
    """Streamlines on a mesh as polylines; each of their segments lies in a face.

    Attributes
    ----------
    mesh : TriangleMesh
    spacing : float
    faces : (k,) integer array
        The face of the segment that follows each point; of a last point, the face of the last segment.
    weights : (k, 3) array
        Barycentric coordinates of the points in these faces.
    lines : (p + 1,) integer array
        Streamline i has the points from ``lines[i]`` to ``lines[i + 1] - 1``, downstream.
    arc_length, time, speed : (k,) arrays
        From the first point of the streamline, and speed in the face.
    along_edge : (k,) array of 0 and 1
        Whether the segment that follows goes along an edge, since the fields on both sides point into it.
    stops : (p, 2) integer array
        Why each streamline begins and ends, as numbers of `STOPS`.
    neighbor_distances : (q,) array
        Distance on the surface to the nearest other streamline, or to another part of the same one, at places half a
        spacing apart on all streamlines; infinite beyond three spacings.
    """

    mesh: TriangleMesh
    spacing: float
    faces: Ints
    weights: Floats
    lines: Ints
    arc_length: Floats
    time: Floats
    speed: Floats
    along_edge: Ints
    stops: Ints
    neighbor_distances: Floats

    def __len__(self) -> int:
        return len(self.stops)

    def __repr__(self) -> str:
        return f"{len(self)} Streamlines, length {self.lengths.sum():.6g}"

    @cached_property
    def positions(self) -> Floats:
        """Coordinates of the points, (k, 3)."""
        return points_on(self.mesh, self.faces, self.weights)

    @property
    def lengths(self) -> Floats:
        """Length of each streamline, (p,)."""
        return np.asarray(self.arc_length[self.lines[1:] - 1])

    @property
    def closed(self) -> Ints:
        """Whether each streamline is closed, (p,), as 0 and 1."""
        return (self.stops[:, 0] == STOPS.index("closed")).astype(np.int32)

    def polylines(self) -> Cloud:
        """Return the streamlines as polylines.

        Returns
        -------
        Cloud with ``path`` (number of the streamline), ``face``, ``barycentric``, ``arc_length``, ``time``, ``speed``,
        ``along_edge`` and ``stop`` on points, and ``length`` and ``closed`` of each streamline.
        """
        stop = np.zeros(len(self.faces), dtype=np.int32)
        stop[self.lines[:-1]], stop[self.lines[1:] - 1] = self.stops.T
        fields = [
            Field("path", "vertex", np.repeat(np.arange(len(self), dtype=np.int32), np.diff(self.lines))),
            Field("face", "vertex", self.faces.astype(np.int32)),
            Field("barycentric", "vertex", self.weights),
            Field("arc_length", "vertex", self.arc_length),
            Field("time", "vertex", self.time),
            Field("speed", "vertex", self.speed),
            Field("along_edge", "vertex", self.along_edge),
            Field("stop", "vertex", stop),
            Field("length", "mesh", self.lengths),
            Field("closed", "mesh", self.closed),
        ]
        return Cloud(self.positions, fields, self.lines)

    def report(self) -> dict[str, Any]:
        """Return numbers of streamlines and of their ends by reason, as plain values; distances in spacings."""
        ends = Counter(STOPS[k] for k in self.stops[self.closed == 0].ravel().tolist())
        ratios = self.neighbor_distances / self.spacing
        return {
            "spacing": self.spacing,
            "streamlines": len(self),
            "closed": int(self.closed.sum()),
            "ends": dict(sorted(ends.items())),
            "length": float(self.lengths.sum()),
            "neighbor_distance": {
                "median": float(np.median(ratios)) if len(ratios) else None,
                "share_from_half_to_twice": float(np.mean((ratios >= 0.5) & (ratios <= 2))) if len(ratios) else None,
            },
        }
