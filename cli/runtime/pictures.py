"""Files of pictures: PNG with metadata, SVG and PDF; and the renderer, loaded while a method computes."""

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geomhw_cli.runtime.memory import DRAWING, require_memory
from geomhw_cli.specs.files import require_writable
from geomhw_cli.specs.looks import take_look

if TYPE_CHECKING:
    from geomhw.render.look import Look
    from geomhw.render.panels import Picture

COMMAND_LINE = "geomhw.command_line"
#: Kinds of files that hold one picture.
KINDS = ("png", "svg", "pdf")


@dataclass
class PictureFiles:
    """Paths of the pictures of a run by kind, their look and their dots per inch."""

    paths: dict[str, Path]
    look: "Look"
    dpi: float | None = None

    @classmethod
    def take(cls, settings: dict[str, Any]) -> "PictureFiles":
        """Take the options of pictures out of the values of options."""
        paths = {kind: settings.pop(kind, None) for kind in KINDS}
        return cls({kind: path for kind, path in paths.items() if path}, take_look(settings), settings.pop("dpi", None))

    def require(self) -> None:
        """Check that the files can be written, and start to load the renderer in a thread."""
        for kind, path in self.paths.items():
            require_writable([path], [f".{kind}"])
        if self.paths:
            load_renderer()

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


def keep_command_line(context: click.Context, arguments: list[str]) -> None:
    """Keep the command line, which pictures carry."""
    context.meta[COMMAND_LINE] = shlex.join(["geomhw", *arguments])


def load_renderer() -> None:
    """Start to import pyvista, while the main thread computes."""
    from geomhw.render.offscreen import pyvista_import

    require_memory(DRAWING, "drawing")
    pyvista_import()
