"""The stress test, in tests/: ``python -m attack.run [--seed S] [--count N] [PART ...]``, by default all parts.

Each part prints how much it has tried and what failed; the same seed gives the same attacks. N counts meshes; the other
parts have a share of it. A failure names its mesh or command line.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterator

from attack import files, metamorphic, rivals, signals, states

Attack = Callable[[int, int], Iterator[list[str]]]
#: The parts, and how many of each for a thousand meshes.
PARTS: dict[str, tuple[Attack, int]] = {
    "metamorphic": (metamorphic.attack, 1000),
    "signals": (signals.attack, 500),
    "rivals": (rivals.attack, 100),
    "states": (states.attack, 200),
    "files": (files.attack, 300),
}


def attack(names: list[str], seed: int, count: int) -> int:
    """Run some parts; print and count what is wrong."""
    failed = 0
    for name in names:
        part, share = PARTS[name]
        begun, checks, wrong, apart = time.monotonic(), 0, 0, 0
        try:
            for failures in part(seed, max(1, count * share // 1000)):
                checks += 1
                apart += sum(signals.APART in words for words in failures)
                wrong += sum(signals.APART not in words for words in failures)
                for words in failures:
                    print(f"  {words}", flush=True)
        finally:  # also of a run that is stopped
            print(
                f"{name}: {checks} checks, {wrong} failures, {apart} apart, {time.monotonic() - begun:.0f} s",
                flush=True,
            )
        failed += wrong
    return failed


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=100, help="meshes, and a share of it in the other parts")
    chosen = parser.parse_args()
    if unknown := set(chosen.parts) - PARTS.keys():
        parser.error(f"no part {', '.join(unknown)}; the parts are {', '.join(PARTS)}")
    sys.exit(bool(attack(chosen.parts or list(PARTS), chosen.seed, chosen.count)))


if __name__ == "__main__":
    main()
