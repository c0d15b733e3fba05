"""The shifts of N cells: how each drifts from pick to pick, and what a camera over the bins tells of every throw."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replaced
from pnt_gym.cells.base.aside import Purpose, aside
from pnt_gym.cells.base.cell import Generators
from pnt_gym.cells.base.features import FeatureTable, Quantity
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Before, Context, Drifted
from pnt_gym.cells.conveyor.objects.drawing import spin_gripped
from pnt_gym.cells.conveyor.observation import DRIFT, HIDDEN, SHIFT_TABLE, TABLE
from pnt_gym.cells.conveyor.outcome import Outcome
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.ballistics import landing_point
from pnt_gym.planning.straight.plan import ReleaseBatch

SEEN: Final = ("seen_along", "seen_across")
"""Landing errors as a camera over the bins tells them."""
FEWEST_PICKS: Final = 2
"""In a shift from whose throws something can be learned."""
MOST_PICKS: Final = 100_000
"""In a shift that is drawn whole when it begins."""


@final
@dataclass(frozen=True)
class Shift:
    """N shifts of P picks, drawn whole when they begin."""

    delay: Floats
    """(N, P) [s], and so on as in `Drifted`."""
    camera: Floats
    encoder: Floats
    draught: Floats
    noise: Floats
    """Standard normal, what the bin's camera adds along and across (N, P, 2)."""
    chance: Floats
    """Uniform, whether it sees the landing (N, P)."""
    at: Ints
    """The pick that comes, the first being 0 (N,)."""

    @classmethod
    def drawn(cls, generators: list[np.random.Generator], config: ConveyorConfig) -> Self:
        """Shifts that begin, one for each generator, which stays where it is."""
        picks = config.picks_per_shift
        columns = [_drawn(aside(generator, Purpose.SHIFT), picks, config) for generator in generators]
        fields = [np.stack(values) for values in zip(*columns, strict=True)]
        return cls(*fields, at=np.zeros(len(generators), dtype=np.int64))

    def now(self) -> Drifted:
        """How things stand at the coming picks; behind the end of a shift as at its last one."""
        here = np.arange(len(self.at)), np.minimum(self.at, self.delay.shape[1] - 1)
        return Drifted(self.delay[here], self.camera[here], self.encoder[here], self.draught[here])

    def told(self, outcome: Outcome, config: ConveyorConfig) -> tuple[Bools, Floats]:
        """Which landings of the present throws the bin's camera sees (N,), and what it says of them (N, 2) [m]."""
        here = np.arange(len(self.at)), np.minimum(self.at, self.delay.shape[1] - 1)
        true = np.stack([outcome.landing_along, outcome.landing_across], axis=1)
        far = ~(np.hypot(true[:, 0], true[:, 1]) <= config.feedback.view)  # one that is nowhere, too
        seen = ~(far | outcome.dropped | (self.chance[here] < config.feedback.unseen))
        return seen, np.where(seen[:, None], true + config.feedback.noise * self.noise[here], 0.0)

    def thrown(self) -> Self:
        """One throw later."""
        return replace(self, at=self.at + 1)


def _drawn(spare: np.random.Generator, picks: int, config: ConveyorConfig) -> tuple[Floats, ...]:
    """The columns of one shift, from a generator of its own."""
    random, drift, m = np.random.default_rng(spare.integers(2**63, size=4)), config.drift, config.mismatch

    def level(*names: Any) -> Floats:
        return m * np.stack([one.path(random, picks, drift.steps_every) for one in names], axis=-1)

    delay, encoder = level(drift.delay)[:, 0], level(drift.encoder)[:, 0]
    camera, draught = level(drift.camera, drift.camera), level(drift.draught, drift.draught)
    return delay, camera, encoder, draught, random.standard_normal((picks, 2)), random.random(picks)


class Steady:
    """N cells that stay as they are, without a camera over their bins: nothing is told of throws."""

    seen: tuple[str, ...] = ()
    """Keys of the info that tell of the landing errors, where they are not the true ones."""
    table: FeatureTable = TABLE
    """What is seen of the coming throws."""
    hidden: tuple[Quantity, ...] = HIDDEN
    """What is not."""

    def begin(self, rows: Ints, generators: Generators, picks: Context) -> Context:
        """First picks of new shifts in some rows, each with its own generator."""
        return picks

    def after(self, thrown: Context, plans: ReleaseBatch, outcome: Outcome, picks: Context) -> Context:
        """The picks that follow throws, with what is known of these."""
        return picks

    def feedback(self, before: Before) -> dict[str, NDArray[Any]]:
        """What the info tells of the throws before, (N,) each."""
        return {}


