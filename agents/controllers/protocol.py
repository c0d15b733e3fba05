"""What a controller is: it sees a pick, corrects the throw, and may learn from where the object landed.

Evaluation, practice and the benchmark know only these types, and take every class that fits them for one of ours. All
arrays hold one row per throw of a batch.
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
    """What the cell's classifier says the object is: index into the core's `item_names` (N,)."""


@final
@dataclass(frozen=True)
class Outcome:
    """N throws and what became of them."""

    observation: Observation
    action: Actions
    error: Floats
    """Errors in the coordinates that actions shift (N, E), by the names of the core's `Correction`; on the conveyor the
    landing against the target, along and across the throw [m]. E is 0 where the core has no correction."""
    is_success: Bools
    cycle_time: Floats
    """Pick to pick, with dwell [s]."""
    clipped: Bools
    """The action was infeasible and another one was executed: nothing can be learned from it."""


class Controller(Protocol):
    """Corrects throws.

    A class of your own inherits from it, or looks like it; inherited, `name` and `act` are all it needs:

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
        """Forget what was learned and reseed whatever is random; unless overridden there is nothing to forget."""

    @abstractmethod
    def act(self, observation: Observation) -> Actions:
        """Actions (N, A) in [-1, 1]; zero is the analytic planner."""
        ...

    def learn(self, outcome: Outcome) -> None:
        """Take in the outcome of the throws of the last `act`; unless overridden nothing is learned."""


@runtime_checkable
class Learner(Controller, Protocol):
    """A controller that gets better by throwing, and whose knowledge can be kept."""

    def begin_practice(self, throws: int) -> None:
        """Announce that about `throws` throws are for learning; it may explore until `end_practice`."""

    def end_practice(self) -> None:
        """Stop exploring and settle what was learned."""

    @abstractmethod
    def state(self) -> State:
        """What was learned, as named arrays; independent of the level it was learned on."""
        ...

    @abstractmethod
    def restore(self, state: State) -> None:
        """Take over what another controller of the same name learned."""
        ...
