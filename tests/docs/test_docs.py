"""Every option is documented, and every command line of the documents runs as printed."""

import re
import runpy
import shlex
import shutil
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

import click
import pytest

from geomhw_cli.main import program
from support.pictures import needs_opengl
from support.program import run

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
REFERENCE = ROOT / "examples" / "reference"
OPTIONS_PAGE = (REFERENCE / "options.md").read_text(encoding="utf-8")
DOCUMENTS = sorted([ROOT / "README.md", *ROOT.glob("examples/**/*.md"), ROOT / "data" / "README.md"])
PROGRAMS = ("geomhw", "make", "python", "pip", "pytest", "eval")
#: Lines that are not run here, and why; ``make -n`` is run all the same.
ELSEWHERE = {
    "README.md": {
        "make demo": "makes an environment",
        "make test": "is what runs",
        "pip install .": "needs a network; test_packaging builds the wheel",
    },
    "examples/flow/README.md": {"make": "takes a minute; test_examples runs it on small spheres"},
    "examples/handout/README.md": {
        "make": "takes a minute; test_examples runs it",
        "make MESH=../../data/genus2.off": "takes as long",
    },
    "examples/reference/distributed.md": {"make test-mpi": "installs PETSc and MPI"},
    "examples/golden/README.md": {"make": "is run by test_golden", "make renew": "is run by test_golden"},
}


@dataclass
class Page:
    """The command lines of a document or of a command's help, and the folder where they run.

    elsewhere: lines that are not run.

    Each line needs the files of those before it; asking for one answer runs them all, once.
    """

    name: str
    lines: list[str]
    place: str = "."
    elsewhere: list[str] = field(default_factory=list)
    folder: Path | None = None
    answers: list[tuple[int, str]] = field(default_factory=list)

    def answer(self, number: int, clone: Callable[[], Path]) -> tuple[int, str]:
        """Return the exit code and output of a line."""
        self.folder = self.folder or clone()
        while len(self.answers) <= number:
            self.answers.append(typed(self.lines[len(self.answers)], self.folder / self.place))
        return self.answers[number]


