"""Shifts of picks of N cells: how cells differ and drift, and measurements of a camera over the bins."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take
from pnt_gym.cells.base.cell import Generators, Purpose, draw_aside
from pnt_gym.cells.base.features import FeatureTable, Quantity
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context, HiddenCell, HiddenDrift, LastThrow, constant_bias, unseen_grasp
from pnt_gym.cells.conveyor.objects.drawing import lip_spin, release_delay, spin_at_grasp
from pnt_gym.cells.conveyor.observation import CELL, DRIFT, HIDDEN, SHIFT_TABLE, TABLE
from pnt_gym.cells.conveyor.outcome import Outcome
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.ballistics import landing_point
from pnt_gym.planning.straight.plan import ReleaseBatch

CAMERA_ERRORS: Final = ("seen_along", "seen_across")
"""Info keys of the landing errors that the camera over the bins measures."""
FEWEST_PICKS: Final = 2
"""Smallest number of picks in a shift with feedback: one throw must follow another."""
MOST_PICKS: Final = 100_000
"""Largest number of picks in a shift with feedback: the drift of the whole shift is drawn when it begins."""


@final
@dataclass(frozen=True)
class DriftSchedule:
    """Drift schedules of N shifts of P picks, drawn whole when the shifts begin."""

    drift: HiddenDrift
    """Drift at every pick (N, P)."""
    noise: Floats
    """Standard normal draws of the bin camera's noise, along and across (N, P, 2)."""
    chance: Floats
    """Uniform draws whether the bin's camera sees the landing (N, P)."""
    at: Ints
    """Number of the coming pick in the shift, from 0 (N,)."""

    @classmethod
    def draw(cls, generators: list[np.random.Generator], config: ConveyorConfig) -> Self:
        """Draw new shifts, one shift per generator; the generators do not advance."""
        picks = config.picks_per_shift
        drift, columns = config.drift, list[tuple[Floats, ...]]()
        for generator in generators:
            random = _own_generator(generator, Purpose.SHIFT)
            # Paths of the parts, in the order in which they are drawn.
            parts = drift.delay, drift.encoder, drift.camera, drift.camera, drift.draught, drift.draught
            paths = config.mismatch * np.stack([p.path(random, picks, drift.steps_every) for p in parts], axis=-1)
            levels = paths[:, 0], paths[:, 2:4], paths[:, 1], paths[:, 4:6]
            columns.append((*levels, random.standard_normal((picks, 2)), random.random(picks)))
        delay, camera, encoder, draught, noise, chance = (np.stack(values) for values in zip(*columns, strict=True))
        drift = HiddenDrift.of(*delay.shape, delay=delay, camera=camera, encoder=encoder, draught=draught)
        return cls(drift, noise, chance, at=np.zeros(len(generators), dtype=np.int64))

    def now(self) -> HiddenDrift:
        """Drift at the coming picks; after the end of a shift that of its last pick."""
        return take(self.drift, self._index())

    def measure(self, outcome: Outcome, config: ConveyorConfig) -> tuple[Bools, Floats]:
        """Which landings of the present throws the bin's camera sees (N,), and the measured errors (N, 2) [m]."""
        index = self._index()
        true = np.stack([outcome.landing_along, outcome.landing_across], axis=1)
        far = ~(np.hypot(true[:, 0], true[:, 1]) <= config.feedback.view)  # a landing of NaN is far, too
        is_visible = ~(far | outcome.dropped | (self.chance[index] < config.feedback.unseen))
        return is_visible, np.where(is_visible[:, None], true + config.feedback.noise * self.noise[index], 0.0)

    def _index(self) -> tuple[Ints, Ints]:
        """Index of the coming picks, or of the last picks of shifts that are over."""
        return np.arange(len(self.at)), np.minimum(self.at, self.chance.shape[1] - 1)

    def advance(self, thrown: Bools) -> Self:
        """The shifts after one more throw in some rows (N,)."""
        return replace(self, at=self.at + thrown)


