"""Figures of a training's last steps, averaged over a window."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, final

import numpy as np

from ..ground import metrics


class Window(ABC):
    """Abstract: figures of the last steps of a training, averaged."""

    step: ClassVar[str] = "throws"
    """Name of the counted steps, in the plural."""
    column: ClassVar[str]
    """Column of the figure in progress.csv."""
    label: ClassVar[str]
    """Label of the figure on the axis of a curve."""
    scale: ClassVar[float] = 1.0
    """Factor from the figure to the unit of the label."""
    every: ClassVar[int]
    """Steps per line of progress.csv."""

    @abstractmethod
    def clear(self) -> None:
        """Forget all steps, so that the figures of a leg do not depend on a restart of the process before it."""

    @abstractmethod
    def add(self, infos: Sequence[Mapping[str, Any]], rewards: Sequence[float]) -> tuple[float, float, float]:
        """Add one step of all rows; mean success, figure and reward of the last steps."""

    @abstractmethod
    def text(self, figure: float) -> str:
        """Text of the figure on a progress bar."""


@final
class ThrowWindow(Window):
    """Landing error of the last throws."""

    column = "landing_error_mean_m"
    label = "landing error, mean [mm]"
    scale = 1000.0
    every = 256
    size: ClassVar[int] = 256
    """Number of throws in the window."""

    def __init__(self) -> None:
        self._throws: deque[tuple[float, float, float]] = deque(maxlen=self.size)

    def clear(self) -> None:
        """Forget all steps."""
        self._throws.clear()

    def add(self, infos: Sequence[Mapping[str, Any]], rewards: Sequence[float]) -> tuple[float, float, float]:
        """Add one step of all rows; mean success, landing error [m] and reward of the last throws."""
        for info, reward in zip(infos, rewards, strict=True):
            if info:  # else the row's pick goes on
                self._throws.append((info.get("is_success", 0.0), info.get("landing_error", np.nan), float(reward)))
        success, error, reward = map(metrics.mean, zip(*self._throws, strict=True)) if self._throws else 3 * (np.nan,)
        return success, error, reward

    def text(self, figure: float) -> str:
        """Text of the landing error on a progress bar."""
        return f"{self.scale * figure:.1f} mm off"


@final
class DecisionWindow(Window):
    """Value per minute of the last decisions of lines; decisions are more numerous and scatter more than throws."""

    step = "decisions"
    column = "value_per_min"
    label = "value per minute"
    every = 4096
    size: ClassVar[int] = 4096
    """Number of decisions in the window."""

    def __init__(self) -> None:
        self._steps: deque[tuple[float, ...]] = deque()

    def clear(self) -> None:
        """Forget all steps."""
        self._steps.clear()

    def add(self, infos: Sequence[Mapping[str, Any]], rewards: Sequence[float]) -> tuple[float, float, float]:
        """Add one step of all rows; mean success, value per minute and mean reward of the last decisions."""
        sums = (float(sum(info[name] for info in infos)) for name in ("is_success", "value", "dt"))
        self._steps.append((len(infos), float(np.sum(rewards)), *sums))
        while len(self._steps) > 1 and sum(step[0] for step in self._steps) > self.size:
            self._steps.popleft()  # the last step stays, however many lines it has
        count, reward, success, value, seconds = map(sum, zip(*self._steps, strict=True))
        return success / count, 60.0 * value / seconds if seconds > 0.0 else np.nan, reward / count

    def text(self, figure: float) -> str:
        """Text of the value per minute on a progress bar."""
        return f"{figure:.1f} value/min"
