"""Controllers that grasp and throw: where the cup goes, how fast the throw is, and how its release is corrected."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final, Literal, Protocol, final, runtime_checkable

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.grip import Hold
from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.observation import TABLE

from ..ground.cli import UsageError
from .protocol import Actions, Learner, Observation, Outcome, State
from .regression import OnPolicyRegression

RESIDUAL: Final = slice(-2, None)
"""The numbers of an action that correct the release."""
FURTHER: Final = 3
"""Features of the residual beside the observation's vector: pace, and the cup's place along and across the throw."""
PLACE_UNIT: Final = 0.05
"""Length that the cup's place counts as 1 in the residual's features [m]."""
SCATTER: Final = 0.015
"""Standard deviation of the places around the rule's, per axis, in practice [m]."""
SAFETY: Final = 1.3
"""Factor of the measured load that a grip must hold at a pace by the gauge (Hold.acceleration)."""
GIVE_UP: Final = -1.0
"""Third number of an action that lets an object ride."""


class Place(Protocol):
    """Chooses where the cups grasp."""

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Places of the cups for some rows of an observation, from the pictures' middles (K, 2) [m]."""
        ...


@runtime_checkable
class Mapped(Protocol):
    """Scores the places of pictures."""

    def maps(self, observation: Observation, rows: Ints) -> Floats:
        """Scores by which the places for some rows are chosen (K, 48, 48)."""
        ...


