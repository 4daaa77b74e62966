"""Compiled loops: the one way of compiling here, by numba, with machine code cached on disk."""

import logging
from collections.abc import Callable
from threading import Timer
from typing import Any, TypeVar

from numba import njit
from numba.core import event
from numba.core.caching import FunctionCache
from numba.core.runtime import rtsys

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
        loop._cache = _MachineCode(function)
        loop._cache.allocates = options.get("_nrt", True)
    except RuntimeError:  # no cache folder can be written
        pass
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


class _MachineCode(FunctionCache):  # type: ignore[misc]
    """Cached machine code, loaded without the declarations that only compiling needs: they take 0.2 s.

    allocates: whether the loop allocates memory.
    """

    allocates = True

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the code for arguments of some types; None if there is none, and numba compiles it."""
        if self.allocates:
            rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


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
