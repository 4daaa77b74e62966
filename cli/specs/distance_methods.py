"""The choice between the heat method and fronts, exact or fast, the options of each, and their solvers."""

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any

import click

from geomhw.options import DistanceMethodName
from geomhw_cli.options import is_given
from geomhw_cli.specs.queries import Rows

if TYPE_CHECKING:
    from geomhw.geodesic.front_distance import FrontDistance
    from geomhw.geodesic.heat_method import HeatDistance
    from geomhw.mesh.triangle_mesh import TriangleMesh

#: Options of the heat method, and of fronts, only, by parameter name.
HEAT_OPTIONS, FRONT_OPTIONS = ("time", "robust", "refine", "bound", "boundary", "solver"), ("limit", "to")


@dataclass(frozen=True)
class DistanceMethod:
    """A method, and the values of its options: arguments of `HeatDistance`, or ``limit``."""

    name: DistanceMethodName
    settings: dict[str, Any]

    @classmethod
    def parse(
        cls, name: DistanceMethodName, heat: dict[str, Any], limit: float | None, has_columns: bool
    ) -> "DistanceMethod":
        """Read the options of the current command. Raises UsageError for an option of the other method.

        has_columns: whether ``--to`` selects columns of a matrix, which both methods allow.
        """
        other, options = ("exact or fast-marching", FRONT_OPTIONS) if name == "heat" else ("heat", HEAT_OPTIONS)
        allowed = "to" if has_columns else None
        if given := next((option for option in options if option != allowed and is_given(option)), None):
            raise click.UsageError(f"--{given} is for --method {other}.")
        return cls(name, heat if name == "heat" else {"limit": inf if limit is None else limit})

    def report(self) -> dict[str, Any]:
        """Return what identifies the method in the record of a resumable run."""
        return self.settings if self.name == "heat" else {"method": self.name, **self.settings}

    def front(self, mesh: "TriangleMesh") -> "FrontDistance":
        """Return the solver of a method that is a front."""
        if self.name == "exact":
            from geomhw.geodesic.exact import ExactDistance

            return ExactDistance(mesh)
        from geomhw.geodesic.fast_marching import FastMarchingDistance

        return FastMarchingDistance(mesh)

    def solver(self, mesh: "TriangleMesh", queries: int = 1) -> "HeatDistance | FrontDistance":
        """Return the solver on a mesh for about this number of queries."""
        if self.name != "heat":
            return self.front(mesh)
        from geomhw.geodesic.heat_method import HeatDistance

        solver = HeatDistance(mesh, **self.settings, queries=queries)
        if queries > 1:
            solver.prepare()
        return solver

    def rows(self, solver: "HeatDistance | FrontDistance") -> Rows:
        """Return the function that computes rows of distances."""
        from geomhw.geodesic.heat_method import HeatDistance

        if isinstance(solver, HeatDistance):
            return lambda sets, _targets: solver.rows(sets)
        return lambda sets, targets: solver.rows(sets, self.settings["limit"], targets)
