"""``geomhw batch``: a folder and a row for each mesh; failures, resumption, parts and interrupts."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from geomhw.mesh.primitives import icosphere
from geomhw_cli.batch import NOT_FOR
from geomhw_cli.main import program
from geomhw_cli.runtime.mesh_batch import Task
from support.messages import missing
from support.program import contents, files, run, save_off

OPTIONS = ("--", "--tolerance", "1e-3", "-q")


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with two meshes of one name, and one that ends early."""
    for place in ("a", "b"):
        Path(place).mkdir()
        save_off(icosphere(1 if place == "a" else 0), f"{place}/ball.off")
    Path("b/cut.off").write_text("OFF\n3 1 0\n0 0 0\n")
    return folder


def rows(path: str = "out/results.csv") -> dict[str, dict[str, str]]:
    """Read the table by name."""
    with Path(path).open(newline="", encoding="utf-8") as stream:
        return {row["name"]: row for row in csv.DictReader(stream)}


def test_every_mesh_has_files_or_a_reason() -> None:
    """Meshes of a path, a folder and a list, and one that is not there: two done, two failed, each with its reason."""
    Path("list.txt").write_text("a/ball.off\nnowhere.off\n")
    answer = run("batch", "info", "@list.txt", "a/ball.off", "b", "--out", "out", "--json")
    assert answer.exit_code == 1
    assert (json.loads(answer.stdout)["meshes"], json.loads(answer.stdout)["failed"]) == (4, 2)
    found = rows()
    assert [row["mesh"] for row in found.values()] == ["a/ball.off", "nowhere.off", "b/ball.off", "b/cut.off"]
    assert [row["status"] for row in found.values()] == ["done", "failed", "done", "failed"]
    assert (found["ball"]["mesh.vertices"], found["ball-2"]["mesh.vertices"]) == ("42", "12")
    assert not missing(found["cut"]["reason"], "ends after 1 of 3")
    assert not missing(found["nowhere"]["reason"], "no such file")
    assert "Traceback" not in answer.stderr


def test_a_batch_goes_on_where_it_ended() -> None:
    """What is done is kept while mesh and options are the same; what failed is tried again."""
    answer = run("batch", "repair", "a", "b", "--out", "out", *OPTIONS)
    assert answer.exit_code == 1
    before = contents(Path("out"))
    save_off(icosphere(0), "b/cut.off")
    answer = run("batch", "repair", "a", "b", "--out", "out", "--json", *OPTIONS)
    assert (answer.exit_code, json.loads(answer.stdout)["kept"]) == (0, 2)
    after = contents(Path("out"))
    assert {name for name in after if before.get(name) != after[name] and name != "results.csv"} == {
        f"cut/{name}" for name in ("errors.txt", "outcome.json", "repair.ply")
    }
    save_off(icosphere(1), "b/ball.off")
    assert json.loads(run("batch", "repair", "a", "b", "--out", "out", "--json", *OPTIONS).stdout)["kept"] == 2
    assert json.loads(run("batch", "repair", "a", "--out", "out", "--json").stdout)["kept"] == 0


def test_parts_of_a_batch_join_to_its_table() -> None:
    """Two parts in one folder, merged: the table of one batch, byte for byte."""
    assert run("batch", "info", "a", "b", "--out", "one").exit_code == 1
    for part in ("1/2", "2/2"):
        run("batch", "info", "a", "b", "--out", "out", "--shard", part)
    shards = [f"out/results.{k}-of-2.shard" for k in (1, 2)]
    answer = run("merge", *shards, "-o", "joined.csv", "--json")
    assert answer.exit_code == 0, answer.output
    assert json.loads(answer.stdout)["failed"] == 1
    assert Path("joined.csv").read_bytes() == Path("one/results.csv").read_bytes()


def test_outputs_in_the_options() -> None:
    """{out}, {name} and {mesh} stand for the folder, the name and the path of each mesh."""
    options = ("--", "--all-pairs", "-q", "-o", "{out}/{name}.npy")
    assert run("batch", "geodesic", "a", "b/ball.off", "--out", "out", *options).exit_code == 0
    assert Path("out/ball/ball.npy").exists()
    assert Path("out/ball-2/ball-2.npy").exists()
    answer = run("batch", "geodesic", "a", "b", "--out", "other", "--", "-o", "x.vtp")
    assert answer.exit_code == 2
    assert not missing(answer.stderr, "{out}")


