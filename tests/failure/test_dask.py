"""Dask: matrices and batches on workers are those of one run, also when a worker or the client is killed."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geomhw.io.artifacts.resumable_file import ResumableFile
from geomhw.mesh.primitives import icosphere
from support.messages import missing
from support.program import run, save_off

distributed: Any = pytest.importorskip("distributed")
pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="sends signals"),
    pytest.mark.filterwarnings("ignore"),
]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Start a cluster of two processes."""
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as found:
        yield found


@pytest.fixture
def matrix(folder: Path) -> bytes:
    """The matrix of one run on a mesh that takes some seconds on workers."""
    save_off(icosphere(4))
    assert run("geodesic", "ball.off", "--all-pairs", "--single", "-o", "one.npy", "-q").exit_code == 0
    return Path("one.npy").read_bytes()


def partial_is_there(still_running: Any) -> None:
    """Wait until the first rows are there."""
    while not (Path("D.partial.npy").exists() and Path("D.partial.npy").stat().st_size > 1000):
        time.sleep(0.01)
        assert still_running()


def test_a_worker_is_killed(cluster: Any, matrix: bytes) -> None:
    """Its blocks are computed again on another worker."""
    command = ["geodesic", "ball.off", "--all-pairs", "--single", "-o", "D.npy", "-q"]
    answers: list[Any] = []
    work = threading.Thread(
        target=lambda: answers.append(run(*command, "--scheduler", cluster.scheduler_address)), daemon=True
    )
    work.start()
    partial_is_there(work.is_alive)
    os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
    work.join(120)
    assert answers[0].exit_code == 0, answers[0].output
    assert Path("D.npy").read_bytes() == matrix


def test_the_client_is_killed(cluster: Any, matrix: bytes) -> None:
    """What it had written stays; the same command goes on, without a scheduler too."""
    command = ["geodesic", "ball.off", "--all-pairs", "--single", "-o", "D.npy"]
    words = [sys.executable, "-m", "geomhw_cli", *command, "--scheduler", cluster.scheduler_address]
    with subprocess.Popen(words, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as process:
        partial_is_there(lambda: process.poll() is None)
        process.kill()
    answer = run(*command)
    assert answer.exit_code == 0, answer.output
    assert Path("D.npy").read_bytes() == matrix


@pytest.mark.parametrize("options", ["--all-pairs --single", "--pairs pairs.txt", "--all-pairs --labels l.npy"])
def test_workers_of_other_machines(cluster: Any, options: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers that do not see the file send their blocks; the bytes are those of one run, as where they see it."""
    save_off(icosphere(3))
    Path("pairs.txt").write_text("".join(f"{k} {k // 2}\n" for k in range(642)))
    np.save("l.npy", np.arange(642) % 5)
    end = ".npy" if "--single" in options else ".csv"
    assert run("geodesic", "ball.off", *options.split(), "-o", f"one{end}", "-q").exit_code == 0
    place = ResumableFile.place
    for inode in (None, 0):
        if inode is not None:
            monkeypatch.setattr(ResumableFile, "place", lambda self: replace(place(self), inode=0))
        words = [*options.split(), "-o", f"D{end}", "-q", "--scheduler", cluster.scheduler_address]
        answer = run("geodesic", "ball.off", *words)
        assert answer.exit_code == 0, answer.output
        assert Path(f"D{end}").read_bytes() == Path(f"one{end}").read_bytes()


def test_a_batch_on_workers(cluster: Any, folder: Path) -> None:
    """The table of a batch on workers is that of a batch here."""
    save_off(icosphere(0))
    Path("cut.off").write_text("OFF\n3 1 0\n0 0 0\n")
    assert run("batch", "info", "ball.off", "cut.off", "--out", "here").exit_code == 1
    answer = run("batch", "info", "ball.off", "cut.off", "--out", "there", "--scheduler", cluster.scheduler_address)
    assert answer.exit_code == 1
    assert Path("there/results.csv").read_bytes() == Path("here/results.csv").read_bytes()


def test_without_a_scheduler(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An address that does not answer, a word that is no address, and no Dask: one sentence each, and no file."""
    save_off(icosphere(0))
    command = ["geodesic", "ball.off", "--all-pairs", "-o", "D.npy", "--scheduler"]
    monkeypatch.setattr("geomhw_cli.runtime.dask_cluster.PATIENCE", 1)
    for address in ("tcp://127.0.0.1:1", "nonsense"):
        answer = run(*command, address)
        assert (answer.exit_code, missing(answer.stderr, address)) == (2, [])
    monkeypatch.setitem(sys.modules, "distributed", None)
    answer = run(*command, "local")
    assert (answer.exit_code, missing(answer.stderr, "geomhw[dask]")) == (2, [])
    assert not list(Path().glob("D*"))
