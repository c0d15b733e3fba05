"""Protocol of controllers: a controller observes a pick, corrects the throw, and may learn from the landing.

Evaluation, practice and the benchmark know only these types, and accept every class that fits them. All arrays hold one
row per throw of a batch.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol, final, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.cells.base.action import Correction

from ..ground.cli import UsageError

Actions = NDArray[np.float32]
State = Mapping[str, NDArray[Any]]

STEPS: Final = 2
"""Predictions of a throw that is aimed by a model of the cell; two leave 0.2 mm on `waste`."""


@final
@dataclass(frozen=True)
class Observation:
    """N coming picks as a controller observes them."""

    features: NDArray[np.float32]
    """Observations of the environment (N, D); of an environment with pictures, the vectors beside the pictures."""
    kind: Ints
    """Item of the object by the cell's classifier: index into the core's `item_names` (N,)."""
    image: NDArray[np.uint8] | None = None
    """Pictures (N, 5, H, W) as `PnTGrasp-v0` shows them; None in environments without pictures."""
    last: NDArray[np.float32] | None = None
    """The last try and the last landing (N, L) as `PnTGrasp-v0` shows them in shifts; None in other episodes."""


@final
@dataclass(frozen=True)
class Outcome:
    """Actions and results of N throws."""

    observation: Observation
    action: Actions
    error: Floats
    """Errors in the coordinates that actions offset (N, E), by the names of the core's `Correction`; on the conveyor
    the landing against the target, along and across the throw [m]. E is 0 where the core has no correction."""
    is_success: Bools
    cycle_time: Floats
    """Time from pick to pick, with dwell [s]."""
    clipped: Bools
    """Whether the action was infeasible and another one was executed; such throws tell nothing of their action."""
    reward: Floats
    """Rewards of the environment (N,)."""


class Controller(Protocol):
    """Corrects throws.

    A user's class inherits from `Controller` or has the same methods; a subclass needs only `name` and `act`:

        class Further(Controller):
            name = "further"

            def __init__(self, core: Core) -> None:
                self.core = core

            def act(self, observation: Observation) -> Actions:
                return np.full((len(observation.kind), self.core.action_space.shape[0]), 0.1, dtype=np.float32)

    `--controller MODULE:CLASS` calls the class without arguments, but for `core=`, the cells behind the environment
    (`pnt_gym.cells.base.core.Core`), if it has a parameter of that name.
    """

    name: str
    """Name in tables and files."""

    def reset(self, seed: int) -> None:
        """Forget what was learned and reseed random numbers; the default does nothing."""

    @abstractmethod
    def act(self, observation: Observation) -> Actions:
        """Actions (N, A) in [-1, 1]; zero is the analytic planner."""
        ...

    def learn(self, outcome: Outcome) -> None:
        """Learn from the outcome of the throws of the last `act`; the default learns nothing."""


def learns(controller: Controller) -> bool:
    """Whether a controller has a `learn` of its own, and so can practise."""
    return getattr(type(controller), "learn", Controller.learn) is not Controller.learn


@runtime_checkable
class Learner(Controller, Protocol):
    """A controller that improves with throws, explores in its practice, and whose knowledge can be saved."""

    def begin_practice(self, throws: int) -> None:
        """Begin about `throws` throws of practice; the controller may explore until `end_practice`."""

    def end_practice(self) -> None:
        """Stop exploring and settle the learned correction."""

    @abstractmethod
    def state(self) -> State:
        """Learned values as named arrays, independent of the level."""
        ...

    @abstractmethod
    def restore(self, state: State) -> None:
        """Load the state of another controller of the same name."""
        ...


def to_action(offset: Floats, correction: Correction) -> Actions:
    """Actions (N, E) that offset the planned outcome by `offset` (N, E), clipped to [-1, 1]."""
    return np.clip(offset / correction.scale, -1.0, 1.0).astype(np.float32)


def aimed_offsets(predict: Callable[[Floats], Floats], count: int, correction: Correction) -> Floats:
    """Offsets (N, E) at which a model's errors (N, E), as `predict` has them for offsets (N, E), are near zero.

    Each step takes the predicted errors off the offsets, within the range of actions.
    """
    offset, scale = np.zeros((count, correction.count)), correction.scale
    for _ in range(STEPS):
        offset = np.clip(offset - predict(offset), -scale, scale)
    return offset


def ideal_offsets(outcome: Outcome, correction: Correction) -> Floats:
    """Offset (N, E) that would have brought each throw to its goal.

    The outcome is assumed to follow the offset one to one: the offset of the action minus the error. The result is
    clipped to the action range, so that an object deflected by a rim or a touch only counts as far off.
    """
    return np.clip(outcome.action * correction.scale - outcome.error, -correction.scale, correction.scale)


def is_instructive(outcome: Outcome) -> Bools:
    """Whether each throw (N,) was executed as asked and its error was measured."""
    return np.isfinite(outcome.error).all(axis=1) & ~outcome.clipped


def check(offset: Floats, correction: Correction, name: str) -> None:
    """Check that the learned offsets (M, E) of a controller have the number of coordinates of this cell.

    Raises:
        UsageError: the number of coordinates differs.
    """
    count, required = offset.shape[1], correction.count
    if count != required:
        raise UsageError(f"the saved state of {name!r} holds shifts of {count} numbers; they must have {required} here")


@final
class SeparateControllers(Controller):
    """N controllers of one class; controller i sees only row i.

    Args:
        controllers: one controller for each row.
    """

    def __init__(self, controllers: Sequence[Controller]) -> None:
        self._controllers = list(controllers)
        self.name = self._controllers[0].name

    def reset(self, seed: int) -> None:
        """Reset every controller, each with its own seed."""
        for row, controller in enumerate(self._controllers):
            controller.reset(seed + row)

    def act(self, observation: Observation) -> Actions:
        """Action of each row's controller (N, A)."""
        rows = [slice(row, row + 1) for row in range(len(observation.kind))]
        return np.concatenate(
            [controller.act(take(observation, row)) for controller, row in zip(self._controllers, rows, strict=False)]
        )

    def learn(self, outcome: Outcome) -> None:
        """Pass each row's outcome to the row's controller."""
        for row in range(len(outcome.cycle_time)):
            self._controllers[row].learn(take(outcome, slice(row, row + 1)))
