"""Supernodal Cholesky factorization by CHOLMOD, where kvxopt is installed: ``pip install geomhw[fast]``.

Fast to factor and for one right-hand side at a time; of many it solves one after the other.

Chen, Davis, Hager, Rajamanickam: Algorithm 887: CHOLMOD. ACM Trans. Math. Softw. 35(3), 2008.
"""

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from geomhw.errors import ConvergenceError
from geomhw.solvers.factorization import NO_SOLUTION, NOT_DEFINITE, Factorization

#: A solution whose residual is larger than this share of what it is made of is none.
RESIDUAL = 1e-6
SUPERNODAL = 2


@cache
def installed() -> bool:
    """Whether it can be used here."""
    return find_spec("kvxopt") is not None


@cache
def _library() -> tuple[Any, Any, ThreadpoolController]:
    """kvxopt, its module for CHOLMOD, and the threads of the BLAS that is loaded with it."""
    return import_module("kvxopt"), import_module("kvxopt.cholmod"), ThreadpoolController()


class Cholmod(Factorization):
    """Solves A x = b for A symmetric, or Hermitian, and positive definite; ConvergenceError if it is not."""

    def __init__(self, matrix: sp.csr_array) -> None:
        kvxopt, cholmod, threads = _library()
        self._dtype = np.result_type(matrix.dtype, np.float64)
        lower = sp.tril(matrix).tocoo()
        places = (kvxopt.matrix(index.astype(np.int64)) for index in lower.coords)
        A = kvxopt.spmatrix(kvxopt.matrix(lower.data.astype(self._dtype)), *places, matrix.shape)
        cholmod.options.update({"supernodal": SUPERNODAL, "print": 0})
        b = np.ones(matrix.shape[0], dtype=self._dtype)
        try:
            with threads.limit(limits=1, user_api="blas"):
                self._factor = cholmod.symbolic(A)
                cholmod.numeric(A, self._factor)
            x = self(b)
        except (ArithmeticError, ConvergenceError) as error:
            raise ConvergenceError(NOT_DEFINITE) from error
        # It may go on with a matrix that is not definite, to a factor of something else.
        if np.abs(matrix @ x - b).max() > RESIDUAL * (abs(matrix) @ np.abs(x)).max():
            raise ConvergenceError(NOT_DEFINITE)

    def _solved(self, b: NDArray[Any]) -> NDArray[Any]:
        if b.dtype.kind == "c" and self._dtype.kind != "c":
            return np.asarray(self._solved(b.real) + 1j * self._solved(b.imag))
        kvxopt, cholmod, threads = _library()
        x = kvxopt.matrix(b.reshape(len(b), -1).astype(self._dtype))
        try:
            with threads.limit(limits=1, user_api="blas"):
                cholmod.solve(self._factor, x)
        except ArithmeticError as error:
            raise ConvergenceError(NO_SOLUTION) from error
        return np.array(x).reshape(b.shape)
