"""What a factorization answers, whichever library makes it."""

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.errors import ConvergenceError

NO_SOLUTION = "the linear system has no finite solution; look for faces of nearly no area"
NOT_DEFINITE = "the matrix is not positive definite"


class Factorization(ABC):
    """Solves A x = b by a library, which solves for b as it stands."""

    def __call__(self, rhs: NDArray[Any], places: Ints | None = None, into: NDArray[Any] | None = None) -> NDArray[Any]:
        """x for one right-hand side, (n,), or several, (n, k); ConvergenceError if it is not finite.

        places: (n,), where they stand in longer vectors; the solution is then put there.
        """
        x = self._solved(rhs if places is None else rhs[places])
        if not np.isfinite(x).all():
            raise ConvergenceError(NO_SOLUTION)
        if into is None:
            return x
        into[places] = x
        return into

    @abstractmethod
    def _solved(self, b: NDArray[Any]) -> NDArray[Any]:
        """x, of the shape of b, complex if A or b is."""