class SteadyCells:
    """N cells without drift and without a camera over their bins, so observations have no previous landing.

    Args:
        config: the cell; where its section `cells` has ranges, every episode has a cell of its own.
        generators: one per row.
    """

    info_errors: tuple[str, ...] = ()
    """Info keys of measured landing errors; empty where the info has only the true errors."""
    table: FeatureTable = TABLE
    """Features of an observation."""

    def __init__(self, config: ConveyorConfig, generators: Generators) -> None:
        self._config = config
        self._cells = draw_cells(config, generators)
        self._differ = bool(config.cells.ranges)
        """Whether cells differ from one another."""
        self._held: Bools = np.zeros(len(generators), dtype=np.bool_)
        """Rows that `hold_back` holds back (N,)."""

    @property
    def hidden(self) -> tuple[Quantity, ...]:
        """Hidden values, which no observation has."""
        return (*HIDDEN, *CELL) if self._differ else HIDDEN

    def begin(self, rows: Ints, generators: Generators, picks: Context) -> Context:
        """First picks of new shifts in some rows, with one generator per row."""
        self._cells.put(rows, draw_cells(self._config, generators))
        return self._hide(picks, take(self._cells, rows), HiddenDrift.of(len(rows))) if self._differ else picks

    def after(self, context: Context, plans: ReleaseBatch, outcome: Outcome, picks: Context) -> Context:
        """The picks that follow throws, with the measurements of those throws and the drift by now."""
        return self._hide(picks, self._cells, HiddenDrift.of(len(picks.pick))) if self._differ else picks

    @contextmanager
    def hold_back(self, rows: Bools) -> Generator[None]:
        """Context in which some rows (N,) throw nothing, so their shifts do not go on."""
        self._held = rows
        try:
            yield
        finally:
            self._held = np.zeros_like(rows)

    def feedback(self, before: LastThrow) -> dict[str, NDArray[Any]]:
        """Info of the previous throws, (N,) each."""
        return {}

    def _hide(self, picks: Context, cells: HiddenCell, now: HiddenDrift) -> Context:
        """Picks in cells that differ, and that have drifted by now."""
        config = self._config
        if self._differ:
            m = config.mismatch
            calibration = HiddenDrift.of(len(picks.pick), encoder=m * cells.encoder, scale=m * cells.camera)
            return apply_drift(apply_cell(picks, cells, config), calibration.plus(now), config)
        return apply_drift(picks, now, config) if config.drift.moves else picks


@final
class DriftingCells(SteadyCells):
    """N cells that drift, with a camera over their bins whose measurements are in the next observation.

    Args:
        config: the cell.
        generators: one per row.

    Raises:
        ConfigError: a shift of one pick, or of too many picks to be drawn whole.
    """

    info_errors = CAMERA_ERRORS
    table = SHIFT_TABLE

    def __init__(self, config: ConveyorConfig, generators: Generators) -> None:
        if not FEWEST_PICKS <= config.picks_per_shift <= MOST_PICKS:
            raise ConfigError(
                f"picks_per_shift is {config.picks_per_shift}; where a camera sees landings it must be "
                f"{FEWEST_PICKS} to {MOST_PICKS}"
            )
        super().__init__(config, generators)
        self._schedule = DriftSchedule.draw(generators, config)

    @property
    def hidden(self) -> tuple[Quantity, ...]:
        """Hidden values, which no observation has."""
        return (*super().hidden, *DRIFT)

    def begin(self, rows: Ints, generators: Generators, picks: Context) -> Context:
        """First picks of new shifts, whose drift is drawn here."""
        schedule = DriftSchedule.draw(generators, self._config)
        self._schedule = replace_rows(self._schedule, rows, schedule)
        self._cells.put(rows, draw_cells(self._config, generators))
        return self._hide(picks, take(self._cells, rows), schedule.now())

    def after(self, context: Context, plans: ReleaseBatch, outcome: Outcome, picks: Context) -> Context:
        """The next picks in cells that have drifted further, with the camera's measurements of these throws."""
        is_visible, error = self._schedule.measure(outcome, self._config)
        self._schedule = self._schedule.advance(~self._held)
        # Measurements of throws, as the next observation has them.
        gone = self._schedule.at / self._config.picks_per_shift
        rim = context.target[:, 2]
        displacement = landing_point(plans.position, plans.velocity, rim) - landing_point(
            context.plan.position, context.plan.velocity, rim
        )
        offset = np.nan_to_num(np.stack(context.to_throw_frame(displacement), axis=1))
        before = LastThrow.of(
            len(rim), seen=is_visible, error=error, shift=offset, direction=context.direction, gone=gone
        )
        return self._hide(picks, self._cells, self._schedule.now()).replace(before=before)

    def feedback(self, before: LastThrow) -> dict[str, NDArray[Any]]:
        """Landing errors that the camera measured, NaN where it saw nothing, and the throw's number in the shift."""
        error = np.where(before.seen[:, None], before.error, np.nan)
        return {**dict(zip(CAMERA_ERRORS, error.T.copy(), strict=True)), "pick_in_shift": self._schedule.at - 1}


