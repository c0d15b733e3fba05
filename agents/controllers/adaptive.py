"""Controllers of a drifting cell: a static policy that knows the objects, and a tracker of the present shift of picks.

Adaptive controllers see what every agent sees of `PnTAdapt-v0`: observations include the previous landing, and a share
of 0 of the shift of picks marks the beginning of a new one. They use no other information.
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
from .protocol import Actions, Learner, Observation, Outcome, State, is_instructive, to_action
from .regression import Mlp, OnPolicyRegression
from .trackers import NoTracker, Tracker, UnseenKinds

FEEDBACK_SIZE: Final = len(FEEDBACK)
"""Entries at the end of an observation that describe the previous throw."""
WIDTH: Final = 128
STEPS: Final = 6000
STATIC: Final = "static"
"""Name of the static policy under adaptive controllers, and prefix of its arrays."""
IN_CONTEXT: Final = "in_context"
"""Controller whose file also holds the static policy of all adaptive controllers but `STATIC`, learned without
drift."""
PRETRAINED: Final = (STATIC, "ema", "kalman", "recursive_ridge", IN_CONTEXT)
"""Adaptive controllers that need no practice, because they ship pre-trained."""
MIN_THROWS: Final = 20
"""Kinds with fewer throws in practice count as unseen."""


def without_feedback(observation: Observation) -> Observation:
    """Observation without the feedback of the previous throw, as in a cell without a camera over its bins."""
    return Observation(observation.features[:, :-FEEDBACK_SIZE], observation.kind)


def ideal_offsets(observation: Observation) -> tuple[Floats, Bools]:
    """Ideal offsets of the previous throws (N, 2) [m], along and left of them, and whether each is known (N,)."""
    features = SHIFT_TABLE.decode(observation.features)
    offset = np.stack([features["last_shift_along"], features["last_shift_across"]], axis=1)
    error = np.stack([features["last_along"], features["last_across"]], axis=1)
    return offset - error, (features["last_seen"] > 0.5) & ~begins_shift(observation)


def begins_shift(observation: Observation) -> Bools:
    """Whether each coming throw is the first of its shift of picks (N,)."""
    return observation.features[:, -1] <= 0.0


def has_feedback(core: Core) -> bool:
    """Whether observations include the previous landing and the time in the shift of picks."""
    table = getattr(getattr(core, "cell", None), "table", None)
    return table is not None and table.names[-1] == FEEDBACK[-1].name


def check(env: Env, user: str) -> None:
    """Check that the observations of an environment mark the beginning of a shift of picks.

    Raises:
        UsageError: observations do not, so no controller there can forget the previous shift.
    """
    if not has_feedback(core_of(env)):
        raise UsageError(f"{user} needs observations that mark the beginning of a shift; use PnTAdapt-v0")


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
        self._throw_counts = np.zeros(len(self._items), dtype=np.int64)
        self._shift, self._shifts = np.zeros(0, dtype=np.int64), list[Ints]()
        self._static.reset(seed)
        self.restore(self._shipped)

    def act(self, observation: Observation) -> Actions:
        """Offsets of the static policy minus the estimated effects of drift and kind, as actions (N, 2)."""
        if self._practising:
            return self._static.act(without_feedback(observation))
        is_first = begins_shift(observation)
        if self._last is None or len(is_first) != len(self._last[1]):
            self._last, is_first = None, np.full(len(is_first), True)
        if self._last is not None:
            last_throws, last_offset, kind = self._last
            ideal_offset, has_landing = ideal_offsets(observation)
            has_landing, is_unseen = has_landing & ~is_first, self._newcomers.is_unseen(kind)
            self._newcomers.learn(
                kind, last_throws, last_offset - ideal_offset - self._tracker.effect(last_throws), has_landing
            )
            self._tracker.learn(last_throws, last_offset - ideal_offset, has_landing & ~is_unseen)
        self._tracker.begin(is_first)  # last, so that a row with a new shift has no trace of the previous one
        plain = without_feedback(observation)
        offset, throws = self._static.predict(plain), plain.features.astype(np.float64)
        self._last = throws, offset, observation.kind
        effect = self._tracker.effect(throws) + self._newcomers.effect(observation.kind, throws)
        return to_action(offset - effect, self._correction)

    def learn(self, outcome: Outcome) -> None:
        """Train the static policy in practice. Outside practice all feedback is in the observations."""
        if self._practising:
            self._static.learn(replace(outcome, observation=without_feedback(outcome.observation)))
            self._throw_counts += np.bincount(outcome.observation.kind, minlength=len(self._throw_counts))
            begins, count = begins_shift(outcome.observation), len(outcome.observation.kind)
            if len(self._shift) < count:
                self._shift = np.arange(count)
            # The number of a row's new shift is as many further as there are rows.
            self._shift[:count] += len(self._shift) * begins
            self._shifts.append(self._shift[:count][is_instructive(outcome)])

    def begin_practice(self, throws: int) -> None:
        """Begin the practice of the static policy from its initial state."""
        self._practising, self._shifts = True, []
        self._static.reset(self._seed)
        self._static.begin_practice(throws)

    def end_practice(self) -> None:
        """End the practice, and let the tracker study the static policy's errors."""
        self._practising = False
        self._static.end_practice()
        throws, ideal_offset = self._static.data()
        offset = self._static.predict(Observation(throws.astype(np.float32), np.zeros(len(throws), dtype=np.int64)))
        self._tracker.study(
            throws, offset - ideal_offset, np.concatenate([*self._shifts, []]).astype(np.int64), self._seed
        )
        self._set_known_kinds(self._items[self._throw_counts >= MIN_THROWS])

    def state(self) -> State:
        """State of the static policy, names of the learned kinds, and state of the tracker."""
        static_arrays = {f"{STATIC}_{name}": value for name, value in self._static.state().items()}
        return {**static_arrays, "kinds": self._kinds, **self._tracker.state()}

    def restore(self, state: State) -> None:
        """Load a static policy and the state of the tracker."""
        static_arrays = {name: value for name, value in state.items() if name.startswith(f"{STATIC}_")}
        self._static.restore({name.removeprefix(f"{STATIC}_"): value for name, value in static_arrays.items()})
        self._tracker.restore(
            {name: value for name, value in state.items() if name not in static_arrays and name != "kinds"}
        )
        self._set_known_kinds(np.asarray(state.get("kinds", self._items[:0])))

    def _set_known_kinds(self, kinds: NDArray[np.str_]) -> None:
        """Mark the kinds of these names as known."""
        self._kinds = kinds
        is_known = np.isin(self._items, kinds) | isinstance(self._tracker, NoTracker)
        self._newcomers = UnseenKinds(is_known)
