"""The long fuzzing run, in tests/: ``python -m fuzz.run [--runs N] [--plain] [TARGET ...]``, by default all readers.

Guided by atheris (libFuzzer) where that is installed and --plain is not given, else by chance alone. What breaks a
reader is kept in ``build/fuzz/found``; a copy of it in ``tests/fuzz/found`` makes it a test.
"""

import argparse
import random
import re
import resource
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).resolve().parent
CORPUS, BUILD = HERE / "corpus", HERE.parent.parent / "build" / "fuzz"
SECONDS, MEGABYTES, LONGEST = 1, 2048, 1 << 16
#: libFuzzer's clock goes on while a busy machine does other things: it is for what hangs.
HANGS = 20
#: So many inputs a process: what the fuzzer itself keeps of each, a kilobyte or so, adds up.
ROUND = 500_000


def guided(name: str, runs: int, seed: int) -> None:
    """Hand this process to libFuzzer."""
    import atheris

    with atheris.instrument_imports(include=["geomhw", "meshio"]):
        import meshio  # noqa: F401  # which readers load when they need it

        from fuzz.targets import feed

    grown, found = BUILD / name, BUILD / "found"
    for folder in (grown, found):
        folder.mkdir(parents=True, exist_ok=True)
    options = [f"-runs={runs}", f"-timeout={HANGS}", f"-rss_limit_mb={MEGABYTES}", f"-max_len={LONGEST}"]
    options += [f"-artifact_prefix={found}/{name}-", "-print_final_stats=1", "-verbosity=0", f"-seed={seed}"]
    atheris.Setup([sys.argv[0], *options, str(grown), str(CORPUS / name)], lambda data: feed(name, data))
    atheris.Fuzz()


def plain(name: str, runs: int) -> int:
    """Mutated files by chance; how many broke the reader."""
    from fuzz.mutations import mutated
    from fuzz.targets import feed

    seeds = [path.read_bytes() for path in sorted((CORPUS / name).iterdir())]
    chance, broken, begun = random.Random(name), 0, time.monotonic()
    for number in range(runs):
        data = mutated(seeds, chance)
        before = time.process_time()
        try:
            feed(name, data)
            reason = "slow" if time.process_time() - before > SECONDS else ""
        except Exception as error:
            reason = type(error).__name__
        if reason:
            broken += 1
            (BUILD / "found").mkdir(parents=True, exist_ok=True)
            (BUILD / "found" / f"{name}-{reason}-{number}").write_bytes(data)
    print(f"{name}: {runs} inputs by chance, {broken} of them break it, {time.monotonic() - begun:.0f} s", flush=True)
    return broken


def every(names: list[str], runs: int) -> int:
    """All targets one after the other, each guided in processes of their own."""
    total, failed = 0, []
    for name in names:
        count = 0
        for seed, start in enumerate(range(0, runs, ROUND), start=1):
            runs_now = str(min(ROUND, runs - start))
            command = [sys.executable, "-m", "fuzz.run", "--runs", runs_now, "--seed", str(seed), "--one", name]
            answer = subprocess.run(command, capture_output=True, text=True, errors="replace", cwd=HERE.parent)
            done = re.search(r"number_of_executed_units: (\d+)", answer.stderr)
            count += int(done[1]) if done else 0
            if answer.returncode:
                failed.append(name)
                print(answer.stderr[-3000:], file=sys.stderr)
                break
        total += count
        print(f"{name}: {count} guided inputs, exit code {answer.returncode}", flush=True)
    print(f"{total} inputs; broken: {', '.join(failed) or 'none'}")
    return len(failed)


def main() -> None:
    """Choose targets and the way of fuzzing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="TARGET")
    parser.add_argument("--runs", type=int, default=40_000, help="inputs a reader")
    parser.add_argument("--plain", action="store_true", help="mutate by chance, without atheris")
    parser.add_argument("--seed", type=int, default=1, help=argparse.SUPPRESS)
    parser.add_argument("--one", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
    if chosen.one:
        guided(chosen.one, chosen.runs, chosen.seed)
        return
    names = chosen.names or sorted(path.name for path in CORPUS.iterdir())
    if find_spec("atheris") and not chosen.plain:
        sys.exit(bool(every(names, chosen.runs)))
    sys.exit(bool(sum(plain(name, chosen.runs) for name in names)))


if __name__ == "__main__":
    main()
