"""The shifts of N cells: how each drifts from pick to pick, and what a camera over the bins tells of every throw."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.aside import Purpose, aside
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Before, Context, Drifted
from pnt_gym.cells.conveyor.objects.drawing import spin_gripped
from pnt_gym.cells.conveyor.outcome import Outcome
from pnt_gym.planning.motion.ballistics import landing_point
from pnt_gym.planning.straight.plan import ReleaseBatch


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
