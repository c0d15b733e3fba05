"""Controllers of a cell that drifts: a policy that knows the objects, and what the shift does on top of it.

They see what every agent sees of `PnTAdapt-v0`: the observation tells of the throw before, and 0 as the share of the
shift that is gone says that another one begins. Nothing reaches them by any other way.
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
"""Entries at the end of an observation that tell of the throw before."""
WIDTH: Final = 128
STEPS: Final = 6000
STATIC: Final = "static"
"""The policy under all of them; the names of its arrays begin so."""
IN_CONTEXT: Final = "in_context"
"""Its file also holds the policy under all but `STATIC`, which has learned without drift."""
READY: Final = (STATIC, "ema", "kalman", "recursive_ridge", IN_CONTEXT)
"""Those that need no practice: what they have learned ships."""
FEW: Final = 20
"""A kind of which there were fewer throws in practice is not known."""


def without_feedback(observation: Observation) -> Observation:
    """What an agent of a cell without a camera over its bins would see."""
    return Observation(observation.features[:, :-FEEDBACK_SIZE], observation.kind)


def told(observation: Observation) -> tuple[Floats, Bools]:
    """What would have been right for the throws before (N, 2) [m], along and left of them, and of which it is known."""
    seen = SHIFT_TABLE.decode(observation.features)
    asked = np.stack([seen["last_shift_along"], seen["last_shift_across"]], axis=1)
    error = np.stack([seen["last_along"], seen["last_across"]], axis=1)
    return asked - error, (seen["last_seen"] > 0.5) & ~begins(observation)


def begins(observation: Observation) -> Bools:
    """Which of the coming throws are the first of their shift (N,)."""
    return observation.features[:, -1] <= 0.0


def is_told(core: Core) -> bool:
    """Whether observations include the previous landing and the time in the shift."""
    table = getattr(getattr(core, "cell", None), "table", None)
    return table is not None and table.names[-1] == FEEDBACK[-1].name


def check_begins(env: Env, who: str) -> None:
    """Make sure that the observations of an environment tell where a shift begins.

    Raises:
        UsageError: they do not, so nothing there can forget the shift before.
    """
    if not is_told(core_of(env)):
        raise UsageError(f"{who} goes by where a shift begins, which observations here do not tell; use PnTAdapt-v0")


@final
class Adaptive(Learner):
    """An MLP, corrected by a tracker of the drift; without a tracker the MLP alone, which does not adapt.

    Practice trains the MLP on the features of the object, under the drift of the level. With a tracker, kinds that were
    not practised have a separate correction each, and the tracker learns from known kinds alone.

    Args:
        name: name of the controller.
        correction: what an action means.
        features: entries of an observation D.
        items: names of the kinds.
        tracker: of the shift.
        shipped: what the static policy knows without practice.
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
        """Back to what ships, and forget the shift."""
        self._seed, self._practising = seed, False
        self._last: tuple[Floats, Floats, Ints] | None = None
        self._thrown = np.zeros(len(self._items), dtype=np.int64)
        self._static.reset(seed)
        self.restore(self._shipped)

    def act(self, observation: Observation) -> Actions:
        """The static shift less what the day and the kind do to it (N, 2)."""
        if self._practising:
            return self._static.act(without_feedback(observation))
        self._take_in(observation)
        plain = without_feedback(observation)
        own, throws = self._static.predict(plain), plain.features.astype(np.float64)
        self._last = throws, own, observation.kind
        off = self._tracker.effect(throws) + self._newcomers.effect(observation.kind, throws)
        return to_action(own - off, self._correction)

    def learn(self, outcome: Outcome) -> None:
        """In practice: the static policy does. What a shift teaches is in the observations."""
        if self._practising:
            self._static.learn(replace(outcome, observation=without_feedback(outcome.observation)))
            self._thrown += np.bincount(outcome.observation.kind, minlength=len(self._thrown))

    def begin_practice(self, throws: int) -> None:
        """The static policy practises, from nothing."""
        self._practising = True
        self._static.reset(self._seed)
        self._static.begin_practice(throws)

    def end_practice(self) -> None:
        """It has; what it leaves of the throws is for the tracker to study."""
        self._practising = False
        self._static.end_practice()
        throws, right = self._static.data()
        own = self._static.predict(Observation(throws.astype(np.float32), np.zeros(len(throws), dtype=np.int64)))
        self._tracker.study(throws, own - right, self._seed)
        self._learned(self._items[self._thrown >= FEW])

    def state(self) -> State:
        """The static policy's, the names of the kinds that it has learned, and the tracker's."""
        own = {f"{STATIC}_{name}": value for name, value in self._static.state().items()}
        return {**own, "kinds": self._kinds, **self._tracker.state()}

    def restore(self, state: State) -> None:
        """Take over a static policy, and what goes with the tracker."""
        own = {name: value for name, value in state.items() if name.startswith(f"{STATIC}_")}
        self._static.restore({name.removeprefix(f"{STATIC}_"): value for name, value in own.items()})
        self._tracker.restore({name: value for name, value in state.items() if name not in own and name != "kinds"})
        self._learned(np.asarray(state.get("kinds", self._items[:0])))

    def _learned(self, kinds: NDArray[np.str_]) -> None:
        """The kinds of these names are known."""
        self._kinds = kinds
        known = np.isin(self._items, kinds) | isinstance(self._tracker, Nothing)
        self._newcomers = Newcomers(known)

    def _take_in(self, observation: Observation) -> None:
        """What is told of the throws before."""
        fresh = begins(observation)
        if self._last is None or len(fresh) != len(self._last[1]):
            self._last, fresh = None, np.full(len(fresh), True)
        if self._last is not None:
            throws, own, kind = self._last
            right, known = told(observation)
            known, new = known & ~fresh, self._newcomers.new(kind)
            self._newcomers.learn(kind, throws, own - right - self._tracker.effect(throws), known)
            self._tracker.learn(throws, own - right, known & ~new)
        self._tracker.begin(fresh)  # last, so that a row that has just begun is as one that never threw
