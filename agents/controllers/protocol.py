"""The protocol of controllers: a controller sees a pick, corrects the throw, and may learn from its landing.

Evaluation, practice and the benchmark use only these types, and accept every class with the same methods. All arrays
hold one row per throw of a batch.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, final, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints

Actions = NDArray[np.float32]
State = Mapping[str, NDArray[Any]]


@final
@dataclass(frozen=True)
class Observation:
    """N coming picks as a controller sees them."""

    features: NDArray[np.float32]
    """What the environment returned, (N, D)."""
    kind: Ints
    """Seen class of each object: index into the core's `item_names` (N,)."""


@final
@dataclass(frozen=True)
class Outcome:
    """N throws and their outcomes."""

    observation: Observation
    action: Actions
    error: Floats
    """Errors in the coordinates that actions shift (N, E), by the names of the core's `Correction`; on the conveyor the
    landing against the target, along and across the throw [m]. E is 0 where the core has no correction."""
    is_success: Bools
    cycle_time: Floats
    """Pick to pick, with dwell [s]."""
    clipped: Bools
    """The action was infeasible and a shortened one was carried out: a learner skips this throw."""


class Controller(Protocol):
    """Corrects throws.

    A class of your own inherits from `Controller`, or has the same methods. A subclass needs only `name` and `act`:

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
    """In tables and files."""

    def reset(self, seed: int) -> None:
        """Forget the learned state and seed random numbers anew; by default there is no state."""

    @abstractmethod
    def act(self, observation: Observation) -> Actions:
        """Actions (N, A) in [-1, 1]; zero is the analytic planner."""
        ...

    def learn(self, outcome: Outcome) -> None:
        """Learn from the outcome of the throws of the last `act`; by default nothing is learned."""


@runtime_checkable
class Learner(Controller, Protocol):
    """A controller that learns from throws, and whose learned state can be saved."""

    def begin_practice(self, throws: int) -> None:
        """Begin a practice of about `throws` throws; the controller may explore until `end_practice`."""

    def end_practice(self) -> None:
        """End the practice: stop exploring and settle the learned state."""

    @abstractmethod
    def state(self) -> State:
        """The learned state, as named arrays, independent of the level of the practice."""
        ...

    @abstractmethod
    def restore(self, state: State) -> None:
        """Take over the learned state of another controller of the same name."""
        ...
