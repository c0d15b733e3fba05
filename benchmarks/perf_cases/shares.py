"""Cases of where time goes: shares of a step, and of a training, by their parts."""

from __future__ import annotations

import os
import signal
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Final

from benchmarks.perf_cases.cells import FLIGHT, open_cells, repeat
from benchmarks.timing import Count, Options, Row

INTERVAL: Final = 0.001
"""Between two samples [s]; machine code is sampled at its end, with all the time that it took."""
ROOT: Final = Path(__file__).resolve().parents[2]
Parts = Sequence[tuple[str, set[str]]]
"""Parts of what runs, each with functions that are all on the stack; a sample belongs to the first part that fits."""
THROW: Final[Parts] = (
    ("engine: robot and object", {"Batch.rollout", "ConveyorPlant._roll_out_robot"}),
    ("engine: object alone", {"Batch.rollout", "fall"}),
    ("engine: contacts of flights", {"Batch.rollout", "settle"}),
    ("flights in machine code", {"FreeObjects.predict_landings"}),
    ("swing and grip until the release", {"ThrowClock.of"}),
    ("models and states for the engine", {"ConveyorPlant.write"}),
    ("models and states for the engine", {"FreeObjects._write"}),
    ("references of the motors", {"ConveyorPlant._references"}),
    ("effort of the motors", {"ConveyorPlant._effort_of_plan"}),
    ("effort of the motors", {"ConveyorPlant._effort"}),
    ("joining and judging", {"ConveyorCell._simulate"}),
    ("choice of the next object", {"BeltPicks._choose_picks"}),
    ("new objects on the belt", {"BeltStream.ride"}),
    ("choice of the next object", {"BeltPicks.following"}),
    ("plan of the throw", {"Core.plan"}),
    ("plan of the throw", {"ConveyorCell._motion"}),
    ("objects beside the throw", {"BeltPicks.find_collisions"}),
    ("observation, rewards, info", {"Core.observe"}),
    ("observation, rewards, info", {"ConveyorCell.reward"}),
    ("observation, rewards, info", {"ConveyorCell.info"}),
)
DECISION: Final[Parts] = (
    ("decisions in machine code", {"Chooser.advance"}),
    ("choice carried out", {"LineCell.take"}),
    ("objects of new shifts", {"StreamSampler.draw"}),
    ("figures of a shift", {"LineCore._shift_info"}),
)
TRAINING: Final[Parts] = (
    ("gradient steps", {"BanditSAC.train"}),
    ("throws", {"SameStepVecEnv.step_wait"}),
    ("libraries, cells and networks", {"Session.__init__"}),
    ("libraries, cells and networks", {"open_trial"}),
    ("libraries, cells and networks", {"Session.create"}),
    ("choice of actions", {"OffPolicyAlgorithm._sample_action"}),
    ("checkpoints", {"RunFolder.save"}),
)
REST: Final = "everything else"
STEPS: Final = (
    ("PnTConveyor-v0", "waste", 1, 4000, THROW),
    ("PnTConveyor-v0", "waste", 64, 100, THROW),
    ("PnTConveyor-v0", FLIGHT, 1, 8000, THROW),
    ("PnTConveyor-v0", FLIGHT, 64, 400, THROW),
    ("PnTLine-v0", "single", 64, 5000, DECISION),
)
"""Environment, level, cells, steps that are sampled, and parts; one cell is a single environment."""
THROWS = 1000
"""Throws of a training."""


@contextmanager
def sample_shares(parts: Parts) -> Iterator[dict[str, float]]:
    """Shares of this thread's processor time by part, from the end of the context on."""
    times, last = defaultdict[str, float](float), time.thread_time()

    def take_sample(_: int, frame: FrameType | None) -> None:
        nonlocal last
        now, names = time.thread_time(), set[str]()
        while frame is not None:
            names.add(frame.f_code.co_qualname)
            frame = frame.f_back
        times[next((part for part, functions in parts if functions <= names), REST)] += now - last
        last = time.thread_time()  # the sample's own time is no part's

    before, shares = signal.signal(signal.SIGALRM, take_sample), dict[str, float]()
    signal.setitimer(signal.ITIMER_REAL, INTERVAL, INTERVAL)
    try:
        yield shares
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    shares |= {part: times[part] / sum(times.values()) for part in [*dict(parts), REST] if part in times}


def steps(options: Options) -> Iterator[Row]:
    """Shares of a step by its parts, of single environments and of vectors on one thread."""
    yield Count(("cpus",), os.cpu_count())
    for n, (env_id, level, cells, usual, parts) in enumerate(STEPS):
        step, count = open_cells(env_id, level, cells).step, options.size(usual)
        repeat(step, max(count // 10, 2))
        with sample_shares(parts) as shares:
            repeat(step, count)
        name = level if isinstance(level, str) else level["name"]
        yield Count(("steps", n), {"env": env_id, "level": name, "cells": cells})
        yield Count(("steps", n, "parts"), shares)


def training(options: Options) -> Iterator[Row]:
    """A training of SAC by its parts."""
    from agents.train import Arguments, main  # noqa: PLC0415 - imports torch on its way

    throws = options.size(THROWS)
    yield Count((), {"cpus": os.cpu_count(), "throws": throws})
    with TemporaryDirectory() as folder, sample_shares(TRAINING) as shares:
        main(Arguments(env="PnTConveyor-v0", steps=throws, out=Path(folder) / "run", eval_picks=0))
    yield Count(("parts",), shares)
