"""Multigrid loads its libraries before its thread starts."""

import subprocess
import sys


def test_no_imports_in_the_background() -> None:
    """The libraries of multigrid are loaded before its set-up starts in another thread."""
    program = """
import sys
import numpy as np
import scipy.sparse as sp
from geomhw.solvers import auto

before = set(sys.modules)
loaded = []
make = auto.MultigridSolver

def recording(*arguments):
    loaded.append(set(sys.modules))
    made = make(*arguments)
    loaded.append(set(sys.modules))
    return made

auto.MultigridSolver = recording
chain = sp.csr_array(sp.diags_array([-1.0, 2.5, -1.0], offsets=[-1, 0, 1], shape=(500, 500)))
solver = auto.LaplaceSolver(chain, np.ones(500, dtype=bool), "multigrid")
solver.begin()
np.testing.assert_allclose(chain @ solver(np.ones(500)), 1, rtol=1e-6)
assert "pyamg.aggregation" not in before
assert loaded[0] == loaded[1], loaded[1] - loaded[0]
"""
    subprocess.run([sys.executable, "-c", program], check=True)
