"""A tracker that learns in context: a recurrent network trained on simulated shifts of picks.

Practice in a cell without drift gives the static policy's landing errors. The training data put such throws in any
order and add drifts as the shipped levels draw them, by the physical effect of each drift on every throw. A few throws
give as many shifts as needed. Where every shift of the practice has another cell, the training data are these shifts,
with their throws in any order, because a cell stays the same in a shift.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.conveyor.config import ConveyorConfig

from ..ground.cli import UsageError
from .protocol import State
from .recurrent import Recurrent, TrainingShifts, train
from .trackers import Tracker, drift_effects

LEVELS: Final = ("day", "steps", "drift_mix")
"""Levels whose drifts are used in training; each shift has the drift of one level, up to `STRONGEST` times as
strong."""
STRONGEST: Final = 1.5
SHIFTS: Final = 64
"""Shifts in a batch."""
PICKS: Final = 50
"""Throws in a shift."""
UNSEEN: Final = 0.3
"""Largest share of landings in a shift without feedback."""
SHORT: Final = 32
"""Throws in a training shift that is one of the practice; a shift with fewer landings is not used."""
BLURRED: Final = 0.02
"""Largest additional standard deviation of another camera over the bins, along and across [m]; in half of the shifts
the camera is that of the practice."""


@final
class InContext(Tracker):
    """Tracker with a recurrent network and a memory for every row.

    Args:
        camera_x: place where the camera sees objects [m].
        cells_differ: whether every shift of the practice has another cell.
        size: numbers in the network's memory.
        batches: training batches.
    """

    def __init__(self, camera_x: float, cells_differ: bool, size: int = 64, batches: int = 4000) -> None:
        self._camera_x, self._cells_differ, self._size, self._batches = camera_x, cells_differ, size, batches
        self._network: Recurrent | None = None
        self._memory = np.zeros((0, size))

    def begin(self, rows: Bools) -> None:
        """Clear the memory of some rows."""
        if len(rows) != len(self._memory):
            self._memory = np.zeros((len(rows), self._size))
        self._memory[rows] = 0.0

    def learn(self, throws: Floats, z: Floats, rows: Bools) -> None:
        """Update the memory by throws and their landings."""
        if self._network is not None:
            new = self._network.update(self._memory, throws, z)
            self._memory = np.where(rows[:, None], new, self._memory)

    def effect(self, throws: Floats) -> Floats:
        """Effect that the network predicts (N, 2); zero before its training."""
        if self._network is None:
            return np.zeros((len(throws), 2))
        return self._network.predict(self._memory, throws)

    def study(self, throws: Floats, z: Floats, shift: Ints, seed: int) -> None:
        """Train the network on simulated shifts made from these throws, or on these shifts where cells differ."""
        if self._cells_differ:
            shifts = shuffle_shifts(throws, z, shift, self._batches, seed)
        else:
            shifts = simulate_shifts(throws, z, self._camera_x, self._batches, seed)
        self._network = train(shifts, self._batches, throws.shape[1], seed, self._size)

    def state(self) -> State:
        """State of the network; empty before its training."""
        return {} if self._network is None else self._network.state()

    def restore(self, state: State) -> None:
        """Load a network.

        Raises:
            UsageError: the state holds no network.
        """
        if not state:
            self._network = None
            return
        if "memory_in_weight" not in state:
            raise UsageError(
                "the saved state of 'in_context' holds no network; let 'in_context' practise without drift first"
            )
        self._network = Recurrent.of(state)
        self._size = self._network.size
        self._memory = np.zeros((0, self._size))


def simulate_shifts(throws: Floats, z: Floats, camera_x: float, batches: int, seed: int) -> Iterator[TrainingShifts]:
    """Batches of simulated shifts, from throws (M, D) with landing errors z (M, 2) [m] without drift."""
    random, drifts = np.random.default_rng(seed), [ConveyorConfig.load(name).drift for name in LEVELS]
    effect = drift_effects(throws, camera_x)
    for _ in range(batches):
        picks = random.integers(len(throws), size=(SHIFTS, PICKS))
        # Delay, camera along x and y, and encoder of the drift of each shift.
        drifted: list[Floats] = []
        for drift in (drifts[random.integers(len(drifts))] for _ in range(SHIFTS)):
            parts = (drift.delay, drift.camera, drift.camera, drift.encoder)
            strength = STRONGEST * random.random()
            paths = [part.path(random, PICKS, drift.steps_every) for part in parts]
            drifted.append(strength * np.stack(paths, axis=1))
        state = np.stack(drifted)
        has_landing = random.random((SHIFTS, PICKS)) >= UNSEEN * random.random((SHIFTS, 1))
        landing_errors = z[picks] + (effect[picks] @ state[..., None])[..., 0]
        blur = BLURRED * np.maximum(2.0 * random.random((SHIFTS, 1, 1)) - 1.0, 0.0)
        observed = landing_errors + blur * random.standard_normal(landing_errors.shape)
        yield TrainingShifts(
            throws[picks], np.where(has_landing[..., None], observed, 0.0), landing_errors, has_landing
        )


def shuffle_shifts(throws: Floats, z: Floats, shift: Ints, batches: int, seed: int) -> Iterator[TrainingShifts]:
    """Batches of shifts of a practice, each with `SHORT` of its throws in any order.

    Args:
        throws: observations (M, D).
        z: their landing errors (M, 2) [m].
        shift: number of the shift of each throw (M,).
        batches: number of batches.
        seed: seed of the choices.

    Raises:
        UsageError: no shift has so many landings.
    """
    random, order = np.random.default_rng(seed), np.argsort(shift, kind="stable")
    _, first, count = np.unique(shift[order], return_index=True, return_counts=True)
    whole = np.flatnonzero(count >= SHORT)
    if whole.size == 0:
        raise UsageError(
            f"no shift of the practice has {SHORT} landings, from which 'in_context' learns what cells have in common; "
            "practise longer, or with more picks_per_shift"
        )
    for _ in range(batches):
        chosen = random.choice(whole, SHIFTS)
        picks = np.stack([order[first[k] + random.permutation(count[k])[:SHORT]] for k in chosen])
        has_landing = random.random(picks.shape) >= UNSEEN * random.random((SHIFTS, 1))
        yield TrainingShifts(throws[picks], np.where(has_landing[..., None], z[picks], 0.0), z[picks], has_landing)
