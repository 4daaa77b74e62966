"""Exceptions of the package. Each message is one sentence: what is wrong, where, and what to do."""

from typing import Literal

#: An argument of a method that avoids an error.
Remedy = Literal["", "robust=True", "solver='direct'", "refine=False"]

_LONGEST = 2000


class GeomhwError(Exception):
    """Base class of the exceptions of this package; commands print the message and exit with code 1 or 2.

    A message may quote a file. It is shortened to 2,000 characters, and unprintable characters are escaped.

    remedy: the argument that avoids the error, which the message names too, or "" if there is none.
    """

    def __init__(self, message: str = "", remedy: Remedy = "") -> None:
        super().__init__(message)
        self.remedy = remedy

    def __str__(self) -> str:
        message = super().__str__()
        if len(message) > _LONGEST:
            message = f"{message[: _LONGEST - 200]} ... {message[-195:]}"
        if message.isprintable():
            return message
        return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in message)


class MeshError(GeomhwError):
    """A mesh is invalid or not suited to the computation, such as by a face of zero area."""


class FormatError(GeomhwError):
    """A file cannot be read or written: its name, syntax or extension."""


class FieldError(GeomhwError):
    """An array on a mesh has a wrong size, location or value, or a source does not exist."""


class ArgumentError(FieldError):
    """An argument is impossible on any mesh or on this one, such as a negative time step or a missing vertex.

    Commands exit with code 2.
    """


class ConvergenceError(GeomhwError):
    """An iteration did not reach the required accuracy."""


class RenderError(GeomhwError):
    """A picture or film cannot be made on this machine: no OpenGL library, no film encoder."""
