"""MPI ranks: sums over all of them, exchange of rows between them, errors that all of them raise."""

import ctypes
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from time import sleep
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Ints
from geomhw.errors import ArgumentError, GeomhwError

#: Seconds that a rank that fails waits for the others to fail, too, and between looks.
PATIENCE, PAUSE = 5.0, 0.01


class Ranks:
    """The ranks of an MPI communicator.

    Attributes
    ----------
    comm : mpi4py communicator.
    rank, size : int
        The number of this rank, and of all ranks.
    bytes_sent : int
        Bytes that this rank has sent to others so far, without sums over all ranks.
    """

    def __init__(self, comm: Any, petsc: Any) -> None:
        self.comm, self.petsc = comm, petsc
        self.rank, self.size = int(comm.Get_rank()), int(comm.Get_size())
        self.bytes_sent = 0

    def shares(self, count: int) -> Ints:
        """Return the first of ``count`` items that each rank takes, and the end, (size + 1,)."""
        return np.arange(self.size + 1) * count // self.size

    def sum(self, value: Any) -> Any:
        """Sum a number or array over all ranks."""
        return self.comm.allreduce(value)

    def max(self, value: Any) -> Any:
        """Return the largest value of all ranks."""
        return max(self.comm.allgather(value))

    def min(self, value: Any) -> Any:
        """Return the smallest value of all ranks."""
        return min(self.comm.allgather(value))

    def starts(self, count: int) -> Ints:
        """Return the sums of the counts of the ranks before each rank, and of all ranks, (size + 1,)."""
        return np.concatenate([[0], np.cumsum(self.comm.allgather(count))])

    def exchange(self, rows: NDArray[Any], counts: Ints) -> tuple[NDArray[Any], Ints]:
        """Send rows, grouped by destination with these counts, (size,); return those received and their counts."""
        rows = np.ascontiguousarray(rows)
        received = np.empty(self.size, dtype=np.int64)
        self.comm.Alltoall(np.ascontiguousarray(counts, dtype=np.int64), received)
        return self.send(rows, counts, received), received

    def send(self, rows: NDArray[Any], counts: Ints, received: Ints) -> NDArray[Any]:
        """Exchange rows, grouped by destination, where each rank knows how many it receives from each."""
        from mpi4py import MPI

        rows = np.ascontiguousarray(rows)
        found = np.empty((int(received.sum()), *rows.shape[1:]), dtype=rows.dtype)
        width = rows.itemsize * int(np.prod(rows.shape[1:]))
        kind = MPI.BYTE.Create_contiguous(width).Commit()
        try:
            begins = np.cumsum(counts) - counts, np.cumsum(received) - received
            self.comm.Alltoallv([rows, (counts, begins[0]), kind], [found, (received, begins[1]), kind])
        finally:
            kind.Free()
        self.bytes_sent += width * int(np.sum(counts) - counts[self.rank])
        return found

    @contextmanager
    def agreeing(self) -> Iterator[None]:
        """Run a block that communicates with no other rank; if it fails on one rank, raise its error on all."""
        error: GeomhwError | None = None
        try:
            yield
        except GeomhwError as found:
            error = found
        except OSError as found:
            error = GeomhwError(f"{found.filename or 'a file'}: {found.strerror or found}")
        except MemoryError:
            error = GeomhwError(f"rank {self.rank} has not enough memory for its part of the mesh; start more ranks")
        errors = self.comm.allgather(error and (type(error), str(error), error.remedy))
        for kind, text, remedy in filter(None, errors):
            raise kind(text, remedy)

    @contextmanager
    def stopping_together(self) -> Iterator[None]:
        """Run a block that communicates; an error on one rank alone ends all ranks, with its message.

        A rank that fails waits for the others; those that work on never arrive.
        """
        others = self.comm.Dup()
        try:
            yield
        except Exception as error:
            arrived = others.Ibarrier()
            for _ in range(int(PATIENCE / PAUSE)):
                if arrived.Test():
                    raise
                sleep(PAUSE)
            text = str(error) if isinstance(error, GeomhwError) else f"{type(error).__name__}: {error}"
            print(f"Error: rank {self.rank}: {' '.join(text.split())}", file=sys.stderr, flush=True)
            self.comm.Abort(1)


def release_memory() -> None:
    """Return freed memory to the system, where the C library keeps it for later arrays (glibc)."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def connect() -> Ranks:
    """Start MPI and PETSc, and return all ranks.

    Raises
    ------
    ArgumentError
        If mpi4py or petsc4py cannot be loaded.
    """
    try:
        import petsc4py

        petsc4py.init([])
        from mpi4py import MPI
        from petsc4py import PETSc
    except (ImportError, AttributeError) as error:  # the latter where petsc4py was built for another numpy
        raise ArgumentError(
            f"mpi4py and petsc4py are needed, and do not load ({error}); "
            "on Debian: apt install python3-petsc4py python3-mpi4py openmpi-bin"
        ) from error
    PETSc.Sys.popErrorHandler()
    return Ranks(MPI.COMM_WORLD, PETSc)
