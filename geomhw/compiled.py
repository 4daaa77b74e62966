"""Compiled loops: the one way of compiling here, by numba, with machine code cached on disk."""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Decorate a plain loop over arrays: compiled on first use, without changing the order of operations.

    Division by zero gives inf or NaN, as in numpy. Compiling takes a second once per machine. Other Python threads run
    meanwhile. Import modules with compiled loops where they are used, since numba takes 0.2 s to load.
    """
    return njit(cache=True, nogil=True, error_model="numpy")(function)


def compiled_in_place(function: F) -> F:
    """Decorate, as `compiled`, a loop that allocates no memory and calls only such loops.

    Array references are not counted. Counting takes half of the time where small functions call each other often.
    """
    return njit(cache=True, nogil=True, error_model="numpy", _nrt=False)(function)
