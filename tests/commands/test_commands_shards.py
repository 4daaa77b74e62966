"""``--shard`` and ``merge``: the parts of a run give its file byte for byte, or are refused."""

import json
from pathlib import Path

import numpy as np
import pytest

from geomhw.mesh.primitives import icosphere
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
