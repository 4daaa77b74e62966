"""One command on many meshes: a process for each, its files and outcome in a folder of its own."""

import csv
import json
import re
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Lock
from typing import TYPE_CHECKING, Any

from geomhw_cli.runtime.interrupts import delayed
from geomhw_cli.runtime.progress import progress

if TYPE_CHECKING:
    from geomhw.io.artifacts.shards import Shard

#: Items of a report that are no results.
OTHERS = ("command", "input", "files", "seconds", "remarks", "check", "profile")
#: Reasons that a program cannot give itself.
ENDED = {137: "killed, perhaps for lack of memory", 143: "stopped by a signal", 130: "stopped by a signal"}


@dataclass(frozen=True)
class Task:
    """One mesh of a batch. words: the command line after the program's name. key: what the outcome depends on."""

    name: str
    mesh: str
    folder: Path
    words: Sequence[str]
    key: Mapping[str, Any]

    @property
    def record(self) -> Path:
        """The file of the outcome."""
        return self.folder / "outcome.json"

    def former(self) -> dict[str, Any] | None:
        """The outcome of an earlier run of the same task that succeeded."""
        try:
            found = json.loads(self.record.read_text(encoding="utf-8"))
            return found if found["key"] == self.key and found["exit_code"] == 0 else None
        except (OSError, ValueError, KeyError, TypeError):
            return None


def mesh_names(meshes: Sequence[str]) -> list[str]:
    """Return a folder name for each mesh: its stem, with a number if an earlier mesh has it, in capitals or not."""
    taken: set[str] = set()
    names = []
    for mesh in meshes:
        stem = re.sub(r"^[.-]|[\x00-\x1f/\\:*?\"<>|]", "_", Path(mesh).stem) or "mesh"
        candidates = (stem if k == 1 else f"{stem}-{k}" for k in range(1, len(meshes) + 2))
        names.append(next(name for name in candidates if name.casefold() not in taken))
        taken.add(names[-1].casefold())
    return names


#: A function that runs tasks, and yields each with its outcome when it ends.
RunTasks = Callable[[Sequence[Task]], Generator[tuple[Task, dict[str, Any]], None, None]]


class _Stopped(Exception):
    """The batch was stopped before the end of a process."""


class Runner:
    """Runs tasks as processes, which `stop` ends."""

    def __init__(self) -> None:
        self._running: set[subprocess.Popen[bytes]] = set()
        self._lock, self._stopped = Lock(), Event()

    def __call__(self, task: Task) -> dict[str, Any]:
        """Run a task and return its outcome, which its folder keeps, with what it printed; of a stopped task, none."""
        from geomhw.io import replacing

        task.folder.mkdir(parents=True, exist_ok=True)
        task.record.unlink(missing_ok=True)
        begun = time.monotonic()
        try:
            with replacing([task.folder / "report.json", task.folder / "errors.txt"]) as printed:
                code = self._run([sys.executable, "-m", "geomhw", *task.words], *printed)
        except _Stopped:
            return {}
        outcome = {"key": dict(task.key), "exit_code": code, "reason": _reason(task, code)}
        outcome |= {"seconds": round(time.monotonic() - begun, 3)}
        with replacing([task.record]) as (temporary,):
            temporary.write_text(json.dumps(outcome, indent=2) + "\n", encoding="utf-8")
        return outcome

    def _run(self, command: Sequence[str], report: Path, errors: Path) -> int:
        """Run a process to its end, its output in two files; return its exit code. Raises _Stopped."""
        with report.open("wb") as out, errors.open("wb") as err:
            with self._lock:
                if self._stopped.is_set():
                    raise _Stopped
                process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=err)
                self._running.add(process)
            code = process.wait()
        with self._lock:
            self._running.discard(process)
            if self._stopped.is_set():
                raise _Stopped
        return code

    def __reduce__(self) -> tuple[type["Runner"], tuple[()]]:
        """A worker has a runner of its own."""
        return Runner, ()

    def stop(self) -> None:
        """End all processes, and start none any more."""
        with self._lock:
            self._stopped.set()
            for process in self._running:
                process.terminate()


def run_here(tasks: Sequence[Task], jobs: int) -> Generator[tuple[Task, dict[str, Any]], None, None]:
    """Run tasks on this machine, some at a time; yield each with its outcome when it ends."""
    runner = Runner()
    with ThreadPoolExecutor(jobs) as threads:
        try:
            with delayed():  # an executor does not wait for a thread whose start was interrupted
                futures = {threads.submit(runner, task): task for task in tasks}
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BaseException:
            threads.shutdown(wait=False, cancel_futures=True)
            runner.stop()
            threads.shutdown()  # which remove their unfinished files
            raise


def run_batch(tasks: Sequence[Task], run: RunTasks) -> tuple[list[dict[str, Any]], int]:
    """Run all tasks that no earlier run did; return a row of the table for each, and the number of those kept."""
    outcomes = {task.name: former for task in tasks if (former := task.former())}
    kept = len(outcomes)
    waiting = [task for task in tasks if task.name not in outcomes]
    with progress("batch") as bar, closing(run(waiting)) as found:
        for done, (task, outcome) in enumerate(found, start=1):
            outcomes[task.name] = outcome
            bar(done / len(waiting))
    return [_row(task, outcomes[task.name]) for task in tasks], kept


def row_lines(rows: Iterable[Mapping[str, Any]]) -> Iterator[bytes]:
    """Rows of the table as the data of a shard."""
    return (json.dumps(row).encode() + b"\n" for row in rows)


def write_rows(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write the table, with the columns of all rows, in order of first appearance."""
    from geomhw.io import replacing

    columns = dict.fromkeys(name for row in rows for name in row)
    with replacing([path]) as (temporary,), temporary.open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(columns), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def join_rows(shards: "Sequence[Shard]", path: Path) -> dict[str, Any]:
    """Write the table of one batch from all of its shards; return what the report says of it."""
    rows = [json.loads(line) for shard in shards for line in shard.lines()]
    write_rows(path, rows)
    return {"meshes": len(rows), "failed": sum(row["status"] == "failed" for row in rows)}


def _row(task: Task, outcome: Mapping[str, Any]) -> dict[str, Any]:
    """What the table says of a mesh: its outcome, and all single values of the report."""
    code = outcome["exit_code"]
    row = {"name": task.name, "mesh": task.mesh, "status": "failed" if code else "done"}
    row |= {"exit_code": code, "reason": outcome["reason"]}
    report = _report(task)
    return row | dict(_single({name: value for name, value in report.items() if name not in OTHERS}))


def _report(task: Task) -> dict[str, Any]:
    """The report that a task printed; empty without one."""
    try:
        found = json.loads((task.folder / "report.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _reason(task: Task, code: int) -> str:
    """Why a task failed, in a line."""
    if code == 0:
        return ""
    text = (task.folder / "errors.txt").read_text(encoding="utf-8", errors="replace")
    last = next((line for line in reversed(text.splitlines()) if line.strip()), "")
    defects = [
        f"{item['what']}: {len(item['places'])}" for item in _report(task).get("check", ()) if item["kind"] == "defect"
    ]
    status = code if code >= 0 else 128 - code
    return last.removeprefix("Error: ") or "; ".join(defects) or ENDED.get(status, f"exit code {status}")


def _single(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Single values of nested objects, such as ``farthest.distance``."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _single(value, f"{prefix}{name}.")
        elif not isinstance(value, list):
            yield f"{prefix}{name}", value
