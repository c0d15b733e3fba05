"""Records the throws of a controller as a log, with the noise of the camera over the bins."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, Self, final

import numpy as np

from pnt_gym.arrays import Floats, concatenate_records, take
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.shift import CAMERA_ERRORS

from ...controllers.protocol import Actions, Controller, Observation, Outcome
from ...ground.cli import UsageError
from .data import Throws
from .log import ThrowLog, landing_in_world


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
        self._parts.append(ThrowLog.of_throws(self._core.context, plans))
        return actions

    def learn(self, outcome: Outcome) -> None:
        """Let the inner controller learn."""
        assert self._inner is not None
        self._inner.learn(outcome)

    def log(self, throws: Throws, seed: int) -> ThrowLog:
        """The log of the throws that were carried out since `watch`; `seed` is that of the camera's noise."""
        log = take(concatenate_records(self._parts), slice(len(throws)))
        return complete_log(log, throws.info, self._core.config, np.random.default_rng((seed, 7)))

    def text(self, throws: Throws, seed: int) -> str:
        """The log of throws as CSV."""
        return self.log(throws, seed).text(self._core.item_names)

    def keep(self, steps: Iterator[Throws]) -> Iterator[Throws]:
        """Throws one after the other, which are kept for `all_text`."""
        for throws in steps:
            self._throws.append(throws)
            yield throws

    def all_text(self, seed: int) -> str:
        """The log of the throws that passed through `keep` as CSV."""
        return self.text(concatenate_records(self._throws), seed)


def complete_log(
    log: ThrowLog, info: Mapping[str, Any], config: ConveyorConfig, random: np.random.Generator
) -> ThrowLog:
    """A log with the results of its throws, measured as `feedback` says.

    Args:
        log: what the cell knew of N throws.
        info: results of the throws by info key (N,).
        config: the cell.
        random: generator of the camera's noise; a cell with a camera over its bins has measured already.
    """
    count, sealed, lost = len(log), np.asarray(info["picked"]), np.asarray(info["dropped"])
    true = np.stack([info["landing_along"], info["landing_across"]], axis=1)
    visible = np.hypot(*true.T) <= config.feedback.view
    noise, chance = random.standard_normal((count, 2)), random.random(count)
    errors: Floats = true + config.feedback.noise * noise
    visible &= chance >= config.feedback.unseen
    if set(CAMERA_ERRORS) <= set(info):
        errors = np.stack([info[name] for name in CAMERA_ERRORS], axis=1)
        visible = np.isfinite(errors).all(axis=1)
    landing = landing_in_world(log, *errors.T)
    landing[~(visible & sealed & ~lost)] = np.nan
    return replace(
        log,
        sealed=sealed.astype(np.float64),
        lost=np.where(sealed, lost, np.nan).astype(np.float64),
        landing=landing,
    )
