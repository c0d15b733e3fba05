"""The controller that learns from rewards alone where to grasp and how fast to throw.

The first network values places of the cup in a picture, the second paces of a throw by the gauge. A return is the
reward of a pick, less the price of its time: the reward that the last picks have earned in a second. So the networks
learn to earn the most in a minute, and not in a pick. A grasp that holds is worth what the second network expects of
its best pace (fitted Q iteration; Ernst et al. 2005), because the pace of a try is often one that explores.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.images import pixel_places
from pnt_gym.cells.grasp.observation import TABLE

from ..grasping.features import NAMES, SIGHTS, PlaceFeatures, best_places, blur_maps, place_features
from ..grasping.network import PlaceNetwork
from ..ground.cli import UsageError, check_libraries
from ..ground.places import GRASPING, at
from .grasps import choose, shipped_release
from .protocol import Actions, Learner, Observation, Outcome, State
from .regression import OnPolicyRegression
from .state import load_state

PACES: Final = 9
"""Number of paces between which a throw chooses."""
LOWEST, HIGHEST = -1.2, 0.8
"""Returns that the networks' outputs 0 and 1 mean: beside those of all picks with the level's own rewards."""
TEMPERATURE: Final = 0.02
"""Of practice: a choice is made with a probability proportional to exp(value / temperature), values from 0 to 1."""
EXPLORES: Final = 0.15
"""Share of the choices in practice that are random, after the first fit."""
ROUNDS: Final = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
"""Shares of the practice after which the networks are fitted; before the first, choices are random."""
QUICK_STEPS, STEPS = 500, 3000
"""Gradient steps of a fit in practice, and of the last one."""
RECENT: Final = 0.2
"""Share of the last picks from which the price of time is taken."""
NEAR: Final = 0.02
"""Length of distances from a place that failed, as a feature of a further try [m]."""


class Picks(NamedTuple):
    """N picks that are over, as they teach."""

    reward: Floats
    seconds: Floats
    held: Bools
    retried: Bools
    """Whether a first try failed, and another followed (N,)."""
    first: Floats
    """Features of the place of the first try (N, D)."""
    second: Floats
    """Features of the place of the second try (N, D); of no meaning without one."""
    throw: Floats
    """Features of the throw with its pace (N, E); of no meaning without one."""


@final
class GraspValues:
    """Values of places and of paces.

    Args:
        config: the cell.
    """

    libraries: tuple[str, ...] = ("torch",)
    """Optional libraries by which it fits."""

    def __init__(self, config: GraspConfig) -> None:
        self._config = config
        self._slow, self._fast = config.grasp.pace
        self._practises = False
        self.reseed(0)
        self._clear()

    def reseed(self, seed: int) -> None:
        """Reseed the random numbers of practice and fits."""
        self._random = np.random.default_rng([seed, 3])

    def _clear(self) -> None:
        """Forget all picks and both fits."""
        local = [*SIGHTS["local"], len(NAMES), len(NAMES) + 1]
        self._places, self._paces = PlaceNetwork(local, len(NAMES) + 2), PlaceNetwork(None, len(TABLE) + 1)
        self._picks: list[Picks] = []
        self._rides = 0.0
        self._due: list[int] = []

    # Choices

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Places of the cups for some rows (K, 2) [m]; NaN for an object that should ride on after a failed try."""
        places, rides = self._choices(observation, rows)
        return np.where(rides[:, None], np.nan, places)

    def _choices(self, observation: Observation, rows: Ints) -> tuple[Floats, Bools]:
        """Places of the cups for some rows (K, 2) [m], and which objects rather ride on (K,)."""
        assert observation.image is not None  # of this environment
        tries = _Tries.of(take(observation, rows), self._config)
        radius = TABLE.decode(observation.features)["cup_radius"][rows]
        features = place_features(observation.image[rows], radius, of_all=self._config.grasp.objects > 1)
        if not self._places.is_fitted:
            chosen = features.best(self._random.gumbel(size=len(features.picture)))
            return chosen, tries.failed & (self._random.random(len(rows)) < 0.5)
        worth = self._places.predict(tries.inputs(features, features.picture, features.places()))
        maps = blur_maps(features.maps(worth, _scaled(self._rides)))
        expected = maps[features.picture, features.pixel[:, 0], features.pixel[:, 1]]
        most = np.full(len(rows), -np.inf)
        np.maximum.at(most, features.picture, expected)
        rides = tries.failed & (most < _scaled(self._rides))
        if not self._practises:
            on_object = features.maps(expected, -1.0)
            return best_places(on_object), rides
        greedy = self._random.random(len(rows)) >= EXPLORES
        score = self._random.gumbel(size=len(expected)) + greedy[features.picture] * expected / TEMPERATURE
        return features.best(score), np.where(greedy, rides, tries.failed & (self._random.random(len(rows)) < 0.5))

    def shares(self, observation: Observation) -> Floats:
        """Paces of N objects (N,), as shares of the robot's acceleration."""
        count = len(observation.kind)
        if not self._paces.is_fitted:
            middle = np.full(count, (self._slow + self._fast) / 2.0)
            return self._random.uniform(self._slow, self._fast, count) if self._practises else middle
        score = self._pace_values(observation.features.astype(np.float64))
        if self._practises:
            greedy = self._random.random(count) >= EXPLORES
            score = self._random.gumbel(size=score.shape) + greedy[:, None] * score / TEMPERATURE
        return self._grid()[score.argmax(axis=1)]

    def _grid(self) -> Floats:
        """The paces between which a throw chooses (PACES,)."""
        return np.linspace(self._slow, self._fast, PACES)

    def _pace_values(self, vectors: Floats) -> Floats:
        """Values of the paces of the grid (N, PACES), by vectors (N, 32)."""
        grid = np.tile(self._grid(), len(vectors))
        inputs = np.column_stack([np.repeat(vectors, PACES, axis=0), grid])
        return self._paces.predict(inputs).reshape(-1, PACES)

    # Learning

    def begin_practice(self, throws: int) -> None:
        """Begin to explore, without any earlier knowledge."""
        self._clear()
        self._practises, self._due = True, [round(share * throws) for share in ROUNDS]

    def end_practice(self) -> None:
        """Fit both networks to all picks, and stop exploring."""
        self._practises = False
        self._fit(STEPS)

    def learn(self, outcome: Outcome) -> None:
        """Learn from picks that are over."""
        observation, config = outcome.observation, self._config
        assert observation.image is not None  # of this environment
        tries = _Tries.of(observation, config)
        values = TABLE.decode(observation.features)
        features = place_features(observation.image, values["cup_radius"])
        asked = config.grasp.reach * outcome.action[:, :2].astype(np.float64)
        held, rides = values["holds"] > 0.5, outcome.action[:, 2] < -0.5
        last = np.where(held[:, None], tries.hung, asked)
        first = np.where(tries.failed[:, None], tries.place, last)
        rows = np.arange(len(held))
        pace = self._slow + (self._fast - self._slow) * (outcome.action[:, 3].astype(np.float64) + 1.0) / 2.0
        untried = tries._replace(failed=np.zeros_like(tries.failed))
        self._picks.append(
            Picks(
                outcome.reward,
                outcome.cycle_time,
                held,
                tries.failed & ~(~held & rides),
                untried.at(features, rows, first),
                tries.at(features, rows, last),
                np.column_stack([observation.features.astype(np.float64), pace]),
            )
        )
        if self._due and sum(len(picks.reward) for picks in self._picks) >= self._due[0]:
            self._due = self._due[1:]
            self._fit(QUICK_STEPS)

    def _fit(self, steps: int) -> None:
        """Fit both networks to the returns of all picks."""
        picks = Picks(*map(np.concatenate, zip(*self._picks, strict=True)))
        recent = slice(-max(int(RECENT * len(picks.reward)), 1), None)
        price = picks.reward[recent].sum() / picks.seconds[recent].sum()
        returns, held = picks.reward - price * picks.seconds, picks.held
        seed = int(self._random.integers(2**31))
        self._paces.fit(picks.throw[held], _scaled(returns[held]), seed, steps)
        values = _scaled(returns)
        values[held] = self._pace_values(picks.throw[held, :-1]).max(axis=1)
        over = ~held & ~picks.retried
        self._rides = float(returns[over].mean()) if over.any() else float(returns.min())
        after = np.maximum(values, _scaled(self._rides))  # an object may ride on where another try is worth less
        tried_again = np.flatnonzero(picks.retried)
        inputs = np.concatenate([picks.first, picks.second[tried_again]])
        targets = np.concatenate([np.where(picks.retried, after, values), values[tried_again]])
        self._places.fit(inputs, targets, seed + 1, steps)

    def state(self) -> State:
        """Arrays of both networks, and the return of an object that rides on."""
        if not self._places.is_fitted:
            return {}
        parts = {"place": self._places, "pace": self._paces}
        arrays = {f"{part} {name}": a for part, network in parts.items() for name, a in network.state().items()}
        return {**arrays, "rides": np.array(self._rides)}

    def restore(self, state: State) -> None:
        """Load both networks."""
        if not state:
            return
        for part, network in (("place ", self._places), ("pace ", self._paces)):
            network.restore({name.removeprefix(part): a for name, a in state.items() if name.startswith(part)})
        self._rides = float(state["rides"])


