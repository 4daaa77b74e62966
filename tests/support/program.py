"""Runs the program in this process, and inspects its answer and the files that it leaves."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from click.testing import CliRunner, Result

from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw_cli.main import program
from support.messages import missing


def run(*arguments: str | Path, stdin: bytes | None = None) -> Result:
    """Run the program and return its answer; exceptions other than a clean exit are raised."""
    answer = CliRunner().invoke(program, [str(argument) for argument in arguments], input=stdin)
    if answer.exception is not None and not isinstance(answer.exception, SystemExit):
        raise answer.exception
    return answer


def save_off(mesh: TriangleMesh, name: str = "ball.off") -> Path:
    """Write a mesh as an OFF file."""
    lines = ["OFF", f"{mesh.n_vertices} {mesh.n_faces} 0"]
    lines += [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]
    Path(name).write_text("\n".join(lines) + "\n")
    return Path(name)


def files(folder: Path) -> list[str]:
    """Return the names in a folder, hidden ones too."""
    return sorted(path.name for path in folder.iterdir())


def one_line(answer: Result, *words: str) -> None:
    """Check for exit code 1, one line on stderr with these keywords, and nothing on stdout."""
    assert answer.exit_code == 1
    assert answer.stdout == ""
    (line,) = answer.stderr.strip().splitlines()
    for word in words:
        assert not missing(line, word)


def contents(folder: Path) -> dict[str, bytes]:
    """Return every file of a folder and of the folders in it."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@contextmanager
def files_no_larger_than(size: int) -> Iterator[None]:
    """Make writing beyond a size fail, as on a full disk."""
    import resource  # not on Windows

    former = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, former[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, former)
