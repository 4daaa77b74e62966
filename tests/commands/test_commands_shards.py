"""``--shard`` and ``merge``: the parts of a run give its file byte for byte, or are refused."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.mesh.primitives import grid, icosphere
from support.messages import missing
from support.program import files, one_line, run, save_off

#: Runs, and the file that each writes.
RUNS = {
    "rows": ("--all-pairs", "D.npy"),
    "single": ("--all-pairs --single --method exact --limit 1 --beyond -1", "D.npy"),
    "sets": ("--sources sources.txt", "D.npy"),
    "pairs": ("--pairs pairs.txt", "D.csv"),
    "array of pairs": ("--pairs pairs.txt --single", "D.npy"),
    "labels": ("--all-pairs --labels labels.npy", "D.csv"),
    "sparse": ("--all-pairs --method exact --limit 0.9", "D.npz"),
}


@pytest.fixture(autouse=True)
def folder(folder: Path) -> Path:
    """Each test has its own working folder with a mesh, sources, pairs and labels."""
    save_off(icosphere(2))
    rng = np.random.default_rng(0)
    Path("sources.txt").write_text("".join(f"{a} {b}\n" for a, b in rng.integers(0, 162, (70, 2))))
    Path("pairs.txt").write_text("".join(f"{a} {b}\n" for a, b in rng.integers(0, 162, (200, 2))))
    np.save("labels.npy", np.arange(162) % 5)
    return folder


def shards(options: str, of: int) -> list[str]:
    """Run each of the parts, and return the names of their files."""
    names = [f"D.{k}.shard" for k in range(1, of + 1)]
    for k, name in enumerate(names, start=1):
        answer = run("geodesic", "ball.off", *options.split(), "--shard", f"{k}/{of}", "-o", name, "-q")
        assert answer.exit_code == 0, answer.output
    return names


@pytest.mark.parametrize("kind", RUNS)
def test_shards_join_to_the_file_of_one_run(kind: str, folder: Path) -> None:
    """Two parts, and more parts than there are blocks, in any order: the same bytes; nothing else is left."""
    options, name = RUNS[kind]
    assert run("geodesic", "ball.off", *options.split(), "-o", name, "-q").exit_code == 0
    before = files(folder)
    for of in (2, 8):
        parts = shards(options, of)
        answer = run("merge", "-o", f"joined{Path(name).suffix}", *parts[::-1], "--json")
        assert answer.exit_code == 0, answer.output
        report = json.loads(answer.stdout)
        assert report["shards"] == of
        assert Path(name).read_bytes() == Path(*report["files"]).read_bytes()
        for file in [*parts, *report["files"]]:
            Path(file).unlink()
        assert files(folder) == before


@pytest.mark.parametrize("end", [".vtp", ".csv"])
@pytest.mark.parametrize("within_faces", [False, True])
def test_paths_join_to_the_file_of_one_run(end: str, within_faces: bool, folder: Path) -> None:
    """Two parts, and more parts than some sources: the same bytes, also where points of all parts divide faces."""
    if within_faces:
        rng = np.random.default_rng(1)
        points = [f"face:{f}:0.2,0.3,0.5" for f in rng.integers(0, 320, 12)]
        Path("pairs.txt").write_text("".join(f"{points[k % 5]} {points[-1 - k % 7]}\n" for k in range(20)))
    assert run("path", "ball.off", "--pairs", "pairs.txt", "-o", f"one{end}", "-q").exit_code == 0
    for of in (2, 8):
        names = [f"p.{k}.shard" for k in range(1, of + 1)]
        for k, name in enumerate(names, start=1):
            answer = run("path", "ball.off", "--pairs", "pairs.txt", "--shard", f"{k}/{of}", "-o", name, "-q")
            assert answer.exit_code == 0, answer.output
        answer = run("merge", "-o", f"joined{end}", *names[::-1], "--json")
        assert answer.exit_code == 0, answer.output
        assert Path(f"joined{end}").read_bytes() == Path(f"one{end}").read_bytes()


@pytest.mark.parametrize("of", [2, 5, 40])
def test_lines_of_a_fan_join(of: int, folder: Path) -> None:
    """The same bytes from parts of the lines of three points, some of which point off the surface."""
    save_off(grid(4, 4), "square.off")
    words = ["trace", "square.off", "--from", "0,4,12", "--length", "0.7", "--fan", "12"]
    assert run(*words, "-o", "one.vtp").exit_code == 0
    names = [f"l.{k}.shard" for k in range(1, of + 1)]
    for k, name in enumerate(names, start=1):
        answer = run(*words, "--shard", f"{k}/{of}", "-o", name, "-q")
        assert answer.exit_code == 0, answer.output
    answer = run("merge", "-o", "joined.vtp", *names, "--json")
    assert answer.exit_code == 0, answer.output
    assert 12 < json.loads(answer.stdout)["curves"] < 36
    assert Path("joined.vtp").read_bytes() == Path("one.vtp").read_bytes()


@pytest.mark.parametrize("end", [".json", ".txt"])
def test_reports_join_to_the_file_of_one_run(end: str) -> None:
    """The report on meshes of which some fail: the same bytes from two parts, and from more parts than meshes."""
    for k in range(4):
        save_off(icosphere(k % 2), f"m{k}.off")
    Path("cut.off").write_text("OFF\n3 1 0\n0 0 0\n")
    words = ["info", "m0.off", "m1.off", "cut.off", "m2.off", "m3.off", "--check"]
    printed = run(*words, *(["--json"] if end == ".json" else []))
    answer = run(*words, "-o", f"one{end}")
    assert (answer.exit_code, answer.stdout) == (printed.exit_code, "")
    assert Path(f"one{end}").read_text() == printed.stdout
    for of in (2, 7):
        names = [f"i.{k}.shard" for k in range(1, of + 1)]
        codes = [run(*words, "--shard", f"{k}/{of}", "-o", names[k - 1]).exit_code for k in range(1, of + 1)]
        assert max(codes) == printed.exit_code
        assert run("merge", "-o", f"joined{end}", *names[::-1], "-q").exit_code == 0
        assert Path(f"joined{end}").read_bytes() == Path(f"one{end}").read_bytes()


def test_parts_of_other_runs() -> None:
    """Parts of other pairs, other meshes, other options or another kind do not join."""
    Path("other.txt").write_text("0 1\n1 0\n")
    run("path", "ball.off", "--pairs", "pairs.txt", "--shard", "1/2", "-o", "1.shard", "-q")
    run("path", "ball.off", "--pairs", "other.txt", "--shard", "2/2", "-o", "2.shard", "-q")
    one_line(run("merge", "-o", "p.csv", "1.shard", "2.shard"), "2.shard ... another run ... pairs")
    run("info", "ball.off", "ball.off", "--shard", "2/2", "-o", "3.shard")
    one_line(run("merge", "-o", "p.csv", "1.shard", "3.shard"), "another run")
    run("info", "ball.off", "ball.off", "--check", "--shard", "1/2", "-o", "4.shard")
    one_line(run("merge", "-o", "p.json", "3.shard", "4.shard"), "another run", "check")


@pytest.mark.parametrize(
    "words",
    [
        "path ball.off --from 0 --to 3 --shard 1/2 -o p.shard",
        "path ball.off --pairs pairs.txt --shard 1/2",
        "path ball.off --pairs pairs.txt --shard 1/2 -o p.vtp",
        "path ball.off --pairs pairs.txt --shard 1/2 -o p.shard --png p.png",
        "path ball.off --pairs pairs.txt -o p.shard",
        "trace ball.off --from 0 --length 1 --shard 1/2 -o l.shard",
        "trace ball.off --from 0 --length 1 --fan 3 --shard 1/2",
        "info ball.off ball.off --shard 1/2",
        "info ball.off ball.off --shard 1/2 -o i.json",
        "geodesic ball.off --all-pairs --shard 1/2 -o D.npy",
        "geodesic ball.off --all-pairs --limit 1 --method exact --shard 1/2 -o D.npz",
        "info ball.off -o i.shard",
        "info ball.off -o ball.off",
    ],
)
def test_parts_go_to_shards(words: str, folder: Path) -> None:
    """A part is written to a shard, and a whole run is not."""
    before = files(folder)
    assert run(*words.split()).exit_code == 2
    assert files(folder) == before


@pytest.mark.parametrize(
    "command", ["geodesic ball.off --all-pairs", "info ball.off ball.off", "trace ball.off --fan 4 --length 1"]
)
def test_parts_with_one_name(command: str) -> None:
    """A part does not replace another one; the same part is computed anew."""
    for part, code in (("1/2", 0), ("2/2", 2), ("1/2", 0)):
        answer = run(*command.split(), "--shard", part, "-o", "D.shard", "-q")
        assert answer.exit_code == code, answer.output
    answer = run(*command.split(), "--shard", "2/3", "-o", "D.shard")
    assert not missing(answer.stderr, "D.shard ... part 1 of 2 ... part 2 ... a file of its own")
    assert run(*command.split(), "--shard", "1/3", "-o", "D.shard").exit_code == 0


def test_the_report_says_which_part() -> None:
    """A shard says which part it is; the joined report has the extremes of all."""
    answer = run("geodesic", "ball.off", "--all-pairs", "--shard", "1/2", "-o", "D.1.shard", "--json")
    report = json.loads(answer.stdout)
    assert (report["shard"], report["queries"], report["shape"]) == ("1/2", 96, [96, 162])
    run("geodesic", "ball.off", "--all-pairs", "--shard", "2/2", "-o", "D.2.shard")
    joined = json.loads(run("merge", "D.1.shard", "D.2.shard", "-o", "D.npy", "--json").stdout)
    assert joined["largest_distance"] == np.load("D.npy").max()


def test_wrong_sets_of_shards() -> None:
    """A part that is missing, twice, of another run, of another division, damaged, or no shard: one sentence."""
    first, second, third = shards("--all-pairs", 3)
    one_line(run("merge", "-o", "D.npy", first, third), "of 3", "missing: 2")
    Path("copy.shard").write_bytes(Path(first).read_bytes())
    one_line(run("merge", "-o", "D.npy", first, second, third, "copy.shard"), "shard 1", "twice", "copy.shard")
    run("geodesic", "ball.off", "--all-pairs", "--time", "h2", "--shard", "2/3", "-o", "other.shard", "-q")
    one_line(run("merge", "-o", "D.npy", first, "other.shard", third), "another run", "time")
    run("geodesic", "ball.off", "--all-pairs", "--shard", "2/4", "-o", "four.shard", "-q")
    one_line(run("merge", "-o", "D.npy", first, "four.shard", third), "one of 4", "one of 3")
    one_line(run("merge", "-o", "D.npy", "ball.off"), "ball.off is no shard")
    assert run("merge", "-o", "D.csv", first, second, third).exit_code == 2
    assert not Path("D.npy").exists()


@pytest.mark.parametrize("place", [20, 200, -100])
def test_damaged_shards(place: int) -> None:
    """A changed byte in the manifest or in the data, and a file that ends early: one sentence, nothing written."""
    first, second = shards("--all-pairs", 2)
    whole = Path(second).read_bytes()
    damaged = bytearray(whole)
    damaged[place] ^= 1
    for data in (bytes(damaged), whole[:place], b"geomhw shard 1\n"):
        Path(second).write_bytes(data)
        one_line(run("merge", "-o", "D.npy", first, second), second, "damaged")
    assert not Path("D.npy").exists()


@pytest.mark.parametrize("part", ["0/2", "3/2", "1", "a/b", "1/0", "-1/2", "1/99999999"])
def test_wrong_parts(part: str) -> None:
    """K/N with K from 1 to N."""
    answer = run("geodesic", "ball.off", "--all-pairs", f"--shard={part}", "-o", "D.shard")
    assert answer.exit_code == 2
    assert not missing(answer.stderr, part)


def test_shards_are_of_many_questions() -> None:
    """A single distance has no parts, and a part is no matrix."""
    assert run("geodesic", "ball.off", "--shard", "1/2", "--no-png").exit_code == 2
    assert run("geodesic", "ball.off", "--all-pairs", "-o", "D.shard").exit_code == 2
    assert run("geodesic", "ball.off", "--all-pairs", "--shard", "1/2").exit_code == 2
