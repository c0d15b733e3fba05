"""Speeds of this code beside those of older code, in turn."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from itertools import product
from pathlib import Path
from statistics import median
from subprocess import PIPE
from tempfile import TemporaryDirectory
from typing import Final, NamedTuple

from agents.ground.cli import UsageError
from agents.ground.versions import commit_of
from benchmarks.perf_cases.cells import FLIGHT
from benchmarks.timing import Count, Options, Row

ROOT: Final = Path(__file__).parents[2]
TURNS = 10
"""Number of turns."""
THROWS, SEEDS = 5000, 3
"""Throws of a training, and number of trainings."""


def training(options: Options) -> Iterator[Row]:
    """Seconds and landing error of a training of SAC beside those of older code."""
    throws, codes = options.size(THROWS), _codes(options)
    yield Count(("older",), _commit(codes["before"]))
    yield Count(("training", "throws"), throws)
    for seed in range(options.repeats or SEEDS):
        yield Count(("training", "seeds", seed), {name: train(code, throws, seed) for name, code in codes.items()})


class Stepped(NamedTuple):
    """Cells that are stepped at random."""

    env: str
    level: str | Mapping[str, str]
    cells: int
    threads: int
    steps: int
    """Steps of a turn."""


STEPS: Final = (
    Stepped("PnTConveyor-v0", "waste", 1, 1, 200),
    Stepped("PnTConveyor-v0", FLIGHT, 1, 1, 400),
    Stepped("PnTConveyor-v0", FLIGHT, 64, 1, 20),
    Stepped("PnTConveyor-v0", FLIGHT, 64, 2, 20),
    Stepped("PnTLine-v0", "single", 64, 1, 600),
    Stepped("PnTLine-v0", "single", 64, 2, 600),
    Stepped("PnTLine-v0", "skills3", 64, 1, 600),
    Stepped("PnTLine-v0", "skills3", 64, 2, 600),
)


def steps(options: Options) -> Iterator[Row]:
    """Steps beside those of older code."""
    turns, codes = options.repeats or options.size(TURNS), _codes(options)
    yield Count(("older",), _commit(codes["before"]))
    yield Count(("steps",), {"turns": turns, "cpus": os.cpu_count()})
    for n, stepped in enumerate(STEPS):
        level = stepped.level if isinstance(stepped.level, str) else stepped.level["name"]
        rates = pair_steps(codes, stepped, turns)
        yield Count(("steps", "rows", n), {**stepped._asdict(), "level": level, **rates})


def _codes(options: Options) -> dict[str, Path]:
    """Checkouts of the older code and of this code.

    Raises:
        UsageError: there is no older code.
    """
    if options.before is None:
        raise UsageError("a comparison with older code needs the older code's checkout: give --before DIR")
    return {"before": options.before, "now": ROOT}


def _commit(checkout: Path) -> str:
    """The first digits of a checkout's commit."""
    return (commit_of(checkout) or "unknown")[:8]


def train(checkout: Path, throws: int, seed: int) -> dict[str, float]:
    """Seconds of a training by the code of a checkout, and the last landing error [m]."""
    with TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        words = f"-m agents.train --env PnTConveyor-v0 --steps {throws} --seed {seed} --eval-picks 0 --out {out}"
        subprocess.run(
            [sys.executable, *words.split()], cwd=checkout, env=_environment(checkout), check=True, capture_output=True
        )
        last = list(csv.DictReader((out / "progress.csv").read_text(encoding="utf-8").splitlines()))[-1]
    return {"seconds": float(last["seconds"]), "landing_error_m": float(last["landing_error_mean_m"])}


def pair_steps(codes: Mapping[str, Path], stepped: Stepped, turns: int) -> dict[str, float]:
    """Medians of the throws/s, or decisions/s, of each code, and of the ratios of the codes' turns.

    Args:
        codes: checkouts by name, `before` and `now`.
        stepped: what is stepped.
        turns: number of turns, after one that warms up.
    """
    script = str(Path(__file__).with_name("stepping.py"))
    words = [stepped.env, json.dumps(stepped.level), str(stepped.cells), str(stepped.threads)]
    command = [sys.executable, script, *words]
    seconds: dict[str, list[float]] = {name: [] for name in codes}
    with ExitStack() as stack:
        processes = {
            name: stack.enter_context(
                subprocess.Popen(command, cwd=code, env=_environment(code), text=True, stdin=PIPE, stdout=PIPE)
            )
            for name, code in codes.items()
        }
        for _, (name, process) in product(range(1 + turns), processes.items()):
            seconds[name].append(_turn(process, stepped.steps))
    before, now = (seconds[name][1:] for name in ("before", "now"))
    ratio = median(old / new for old, new in zip(before, now, strict=True))
    count = stepped.cells * stepped.steps
    return {"before": count / median(before), "now": count / median(now), "ratio": ratio}


def _environment(checkout: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(checkout.resolve())}


def _turn(process: subprocess.Popen[str], steps: int) -> float:
    """Seconds that a process takes for the steps of a turn."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(f"{steps}\n")
    process.stdin.flush()
    return float(process.stdout.readline())
