"""The limit of the operating system on a process's memory, checked before libraries that fail badly below it load."""

import os

from geomhw.errors import GeomhwError

#: Address space that numpy and scipy take, and that pictures take (VTK with its software renderer), in megabytes.
COMPUTING, DRAWING = 400, 1500


def require_memory(megabytes: int, purpose: str) -> None:
    """Raise an error if the limit on the address space (``ulimit -v``) is lower."""
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < megabytes * 10**6:
        have = limit // 10**6
        raise GeomhwError(
            f"there is not enough memory: the limit is {have:,} MB (ulimit -v), and {purpose} takes {megabytes:,} MB"
        )


def available_memory() -> int | None:
    """Bytes of memory of this machine, or of the limit on the process if that is less; None if they are not known."""
    try:
        import resource

        found = [os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    except (ImportError, ValueError, OSError):
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return min([*found, limit] if limit != resource.RLIM_INFINITY else found)
