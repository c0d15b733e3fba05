"""Progress of a training run: a bar on the terminal, lines in progress.csv, a stop on Ctrl-C."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import final

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from pnt_gym.reading import text_of

from ..ground.files import MOST_RESULTS, write_text
from ..ground.streams import handle_signals, interrupt
from .windows import Window

HEADER = "throws,seconds,success_rate,{},reward_mean"
LINE = re.compile(r"(\d{1,15}),(\d{1,15}\.\d+),", re.ASCII)
"""Beginning of a line of progress.csv: steps, and seconds of training of all legs, before and after a resume."""


@final
class Stop:
    """When a training stops: at a request by a signal, after the current step, or at a number of throws.

    Args:
        until: throws at which the training stops, and can go on later to its total number; None for this number.
    """

    def __init__(self, until: int | None = None) -> None:
        self.until = until
        self.number: int | None = None
        """Number of the signal, or None."""

    @property
    def is_set(self) -> bool:
        """Whether a signal has asked to stop."""
        return self.number is not None

    @contextmanager
    def listen(self) -> Iterator[Stop]:
        """Handle signals in the block: the first one requests a stop, the second one interrupts at once."""
        with handle_signals(self._on_signal):
            yield self

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self.is_set:
            interrupt(number, frame)
        self.number = number


@final
class ProgressCallback(BaseCallback):
    """Reports steps, success and a figure of the training to a progress bar and to progress.csv.

    Args:
        file: progress.csv; lines after step `start` belong to a leg that is repeated, and are dropped.
        start: number of steps already done.
        stop: checked after each batch.
        window: figures of the last steps.
        show: called with steps of the batch, steps per second, success rate and the window's figure.
    """

    def __init__(
        self, file: Path, start: int, stop: Stop, window: Window, show: Callable[[int, float, float, float], None]
    ) -> None:
        super().__init__()
        self._file = file
        self._stop = stop
        self._window = window
        self._show = show
        self._began = time.perf_counter()
        self._count = 0
        self._lines = [HEADER.format(window.column)]
        if file.is_file():  # of an earlier leg, up to the throws of the checkpoint
            earlier = text_of(file, MOST_RESULTS).splitlines()[1:]
            self._lines += [line for line in earlier if _numbers(line)[0] <= start]
        self._before = _numbers(self._lines[-1])[1] if self._lines[1:] else 0.0
        self._line = ""
        self._written = start

    def _on_training_start(self) -> None:
        self._window.clear()

    def _on_step(self) -> bool:
        rewards = self.locals["rewards"]
        success, figure, reward = self._window.add(self.locals["infos"], rewards)
        self._count += len(rewards)
        seconds = time.perf_counter() - self._began
        self._show(len(rewards), self._count / seconds, success, figure)
        self._line = f"{self.num_timesteps},{self._before + seconds:.2f},{success:.4f},{figure:.5f},{reward:.4f}"
        if self.num_timesteps - self._written >= self._window.every:
            self._write()
        return not self._stop.is_set

    def _on_training_end(self) -> None:
        if self.num_timesteps > self._written:
            self._write()

    def _write(self) -> None:
        self._written = self.num_timesteps
        self._lines.append(self._line)
        write_text(self._file, "\n".join(self._lines) + "\n")


def _numbers(line: str) -> tuple[float, float]:
    """Throws and seconds of training in a line of progress.csv; infinitely many throws for a line of another form."""
    match = LINE.match(line)
    return (float(match[1]), float(match[2])) if match else (np.inf, 0.0)
