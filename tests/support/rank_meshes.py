"""Meshes for tests over MPI ranks, and arrays of all ranks in the order of the file."""

from pathlib import Path
from typing import Any

import numpy as np

from geomhw.distributed import connect
from geomhw.io import read, write
from geomhw.mesh import TriangleMesh
from geomhw.mesh.primitives import grid, icosphere, torus
from geomhw.results import Result
from support.meshes import folded
from support.reference import REFERENCE

RANKS = connect()


def genus_two() -> TriangleMesh:
    """Two tori that share a patch, glued where a face of each is left out."""
    one = torus(24, 12)
    far = one.vertices + np.array([2 * one.vertices[:, 0].max() + 0.05, 0, 0])
    mirrored = far * [-1, 1, 1] + [2 * far[:, 0].min() + far[:, 0].max() - far[:, 0].min(), 0, 0]
    other = TriangleMesh(mirrored, one.faces[:, ::-1])
    near = int(one.vertices[one.faces].mean(axis=1)[:, 0].argmax())
    low = int(other.vertices[other.faces].mean(axis=1)[:, 0].argmin())
    faces = np.concatenate([np.delete(one.faces, near, 0), np.delete(other.faces, low, 0) + one.n_vertices])
    a, b = one.faces[near], other.faces[low][::-1] + one.n_vertices
    tube = [[a[k], a[k - 2], b[k]] for k in range(3)] + [[a[k - 2], b[k - 2], b[k]] for k in range(3)]
    return TriangleMesh(np.concatenate([one.vertices, other.vertices]), np.concatenate([faces, tube]))


def folded_sheet() -> TriangleMesh:
    flat = grid(20, 10, 2.0, 1.0)
    return folded(TriangleMesh(flat.vertices - [1.0, 0.0, 0.0], flat.faces))


def with_loose_vertex() -> TriangleMesh:
    ball = icosphere(2)
    return TriangleMesh(np.concatenate([ball.vertices, [[3.0, 3.0, 3.0]]]), ball.faces)


def camelhead() -> TriangleMesh:
    return read(REFERENCE / "meshes" / "hostile" / "camelhead.off").mesh


def saved(mesh: TriangleMesh, folder: Path) -> Path:
    if RANKS.rank == 0:
        write(Result(mesh), folder / "mesh.ply")
    RANKS.comm.Barrier()
    return folder / "mesh.ply"


def in_order(mesh: Any, values: Any) -> Any:
    """Return the values of all ranks in the order of the file."""
    places = np.concatenate(RANKS.comm.allgather(mesh.part.in_file))
    gathered = np.concatenate(RANKS.comm.allgather(values))
    found = np.empty_like(gathered)
    found[places] = gathered
    return found