def draw_cells(config: ConveyorConfig, generators: Generators) -> HiddenCell:
    """The numbers of new cells, one cell per generator; the generators do not advance."""
    cells = HiddenCell.of_level(config, len(generators))
    if not config.cells.ranges:
        return cells
    drawn = list[dict[str, float]]()
    for generator in generators:
        drawn.append(config.cells.draw(_own_generator(generator, Purpose.CELL)))
    return cells.replace(**{name: np.array([values[name] for values in drawn]) for name in config.cells.ranges})


def _own_generator(generator: np.random.Generator, purpose: Purpose) -> np.random.Generator:
    """A new generator for a purpose, which is a function of a row's generator; that does not advance."""
    (seed,) = draw_aside(generator, (purpose, lambda aside: aside.integers(2**63, size=4)))
    return np.random.default_rng(seed)


def make_drift(config: ConveyorConfig, generators: Generators, feedback: bool) -> SteadyCells:
    """The drift of cells, with a camera over their bins (`feedback`) or without.

    Raises:
        ConfigError: a level with drift and without the camera, or a shift that is too short or too long for the camera.
    """
    if feedback:
        return DriftingCells(config, generators)
    if config.drift.moves:
        raise ConfigError(
            f"level {config.name!r} drifts, and the observations of this environment do not show drift; use "
            "PnTAdapt-v0, or set the parts of its section `drift` to 0"
        )
    return SteadyCells(config, generators)


def apply_cell(context: Context, cell: HiddenCell, config: ConveyorConfig) -> Context:
    """Picks in cells that differ: delay, spin, drag, restitution and seals change, measurements do not."""
    objects, m, suction = context.objects, config.mismatch, config.suction
    usual = config.cup.blow_off
    blow_off = objects.blow_off * (cell.blow_off / usual) if usual > 0.0 else cell.blow_off
    # A lip's stiffness and the vacuum belong to the cell, drag and restitution to the cell's objects.
    changed = objects.replace(
        valve=cell.valve, tau=cell.tau, blow_off=blow_off, stiffness=cell.stiffness,
        drag=objects.drag * (1.0 + m * (cell.drag - 1.0)),
        restitution=np.minimum(objects.restitution * (1.0 + m * (cell.restitution - 1.0)), 1.0),
        pick_chance=np.clip(objects.pick_chance + cell.seal, 0.0, 1.0),
    )  # fmt: skip
    place = objects.grasp + context.unseen
    before, after = (release_delay(o.seal, o.mass, o.valve, o.tau, suction) for o in (objects, changed))
    spin = objects.spin + (lip_spin(changed, place, config) - lip_spin(objects, place, config))
    return context.replace(
        objects=changed.replace(delay=np.maximum(objects.delay + m * (after - before), 0.0), spin=spin), cell=cell
    )


def apply_drift(context: Context, now: HiddenDrift, config: ConveyorConfig) -> Context:
    """Picks with hidden drift beside the constants of `bias`: delay, spin and grasp change, measurements do not."""
    objects, constants = context.objects, constant_bias(config, len(context.pick))
    total = constants.plus(now)
    before, unseen = (unseen_grasp(hidden, context.pick, config.belt) for hidden in (constants, total))
    planned = objects.replace(grasp=objects.grasp + before)
    delay = np.maximum(objects.delay + now.delay, 0.0)
    spin = spin_at_grasp(planned, objects.grasp + unseen, config)
    return context.replace(objects=objects.replace(delay=delay, spin=spin), drift=total, unseen=unseen)
