"""The site of the documentation has a page for each document, command and public name, and no dead link."""

import re
import runpy
import sys
from pathlib import Path

import pytest

from geomhw_cli.main import program

pytest.importorskip("markdown")
ROOT = Path(__file__).parents[2]


def test_site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Local links and pictures exist; commands and library are complete."""
    monkeypatch.setattr(sys, "argv", ["website.py", str(tmp_path)])
    runpy.run_path(str(ROOT / "examples" / "reference" / "website.py"), run_name="__main__")
    pages = sorted(tmp_path.rglob("*.html"))
    assert len(pages) > 30
    for page in pages:
        text = re.sub(r"<pre>.*?</pre>", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        for link in re.findall(r'(?:href|src)="([^":#]+\.(?:html|png|md))', text):
            assert (page.parent / link).resolve().is_file(), f"{page.name}: {link}"
    commands = (tmp_path / "commands.html").read_text(encoding="utf-8")
    assert all(f'id="{name}"' in commands for name in program.commands)
    library = (tmp_path / "api.html").read_text(encoding="utf-8")
    for name in ("mesh.TriangleMesh", "scalars.smooth", "geodesic.ExactDistance", "io.read", "results.Result"):
        assert f'id="{name}"' in library
