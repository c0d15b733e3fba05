"""Speeds of this code beside those of older code, in turn."""

from __future__ import annotations

import csv
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
from typing import Final

from agents.ground.cli import UsageError
from benchmarks.timing import Count, Options, Row

ROOT: Final = Path(__file__).parents[2]
LEVELS: Final = ("single", "skills3")
"""Levels of the lines."""
STEPS, TURNS = 100, 10
"""Steps of a turn, and number of turns, of lines."""
THROWS, SEEDS = 5000, 3
"""Throws of a training, and number of trainings."""


def training(options: Options) -> Iterator[Row]:
    """Seconds and landing error of a training of SAC beside those of older code."""
    throws, codes = options.size(THROWS), _codes(options)
    yield Count(("training", "throws"), throws)
    for seed in range(options.repeats or SEEDS):
        yield Count(("training", "seeds", seed), {name: train(code, throws, seed) for name, code in codes.items()})


def lines(options: Options) -> Iterator[Row]:
    """Decisions/s of lines by table beside those of older code."""
    turns, codes = options.repeats or options.size(TURNS), _codes(options)
    yield Count(("lines",), {"cells": options.cells, "turns": turns, "cpus": os.cpu_count()})
    for n, (level, threads) in enumerate(product(LEVELS, options.threads)):
        rates = decide(codes, (level, options.cells, threads), turns)
        yield Count(("lines", "rows", n), {"level": level, "threads": threads, **rates})


def _codes(options: Options) -> dict[str, Path]:
    """Checkouts of the older code and of this code.

    Raises:
        UsageError: there is no older code.
    """
    if options.before is None:
        raise UsageError("a comparison with older code needs the older code's checkout: give --before DIR")
    return {"before": options.before, "now": ROOT}


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


def decide(codes: Mapping[str, Path], settings: tuple[str, int, int], turns: int) -> dict[str, float]:
    """Medians of the decisions/s of each code, and of the ratios of the codes' turns.

    Args:
        codes: checkouts by name, `before` and `now`.
        settings: level, cells and threads.
        turns: number of turns, after one that warms up.
    """
    script = str(Path(__file__).with_name("decide.py"))
    command = [sys.executable, script, *map(str, settings)]
    seconds: dict[str, list[float]] = {name: [] for name in codes}
    with ExitStack() as stack:
        processes = {
            name: stack.enter_context(
                subprocess.Popen(command, cwd=code, env=_environment(code), text=True, stdin=PIPE, stdout=PIPE)
            )
            for name, code in codes.items()
        }
        for _, (name, process) in product(range(1 + turns), processes.items()):
            seconds[name].append(_turn(process))
    before, now = (seconds[name][1:] for name in ("before", "now"))
    ratio = median(old / new for old, new in zip(before, now, strict=True))
    return {**{name: settings[1] * STEPS / median(times[1:]) for name, times in seconds.items()}, "ratio": ratio}


def _environment(checkout: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(checkout.resolve())}


def _turn(process: subprocess.Popen[str]) -> float:
    """Seconds that a process takes for the steps of a turn."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(f"{STEPS}\n")
    process.stdin.flush()
    return float(process.stdout.readline())
