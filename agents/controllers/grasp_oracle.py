"""The oracle of grasps: it simulates each try and each throw before it, and takes the fastest throw that is sorted.

Without foresight of landings, it takes the fastest throw that the hold survives. The oracle knows the surface, the leak
under each lip, the error of the cup, the luck of the try, and where an object lands. It lacks the jitter of the release
alone. Its releases are corrected by the residual of all controllers that grasp, so what it sorts above another row is
worth of place, pace and of the objects that it gives up. What it sorts is reached and no proof: another search, or
better releases, could sort a little more.
"""

from __future__ import annotations

from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, put_rows, take
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.foresight import Foresight
from pnt_gym.cells.grasp.images import pixel_places

from ..grasping.scenes import Scenes
from ..ground.cli import UsageError
from .grasps import GIVE_UP, RESIDUAL, observe, pace_action, phases, shipped_release
from .protocol import Actions, Controller, Observation
from .regression import OnPolicyRegression

PACES: Final = 5
"""Number of paces that the oracle simulates, from the fastest to the slowest of the level."""
ENOUGH: Final = 1.1
"""Acceleration that a hold should survive, over that of the fastest pace, before a place nearer to the centre of mass
is preferred; or this share less than the best place's where none survives so much."""


class _Grasp(NamedTuple):
    """Simulated tries of K objects."""

    picks: Context
    holds: Bools
    vector: NDArray[np.float32]
    """What would be observed after the tries (K, D)."""


class _Throws(NamedTuple):
    """The fastest throws of K objects that are good: sorted, or at least not dropped."""

    found: Bools
    """Whether any of the simulated throws is good (K,)."""
    grasp: Ints
    """Index of the simulated try (K,)."""
    pace: Floats
    """As shares of the robot's acceleration (K,)."""
    residual: Floats
    """Corrections of the releases, as actions (K, 2)."""

    @classmethod
    def none(cls, count: int, pace: float) -> _Throws:
        """No throw yet; the pace stands for one that is not good."""
        return cls(np.full(count, False), np.zeros(count, int), np.full(count, pace), np.zeros((count, 2)))


@final
class GraspOracle(Controller):
    """Grasps where the fastest throw that is sorted begins, and lets an object ride of which it finds no such throw.

    Args:
        core: the cells.
        release: corrects releases; None for the residual that ships.
        lands: whether the oracle knows where objects land, beside how they are held.

    Raises:
        UsageError: the level has groups of objects, no surfaces, or one stage.
    """

    name = "oracle_grasp"

    def __init__(self, core: GraspCore, release: OnPolicyRegression | None = None, *, lands: bool = True) -> None:
        self._residual = shipped_release(core, self.name) if release is None else release
        self._lands = lands
        if core.config.grasp.objects > 1 or core.config.surface is None or core.config.grasp.stages == 1:
            raise UsageError(
                "controller 'oracle_grasp' knows single objects with surfaces, which it grasps first and throws next; "
                "choose another one here"
            )
        self._core, self._foresight = core, Foresight(core)
        slow, fast = core.config.grasp.pace
        self._paces = np.linspace(fast, slow, PACES)

    def act(self, observation: Observation) -> Actions:
        """Actions (N, 6): of the grasp where the cup is free, of the throw where the object hangs."""
        action = np.zeros((len(observation.kind), 6), dtype=np.float32)
        held, _ = phases(observation, self._core.config.grasp.tries)
        for act, rows in ((self._grasp, np.flatnonzero(~held)), (self._throw, np.flatnonzero(held))):
            if rows.size > 0:
                act(observation, rows, action)
        return action

    def maps(self, observation: Observation, rows: Ints) -> Floats:
        """Accelerations that the holds of the next tries survive (K, 48, 48) [m/s2]; 0 where none holds."""
        return np.maximum(self._strength(rows)[0], 0.0).reshape(-1, 48, 48)

    def _grasp(self, observation: Observation, rows: Ints, action: Actions) -> None:
        """Write the actions of free cups."""
        places = self._candidates(rows)
        tries = [_Grasp(*self._foresight.grasp(rows, place)) for place in places]
        best = self._fastest(observation, rows, tries)
        chosen = np.stack(places)[best.grasp, np.arange(len(rows))]
        action[rows, :2] = chosen / self._core.config.grasp.reach
        action[rows[~best.found], 2] = GIVE_UP

    def _throw(self, observation: Observation, rows: Ints, action: Actions) -> None:
        """Write the actions of cups under which objects hang."""
        hanging = _Grasp(take(self._core.context, rows), np.full(len(rows), True), observation.features[rows])
        best = self._fastest(observation, rows, [hanging])
        action[rows, 3] = pace_action(best.pace, self._core.config)
        action[rows, RESIDUAL] = best.residual
        action[rows[~best.found], 2] = GIVE_UP

    def _fastest(self, observation: Observation, rows: Ints, tries: list[_Grasp]) -> _Throws:
        """The fastest throws that are good, after one of some simulated tries."""
        best = _Throws.none(len(rows), self._paces[-1])
        for pace in self._paces:
            for number, grasp in enumerate(tries):
                left = np.flatnonzero(~best.found & grasp.holds)
                if left.size == 0:
                    continue
                residual = self._release(take(grasp, left), observation.kind[rows[left]], pace)
                paces = np.full(len(left), pace)
                outcome = self._foresight.throw(rows[left], take(grasp.picks, left), paces, residual)
                good = outcome.sorted if self._lands else ~outcome.dropped
                found = _Throws(good, np.full(len(left), number), paces, residual)
                best = put_rows(best, left[good], take(found, good), len(rows))
        return best

    def _release(self, grasp: _Grasp, kind: Ints, pace: float) -> Floats:
        """Corrections of releases (K, 2), as actions."""
        action = np.zeros((len(kind), 6), dtype=np.float32)
        action[:, 3] = pace_action(pace, self._core.config)
        seen = observe(Observation(grasp.vector, kind), action, self._core.config)
        return self._residual.act(seen).astype(np.float64)

    def _candidates(self, rows: Ints) -> list[Floats]:
        """Places to simulate (K, 2) [m]: the strongest hold, and one that is strong enough near the centre of mass."""
        strength, distance = self._strength(rows)
        fastest = ENOUGH * self._paces[0] * self._core.config.robot.acceleration
        enough = strength >= np.minimum(strength.max(axis=1) / ENOUGH, fastest)[:, None]
        near = np.where(enough, distance, np.inf).argmin(axis=1)
        return [_PLACES[near], _PLACES[strength.argmax(axis=1)]]

    def _strength(self, rows: Ints) -> tuple[Floats, Floats]:
        """Accelerations that holds at all pixels survive in any direction (K, P) [m/s2], and distances of the cups.

        The accelerations are those of the next tries, the luck included: -inf where a try does not hold, or the cup
        does not reach. The distances (K, P) [m] are from the centres of mass.
        """
        core = self._core
        scenes = Scenes.of_picks(core.config, take(core.picks_when_tried(rows), rows))
        strength, distance = scenes.strength(_PLACES, core.attempts.tries[rows])
        strength[:, np.abs(_PLACES).max(axis=1) > core.config.grasp.reach] = -np.inf
        return strength, distance


_PLACES: Final = pixel_places().reshape(-1, 2)
