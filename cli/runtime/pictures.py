"""Files of pictures: PNG with metadata, SVG and PDF; and the process that draws them."""

import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli.runtime import renderer
from geomhw_cli.runtime.picture_kinds import FILMS, KINDS
from geomhw_cli.specs.files import require_writable
from geomhw_cli.specs.looks import take_look

if TYPE_CHECKING:
    from geomhw.render.look import Look
    from geomhw.render.panels import Picture
    from geomhw.results import Result

COMMAND_LINE = "geomhw.command_line"
#: Extensions of pages for the browser.
PAGES = (".html", ".htm")


@dataclass
class PictureFiles:
    """Paths of the pictures of a run by kind, their look and their dots per inch, and the page for the browser."""

    paths: dict[str, Path]
    look: "Look"
    dpi: float | None = None
    page: Path | None = None

    @classmethod
    def take(cls, settings: dict[str, Any]) -> "PictureFiles":
        """Take the options of pictures out of the values of options."""
        paths = {kind: path for kind in KINDS if (path := settings.pop(kind, None))}
        if paths or any(settings.get(kind) for kind in FILMS):
            click.get_current_context().call_on_close(renderer.end)
            renderer.started()
        return cls(paths, take_look(settings), settings.pop("dpi", None), settings.pop("html", None))

    def stand_as(self, read: "Result") -> None:
        """Let what points up in the format of a file that was read point up, unless the user chose otherwise."""
        from geomhw.io.reading import upward_axis

        self.look = replace(self.look, file_up=upward_axis(read))

    @property
    def files(self) -> list[Path]:
        """All files that are written."""
        return [*self.paths.values(), *([self.page] if self.page else [])]

    def require(self) -> None:
        """Check that the files can be written."""
        for kind, path in self.paths.items():
            require_writable([path], [f".{kind}"])
        if self.page:
            require_writable([self.page], PAGES)

    @contextmanager
    def drawn(self) -> Iterator[None]:
        """Let the process that draws draw all pictures within the block, and end it."""
        from geomhw.render.panels import drawn_by

        with drawn_by(renderer.started().opened):
            yield
        renderer.end()

    def write_page(self, frames: "Sequence[Result]", times: Sequence[float] = (0.0,), **layers: Any) -> list[str]:
        """Write the page, if there is one to write, and return its name. layers: as of `geomhw.render.page`."""
        if self.page is None:
            return []
        write_page(self.page, frames, times, look=self.look, **layers)
        return [str(self.page)]

    def write(self, picture: "Picture") -> list[str]:
        """Write a picture to all files or none, and return their names."""
        from geomhw import __version__
        from geomhw.io import replacing, together, write_png
        from geomhw.render.panels import save_vector

        line = str(click.get_current_context().find_root().meta.get(COMMAND_LINE, ""))
        with together():
            for kind, path in self.paths.items():
                if kind == "png":
                    write_png(path, picture, self.dpi, {"Software": f"geomhw {__version__}", "Description": line})
                    continue
                with replacing([path]) as (temporary,):
                    save_vector(temporary, picture, self.dpi or 100.0, f"geomhw {__version__}: {line}")
        return [str(path) for path in self.paths.values()]


def write_page(path: Path, frames: "Sequence[Result]", times: Sequence[float] = (0.0,), **layers: Any) -> None:
    """Write a page for the browser, whole or not at all."""
    from geomhw.io import replacing
    from geomhw.render import page

    text = page(frames, times, **{"title": path.stem, **layers})
    with replacing([path]) as (temporary,):
        temporary.write_text(text, encoding="utf-8")


def keep_command_line(context: click.Context, arguments: list[str]) -> None:
    """Keep the command line, which pictures carry."""
    context.meta[COMMAND_LINE] = shlex.join(["geomhw", *arguments])
