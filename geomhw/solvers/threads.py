"""How many threads dense algebra takes: one."""

from typing import Any

from threadpoolctl import ThreadpoolController

#: Solvers call BLAS for thousands of small blocks; threads for them cost ten times what they do.
_blas = ThreadpoolController()


def single_threaded() -> Any:
    """A context in which BLAS runs on one thread: faster for small blocks, and the same bits on every machine."""
    return _blas.limit(limits=1, user_api="blas")
