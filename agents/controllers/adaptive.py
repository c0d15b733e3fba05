"""Controllers of a drifting cell: a static policy that knows the objects, and a tracker of the present shift of picks.

Adaptive controllers see what every agent sees of `PnTAdapt-v0`: observations include the previous landing, and a share
of 0 of the shift of picks marks the begin of a new one. They use no other information.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.observation import FEEDBACK, SHIFT_TABLE

from ..ground.cli import UsageError
from ..ground.environments import Env, core_of
from .mlp import Mlp
from .newcomers import Newcomers
from .protocol import Actions, Learner, Observation, Outcome, State
from .regression import OnPolicyRegression
from .shift import to_action
from .trackers import Nothing, Tracker

FEEDBACK_SIZE: Final = len(FEEDBACK)
"""Entries at the end of an observation that describe the previous throw."""
WIDTH: Final = 128
STEPS: Final = 6000
STATIC: Final = "static"
"""Name of the static policy under adaptive controllers, and prefix of its arrays."""
IN_CONTEXT: Final = "in_context"
"""Controller whose file also holds the static policy of all adaptive controllers but `STATIC`, learned without
drift."""
READY: Final = (STATIC, "ema", "kalman", "recursive_ridge", IN_CONTEXT)
"""Adaptive controllers that need no practice, because they ship pre-trained."""
FEW: Final = 20
"""Kinds with fewer throws in practice count as unseen."""


def without_feedback(observation: Observation) -> Observation:
    """Observation without the feedback of the previous throw, as in a cell without a camera over its bins."""
    return Observation(observation.features[:, :-FEEDBACK_SIZE], observation.kind)


def told(observation: Observation) -> tuple[Floats, Bools]:
    """Ideal offsets of the previous throws (N, 2) [m], along and left of them, and whether each is known (N,)."""
    seen = SHIFT_TABLE.decode(observation.features)
    asked = np.stack([seen["last_shift_along"], seen["last_shift_across"]], axis=1)
    error = np.stack([seen["last_along"], seen["last_across"]], axis=1)
    return asked - error, (seen["last_seen"] > 0.5) & ~begins(observation)


def begins(observation: Observation) -> Bools:
    """Whether each coming throw is the first of its shift of picks (N,)."""
    return observation.features[:, -1] <= 0.0


def is_told(core: Core) -> bool:
    """Whether observations include the previous landing and the time in the shift of picks."""
    table = getattr(getattr(core, "cell", None), "table", None)
    return table is not None and table.names[-1] == FEEDBACK[-1].name


def check_begins(env: Env, who: str) -> None:
    """Check that the observations of an environment mark the begin of a shift of picks.

    Raises:
        UsageError: observations do not, so no controller there can forget the previous shift.
    """
    if not is_told(core_of(env)):
        raise UsageError(f"{who} goes by where a shift begins, which observations here do not tell; use PnTAdapt-v0")


@final
class Adaptive(Learner):
    """A static policy, and a tracker that estimates the effect of the present drift on landings.

    Practice trains the static policy: an MLP on the entries that describe the object, learned under any drift. With a
    tracker, unseen kinds have separate corrections, and the tracker learns from the known kinds only: throws of an
    unseen kind do not change the corrections of known kinds.

    Args:
        name: name of the controller.
        correction: meaning of an action.
        features: number of entries of an observation D.
        items: names of the kinds.
        tracker: tracker of the drift.
        shipped: state of the static policy before any practice.
    """

    practice = 0

    def __init__(
        self,
        name: str,
        correction: Correction,
        features: int,
        items: Sequence[str],
        tracker: Tracker,
        shipped: State,
    ) -> None:
        self.name, self._items = name, np.array(items)
        self._correction, self._tracker, self._shipped = correction, tracker, shipped
        self._static = OnPolicyRegression(name, correction, features - FEEDBACK_SIZE, Mlp(WIDTH, STEPS))
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Restore the shipped state and forget the shift."""
        self._seed, self._practising = seed, False
        self._last: tuple[Floats, Floats, Ints] | None = None
        self._thrown = np.zeros(len(self._items), dtype=np.int64)
        self._static.reset(seed)
        self.restore(self._shipped)

    def act(self, observation: Observation) -> Actions:
        """Offsets of the static policy minus the estimated effects of drift and kind, as actions (N, 2)."""
        if self._practising:
            return self._static.act(without_feedback(observation))
        self._take_in(observation)
        plain = without_feedback(observation)
        own, throws = self._static.predict(plain), plain.features.astype(np.float64)
        self._last = throws, own, observation.kind
        off = self._tracker.effect(throws) + self._newcomers.effect(observation.kind, throws)
        return to_action(own - off, self._correction)

    def learn(self, outcome: Outcome) -> None:
        """Train the static policy in practice. Outside practice all feedback is in the observations."""
        if self._practising:
            self._static.learn(replace(outcome, observation=without_feedback(outcome.observation)))
            self._thrown += np.bincount(outcome.observation.kind, minlength=len(self._thrown))

    def begin_practice(self, throws: int) -> None:
        """Begin the practice of the static policy from its initial state."""
        self._practising = True
        self._static.reset(self._seed)
        self._static.begin_practice(throws)

    def end_practice(self) -> None:
        """End the practice, and let the tracker study the static policy's errors."""
        self._practising = False
        self._static.end_practice()
        throws, right = self._static.data()
        own = self._static.predict(Observation(throws.astype(np.float32), np.zeros(len(throws), dtype=np.int64)))
        self._tracker.study(throws, own - right, self._seed)
        self._learned(self._items[self._thrown >= FEW])

    def state(self) -> State:
        """State of the static policy, names of the learned kinds, and state of the tracker."""
        own = {f"{STATIC}_{name}": value for name, value in self._static.state().items()}
        return {**own, "kinds": self._kinds, **self._tracker.state()}

    def restore(self, state: State) -> None:
        """Load a static policy and the state of the tracker."""
        own = {name: value for name, value in state.items() if name.startswith(f"{STATIC}_")}
        self._static.restore({name.removeprefix(f"{STATIC}_"): value for name, value in own.items()})
        self._tracker.restore({name: value for name, value in state.items() if name not in own and name != "kinds"})
        self._learned(np.asarray(state.get("kinds", self._items[:0])))

    def _learned(self, kinds: NDArray[np.str_]) -> None:
        """Mark the kinds of these names as known."""
        self._kinds = kinds
        known = np.isin(self._items, kinds) | isinstance(self._tracker, Nothing)
        self._newcomers = Newcomers(known)

    def _take_in(self, observation: Observation) -> None:
        """Learn from the feedback of the previous throws."""
        fresh = begins(observation)
        if self._last is None or len(fresh) != len(self._last[1]):
            self._last, fresh = None, np.full(len(fresh), True)
        if self._last is not None:
            throws, own, kind = self._last
            right, known = told(observation)
            known, new = known & ~fresh, self._newcomers.new(kind)
            self._newcomers.learn(kind, throws, own - right - self._tracker.effect(throws), known)
            self._tracker.learn(throws, own - right, known & ~new)
        self._tracker.begin(fresh)  # last, so that a row with a new shift has no trace of the previous one