@pytest.mark.parametrize("form", ["-o FILE", "-oFILE", "-qo FILE", "-qoFILE", "--output FILE", "--output=FILE"])
def test_forms_of_the_option_for_the_output(form: str) -> None:
    """The output is read as the command reads it: no second file, and one name for two meshes is refused."""
    words = ("batch", "repair", "a", "b/ball.off", "--out", "out", "--")
    assert run(*words, *form.replace("FILE", "{out}/x.ply").split()).exit_code == 0
    assert files(Path("out/ball-2")) == ["errors.txt", "outcome.json", "report.json", "x.ply"]
    answer = run(*words, *form.replace("FILE", "x.ply").split())
    assert (answer.exit_code, missing(answer.stderr, "{out}")) == (2, [])


@pytest.mark.parametrize(
    ("words", "keyword"),
    [("--csv=t.csv", "{out}"), ("-o {out}/s.pvd --png p.png", "{out}"), ("--noise", "--noise"), ("--steps", "--steps")],
)
def test_options_that_no_mesh_can_take(words: str, keyword: str) -> None:
    """Any output of one name for all meshes, and options that the command does not have or that lack a value."""
    answer = run("batch", "fluid", "a", "b/ball.off", "--out", "out", "--", *words.split())
    assert (answer.exit_code, missing(answer.stderr, keyword)) == (2, [])
    assert not Path("out").exists()


@pytest.mark.parametrize("form", ["--sources {mesh}.txt", "--sources={mesh}.txt"])
def test_files_that_options_name(form: str) -> None:
    """A change of a file that an option names, for each mesh its own, makes the results of that mesh anew."""
    words = ("batch", "geodesic", "a", "b/ball.off", "--out", "out", "--json", "--", *form.split())
    for folder in "ab":
        Path(f"{folder}/ball.off.txt").write_text("0\n1\n")
    kept = [json.loads(run(*words, "-o{out}/D.npy").stdout)["kept"] for _ in range(2)]
    Path("b/ball.off.txt").write_text("2\n")
    assert [*kept, json.loads(run(*words, "-o{out}/D.npy").stdout)["kept"]] == [0, 2, 1]


def test_every_command_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """The words of a batch without options are those of each command, and name the output if it has one."""
    tasks: list[Task] = []
    monkeypatch.setattr("geomhw_cli.batch.run_batch", lambda found, run: (tasks.extend(found) or [], 0))
    for name in (names := set(program.commands) - set(NOT_FOR)):
        assert run("batch", name, "a/ball.off", "--out", "out").exit_code == 0
    assert {task.words[0] for task in tasks} == names
    assert all(task.words[2:3] == ["--json"] for task in tasks)
    outputs = {name for name in names if any("-o" in option.opts for option in program.commands[name].params)}
    assert {task.words[0] for task in tasks if task.words[3:4] == ["-o"]} == outputs - {"info"}  # prints its report


@pytest.mark.parametrize("words", [["nothing", "a"], ["compare", "a"], ["info"], ["info", "a"]])
def test_wrong_command_lines(words: list[str]) -> None:
    """No such command, one that takes no single mesh, no mesh, no folder."""
    answer = run("batch", *words, *(["--out", "out"] if words != ["info", "a"] else []))
    assert answer.exit_code == 2
    assert not Path("out").exists()


def test_a_folder_without_meshes_and_a_folder_that_is_a_file() -> None:
    """One sentence each."""
    Path("empty").mkdir()
    answer = run("batch", "info", "empty", "--out", "out")
    assert (answer.exit_code, missing(answer.stderr, "no mesh")) == (1, [])
    assert run("batch", "info", "a", "--out", "b/cut.off").exit_code == 2


@pytest.mark.skipif(os.name == "nt", reason="sends signals")
def test_an_interrupted_batch(folder: Path) -> None:
    """A signal ends all processes; the same command goes on."""
    save_off(icosphere(4), "a/large.off")
    words = ["batch", "geodesic", "a", "--out", "out", "--jobs", "1", "--", "--all-pairs", "-o", "{out}/D.npy"]
    with subprocess.Popen([sys.executable, "-m", "geomhw_cli", *words], stderr=subprocess.PIPE, text=True) as process:
        while not Path("out/large/D.partial.npy").exists():
            time.sleep(0.05)
            assert process.poll() is None
        process.send_signal(signal.SIGTERM)
        message = process.communicate(timeout=60)[1]
    assert process.returncode == 143
    assert not missing(message, "the same command goes on")
    assert files(folder / "out" / "ball") == ["D.npy", "errors.txt", "outcome.json", "report.json"]
    assert not [name for name in files(folder / "out" / "large") if ".partial." not in name]
    assert "results.csv" not in files(folder / "out")
