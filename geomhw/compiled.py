"""Compiled loops: the one way of compiling here, by numba, with machine code cached on disk."""

import logging
from collections.abc import Callable
from functools import partial
from threading import Timer
from typing import Any, TypeVar

from numba import njit
from numba.core import event

F = TypeVar("F", bound=Callable[..., Any])
#: Seconds of compilation after which it is logged.
SLOW = 1.0


def compiled(function: F, **options: Any) -> F:
    """Decorate a plain loop over arrays: compiled on first use, without changing the order of operations.

    Division by zero gives inf or NaN, as in numpy. Compiling takes seconds once per machine, or once per process if no
    cache folder can be written. Other Python threads run meanwhile. Import modules with compiled loops where they are
    used, since numba takes 0.2 s to load.
    """
    loop = njit(nogil=True, error_model="numpy", **options)(function)
    try:
        loop.enable_caching()
    except RuntimeError:  # no cache folder can be written
        return loop
    loop._cache.load_overload = partial(_load_code, loop._cache, options.get("_nrt", True))
    return loop


def compiled_in_place(function: F) -> F:
    """Decorate, as `compiled`, a loop that allocates no memory and calls only such loops.

    Array references are not counted. Counting takes half of the time where small functions call each other often.
    """
    return compiled(function, _nrt=False)


def compiled_inline(function: F) -> F:
    """Decorate, as `compiled_in_place`, a loop that becomes a part of its callers.

    Each array of an argument is seven words, which a call copies to the stack.
    """
    return compiled(function, _nrt=False, forceinline=True)


def _load_code(cache: Any, allocates: bool, sig: Any, target_context: Any) -> Any:
    """Return cached machine code for arguments of some types; None if there is none, and numba compiles it.

    numba itself first loads the declarations that only compiling needs, which takes 0.2 s. Code that allocates memory
    needs its runtime.
    """
    try:
        if allocates:
            from numba.core.runtime import rtsys

            rtsys.initialize(target_context)
        with cache._guard_against_spurious_io_errors():
            return cache._load_overload(sig, target_context)
    except (ImportError, AttributeError):  # a numba whose parts have other names
        return type(cache).load_overload(cache, sig, target_context)


class _CompilationNotice(event.Listener):  # type: ignore[misc]
    """Logs one line for the first compilation of a process that takes long; by default, logs go to stderr."""

    def __init__(self) -> None:
        self._depth, self._timer = 0, Timer(SLOW, self._notify)

    def on_start(self, event: Any) -> None:
        """Start the clock."""
        if self._depth == 0:
            self._timer = Timer(SLOW, self._notify)
            self._timer.daemon = True
            self._timer.start()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """Stop the clock."""
        self._depth -= 1
        if self._depth == 0:
            self._timer.cancel()

    def _notify(self) -> None:
        logging.getLogger("geomhw").warning("compiling loops for this machine; later runs use the compiled code")
        event.unregister("numba:compile", self)


event.register("numba:compile", _CompilationNotice())
