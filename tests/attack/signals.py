"""Signals at random moments of every command: the exit code of the signal, one line, and no part of a file."""

import random
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from attack.program import COMMANDS, SECONDS, finished, fresh, outputs, prepared, reference, start, wrong_files

import geomhw
import geomhw_cli

SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
#: Where an older run has left files, the first words of each.
OLD = b"old"
#: Start of the words on what is not counted as a failure.
APART = "apart: "
#: Folders of the program.
OURS = [Path(package.__file__ or "").parent for package in (geomhw, geomhw_cli)]


def attack(seed: int, count: int) -> Iterator[list[str]]:
    """Interrupt this number of runs; yield what is wrong with each."""
    chance = random.Random(seed)
    with prepared() as template, tempfile.TemporaryDirectory() as space:
        for number in range(count):
            kind = list(COMMANDS)[number % len(COMMANDS)]
            sent = chance.choice(SIGNALS)
            moment = chance.uniform(0, 1.05)
            folder = fresh(template, Path(space) / "run")
            for name in reference(kind).files if chance.random() < 0.3 else ():
                if "." not in name.removesuffix(Path(name).suffix):
                    (folder / name).parent.mkdir(exist_ok=True)
                    (folder / name).write_bytes(OLD)
            again = chance.random() < 0.25
            label = f"signals {number}: {COMMANDS[kind].split()[0]} ({kind}), {sent.name} at {moment:.2f}"
            yield [f"{label}: {words}" for words in interrupted(kind, folder, sent, moment, again)]


def is_pythons(err: str) -> bool:
    """Whether a message is of an interrupt while Python starts, before the first line of `geomhw_cli.main`."""
    lines = [line for line in err.splitlines() if line.lstrip().startswith("File ") and "__main__.py" not in line]
    ours = any(f'"{folder}/' in line for line in lines for folder in OURS)
    return "KeyboardInterrupt" in err and "Traceback" in err and not ours


def interrupted(kind: str, folder: Path, sent: signal.Signals, moment: float, again: bool) -> list[str]:
    """Send a signal at a share of the usual time; return what is wrong with the exit code, words and files."""
    expected, before = reference(kind), outputs(folder)
    with start(COMMANDS[kind], folder) as process:
        time.sleep(moment * expected.seconds)
        process.send_signal(sent)
        if again:
            time.sleep(0.01)
            process.send_signal(sent)
        try:
            _, err = process.communicate(timeout=SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            return ["does not end"]
    if is_pythons(err):
        return [f"{APART}a signal before the first line of the program"]
    after, wrong = outputs(folder), []
    whole = {name for name, data in expected.files.items() if after.get(name) == data}
    if process.returncode == expected.code:
        if whole != expected.files.keys():
            wrong.append(f"exit code {process.returncode}, but {sorted(expected.files.keys() - whole)} are not there")
    elif process.returncode not in (128 + sent, -sent):
        wrong.append(f"exit code {process.returncode}")
    elif process.returncode == 128 + sent and "Error: interrupted" not in err:
        wrong.append("no word of the interrupt")
    if "Traceback" in err or "Exception" in err or "Fatal" in err:
        wrong.append("a traceback: " + " | ".join(err.splitlines()[-4:]))
    old = {name for name, data in after.items() if data == OLD}
    growing = any(name.endswith((".pvd", "outcome.json")) for name in expected.files)
    if old and whole and not growing and not all(name in err for name in whole):
        wrong.append(
            f"{sorted(whole)} are new beside old {sorted(old)}, and the message does not say so: {err.strip()}"
        )
    wrong += wrong_files(kind, folder, before)
    if any(".partial." in name for name in after):
        finished(COMMANDS[kind], folder)
        wrong += [
            f"{name} differs after resuming"
            for name, data in expected.files.items()
            if outputs(folder).get(name) != data
        ]
    return wrong