class _Tries(NamedTuple):
    """Earlier tries of N objects, from the observation."""

    failed: Bools
    """Whether a try has failed (N,)."""
    place: Floats
    """Place of the failed try (N, 2) [m]."""
    hung: Floats
    """Place of the cup that holds the object (N, 2) [m]; 0 for others."""

    @classmethod
    def of(cls, observation: Observation, config: GraspConfig) -> _Tries:
        """Tries by the vectors of an observation."""
        values = TABLE.decode(observation.features)
        place = np.column_stack([values["failed_x"], values["failed_y"]])
        hung = np.column_stack([values["place_x"], values["place_y"]])
        return cls((place != 0.0).any(axis=1), place, hung)

    def at(self, features: PlaceFeatures, rows: Ints, places: Floats) -> Floats:
        """Inputs of the network of places (N, D) at places (N, 2) [m] in their pictures; 0 beside the object."""
        line = pixel_places()
        column = np.abs(places[:, :1] - line[0, :, 0]).argmin(axis=1)
        row = np.abs(places[:, 1:] - line[:, 0, 1]).argmin(axis=1)
        index = np.full((features.pictures, *line.shape[:2]), -1)
        index[features.picture, features.pixel[:, 0], features.pixel[:, 1]] = np.arange(len(features.picture))
        chosen = index[rows, row, column]
        values = np.where((chosen < 0)[:, None], 0.0, features.values[chosen])
        return np.column_stack([values, self._further(rows, places)])

    def inputs(self, features: PlaceFeatures, rows: Ints, places: Floats) -> Floats:
        """Inputs of the network of places (T, D) at all places of pictures, in the order of the features."""
        return np.column_stack([features.values, self._further(rows, places)])

    def _further(self, rows: Ints, places: Floats) -> Floats:
        """Whether a try has failed, and how near to the place (T, 2)."""
        distance = np.hypot(*(places - self.place[rows]).T)
        failed = self.failed[rows]
        return np.column_stack([failed.astype(np.float64), failed * np.exp(-0.5 * (distance / NEAR) ** 2)])


