"""Saved states with damaged bytes: refused in one line and left alone, or the same result as without the damage."""

import os
import random
import signal
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from attack.program import FLUID, SECONDS, finished, fresh, prepared, start

from geomhw.geodesic.heat_method import HeatDistance
from support.matrix_runs import interrupt, stopping
from support.program import contents, run

MATRIX = "geodesic ring.off --all-pairs --time h2 -o D.npy"
RESUMED = f"fluid ball.off {FLUID} -o f.pvd"
#: Bytes of a state that is whole.
ENOUGH = 9_000
#: A run whose state is not one of `MATRIX`. The state of another flow is the user's choice of it, with its options.
OTHER = "geodesic ring.off --all-pairs --time sqrt-h -o D.npy"


def attack(seed: int, count: int) -> Iterator[list[str]]:
    """Damage this number of states; yield what is wrong with each."""
    chance = random.Random(seed)
    here = os.getcwd()
    with prepared() as template, tempfile.TemporaryDirectory() as space:
        whole = {command: whole_run(command, fresh(template, Path(space) / "whole")) for command in (MATRIX, RESUMED)}
        saved = [
            stopped_matrix(MATRIX, fresh(template, Path(space) / "matrix")),
            stopped(RESUMED, fresh(template, Path(space) / "flow")),
        ]
        other = stopped_matrix(OTHER, fresh(template, Path(space) / "other"))
        for number in range(count):
            k = number % 2
            folder = fresh(saved[k], Path(space) / "run")
            names = ["f.restart.npz"] if k else ["D.partial.npy", "D.partial.json"]
            name = chance.choice(names)
            how = damage(folder / name, None if k else other / name, chance)
            command = RESUMED + " --restart f.restart.npz" if k else MATRIX
            os.chdir(folder)
            try:
                wrong = resumed(command, folder, whole[RESUMED if k else MATRIX])
            finally:
                os.chdir(here)
            yield [f"states {number}: {name} {how}: {words}" for words in wrong]


def whole_run(command: str, folder: Path) -> dict[str, bytes]:
    """Return the files of a run that nothing stops."""
    before = contents(folder)
    finished(command, folder)
    return {name: data for name, data in contents(folder).items() if name not in before}


def stopped_matrix(command: str, folder: Path) -> Path:
    """Interrupt a run of distances in its fourth block; return its folder."""
    here, rows = os.getcwd(), HeatDistance.rows
    os.chdir(folder)
    try:
        HeatDistance.rows = stopping(4, interrupt)  # type: ignore[method-assign]
        run(*command.split())
    finally:
        HeatDistance.rows = rows  # type: ignore[method-assign]
        os.chdir(here)
    return folder


def stopped(command: str, folder: Path) -> Path:
    """Stop a run as soon as it has saved a state; return its folder."""
    with start(command, folder) as process:
        limit = time.monotonic() + SECONDS
        while process.poll() is None and time.monotonic() < limit:
            if any(size_of(path) > ENOUGH for path in folder.glob("*.restart.npz")):
                break
            time.sleep(0.005)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=SECONDS)
    return folder


def size_of(path: Path) -> int:
    """Return the size of a file, which may be gone."""
    return path.stat().st_size if path.exists() else 0


def damage(path: Path, other: Path | None, chance: random.Random) -> str:
    """Damage a file, or replace it by another; return how."""
    data = bytearray(path.read_bytes())
    at = chance.randrange(len(data))
    match chance.randrange(7):
        case 0:
            data[at] ^= 1 << chance.randrange(8)
            how = f"has another bit at {at}"
        case 1:
            del data[at:]
            how = f"is cut off at {at}"
        case 2:
            data[at : at + 64] = chance.randbytes(64)
            how = f"has noise at {at}"
        case 3:
            to, size = chance.randrange(len(data)), chance.randrange(1, 4096)
            data[at : at + size], data[to : to + size] = data[to : to + size], data[at : at + size]
            how = f"has its bytes at {at} and {to} exchanged"
        case 4:
            data += chance.randbytes(chance.randrange(1, 4096))
            how = "has more bytes"
        case 5 if other:
            data = bytearray(other.read_bytes())
            how = "is of another run"
        case _:
            data = bytearray(chance.choice([b"", b"{}", b"null", b"\x93NUMPY\x01\x00", b"PK\x05\x06" + bytes(18)]))
            how = f"is {bytes(data)!r}"
    path.write_bytes(data)
    return how


def resumed(command: str, folder: Path, whole: dict[str, bytes]) -> list[str]:
    """Resume in the folder; return what is wrong."""
    before = contents(folder)
    try:
        answer = run(*command.split())
    except Exception as error:
        return [f"raises {type(error).__name__}: {error}"]
    after = contents(folder)
    if answer.exit_code == 0:
        return [f"{name} is another one" for name in whole if after.get(name) != whole[name]]
    wrong = []
    if answer.exit_code != 1 or len(answer.stderr.strip().splitlines()) != 1:
        wrong.append(f"exit code {answer.exit_code}: {answer.stderr.strip()}")
    if after != before:
        wrong.append("changes files")
    return wrong
