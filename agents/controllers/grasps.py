"""Controllers that grasp and throw, composed of three parts: where the cup goes, how fast the throw is, its release.

A part of one controller fits every other: a place by a rule, a pace by the gauge, a residual that learned releases.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final, Literal, NamedTuple, Protocol, final, runtime_checkable

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.conveyor.cup.hold import Hold
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.observation import TABLE

from ..grasping.gauge import FRICTION, SAFETY, allowed_acceleration
from ..grasping.memory import turned
from ..ground.cli import UsageError
from ..ground.places import GRASPING
from . import state
from .protocol import Actions, Learner, Observation, Outcome, State
from .regression import Mlp, OnPolicyRegression

RESIDUAL: Final = slice(-2, None)
"""The numbers of an action that correct the release."""
FURTHER: Final = 3
"""Features of the residual beside the observation's vector: pace, and the cup's place along and across the throw."""
PLACE_UNIT: Final = 0.05
"""Length that the cup's place counts as 1 in the residual's features [m]."""
SCATTER: Final = 0.015
"""Standard deviation of the places around the rule's, per axis, in practice [m]."""
GIVE_UP: Final = -1.0
"""Third number of an action that lets an object ride."""


class Place(Protocol):
    """Chooses where the cups grasp."""

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Places of the cups for some rows of an observation, from the pictures' middles (K, 2) [m].

        NaN stands for an object that should ride on instead: after a try that failed, and on levels with `grasp.skip`
        before the first one.
        """
        ...


@runtime_checkable
class Mapped(Protocol):
    """Scores the places of pictures."""

    def maps(self, observation: Observation, rows: Ints) -> Floats:
        """Scores by which the places for some rows are chosen (K, 48, 48)."""
        ...


class Pace(Protocol):
    """Chooses how fast objects are thrown."""

    def shares(self, observation: Observation) -> Floats:
        """Largest accelerations of N throws (N,), as shares of the robot's, within the level's `grasp.pace`.

        Of objects that do not hang yet, the pace has no meaning.
        """
        ...


@final
class Centre:
    """The middle of the outline, as the camera sees it."""

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Zeros (K, 2) [m]."""
        return np.zeros((len(rows), 2))


@final
class FixedPace:
    """One pace for all throws.

    Args:
        core: the cells.
        share: the pace, as a share of the robot's acceleration.

    Raises:
        UsageError: the level does not allow this pace.
    """

    def __init__(self, core: GraspCore, share: float) -> None:
        slow, fast = core.config.grasp.pace
        if not slow <= share <= fast:
            raise UsageError(f"pace is {share:g}; it must be 'gauge' or from {slow:g} to {fast:g}")
        self._share = share

    def shares(self, observation: Observation) -> Floats:
        """The pace, N times (N,)."""
        return np.full(len(observation.kind), self._share)


@final
class GaugePace:
    """The fastest paces at which the grips hold their loads, by gauge and scales.

    Args:
        core: the cells.
        safety: factor of the measured load that the grip must hold.
    """

    def __init__(self, core: GraspCore, safety: float = SAFETY) -> None:
        self._range, self._safety = core.config.grasp.pace, safety
        self._fastest = core.config.robot.acceleration

    def shares(self, observation: Observation) -> Floats:
        """The paces (N,)."""
        values = TABLE.decode(observation.features)
        hold = Hold(
            force=np.exp(values["ln_seal"]),
            mass=np.exp(values["ln_mass"]),
            friction=np.full(len(observation.kind), FRICTION),
            depth=values["height"] / 2.0,
            offset=np.hypot(values["place_x"], values["place_y"]),
            radius=values["cup_radius"],
        )
        return np.clip(allowed_acceleration(hold, self._safety) / self._fastest, *self._range)


def shipped_release(core: GraspCore, name: str = "release") -> OnPolicyRegression:
    """The residual that ships: it corrects releases, and learned from the landings of 20,000 throws."""
    release = new_release(core, name)
    release.restore(state.read(GRASPING / "residual.npz")[1])
    return release


def new_release(core: GraspCore, name: str = "release") -> OnPolicyRegression:
    """A residual that corrects nothing before it has practised.

    Raises:
        UsageError: these are no cells that grasp.
    """
    if not isinstance(core, GraspCore):  # pyright: ignore[reportUnnecessaryIsInstance] - of a user's --env
        raise UsageError(f"controller {name!r} chooses where to grasp; use --env PnTGrasp-v0")
    correction = core.correction
    assert correction is not None  # of the mode `release_point`
    return OnPolicyRegression(name, correction, residual_width(), Mlp())


