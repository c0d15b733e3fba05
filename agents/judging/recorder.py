"""A controller that keeps a log of the throws of another one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self, final

import numpy as np

from pnt_gym.arrays import concatenate_records, take
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.cell import ConveyorCell

from ..controllers.protocol import Actions, Controller, Observation, Outcome
from ..fit.log import ThrowLog, complete
from ..ground.cli import UsageError
from .throws import Throws


@final
class Recorder(Controller):
    """A controller that keeps, before each throw of another controller, what the cell knows of the throw.

    Args:
        core: the cells behind the environment.

    Raises:
        UsageError: the environment is none of the conveyor's.
    """

    name = "recorder"

    def __init__(self, core: Any) -> None:
        if not (isinstance(core, Core) and isinstance(core.cell, ConveyorCell)):
            raise UsageError("--log goes with PnTConveyor-v0, PnTRelease-v0 and PnTAdapt-v0, whose throws have a log")
        self._inner: Controller | None = None
        self._core: Any = core
        self._parts: list[ThrowLog] = []
        self._throws: list[Throws] = []

    def watch(self, controller: Controller) -> Self:
        """This recorder, around a controller that has practised."""
        self.name, self._inner = controller.name, controller
        self._parts.clear()
        self._throws.clear()
        return self

    def act(self, observation: Observation) -> Actions:
        """Actions of the inner controller (N, A)."""
        assert self._inner is not None
        actions = self._inner.act(observation)
        plans, _ = self._core.plan(actions)
        self._parts.append(ThrowLog.of(self._core.context, plans))
        return actions

    def learn(self, outcome: Outcome) -> None:
        """Let the inner controller learn."""
        assert self._inner is not None
        self._inner.learn(outcome)

    def log(self, throws: Throws, seed: int) -> ThrowLog:
        """The log of the throws that were carried out since `watch`; `seed` is that of the camera's noise."""
        log = take(concatenate_records(self._parts), slice(len(throws)))
        return complete(log, throws.info, self._core.config, np.random.default_rng((seed, 7)))

    def keep(self, steps: Iterator[Throws]) -> Iterator[Throws]:
        """Throws one after the other, which are kept for `text`."""
        for throws in steps:
            self._throws.append(throws)
            yield throws

    def text(self, seed: int, record: Any = None) -> str:
        """The log of the throws that were carried out since `watch` as CSV.

        Args:
            seed: seed of the camera's noise.
            record: a record of these throws; None for those that passed through `keep`.
        """
        throws = concatenate_records(self._throws) if record is None else record.throws
        return self.log(throws, seed).text(self._core.item_names)
