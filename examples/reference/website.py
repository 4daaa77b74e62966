"""Makes the documentation as a site: ``python website.py [FOLDER]``, by default build/site. See ``make docs``.

Pages are the documents of the repository, the commands as the program prints them, and the library from its docstrings.
"""

import html
import importlib
import inspect
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import markdown

from geomhw_cli.main import program

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("mesh", "intrinsic", "operators", "solvers", "geodesic", "scalars", "transport", "flow", "fluid", "spectral")
ROOMS += ("io", "render", "compare", "results", "errors", "options")
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>{title} - geomhw</title><style>
body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 0 auto; padding: 1rem; }}
pre, code {{ font: 14px/1.4 ui-monospace, monospace; }} pre {{ overflow-x: auto; background: #f4f4f4; padding: .6rem; }}
table {{ border-collapse: collapse; display: block; overflow-x: auto; }}
td, th {{ border: 1px solid #ccc; padding: .2rem .5rem; }}
img {{ max-width: 100%; }} nav a {{ margin-right: 1rem; }}
@media (prefers-color-scheme: dark) {{
body {{ background: #181818; color: #ddd; }}
pre {{ background: #252525; }} a {{ color: #8bf; }} }}
</style></head><body><nav>{links}</nav>
{body}
</body></html>
"""


def documents() -> list[Path]:
    """Return the documents of the repository, the README first."""
    return [
        ROOT / "README.md",
        ROOT / "CHANGELOG.md",
        ROOT / "data" / "README.md",
        *sorted(ROOT.glob("examples/**/*.md")),
    ]


def target(document: Path) -> Path:
    """Return the page of a document, relative to the site; a README is the index of its folder."""
    relative = document.relative_to(ROOT)
    return relative.with_name("index.html" if relative.name == "README.md" else f"{relative.stem}.html")


def page(path: Path, title: str, body: str) -> str:
    """Return a whole page with links to the main ones."""
    up = "../" * (len(path.parts) - 1)
    names = {
        "index.html": "geomhw",
        "examples/index.html": "examples",
        "commands.html": "commands",
        "api.html": "library",
    }
    names |= {
        "examples/reference/index.html": "reference",
        "examples/methods/index.html": "methods",
        "CHANGELOG.html": "changes",
    }
    links = "".join(f'<a href="{up}{name}">{text}</a>' for name, text in names.items())
    return PAGE.format(title=html.escape(title), links=links, body=body)


def of_markdown(document: Path) -> str:
    """Return the body of a document, with links to pages in place of documents."""
    text = document.read_text(encoding="utf-8")
    body = markdown.markdown(text, extensions=["tables", "fenced_code", "toc"])

    def linked(match: re.Match[str]) -> str:
        name, anchor = match[1], match[2] or ""
        there = (document.parent / name).resolve()
        return f'href="{name[: -len(there.name)]}{target(there).name}{anchor}"' if there.is_file() else match[0]

    return re.sub(r'href="([^":#]+\.md)(#[^"]*)?"', linked, body)


def of_commands() -> str:
    """Return the help of each command as the program prints it."""
    parts = ["<h1>Commands</h1>"]
    for name, command in sorted(program.commands.items()):
        context = command.make_context(f"geomhw {name}", [], resilient_parsing=True)
        parts.append(f'<h2 id="{name}">geomhw {name}</h2><pre>{html.escape(command.get_help(context))}</pre>')
    return "\n".join(parts)


def of_library() -> str:
    """Return signature and docstring of each public name, room by room."""
    parts = ["<h1>Library</h1>"]
    for room in ROOMS:
        module: Any = importlib.import_module(f"geomhw.{room}")
        parts.append(f'<h2 id="{room}">geomhw.{room}</h2><p>{html.escape(inspect.getdoc(module) or "")}</p>')
        for name in sorted(n for n in dir(module) if not n.startswith("_")):
            thing = getattr(module, name)
            if not (inspect.isclass(thing) or inspect.isfunction(thing)) or not thing.__module__.startswith("geomhw"):
                continue
            parts.append(f'<h3 id="{room}.{name}">{name}</h3><pre>{html.escape(described(name, thing))}</pre>')
            for method, value in vars(thing).items() if inspect.isclass(thing) else ():
                function = getattr(value, "__func__", value)
                if not method.startswith("_") and inspect.isfunction(function) and function.__doc__:
                    parts.append(f"<h4>{name}.{method}</h4><pre>{html.escape(described(method, function))}</pre>")
    return "\n".join(parts)


def described(name: str, thing: Any) -> str:
    """Return signature and docstring."""
    try:
        signature = str(inspect.signature(thing))
    except (ValueError, TypeError):
        signature = ""
    return f"{name}{signature}\n\n{inspect.getdoc(thing) or ''}"


def main() -> None:
    """Write the site."""
    folder = Path(sys.argv[1]) if sys.argv[1:] else ROOT / "build" / "site"
    pages = {target(document): (document.stem, of_markdown(document)) for document in documents()}
    pages |= {Path("commands.html"): ("commands", of_commands()), Path("api.html"): ("library", of_library())}
    for path, (title, body) in pages.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(page(path, title, body), encoding="utf-8")
        for source in re.findall(r'(?:src|href)="([^":#]+\.(?:png|svg|gif|bib))"', body):
            if (picture := ROOT / path.parent / source).is_file():
                (folder / path.parent / source).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(picture, folder / path.parent / source)
    print(f"wrote {len(pages)} pages to {folder}")


if __name__ == "__main__":
    main()
