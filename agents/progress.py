"""What a training run tells while it runs: a bar on the terminal, lines in progress.csv, a stop on Ctrl-C."""

from __future__ import annotations

import signal
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, final

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from .files import write_text

WINDOW = 256
"""Throws that the figures on the bar are averaged over."""
EVERY = 256
"""Throws per line of progress.csv."""
HEADER = "throws,seconds,success_rate,landing_error_mean_m,reward_mean"


@final
class Stop:
    """Whether Ctrl-C was pressed; the throw in progress is finished first."""

    def __init__(self) -> None:
        self.asked = False

    @contextmanager
    def listening(self) -> Iterator[Stop]:
        """Take the first Ctrl-C as a wish; a second one interrupts at once."""
        before = signal.getsignal(signal.SIGINT)

        def on_signal(*_: Any) -> None:
            self.asked = True
            signal.signal(signal.SIGINT, before)

        signal.signal(signal.SIGINT, on_signal)
        try:
            yield self
        finally:
            signal.signal(signal.SIGINT, before)


@final
class ProgressCallback(BaseCallback):
    """Reports throws, success and landing error.

    Args:
        file: progress.csv; lines after throw `start` are from a leg that is done again and are dropped.
        start: throws already done.
        stop: asked whether to go on after each batch.
        show: called with throws of the batch, throws per second, success rate and mean landing error [m].
    """

    def __init__(self, file: Path, start: int, stop: Stop, show: Callable[[int, float, float, float], None]) -> None:
        super().__init__()
        self._file = file
        self._stop = stop
        self._show = show
        self._recent: deque[tuple[float, float, float]] = deque(maxlen=WINDOW)
        self._began = time.perf_counter()
        self._thrown = 0
        self._lines = _lines_up_to(file, start)
        self._line = ""
        self._written = start

    def _on_training_start(self) -> None:
        self._recent.clear()  # a leg tells the same whether or not the process was restarted before it

    def _on_step(self) -> bool:
        rewards = self.locals["rewards"]
        for info, reward in zip(self.locals["infos"], rewards, strict=True):
            self._recent.append((info.get("is_success", 0.0), info.get("landing_error", np.nan), float(reward)))
        self._thrown += len(rewards)
        seconds = time.perf_counter() - self._began
        success, error, reward = map(_mean, zip(*self._recent, strict=True))
        self._show(len(rewards), self._thrown / seconds, success, error)
        self._line = f"{self.num_timesteps},{seconds:.2f},{success:.4f},{error:.5f},{reward:.4f}"
        if self.num_timesteps - self._written >= EVERY:
            self._write()
        return not self._stop.asked

    def _on_training_end(self) -> None:
        if self.num_timesteps > self._written:
            self._write()

    def _write(self) -> None:
        self._written = self.num_timesteps
        self._lines.append(self._line)
        write_text(self._file, "\n".join(self._lines) + "\n")


def _mean(values: Sequence[float]) -> float:
    """Of those that are numbers; NaN where none is, as before the first pick that holds."""
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else np.nan


def _lines_up_to(file: Path, throws: int) -> list[str]:
    """Header and lines of an earlier progress file, as far as they are part of the run."""
    if not file.is_file():
        return [HEADER]
    old = file.read_text(encoding="utf-8").splitlines()[1:]
    return [HEADER, *(line for line in old if _throws_of(line) <= throws)]


def _throws_of(line: str) -> float:
    """Throws done when a line was written; infinite for one that was not written here."""
    count = line.partition(",")[0]
    return int(count) if count.isdecimal() else np.inf
