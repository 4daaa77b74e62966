"""The files in data/ are those that their generator makes."""

import importlib.util
import shutil
from pathlib import Path

import numpy as np
import pytest

from support.meshes import volume
from support.messages import missing

DATA = Path(__file__).parents[2] / "data"


@pytest.fixture(scope="module")
def generator():
    """Load data/generate.py, which is a script."""
    spec = importlib.util.spec_from_file_location("generate", DATA / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_data_is_what_the_generator_makes(generator):
    """Each file in data/ is what the generator writes."""
    assert generator.check() == []


def test_data_check_notices_a_change(generator, tmp_path):
    """The check names a file with a coordinate off by 1e-8, and one whose hash is not in the table."""
    shutil.copytree(DATA, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "strip.off"
    file.write_text(file.read_text().replace("\n1 0 0\n", "\n1 0.00000001 0\n", 1))
    hashed, compared = generator.check(tmp_path)
    assert not missing(hashed, "strip.off ... sha256 ... README.md")
    assert not missing(compared, "strip.off ... differs ... generate.py")


def test_creature(generator):
    """The creature is closed, connected, of genus 0, symmetric and Delaunay, with good triangles."""
    mesh = generator.creature()
    assert 1300 <= mesh.n_vertices <= 1700
    assert (mesh.is_closed, mesh.is_oriented, mesh.n_components, mesh.genus) == (True, True, 1, 0)
    assert volume(mesh) > 0
    assert np.degrees(mesh.angles.min()) > 15
    assert mesh.edge_cotan_weights.min() > -1e-9
    mirrored = mesh.vertices * [1, 1, -1]
    gaps = np.linalg.norm(mesh.vertices[:, None] - mirrored, axis=2).min(axis=1)
    assert gaps.max() < 1e-9
    assert abs(mesh.vertices[:, 1].min()) < 0.02
