"""What the solvers cost on icospheres, grids and a strip: the measurements behind ``geomhw/solvers/costs.py``.

Prints milliseconds as Markdown, and for each kind of work the power of n that fits best, c and p of c·nᵖ seconds. One
thread: ``OPENBLAS_NUM_THREADS=1 python tests/benchmarks/solver_costs.py``.
"""

import time
from collections.abc import Callable

import numpy as np
import scipy.sparse as sp

from geomhw.geodesic.edge_paths import edge_path_distance
from geomhw.mesh.primitives import grid, icosphere, strip
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.operators.laplacian import stiffness
from geomhw.operators.mass import lumped_mass
from geomhw.solvers.cholmod import Cholmod, installed
from geomhw.solvers.fronts import BlockCholesky
from geomhw.solvers.heat_sweeps import over_relaxation, solve_by_sweeps
from geomhw.solvers.multigrid import MultigridSolver
from geomhw.solvers.nullspace import balanced, free_unknowns
from geomhw.solvers.superlu import SuperLU
from geomhw.solvers.threads import single_threaded

MESHES: dict[str, Callable[[], TriangleMesh]] = {
    **{f"icosphere({k})": lambda k=k: icosphere(k) for k in range(2, 7)},  # type: ignore[misc]
    "grid(100, 100)": lambda: grid(100, 100),
    "grid(250, 150)": lambda: grid(250, 150),
    "strip(5000)": lambda: strip(5000),
    "icosphere(7)": lambda: icosphere(7),
}
#: Beyond, only what iterates is measured, which is chosen between on large meshes alone.
FACTORED = 50_000
ITERATED = (6, 7, 8)
AT_ONCE = 64
KINDS = {
    "SuperLU factor": 0, "a solve": 1, f"of {AT_ONCE}": 2,
    "blocks factor": 3, "a solve ": 4, f"of {AT_ONCE} ": 5,
    "multigrid set-up": 6, "a solve  ": 7, "sweeps": 8,
    **({"CHOLMOD factor": 9, "a solve   ": 10, f"of {AT_ONCE}  ": 11} if installed() else {}),
}  # fmt: skip


def main() -> None:
    """The table, and the fits."""
    print("| mesh | vertices | " + " | ".join(KINDS) + " |")
    print("|---" * (len(KINDS) + 2) + "|")
    sizes, rows = [], []
    for name, make in MESHES.items():
        mesh = make()
        with single_threaded():
            rows.append(measured(mesh))
        sizes.append(mesh.n_vertices)
        print(f"| {name} | {sizes[-1]:,} | " + " | ".join(f"{1000 * x:.2f}" for x in rows[-1]) + " |", flush=True)
    print("\nIcospheres from 642 vertices on, and for iterations from 10,242, c·nᵖ seconds:")
    for kind, column in KINDS.items():
        which = [3, 4, -1] if column in ITERATED else [1, 2, 3, 4]
        p, c = np.polyfit(np.log(sizes)[which], np.log([rows[k][column] for k in which]), 1)
        print(f"{kind.strip()}: {np.exp(c):.2e} n^{p:.2f}")


def measured(mesh: TriangleMesh) -> list[float]:
    """Seconds, in the order of the columns."""
    n, S = mesh.n_vertices, stiffness(mesh)
    A = sp.csr_array(lumped_mass(mesh) + mesh.mean_edge_length**2 * S)
    many = np.random.default_rng(0).random((n, AT_ONCE))
    one = many[:, 0].copy()
    impulse = np.zeros(n)
    impulse[0] = 1
    travel = edge_path_distance(mesh, np.array([0])) / mesh.mean_edge_length
    found: list[float] = []
    for make in (SuperLU, BlockCholesky):
        if n > FACTORED:
            found += 3 * [np.nan]
            continue
        solver = make(A)
        found += [best(lambda: make(A)), best(lambda: solver(one)), best(lambda: solver(many)) / AT_ONCE]  # noqa: B023
    free = free_unknowns(mesh.components, mesh.unreferenced_vertices)
    multigrid = MultigridSolver(S, free)
    b = balanced(one, mesh.components)
    found += [best(lambda: MultigridSolver(S, free)), best(lambda: multigrid(b))]
    omega = over_relaxation(mesh.vertex_areas, A.diagonal())
    found.append(best(lambda: solve_by_sweeps(A, impulse, travel, omega)))
    if installed() and n <= FACTORED:
        solver = Cholmod(A)
        found += [best(lambda: Cholmod(A)), best(lambda: solver(one)), best(lambda: solver(many)) / AT_ONCE]
    return found


def best(work: Callable[[], object]) -> float:
    """The shortest of three times, or of one that is long."""
    times = []
    for _ in range(3):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
        if times[0] > 2:
            break
    return min(times)


if __name__ == "__main__":
    main()