class GraspController(Learner):
    """Grasps at places, throws at paces, and corrects the releases; any part may be a shipped one or a user's own.

    Args:
        name: name of the controller.
        core: the cells.
        place: chooses where the cups grasp, and which objects ride on.
        pace: chooses how fast throws are: "gauge" for the pace at which the grip holds the measured load, one share of
            the robot's acceleration, or a part of its own.
        release: corrects releases; None for the residual that ships.
        safety: factor of the measured load, of paces by the gauge.
        tries: tries to grasp an object before it rides on; None for the level's.

    Raises:
        UsageError: these are no cells that grasp, or a value is not allowed there.
    """

    practice = 0
    """The residual that ships is trained."""

    def __init__(
        self,
        name: str,
        core: GraspCore,
        place: Place,
        *,
        pace: float | Literal["gauge"] | Pace = "gauge",
        release: OnPolicyRegression | None = None,
        safety: float = SAFETY,
        tries: int | None = None,
    ) -> None:
        self._residual = shipped_release(core, name) if release is None else release
        most = core.config.grasp.tries
        tries = most if tries is None else tries
        if not 1 <= tries <= most:
            raise UsageError(f"tries is {tries}; on this level it must be from 1 to {most}")
        self.name, self._config, self._place, self._tries = name, core.config, place, tries
        self._pace, self._practises = _pace_of(core, pace, safety), False
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
        choice = choose(observation, self._config, self._place, self._pace, self._tries)
        if self._practises:
            # Practice explores places nearby, and other paces.
            place = choice.place + SCATTER * self._random.standard_normal(choice.place.shape)
            pace = self._random.uniform(*self._config.grasp.pace, len(choice.pace))
            choice = Choice(place, choice.rides, choice.pace if isinstance(self._pace, FixedPace) else pace)
        return choice.action(observation, self._config, self._residual)

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


def _pace_of(core: GraspCore, pace: float | str | Pace, safety: float) -> Pace:
    """The pace that an argument stands for."""
    if isinstance(pace, (int, float)):
        return FixedPace(core, float(pace))
    if isinstance(pace, str):
        if pace != "gauge":
            raise UsageError(f"pace is {pace!r}; it must be 'gauge' or a share of the robot's acceleration")
        return GaugePace(core, safety)
    return pace


def pace_action(pace: Any, config: GraspConfig) -> Any:
    """Paces, as shares of the robot's acceleration, as numbers of an action."""
    slow, fast = config.grasp.pace
    return 2.0 * (pace - slow) / (fast - slow) - 1.0


class Choice(NamedTuple):
    """What parts choose for N objects."""

    place: Floats
    """Places of the cups from the pictures' middles (N, 2) [m]; 0 for objects that hang or ride on."""
    rides: Bools
    """Whether each object rides on instead of a further try (N,)."""
    pace: Floats
    """Paces of the throws, as shares of the robot's acceleration (N,)."""

    def action(self, observation: Observation, config: GraspConfig, release: OnPolicyRegression) -> Actions:
        """Actions (N, A) with the corrections of the releases."""
        rules = config.grasp
        action = np.zeros((len(self.pace), 6), dtype=np.float32)
        action[:, :2] = np.clip(self.place, -rules.reach, rules.reach) / rules.reach
        action[self.rides, 2] = GIVE_UP
        action[:, 3] = pace_action(self.pace, config)
        action[:, RESIDUAL] = release.act(observe(observation, action, config))
        return action if rules.stages > 1 else np.delete(action, 2, axis=1)


def choose(observation: Observation, config: GraspConfig, place: Place, pace: Pace, tries: int) -> Choice:
    """What a rule of places and one of paces choose, with a number of tries for each object.

    Raises:
        UsageError: the rule of places gives an object up before its first try, on a level without `grasp.skip`.
    """
    held, tried = phases(observation, config.grasp.tries)
    places, free = np.zeros((len(held), 2)), np.flatnonzero(~held)
    if free.size > 0:
        places[free] = place.places(observation, free)
    rides = np.isnan(places).any(axis=1)
    if not config.grasp.skip and (rides & (tried < 1)).any():
        raise UsageError(
            f"a rule of places gave up an object before its first try; level {config.name!r} has `grasp.skip: false`"
        )
    places[rides] = 0.0
    return Choice(places, rides | ~held & (tried >= tries), pace.shares(observation))


def observe(observation: Observation, action: Actions, config: GraspConfig) -> Observation:
    """The observation with pace and place of the throw, for the residual."""
    values = TABLE.decode(observation.features)
    x, y = values["place_x"], values["place_y"]
    if config.grasp.stages == 1:
        x, y = config.grasp.reach * action[:, :2].astype(np.float64).T
    further = [action[:, -3], *(part / PLACE_UNIT for part in turned(x, y, direction_of(values)))]
    features = np.concatenate([observation.features, np.stack(further, axis=1)], axis=1, dtype=np.float32)
    return replace(observation, features=features)


def direction_of(values: Mapping[str, Floats]) -> tuple[Floats, Floats]:
    """Horizontal unit vectors from picks to targets, x and y (N,) each, by decoded observations."""
    ahead = np.stack([values["target_x"] - values["pick_x"], values["target_y"] - values["pick_y"]])
    ex, ey = ahead / np.hypot(*ahead)
    return ex, ey


def phases(observation: Observation, tries: int) -> tuple[Bools, Any]:
    """Which objects hang under their cups (N,), and the numbers of tries that are over (N,)."""
    values = TABLE.decode(observation.features)
    return values["holds"] > 0.5, tries - np.rint(values["tries_left"])


def residual_width() -> int:
    """Number of features of the residual."""
    return len(TABLE) + FURTHER