def _scaled(returns: Any) -> Any:
    """Returns as outputs of the networks, 0 to 1."""
    return np.clip((returns - LOWEST) / (HIGHEST - LOWEST), 0.0, 1.0)


def fitted_values(core: GraspCore, file: str | Path | None = None) -> GraspValues:
    """The values of `fitted_q` as parts of another controller: its places, and its paces.

    Args:
        core: the cells.
        file: values that `--save` has written; None for those that ship.
    """
    return FittedQ(core, file=FILE if file is None else file).values


FILE: Final = GRASPING / "fitted_q.npz"
"""Values that ship."""


@final
class FittedQ(Learner):
    """Grasps and throws by two networks of values, which learn from rewards alone.

    The release is corrected by the residual of the other controllers that grasp, which learned from landings; practice
    leaves the residual as it is.

    Args:
        core: the cells.
        release: corrects releases; None for the residual that ships.
        file: values that `--save` has written; by default those that ship.

    Raises:
        UsageError: the level has one stage, or there is no such file.
    """

    name = "fitted_q"
    practice = 0
    """The values that ship are trained."""

    def __init__(self, core: GraspCore, release: OnPolicyRegression | None = None, file: str | Path = FILE) -> None:
        self._release = shipped_release(core, self.name) if release is None else release
        if core.config.grasp.stages == 1:
            raise UsageError("controller 'fitted_q' grasps first and throws next; this level has `stages: 1`")
        self._config, self.values = core.config, GraspValues(core.config)
        """The values of places and paces, which are parts of other controllers too."""
        load_state(self, at(file))

    def reset(self, seed: int) -> None:
        """Reseed the random numbers; what was learned stays."""
        self.values.reseed(seed)

    def begin_practice(self, throws: int) -> None:
        """Forget the values, and explore places and paces."""
        check_libraries(*self.values.libraries)
        if self._config.grasp.objects > 1:
            raise UsageError("controller 'fitted_q' practises on single objects; this level has groups of objects")
        self.values.begin_practice(throws)

    def end_practice(self) -> None:
        """Fit the values to all picks, and stop exploring."""
        self.values.end_practice()

    def act(self, observation: Observation) -> Actions:
        """Actions (N, 6): of the grasp where the cup is free, of the throw where the object hangs."""
        choice = choose(observation, self._config, self.values, self.values, self._config.grasp.tries)
        return choice.action(observation, self._config, self._release)

    def learn(self, outcome: Outcome) -> None:
        """Learn from picks that are over."""
        self.values.learn(outcome)

    def state(self) -> State:
        """State of the values."""
        return self.values.state()

    def restore(self, state: State) -> None:
        """Load the state of the values."""
        self.values.restore(state)
