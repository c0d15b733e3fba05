"""The controller of shifts of grasps that learned from many simulated shifts how to use its memory.

The memory is that of the hand-written rule: what the cup's error may be, and means over earlier objects of a look. A
network foretells the gauge with attention to the earlier tries. Three regressions have the numbers of the memory among
their features: the value of a try, the value of paces, and the correction of the release. The cup goes to one of a few
places that hold most probably. A value is the chance that the object is sorted, less the price of the time until the
next one.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.images import pixel_places
from pnt_gym.cells.grasp.observation import LAST, TABLE

from ..grasping.attention import TryNetwork
from ..grasping.foretelling import networks_foretell
from ..grasping.memory import MEMORIES, MakesMemory, NoMemory, ShiftMemory
from ..grasping.network import PlaceNetwork
from ..ground.places import GRASPING, at
from .grasps import GIVE_UP, PLACE_UNIT, RESIDUAL, observe, pace_action, phases, residual_width, shipped_release
from .protocol import Actions, Controller, Observation, State, to_action
from .regression import Mlp, OnPolicyRegression
from .state import load_state
from .watching import Watcher

FILE: Final = GRASPING.parent / "PnTGrasp-v0-grasp_shift" / "shift_values.npz"
"""Networks that ship, of simulated shifts with kinds that are drawn with other seeds than the level's."""
WIDTH: Final = 64
"""Width of the layers of the networks that value tries and paces."""
RELEASE_STEPS, RELEASE_DECAY = 8000, 0.01
"""Gradient steps and weight decay of the network that corrects the release."""
PACES: Final = 7
LOWEST, HIGHEST = -1.0, 1.0
"""Values that the networks' outputs 0 and 1 mean."""
PULLS: Final = (0.0, 5.0, 15.0, 40.0)
"""Pulls towards the middle of what a picture shows, of the places between which a try chooses [1/m]."""
TEMPERATURE: Final = 0.03
"""Of practice: a choice is made with a probability proportional to exp(value / temperature)."""
EXPLORES: Final = 0.15
"""Share of the choices in practice that are random."""
SCATTER: Final = (0.03, 0.01)
"""Standard deviations of releases around the expected correction in practice, before the first fit and after it [m]."""
_TRY_INPUTS: Final = 3 + len(TABLE) + MEMORIES
_PACE: Final = len(TABLE)
"""Column of a throw's pace among its features."""
_THROW_INPUTS: Final = residual_width() + MEMORIES + 2


class Sample(NamedTuple):
    """What a pick that is over has taught."""

    tried: Floats
    """Features of the places of its tries (T, D)."""
    throw: Floats
    """Features of its throw with its pace (E,); NaN without one."""
    offset: Floats
    """Offset of the release that would have met the target (2,) [m]; NaN where no landing was seen."""
    is_sorted: float
    seconds: float


