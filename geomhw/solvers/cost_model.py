"""What solvers cost, as measured: seconds by the number of unknowns and of right-hand sides to come.

The constants are those that ``python tests/benchmarks/solver_costs.py`` prints. Nothing is timed at run time, for the
choice, and with it the last digits, must not depend on what else a machine does.
"""

from dataclasses import dataclass
from typing import Literal

from geomhw.solvers.cholmod import installed

FactorName = Literal["superlu", "blocks", "cholmod"]
Kind = Literal["superlu", "blocks", "cholmod", "multigrid", "sweeps"]


@dataclass(frozen=True)
class Work:
    """So many solutions are to come, so many of them at once."""

    solves: int = 1
    at_once: int = 1


#: Of a solver that is made for one question, and of one that is used now and then.
ONE = Work()
OCCASIONAL = Work(solves=100)

#: With fewer unknowns results are the same to the last bit whether the extra is installed or not.
EXTRA = 5000


@dataclass(frozen=True)
class _Cost:
    """Seconds with n unknowns, each as factor c and power p of c nᵖ: to set up, for a solution alone, and for each of
    many at once."""

    setup: tuple[float, float]
    alone: tuple[float, float]
    together: tuple[float, float]

    def of(self, n: int, work: Work) -> float:
        """All of the work."""
        setup, alone, together = (c * float(n) ** p for c, p in (self.setup, self.alone, self.together))
        return setup + work.solves * (together + max(alone - together, 0.0) / work.at_once)


_COSTS: dict[Kind, _Cost] = {
    "superlu": _Cost((7.8e-9, 1.85), (1.2e-9, 1.57), (2.5e-10, 1.68)),
    "blocks": _Cost((9.3e-6, 1.04), (9.0e-8, 1.24), (1.7e-9, 1.34)),
    "cholmod": _Cost((1.4e-7, 1.35), (1.4e-8, 1.25), (1.4e-8, 1.25)),
    "multigrid": _Cost((3.1e-7, 1.0), (7.4e-7, 1.02), (7.4e-7, 1.02)),
    "sweeps": _Cost((0.0, 0.0), (7.2e-7, 1.02), (7.2e-7, 1.02)),
}


def seconds(kind: Kind, n: int, work: Work) -> float:
    """What the model says."""
    return _COSTS[kind].of(n, work)


def cheapest(n: int, work: Work) -> FactorName:
    """The factorization for that work, of those that can be made here."""
    names: list[FactorName] = ["superlu", "blocks"]
    if n >= EXTRA and installed():
        names.append("cholmod")
    return min(names, key=lambda name: seconds(name, n, work))