@final
class Drifting(Steady):
    """N cells that drift, with a camera over their bins that tells of each throw for those that follow.

    Args:
        config: the cell.
        generators: one per row.

    Raises:
        ConfigError: a shift in which no throw tells anything for another, or too long to be drawn whole.
    """

    seen = SEEN
    table = SHIFT_TABLE
    hidden = (*HIDDEN, *DRIFT)

    def __init__(self, config: ConveyorConfig, generators: Generators) -> None:
        if not FEWEST_PICKS <= config.picks_per_shift <= MOST_PICKS:
            raise ConfigError(
                f"picks_per_shift is {config.picks_per_shift}; a shift in which a throw tells something for the "
                f"next has {FEWEST_PICKS} to {MOST_PICKS}"
            )
        self._config = config
        self._shift = Shift.drawn(generators, config)

    def begin(self, rows: Ints, generators: Generators, picks: Context) -> Context:
        """First picks of shifts that are drawn now."""
        shift = Shift.drawn(generators, self._config)
        self._shift = replaced(self._shift, rows, shift)
        return self._off(picks, shift)

    def after(self, thrown: Context, plans: ReleaseBatch, outcome: Outcome, picks: Context) -> Context:
        """The next picks in cells that have drifted on, with what the camera saw."""
        seen, error = self._shift.told(outcome, self._config)
        self._shift = self._shift.thrown()
        before = known(thrown, plans, seen, error, self._shift.at / self._config.picks_per_shift)
        return replace(self._off(picks, self._shift), before=before)

    def feedback(self, before: Before) -> dict[str, NDArray[Any]]:
        """What the camera tells of the landings, NaN where it saw nothing, and at which pick of the shift that was."""
        error = np.where(before.seen[:, None], before.error, np.nan)
        return {**dict(zip(SEEN, error.T.copy(), strict=True)), "pick_in_shift": self._shift.at - 1}

    def _off(self, picks: Context, shift: Shift) -> Context:
        """Picks as they come in cells that are off by now."""
        return drifted(picks, shift.now(), self._config) if self._config.drift.moves else picks


def drift_of(config: ConveyorConfig, generators: Generators, feedback: bool) -> Steady:
    """How cells drift, with a camera over their bins or without.

    Raises:
        ConfigError: a level that drifts without that camera, or a shift that is too short or too long with it.
    """
    if feedback:
        return Drifting(config, generators)
    if config.drift.moves:
        raise ConfigError(
            f"level {config.name!r} drifts, and nothing in this environment tells of it; use PnTAdapt-v0, or set "
            "the parts of its section `drift` to 0"
        )
    return Steady()


def drifted(context: Context, now: Drifted, config: ConveyorConfig) -> Context:
    """Picks of cells that are off by so much, which no sensor tells."""
    objects, offset = context.objects, now.camera.copy()
    offset[:, 0] += now.encoder * (context.pick[:, 0] - config.belt.camera_x)
    delay = np.maximum(objects.delay + now.delay, 0.0)
    spin = spin_gripped(objects, objects.grasp + offset, config)
    return replace(context, objects=replace(objects, delay=delay, spin=spin), drift=now, unseen=offset)


def known(thrown: Context, plans: ReleaseBatch, seen: Bools, error: Floats, gone: Floats) -> Before:
    """What is known of throws for those that follow.

    Args:
        thrown: the N picks.
        plans: how they were thrown.
        seen: which landings were seen (N,).
        error: what was seen of them (N, 2) [m].
        gone: share of the shift that is over (N,).
    """
    rim = thrown.target[:, 2]
    moved = landing_point(plans.position, plans.velocity, rim) - landing_point(
        thrown.plan.position, thrown.plan.velocity, rim
    )
    shift = np.nan_to_num(np.stack(thrown.to_throw_frame(moved), axis=1))
    return Before(seen, error, shift, thrown.direction, gone)