@final
class ShiftValues(Controller):
    """Grasps, throws and gives up by values that it learned, with a memory of its shift among their features.

    Args:
        core: the cells.
        release: the usual correction, against which landings are remembered; None for the residual that ships.
        file: networks that practice has written; by default those that ship. None: networks that know nothing yet.
        memory: makes the memory of the shifts, by which the networks have learned.

    Raises:
        UsageError: the level has no shifts, or there is no such file.
    """

    name = "shift_values"

    def __init__(
        self,
        core: GraspCore,
        release: OnPolicyRegression | None = None,
        file: str | Path | None = FILE,
        memory: MakesMemory = ShiftMemory,
    ) -> None:
        usual = shipped_release(core, self.name) if release is None else release
        self._core, self._config, self._foretold = core, core.config, networks_foretell()
        self._attention = TryNetwork()
        self._watcher = Watcher(self.name, core, self._foretold, usual, self._attention, memory)
        self._tries, self._paces = (PlaceNetwork(None, size, WIDTH) for size in (_TRY_INPUTS, _THROW_INPUTS))
        self._releases, self._knows_releases = Mlp(steps=RELEASE_STEPS, weight_decay=RELEASE_DECAY), False
        self._rides, self._fails = 0.0, -1.0
        self._practice: Practising | None = None
        if file is not None:
            load_state(self, at(file))

    def reset(self, seed: int) -> None:
        """Forget all shifts; what was learned of shifts stays."""
        self._watcher.begin(0)

    def act(self, observation: Observation) -> Actions:
        """Actions (N, 6): of the grasp where the cup is free, of the throw where the object hangs."""
        self._watcher.notice(observation)
        known = self._watcher.known()
        action = np.zeros((len(observation.kind), 6), dtype=np.float32)
        held, tried = phases(observation, self._config.grasp.tries)
        free, hangs = np.flatnonzero(~held), np.flatnonzero(held)
        if free.size > 0:
            self._grasp(observation, free, tried, known, action)
        reference = self._watcher.reference(observation, action)
        if hangs.size > 0:
            self._throw(observation, hangs, known, reference, action)
        return action

    def _grasp(self, observation: Observation, rows: Ints, tried: Floats, known: Floats, action: Actions) -> None:
        """Write the actions of free cups."""
        features = np.column_stack([tried, observation.features.astype(np.float64), known])[rows]
        places, inputs = self._candidates(rows, features)
        log, count = self._practice, len(rows)
        score = self._tries.predict(inputs.reshape(count * len(PULLS), -1)) if self._tries.is_fitted else None
        value = inputs[:, :, 0] if score is None else score.reshape(count, -1)
        chosen = value.argmax(axis=1)
        rides = scaled(np.where(tried[rows] > 0, self._fails, self._rides))
        gives_up = (value.max(axis=1) < rides) & (score is not None)
        if log is not None:
            chosen, gives_up = log.explore(value, gives_up)
            for k in np.flatnonzero(~gives_up):
                log.tried[rows[k]].append(inputs[k, chosen[k]])
        picked = places[np.arange(count), chosen]
        action[rows, :2] = np.clip(picked / self._config.grasp.reach, -1.0, 1.0)
        action[rows[gives_up], 2] = GIVE_UP

    def _candidates(self, rows: Ints, features: Floats) -> tuple[Floats, Floats]:
        """Places between which a try chooses (K, C, 2) [m], and their features (K, C, D).

        Each is the place that holds most probably, with another pull towards the middle of what the picture shows.
        """
        watcher, memory = self._watcher, self._watcher.memory
        foretold = watcher.maps(rows)
        shown = foretold > 0.0
        weights = memory.weights(rows)
        holds, pixels = watcher.holds(foretold, weights), pixel_places()
        error = np.einsum("kij,ijc->kc", weights, memory.offsets)
        middle = np.einsum("kab,abc->kc", shown, pixels) / np.maximum(shown.sum(axis=(1, 2)), 1)[:, None] - error
        distance = np.hypot(*np.moveaxis(pixels - middle[:, None, None], -1, 0))
        places, inputs = list[Floats](), list[Floats]()
        for pull in PULLS:
            best = (holds * np.exp(-pull * distance)).reshape(len(rows), -1).argmax(axis=1)
            at_best = (np.arange(len(rows)), best)
            places.append(pixels.reshape(-1, 2)[best])
            own = holds.reshape(len(rows), -1)[at_best], distance.reshape(len(rows), -1)[at_best] / PLACE_UNIT
            inputs.append(np.column_stack([*own, features]))
        return np.stack(places, axis=1), np.stack(inputs, axis=1)

    def _throw(self, observation: Observation, rows: Ints, known: Floats, reference: Floats, action: Actions) -> None:
        """Write the actions of cups under which objects hang."""
        slow, fast = self._config.grasp.pace
        grid, count = np.linspace(slow, fast, PACES), len(rows)
        inputs = np.repeat(self._throw_inputs(observation, known)[rows, None], PACES, axis=1)
        inputs[:, :, _PACE] = pace_action(grid, self._config).astype(np.float32)  # as actions and observations have it
        if self._paces.is_fitted:
            score = self._paces.predict(inputs.reshape(count * PACES, -1)).reshape(count, PACES)
        else:
            score = np.zeros((count, PACES))
        chosen, log = score.argmax(axis=1), self._practice
        puts_down = self._paces.is_fitted & (score.max(axis=1) < scaled(self._fails))
        if log is not None:
            chosen, greedy = log.choose(score)
            puts_down &= greedy
        picked = inputs[np.arange(count), chosen]
        offset = self._releases.predict(picked) if self._knows_releases else reference[rows]
        if log is not None:
            offset = offset + SCATTER[self._knows_releases] * log.random.standard_normal(offset.shape)
            for k in range(count):
                log.throw[rows[k]] = picked[k]
        correction = self._core.correction
        assert correction is not None  # of the mode `release_point`
        action[rows, 3] = pace_action(grid[chosen], self._config)
        action[rows, RESIDUAL] = to_action(offset, correction)
        action[rows[puts_down], 2] = GIVE_UP

    def _throw_inputs(self, observation: Observation, known: Floats) -> Floats:
        """Features of throws (N, E), with the pace in the middle of its range."""
        action = np.zeros((len(known), 6), dtype=np.float32)
        part = self._watcher.cup_part(observation)
        features = observe(observation, action, self._config).features.astype(np.float64)
        return np.column_stack([features, known, part / 0.02])

    def _best_paces(self, inputs: Floats) -> Floats:
        """Values of throws (K,) at the paces that are worth most, by their features at any pace (K, E)."""
        values = list[Floats]()
        for pace in np.linspace(*self._config.grasp.pace, PACES):
            paced = inputs.copy()
            paced[:, _PACE] = pace_action(pace, self._config)
            values.append(self._paces.predict(paced))
        return np.max(values, axis=0)

    # Learning

    def begin_shifts(self, seed: int, gauge: State) -> None:
        """Begin to explore, with a state of the parts that foretell the gauge."""
        self._seed, self._practice = seed, Practising(seed)
        self._restore(gauge, ("gauge", "attention"))

    def end_shifts(self) -> None:
        """Stop to explore."""
        self._practice = None

    def settle(self, rows: Ints, observation: Observation, is_sorted: Bools, seconds: Floats) -> None:
        """Take in the picks of some rows (K,) that are over, before the next `act`."""
        log = self._practice
        assert log is not None and observation.last is not None  # between `begin_shifts` and `end_shifts`
        last = LAST.decode(observation.last[rows])
        seen = (last["last_seen"] > 0.5) & (last["thrown"] > 0.5)
        shift = np.column_stack([last["last_shift_along"], last["last_shift_across"]])
        ideal = shift - np.column_stack([last["last_along"], last["last_across"]])
        ideal[~seen] = np.nan
        for k, row in enumerate(rows):
            if last["shift_gone"][k] <= 0.0:  # the last pick of a shift, of which nothing is shown any more
                log.forget(int(row))
                continue
            log.settle(int(row), ideal[k], last["thrown"][k] > 0.5, float(is_sorted[k]), float(seconds[k]))

    def fit(self, steps: int) -> None:
        """Fit all networks to the picks of the practice."""
        log = self._practice
        assert log is not None
        samples = log.samples
        won, spent = (np.array([getattr(s, name) for s in samples]) for name in ("is_sorted", "seconds"))
        recent = slice(-max(len(samples) // 3, 1), None)
        price = won[recent].sum() / spent[recent].sum()
        returns = won - price * spent
        throws = np.array([np.isfinite(s.throw).all() for s in samples])
        tries = np.array([len(s.tried) for s in samples])
        skipped, failed = (tries == 0) & ~throws, (tries > 0) & ~throws
        self._rides = float(returns[skipped].mean()) if skipped.any() else -0.3
        self._fails = float(returns[failed].mean()) if failed.any() else -0.6
        inputs = np.stack([s.throw for s, one in zip(samples, throws, strict=True) if one])
        self._paces.fit(inputs, scaled(returns[throws]), self._seed, steps)
        offsets = np.stack([s.offset for s, one in zip(samples, throws, strict=True) if one])
        landed = np.isfinite(offsets).all(axis=1)
        correction = self._core.correction
        assert correction is not None
        self._releases.fit(inputs[landed], np.clip(offsets[landed], -correction.scale, correction.scale), self._seed)
        self._knows_releases = True
        values = scaled(returns)
        values[throws] = self._best_paces(inputs)
        tried = np.concatenate([s.tried for s in samples if len(s.tried)])
        self._tries.fit(tried, np.repeat(values, tries), self._seed + 1, steps)

    @property
    def _parts(self) -> dict[str, Any]:
        """All that is fitted, by name."""
        return {
            "try": self._tries, "pace": self._paces, "release": self._releases, "gauge": self._foretold,
            "attention": self._attention,
        }  # fmt: skip

    def state(self) -> State:
        """Arrays of all networks, and the values of objects that ride on."""
        arrays = {f"{part} {name}": array for part, one in self._parts.items() for name, array in one.state().items()}
        return {
            **arrays,
            "rides": np.array([self._rides, self._fails, float(not isinstance(self._watcher.memory, NoMemory))]),
        }

    def restore(self, state: State) -> None:
        """Load all networks."""
        self._restore(state, self._parts)
        self._rides, self._fails = float(state["rides"][0]), float(state["rides"][1])
        self._knows_releases = True
        if state["rides"][2] < 0.5:
            self._watcher.remember_by(NoMemory)

    def _restore(self, state: State, parts: Iterable[str]) -> None:
        """Load some parts."""
        for part in parts:
            own = {name.removeprefix(f"{part} "): a for name, a in state.items() if name.startswith(f"{part} ")}
            self._parts[part].restore(own)


@final
class Practising:
    """What practice has tried, and its random choices.

    Args:
        seed: seed of the choices.
    """

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng([seed, 7])
        self.samples: list[Sample] = []
        self.tried: defaultdict[int, list[Floats]] = defaultdict(list)
        """Features of the tries at the present object, by row."""
        self.throw: dict[int, Floats] = {}
        """Features of the last throw, by row."""

    def choose(self, value: Floats) -> tuple[Ints, Bools]:
        """Choices by values (K, C), some of them at random, and which are by value (K,)."""
        greedy = self.random.random(len(value)) >= EXPLORES
        score = self.random.gumbel(size=value.shape) + greedy[:, None] * value / TEMPERATURE
        return score.argmax(axis=1), greedy

    def explore(self, value: Floats, gives_up: Bools) -> tuple[Ints, Bools]:
        """Choices by values (K, C), and whether to give up (K,), some of them at random."""
        chosen, greedy = self.choose(value)
        return chosen, np.where(greedy, gives_up, self.random.random(len(value)) < EXPLORES)

    def forget(self, row: int) -> None:
        """Leave out a pick that is over."""
        self.tried.pop(row, None)
        self.throw.pop(row, None)

    def settle(self, row: int, offset: Floats, thrown: bool, is_sorted: float, seconds: float) -> None:
        """Keep a pick that is over."""
        tried, throw = self.tried.pop(row, []), self.throw.pop(row, None)
        if throw is None or not thrown:
            throw, offset = np.full(_THROW_INPUTS, np.nan), np.full(2, np.nan)
        self.samples.append(Sample(np.array(tried), throw, offset, is_sorted, seconds))


def scaled(values: Any) -> Any:
    """Values as outputs of the networks, 0 to 1."""
    return np.clip((values - LOWEST) / (HIGHEST - LOWEST), 0.0, 1.0)