@final
class Centre:
    """The middle of the outline, as the camera sees it."""

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Zeros (K, 2) [m]."""
        return np.zeros((len(rows), 2))


class Pace:
    """Paces of throws as shares of the robot's acceleration, within the level's range.

    Args:
        config: the cell.
        share: one pace for all throws; None for the pace that the gauge allows.
        safety: factor of the measured load that the grip must hold, of paces by the gauge.
    """

    def __init__(self, config: GraspConfig, share: float | None, safety: float) -> None:
        slow, fast = config.grasp.pace
        if share is not None and not slow <= share <= fast:
            raise UsageError(f"pace is {share:g}; it must be 'gauge' or from {slow:g} to {fast:g}")
        self.range = slow, fast
        self.fixed, self._safety, self._fastest = share, safety, config.robot.acceleration
        self._friction = item_arrays(config.item_list()).cup_friction

    def shares(self, observation: Observation) -> Floats:
        """Paces of N objects (N,); of objects that do not hang yet, the pace has no meaning."""
        if self.fixed is not None:
            return np.full(len(observation.kind), self.fixed)
        values = TABLE.decode(observation.features)
        hold = Hold(
            force=np.exp(values["ln_seal"]),
            mass=np.exp(values["ln_mass"]),
            friction=self._friction[observation.kind],
            depth=values["height"] / 2.0,
            offset=np.hypot(values["place_x"], values["place_y"]),
            radius=values["cup_radius"],
        )
        return np.clip(hold.acceleration(self._safety) / self._fastest, *self.range)


@final
class GraspController(Learner):
    """Grasps by a rule, throws at a pace, and corrects the release by regression on the landings of its practice.

    Args:
        name: name of the controller.
        config: the cell.
        correction: meaning of the action's residual.
        place: chooses where the cups grasp.
        residual: corrects releases.
        pace: "gauge" for the pace at which the grip holds the measured load, or one share of the robot's acceleration.
        safety: factor of the measured load, of paces by the gauge.
        tries: tries to grasp an object before it rides on; None for the level's.
    """

    practice = 0
    """The residual that ships is trained."""

    def __init__(
        self,
        name: str,
        config: GraspConfig,
        correction: Correction,
        place: Place,
        residual: OnPolicyRegression,
        *,
        pace: float | Literal["gauge"] = "gauge",
        safety: float = SAFETY,
        tries: int | None = None,
    ) -> None:
        if isinstance(pace, str) and pace != "gauge":
            raise UsageError(f"pace is {pace!r}; it must be 'gauge' or a share of the robot's acceleration")
        most = config.grasp.tries
        tries = most if tries is None else tries
        if not 1 <= tries <= most:
            raise UsageError(f"tries is {tries}; on this level it must be from 1 to {most}")
        self.name = name
        self._config, self._place, self._residual = config, place, residual
        self._pace = Pace(config, None if pace == "gauge" else float(pace), safety)
        self._tries, self._correction, self._practises = tries, correction, False
        self._random = np.random.default_rng(0)

    def reset(self, seed: int) -> None:
        """Reseed the random numbers; what was learned stays."""
        self._random = np.random.default_rng([seed, 1])

    def begin_practice(self, throws: int) -> None:
        """Vary places, and paces but for a fixed one, and explore residuals."""
        self._practises = True
        self._residual.begin_practice(throws)

    def end_practice(self) -> None:
        """Stop varying, and fit the residual to all throws."""
        self._practises = False
        self._residual.end_practice()

    def act(self, observation: Observation) -> Actions:
        """Actions (N, A): of the grasp where the cup is free, of the throw where the object hangs."""
        count, rules = len(observation.kind), self._config.grasp
        action = np.zeros((count, 6), dtype=np.float32)
        held, tried = phases(observation, rules.tries)
        place, pace, free = np.zeros((count, 2)), self._pace.shares(observation), np.flatnonzero(~held)
        if free.size > 0:
            place[free] = self._place.places(observation, free)
        if self._practises:
            place = place + SCATTER * self._random.standard_normal((count, 2))
            varied = self._random.uniform(*self._pace.range, count)
            pace = varied if self._pace.fixed is None else pace
        place = np.clip(place, -rules.reach, rules.reach)
        action[:, :2] = place / rules.reach
        action[~held & (tried >= self._tries), 2] = GIVE_UP
        slow, fast = self._pace.range
        action[:, 3] = 2.0 * (pace - slow) / (fast - slow) - 1.0
        action[:, RESIDUAL] = self._residual.act(observe(observation, action, self._config))
        return action if rules.stages > 1 else np.delete(action, 2, axis=1)

    def maps(self, observation: Observation, rows: Ints) -> Floats | None:
        """Scores by which the cups' places for some rows are chosen (K, 48, 48); None for a rule without scores."""
        return self._place.maps(observation, rows) if isinstance(self._place, Mapped) else None

    def learn(self, outcome: Outcome) -> None:
        """Learn from the throws of the last `act`."""
        seen = observe(outcome.observation, outcome.action, self._config)
        self._residual.learn(replace(outcome, observation=seen, action=outcome.action[:, RESIDUAL]))

    def state(self) -> State:
        """State of the residual."""
        return self._residual.state()

    def restore(self, state: State) -> None:
        """Load the state of the residual."""
        self._residual.restore(state)


def observe(observation: Observation, action: Actions, config: GraspConfig) -> Observation:
    """The observation with pace and place of the throw, for the residual."""
    values = TABLE.decode(observation.features)
    x, y = values["place_x"], values["place_y"]
    if config.grasp.stages == 1:
        x, y = config.grasp.reach * action[:, :2].astype(np.float64).T
    ahead = np.stack([values["target_x"] - values["pick_x"], values["target_y"] - values["pick_y"]])
    ex, ey = ahead / np.hypot(*ahead)
    further = [action[:, -3], (x * ex + y * ey) / PLACE_UNIT, (y * ex - x * ey) / PLACE_UNIT]
    features = np.concatenate([observation.features, np.stack(further, axis=1)], axis=1, dtype=np.float32)
    return replace(observation, features=features)


def phases(observation: Observation, tries: int) -> tuple[Bools, Any]:
    """Which objects hang under their cups (N,), and the numbers of tries that are over (N,)."""
    values = TABLE.decode(observation.features)
    return values["holds"] > 0.5, tries - np.rint(values["tries_left"])


def residual_width() -> int:
    """Number of features of the residual."""
    return len(TABLE) + FURTHER
