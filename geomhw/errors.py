"""What can go wrong, as one small family: every message is one sentence that says what, where and what to do."""

_LONGEST = 2000


class GeomhwError(Exception):
    """Anything this package refuses or fails at; the command line turns it into one line and exit code 1.

    A message may quote what stands in a file: whatever that is, it stays one printable line of bounded length.
    """

    def __str__(self) -> str:
        told = super().__str__()
        if len(told) > _LONGEST:
            told = f"{told[: _LONGEST - 200]} ... {told[-195:]}"
        if told.isprintable():
            return told
        return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in told)


class MeshError(GeomhwError):
    """The mesh cannot carry the computation (an index out of range, a face without area, ...)."""


class FormatError(GeomhwError):
    """A file cannot be read or written (its name, its syntax, its extension)."""


class FieldError(GeomhwError):
    """An array on the mesh has the wrong size, place or values, or a source is not a vertex."""


class ConvergenceError(GeomhwError):
    """A solver could not reach the accuracy it promises."""


class RenderError(GeomhwError):
    """A picture cannot be drawn here (no OpenGL library, no film encoder)."""
