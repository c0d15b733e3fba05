"""What a training run tells while it runs: a bar on the terminal, lines in progress.csv, a stop on Ctrl-C."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, final

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from pnt_gym.reading import text_of

from ..ground.files import MOST_RESULTS, write_text
from ..ground.signals import handled, interrupt

WINDOW = 256
"""Throws that the figures on the bar are averaged over."""
EVERY = 256
"""Throws per line of progress.csv."""
HEADER = "throws,seconds,success_rate,{},reward_mean"
MANY = 4096
"""The same two for decisions at a line, of which there are more, and which differ more."""


@final
class Stop:
    """Whether a signal asked to stop; the throw in progress is finished first."""

    def __init__(self) -> None:
        self.number: int | None = None
        """Of the signal that asked."""

    @property
    def asked(self) -> bool:
        """Whether a signal asked."""
        return self.number is not None

    @contextmanager
    def listening(self) -> Iterator[Stop]:
        """Take the first signal as a wish; a second one interrupts at once."""
        with handled(self._on_signal):
            yield self

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self.asked:
            interrupt(number, frame)
        self.number = number


class ProgressCallback(BaseCallback):
    """Reports throws, success and landing error.

    Args:
        file: progress.csv; lines after throw `start` are from a leg that is done again and are dropped.
        start: throws already done.
        stop: asked whether to go on after each batch.
        show: called with throws of the batch, throws per second, success rate and mean landing error [m].
    """

    figure = "landing_error_mean_m"
    """What is told beside success, in progress.csv."""
    every = EVERY
    """Throws per line there."""

    def __init__(self, file: Path, start: int, stop: Stop, show: Callable[[int, float, float, float], None]) -> None:
        super().__init__()
        self._file = file
        self._stop = stop
        self._show = show
        self._recent: deque[tuple[float, float, float]] = deque(maxlen=WINDOW)
        self._began = time.perf_counter()
        self._thrown = 0
        self._lines = _lines_up_to(file, start, HEADER.format(self.figure))
        self._line = ""
        self._written = start

    def _on_training_start(self) -> None:
        self._recent.clear()  # a leg tells the same whether or not the process was restarted before it

    def _on_step(self) -> bool:
        rewards = self.locals["rewards"]
        success, figure, reward = self._told(self.locals["infos"], rewards)
        self._thrown += len(rewards)
        seconds = time.perf_counter() - self._began
        self._show(len(rewards), self._thrown / seconds, success, figure)
        self._line = f"{self.num_timesteps},{seconds:.2f},{success:.4f},{figure:.5f},{reward:.4f}"
        if self.num_timesteps - self._written >= self.every:
            self._write()
        return not self._stop.asked

    def _told(self, infos: Sequence[Mapping[str, Any]], rewards: Sequence[float]) -> tuple[float, float, float]:
        """Success, figure and reward on average lately, after one more step of all rows."""
        for info, reward in zip(infos, rewards, strict=True):
            self._recent.append((info.get("is_success", 0.0), info.get("landing_error", np.nan), float(reward)))
        success, error, reward = map(_mean, zip(*self._recent, strict=True))
        return success, error, reward

    def _on_training_end(self) -> None:
        if self.num_timesteps > self._written:
            self._write()

    def _write(self) -> None:
        self._written = self.num_timesteps
        self._lines.append(self._line)
        write_text(self._file, "\n".join(self._lines) + "\n")


@final
class ShiftProgress(ProgressCallback):
    """Reports decisions, success, and value per minute; takes what the other does."""

    figure = "value_per_min"
    every = MANY

    def _told(self, infos: Sequence[Mapping[str, Any]], rewards: Sequence[float]) -> tuple[float, float, float]:
        names = ("is_success", "value", "dt")
        sums = (float(sum(info[name] for info in infos)) for name in names)
        self._steps.append((len(infos), float(np.sum(rewards)), *sums))
        while len(self._steps) > 1 and sum(step[0] for step in self._steps) > MANY:
            self._steps.popleft()  # the last step stays, however many lines took part in it
        count, reward, success, value, seconds = map(sum, zip(*self._steps, strict=True))
        return success / count, 60.0 * value / seconds if seconds > 0.0 else np.nan, reward / count

    def _on_training_start(self) -> None:
        self._steps: deque[tuple[float, ...]] = deque()


def _mean(values: Sequence[float]) -> float:
    """Of those that are numbers; NaN where none is, as before the first pick that holds."""
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else np.nan


def _lines_up_to(file: Path, throws: int, header: str) -> list[str]:
    """Header and lines of an earlier progress file, as far as they are part of the run."""
    if not file.is_file():
        return [header]
    old = text_of(file, MOST_RESULTS).splitlines()[1:]
    return [header, *(line for line in old if _throws_of(line) <= throws)]


def _throws_of(line: str) -> float:
    """Throws done when a line was written; infinite for one that was not written here."""
    count = line.partition(",")[0]
    return int(count) if count.isdecimal() else np.inf