def typed(line: str, folder: Path) -> tuple[int, str]:
    """Run a line in a folder: geomhw in this process, others in bash."""
    words = shlex.split(line, comments=True)
    if words[0] == "geomhw" and not re.search(r"[|<>;&$`]", line):
        with pytest.MonkeyPatch.context() as patch:
            patch.chdir(folder)
            answer = run(*words[1:])
        return answer.exit_code, answer.output
    bin_first = f'PATH="{Path(sys.executable).parent}:$PATH"; {line}'
    done = subprocess.run(["bash", "-c", bin_first], cwd=folder, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def blocks(text: str) -> Iterator[str]:
    """Yield indented code, and fenced code without a language."""
    fenced = re.compile(r"^```(.*)\n((?:.*\n)*?)```$", re.MULTILINE)
    yield from (match[2] for match in fenced.finditer(text) if match[1] in ("", "sh", "bash"))
    lines = fenced.sub("", text).split("\n")
    indented = [line[4:] if line.startswith("    ") else "" for line in lines]
    yield "\n".join(indented)


def command_lines(text: str) -> list[str]:
    """Return the lines of code that start with a program's name."""
    joined = "\n".join(blocks(text)).replace("\\\n", " ")
    return [line.strip() for line in joined.split("\n") if line.split(" ")[0] in PROGRAMS]


def bare(line: str) -> str:
    """Remove the comment."""
    return line.split(" #")[0].strip()


def pages() -> list[Page]:
    """Return all documents, then the help of each command."""
    found = []
    for path in DOCUMENTS:
        name = path.relative_to(ROOT).as_posix()
        at_top = path.parent in (ROOT, ROOT / "data", REFERENCE)
        place = "." if at_top else path.parent.relative_to(ROOT).as_posix()
        lines = command_lines(path.read_text(encoding="utf-8"))
        skipped = [line for line in lines if bare(line) in ELSEWHERE.get(name, {})]
        found.append(Page(name, [line for line in lines if line not in skipped], place, skipped))
    for name, command in program.commands.items():
        help_text = textwrap.dedent(command.help or "")
        found.append(Page(f"geomhw {name} --help", re.findall(r"^ +(geomhw .*)$", help_text, re.MULTILINE)))
    return found


PAGES = pages()
LINES = [
    pytest.param(page, number, id=f"{page.name}: {line}") for page in PAGES for number, line in enumerate(page.lines)
]


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Callable[[], Path]:
    """Return a function that copies what a fresh clone has, as far as the documents use it."""

    def copy() -> Path:
        folder = tmp_path_factory.mktemp("clone")
        made = shutil.ignore_patterns("*.gif", "out", "new", "__pycache__")
        for name in ("data", "examples"):
            shutil.copytree(ROOT / name, folder / name, ignore=made)
        for name in ("Makefile", "pyproject.toml"):
            shutil.copy(ROOT / name, folder)
        return folder

    return copy


@needs_opengl
@pytest.mark.parametrize(("page", "number"), LINES)
def test_line_runs_as_printed(page: Page, number: int, clone: Callable[[], Path]) -> None:
    """Each printed line exits with code 0, in the folder of its document."""
    code, printed = page.answer(number, clone)
    assert code == 0, printed


def test_lines_not_run() -> None:
    """Lines that the tests skip stand in the documents, and make knows their goals."""
    for name, lines in ELSEWHERE.items():
        page = next(page for page in PAGES if page.name == name)
        assert set(lines) == set(map(bare, page.elsewhere))
        for line in lines:
            if line.startswith("make"):
                dry = subprocess.run([*line.split(), "-n"], cwd=ROOT / page.place, capture_output=True, text=True)
                assert dry.returncode == 0, dry.stderr


def test_every_command_has_an_example() -> None:
    """Each command has an example in its help and a line in the README's table."""
    for page in PAGES:
        if page.name.startswith("geomhw "):
            command = page.name.removesuffix(" --help")
            assert any(line.startswith(f"{command} ") for line in page.lines), page.name
            assert f"| `{command} " in README


OPTIONS = [
    pytest.param(command, option, id=f"{name} {option.opts[-1]}")
    for name, command in program.commands.items()
    for option in command.params
    if isinstance(option, click.Option)
]


@pytest.mark.parametrize(("command", "option"), OPTIONS)
def test_option_is_documented(command: click.Command, option: click.Option) -> None:
    """Every spelling is on the page of options; the help says what it does, and its default, if it has one."""
    for name in [*option.opts, *option.secondary_opts]:
        assert re.search(rf"`[^`]*(?<![\w-]){re.escape(name)}(?![\w-])", OPTIONS_PAGE), f"{name} is not documented"
    context = command.make_context("", [], resilient_parsing=True)
    shown = option.get_help_record(context)
    assert shown
    assert shown[1].strip()
    if not option.is_flag and not option.multiple and context.params.get(option.name) is not None:
        assert "default: " in shown[1]


def test_options_page_is_generated() -> None:
    """The page of options is what the script makes from the commands."""
    assert runpy.run_path(str(REFERENCE / "generate.py"))["options_page"]() == OPTIONS_PAGE


def test_documented_options_exist() -> None:
    """The README and the reference name no option that no command has."""
    known = {
        name for *_, option in (case.values for case in OPTIONS) for name in [*option.opts, *option.secondary_opts]
    }
    known |= {"--help"}
    for path in [ROOT / "README.md", *REFERENCE.glob("*.md")]:
        text = re.sub(r"`python [^`]*`", "", path.read_text(encoding="utf-8"))
        named = set(re.findall(r"(?<![\w-])--[a-z][\w-]*", text))
        assert named <= known, (path.name, named - known)


def test_documented_arrays() -> None:
    """Every array of the table in files.md is in the help of its command."""
    page = (REFERENCE / "files.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \|([^|]*)\|([^|]*)\|$", page, re.MULTILINE)
    checked = [name for name, *cells in rows if name in program.commands and check_arrays(name, " ".join(cells))]
    assert {"geodesic", "vecdiffuse", "advect", "fluid", "helmholtz"} <= set(checked)


def check_arrays(command: str, cells: str) -> bool:
    """Check that all arrays named in the cells are in the command's help; return whether there are any."""
    names = re.findall(r"`(\w+)`", cells)
    help_text = program.commands[command].help or ""
    missing = [name for name in names if not re.search(rf"\b{name}\b", help_text)]
    assert not missing, f"geomhw {command} --help lacks {missing}"
    return bool(names)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(path: Path) -> None:
    """Links, pictures and headings within the project exist."""
    for target in re.findall(r"\]\((?!https?:)([^)\s]+)\)", path.read_text(encoding="utf-8")):
        name, _, heading = target.partition("#")
        file = path.parent / unquote(name) if name else path
        assert file.exists(), target
        if heading:
            titles = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
            assert heading in {re.sub(r"[^\w-]", "", title.lower().replace(" ", "-")) for title in titles}, target


def test_figures_name_their_tests() -> None:
    """``pytest tests/FILE -k WORD`` beside a figure names tests that exist."""
    for path in DOCUMENTS:
        for file, word in re.findall(
            r"`pytest\s+(tests/[\w/]+\.py)(?:\s+-k\s+(\w+))?`", path.read_text(encoding="utf-8")
        ):
            assert re.search(rf"def test_\w*{word}|\[\w*{word}", (ROOT / file).read_text(encoding="utf-8")), (
                file,
                word,
            )


def test_goals_of_make(clone: Callable[[], Path]) -> None:
    """Each ``make GOAL`` in a sentence is a goal of the Makefile beside it or at the top."""
    folder = clone()
    for mesh in ("spot.obj", "kitten.obj"):
        (folder / "examples" / "films" / mesh).touch()
    for page in PAGES[: len(DOCUMENTS)]:
        for line in re.findall(r"`(make(?: [^`]*)?)`", (ROOT / page.name).read_text(encoding="utf-8")):
            tried = [typed(f"{line} -n", folder / place)[0] for place in dict.fromkeys([page.place, "."])]
            assert 0 in tried, f"{page.name}: {line}"


def test_python_of_the_readme(clone: Callable[[], Path]) -> None:
    """The lines of Python in the README run as printed."""
    (program_text,) = re.findall(r"^```python\n((?:.*\n)*?)```$", README, re.MULTILINE)
    done = subprocess.run([sys.executable, "-c", program_text], cwd=clone(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_citation_file() -> None:
    """CITATION.cff refers to papers of sources.md."""
    dois = re.findall(r"doi: (\S+)", (ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    listed = (REFERENCE / "sources.md").read_text(encoding="utf-8")
    assert len(dois) == 3
    assert all(f"doi = {{{doi}}}" in listed for doi in dois)


def test_completion_in_bash() -> None:
    """The line on the page about running makes bash complete commands, options and choices."""
    page = (REFERENCE / "running.md").read_text(encoding="utf-8")
    line = next(line for line in command_lines(page) if line.startswith("eval "))
    for words, expected in [
        (["geomhw", "geo"], "geodesic"),
        (["geomhw", "geodesic", "--ref"], "--refine"),
        (["geomhw", "fluid", "--scheme", "c"], "conservative"),
    ]:
        quoted = " ".join(map(shlex.quote, words))
        asked = f"COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _geomhw_completion geomhw; echo ${{COMPREPLY[@]}}"
        code, printed = typed(f"{line}; {asked}", ROOT)
        assert (code, printed.strip()) == (0, expected)
