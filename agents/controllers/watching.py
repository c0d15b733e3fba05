"""What a controller of shifts of grasps notices from step to step, and keeps in its memory of the shift.

All of it is in the observations: the picture, the vector, and the entries of the last try and the last landing. A share
of 0 of the shift, before any try, marks the beginning of a new one.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.grasp.config import PIXEL, GraspConfig, Surface
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.images import pixel_places
from pnt_gym.cells.grasp.observation import LAST, TABLE

from ..grasping.attention import LABEL, TryMemory, TryNetwork, place_inputs
from ..grasping.features import blur_maps, place_features
from ..grasping.foretelling import Foretold, LabelTable, labels
from ..grasping.memory import LANDS, Event, MakesMemory, Recalled, ShiftMemory, around, expected, looks, turned
from ..ground.cli import UsageError
from .grasps import direction_of, observe
from .protocol import Actions, Observation
from .regression import OnPolicyRegression

NEAR: Final = 0.06
"""Distance from its target at which a landing counts as a hit [m]."""


@final
class Watcher:
    """Keeps the memory of N rows.

    Args:
        name: name of the controller, for errors.
        core: the cells.
        foretold: foretells from a picture what the gauge reads.
        usual: correction of releases without memory, against which landings are remembered.
        attention: foretells the gauge from earlier tries of the shift too; None for the picture alone.
        makes: makes the memory.

    Raises:
        UsageError: the level's observations have no last try.
    """

    def __init__(
        self,
        name: str,
        core: GraspCore,
        foretold: Foretold,
        usual: OnPolicyRegression,
        attention: TryNetwork | None = None,
        makes: MakesMemory = ShiftMemory,
    ) -> None:
        config: GraspConfig = core.config
        if not config.remembers or config.surface is None or config.grasp.stages == 1:
            raise UsageError(
                f"controller {name!r} remembers what a shift of grasps has shown; use a level with grasp.picks: shift, "
                "surfaces and two stages, such as grasp_shift"
            )
        self._config, self._foretold, self._usual, self._attention = config, foretold, usual, attention
        self._surface: Surface = config.surface
        self._spread = config.drift.camera.normal * config.mismatch
        self._length = config.picks_per_shift
        self.remember_by(makes)

    def remember_by(self, makes: MakesMemory) -> None:
        """Begin anew, with another kind of memory."""
        self._makes = makes
        self.begin(0)

    @property
    def _table(self) -> LabelTable:
        """How labels are spread around those that are foretold."""
        return (self._attention or self._foretold).table

    def begin(self, count: int) -> None:
        """Forget everything, for N rows."""
        self.memory = self._makes(count, self._length, self._spread)
        self._events, self._looks = Event.of(count), np.zeros((count, 8))
        self._number = np.full(count, -1, dtype=np.int64)
        self._maps: NDArray[np.float32] = np.zeros((count, 48, 48), dtype=np.float32)
        self._radius, self._reference = np.full(count, 0.018), np.zeros((count, 2))
        self._tries = TryMemory(count, self._length * self._config.grasp.tries)
        self._places: dict[int, tuple[Ints, Floats]] = {}
        """Pixels (T, 2) of the present objects, by row, and inputs of the network there (T, D)."""

    def notice(self, observation: Observation) -> None:
        """Take in what the last steps showed, before the coming steps are chosen."""
        assert observation.last is not None and observation.image is not None  # of these levels
        last, values = LAST.decode(observation.last), TABLE.decode(observation.features)
        if len(self._number) != len(observation.kind):
            self.begin(len(observation.kind))
        number = np.rint(last["shift_gone"] * self._length).astype(np.int64)
        fresh = np.rint(values["tries_left"]) >= self._config.grasp.tries
        first = (number == 0) & fresh & (last["tried"] < 0.5) & (values["holds"] < 0.5)
        self._take_try(np.flatnonzero((last["tried"] > 0.5) & ~first), last)
        over = np.flatnonzero((number != self._number) & ~first & (self._number >= 0))
        self._take_end(over, last)
        self.memory.begin(np.flatnonzero(first))
        self._tries.begin(np.flatnonzero(first))
        new = np.flatnonzero((number != self._number) | first)
        self._number[new] = number[new]
        if new.size > 0:
            self._see(observation, values, new)

    def _take_try(self, rows: Ints, last: dict[str, Floats]) -> None:
        """Take in the readings of tries in some rows."""
        if rows.size == 0:
            return
        place = np.stack([last["tried_x"], last["tried_y"]], axis=-1)[rows]
        read = labels(last["vacuum"][rows], self._radius[rows], self._surface)
        foretold = around(self._maps[rows], place, 0.0)
        weights = self.memory.weights(rows)
        mean = (foretold * weights).sum(axis=(1, 2))
        self.memory.watch(rows, self._table.likelihood(foretold, read))
        events = self._events
        held, surprise, tried = events.held.copy(), events.surprise.copy(), events.tried.copy()
        tried[rows], held[rows], surprise[rows] = True, last["held"][rows] > 0.5, read - mean
        self._events = events.replace(tried=tried, held=held, surprise=surprise)
        if self._attention is not None and self.memory.attends:
            self._keep_tries(rows, place + self.memory.error(rows), read)
            for row in map(int, rows[~held[rows]]):  # a held object is not tried again
                self._foretell(row)

    def _keep_tries(self, rows: Ints, places: Floats, read: Floats) -> None:
        """Keep tries at expected places (K, 2) [m] with labels (K,) that were read."""
        line = pixel_places()
        for row, place, label in zip(map(int, rows), places, read, strict=True):
            pixels, inputs = self._places[row]
            away = np.hypot(*(line[pixels[:, 0], pixels[:, 1]] - place).T)
            nearest = int(away.argmin()) if len(away) > 0 else -1
            if nearest >= 0 and away[nearest] < PIXEL:
                self._tries.add(row, inputs[nearest], label - inputs[nearest, LABEL])

    def _foretell(self, row: int) -> None:
        """Foretell the labels of the present object of a row, by earlier tries."""
        assert self._attention is not None  # of those who call
        pixels, inputs = self._places[row]
        if len(inputs) > 0:
            self._maps[row, pixels[:, 0], pixels[:, 1]] = self._attention.predict(inputs, *self._tries.of_row(row))

    def _take_end(self, rows: Ints, last: dict[str, Floats]) -> None:
        """Keep the objects of some rows whose picks are over."""
        if rows.size == 0:
            return
        error = np.stack([last["last_along"], last["last_across"]], axis=-1)
        shift = np.stack([last["last_shift_along"], last["last_shift_across"]], axis=-1)
        landed = (last["last_seen"] > 0.5) & (last["thrown"] > 0.5)
        events = self._events.replace(
            thrown=last["thrown"] > 0.5,
            dropped=last["dropped"] > 0.5,
            hit=landed & (np.hypot(*error.T) < NEAR),
            landed=landed,
            off=error - (shift - self._reference),
            direction=np.stack([last["last_direction_x"], last["last_direction_y"]], axis=-1),
        )
        self.memory.add(rows, self._looks[rows], take(events, rows))
        self._events.put(rows, Event.of(len(rows)))

    def _see(self, observation: Observation, values: dict[str, Floats], rows: Ints) -> None:
        """Look at the new objects of some rows."""
        assert observation.image is not None
        features = place_features(observation.image[rows], values["cup_radius"][rows])
        self._events.put(rows, Event.of(len(rows)))
        self._looks[rows] = looks({name: value[rows] for name, value in values.items()}, features)
        label = self._foretold.predict(features.values)
        self._maps[rows] = features.maps(label, 0.0)
        self._radius[rows] = values["cup_radius"][rows]
        if self._attention is not None:
            inputs = place_inputs(features, label, self._looks[rows])
            for k, row in enumerate(map(int, rows)):
                own = features.picture == k
                self._places[row] = features.pixel[own], inputs[own]
                self._foretell(row)

    def maps(self, rows: Ints) -> Floats:
        """Labels of the gauge that are foretold for the present objects (K, 48, 48)."""
        return self._maps[rows].astype(np.float64)

    def holds(self, foretold: Floats, weights: Floats) -> Floats:
        """Probabilities that a try holds (K, 48, 48), at places that the cup reaches.

        Args:
            foretold: labels of the gauge that are foretold (K, 48, 48).
            weights: probabilities of the cup's errors (K, SIDE, SIDE).
        """
        holds = expected(blur_maps(self._table.held(foretold)), weights)
        holds[:, np.abs(pixel_places()).max(axis=-1) > self._config.grasp.reach] = 0.0
        return holds

    def known(self) -> Floats:
        """What is known of objects like the present ones, as features (N, `MEMORIES`)."""
        return self.memory.known(np.arange(len(self._number)), self._looks)

    def recall(self) -> Recalled:
        """What is known of objects like the present ones (N,)."""
        return self.memory.recall(np.arange(len(self._number)), self._looks)

    def reference(self, observation: Observation, action: Actions) -> Floats:
        """Usual offsets of the releases (N, 2) [m], along and left of the throws, which are kept for what follows."""
        hangs = TABLE.decode(observation.features)["holds"] > 0.5
        offset = self._usual.predict(observe(observation, action, self._config))
        self._reference = np.where(hangs[:, None], offset, self._reference)
        return offset

    def cup_part(self, observation: Observation) -> Floats:
        """Expected part of the cup's error in landings (N, 2) [m], along and left of the throws."""
        values = TABLE.decode(observation.features)
        error = -LANDS * self.memory.error(np.arange(len(self._number)))
        return np.stack(turned(error[:, 0], error[:, 1], direction_of(values)), axis=-1)
