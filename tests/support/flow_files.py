"""Options for short flows, and readers of the series and tables that ``advect`` and ``fluid`` write."""

import csv
import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from geomhw.io import read, write
from geomhw.mesh.primitives import grid, icosphere, moebius_band
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result
from support.program import save_off

BALL = icosphere(1)
FINE = icosphere(2)
#: Seven steps with a frame every three: 0, 3, 6, and the last one, which is not regular.
SHORT = ("--dt", "0.01", "--steps", "7", "--every", "3")
#: Steps long enough for visible differences between the four frames.
FILM = ("--dt", "0.03", "--steps", "9", "--every", "3")

both = pytest.mark.parametrize("command", ["advect", "fluid"])


def series(path: str | Path) -> list[Result]:
    """Return the frames of a series, after a check that both indices agree."""
    path = Path(path)
    entries = [item.attrib for item in ElementTree.parse(path).iter("DataSet")]
    index = json.loads(path.with_suffix(".vtp.series").read_text())
    assert index["file-series-version"] == "1.0"
    assert [(entry["file"], float(entry["timestep"])) for entry in entries] == [
        (entry["name"], entry["time"]) for entry in index["files"]
    ]
    found = []
    for k, entry in enumerate(entries):
        assert entry["file"] == f"{path.stem}.{k:05d}.vtp"
        found.append(read(path.parent / entry["file"]))
        assert found[-1]["time"].tolist() == [float(entry["timestep"])]
    return found


def times(path: str | Path) -> list[float]:
    """Return the times of the frames of a series."""
    return [float(frame["time"][0]) for frame in series(path)]


def table(path: str | Path) -> list[dict[str, float]]:
    """Return the lines of a CSV file."""
    with open(path, newline="") as stream:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(stream)]


def jagged(seed: int) -> tuple[TriangleMesh, np.ndarray]:
    """Return a grid with vertices displaced at random by more than an edge, and a random field on it."""
    rng, flat = np.random.default_rng(seed), grid(4, 4)
    noise = rng.normal(size=flat.vertices.shape) * rng.uniform(0.5, 3) * flat.mean_edge_length
    mesh = TriangleMesh(flat.vertices + noise, flat.faces)
    return mesh, rng.normal(size=(mesh.n_faces, 3))


# -- refusals ----------------------------------------------------------------------------------------------------


def spoiled_inputs() -> None:
    """Write wrong field files, a non-manifold mesh and a one-sided one."""
    hole = np.ones((80, 3))
    hole[7, 1] = np.nan
    np.save("hole.npy", hole)
    np.save("short.npy", np.ones((79, 3)))
    fan = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    save_off(fan, "fan.off")
    save_off(moebius_band(12, 3), "moebius.off")
    write(Result(BALL, [Field("wind", "face", BALL.face_normals), Field("u", "vertex", BALL.vertices[:, 0])]), "w.vtp")
