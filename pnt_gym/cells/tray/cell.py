"""The gripper robot's cell: N robots, picking and tossing in step."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from pnt_gym.cells.tray.config import TrayConfig
from pnt_gym.cells.tray.hidden import Hidden, draw_hidden, expected_hidden
from pnt_gym.cells.tray.motion import TossPlans
from pnt_gym.cells.tray.outcome import Outcome, judge
from pnt_gym.cells.tray.planner import TossPlanner
from pnt_gym.cells.tray.plant import TrayPlant
from pnt_gym.engine import MjData, MjModel
from pnt_gym.errors import ConfigError
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.rows import put, take

SHARES: Final = (0.8, 0.6, 0.4, 0.2, 0.0)
"""Shares of an infeasible correction that are tried, the largest feasible one being taken."""
_PROBES: Final = 9

Generators = list[np.random.Generator]


@final
@dataclass(frozen=True)
class Context:
    """N coming throws."""

    kind: Ints
    """Index into the config's things (N,)."""
    place: Floats
    """Where the object is seen on the table, on a belt where it is expected when the claws begin to close (N, 2)
    [m]."""
    measured: Floats
    """Extents along the object's axes as a camera measures them (N, 3) [m]."""
    plans: TossPlans
    """The planner's throws."""
    hidden: Hidden
    """The objects as they are, and what else the planner does not know."""

    @property
    def target(self) -> Floats:
        """Middle of the compartment's opening (N, 3) [m]."""
        return self.plans.target


@final
class TrayCell:
    """N cells in step: `context` holds the coming throws, `throw` carries them out and brings the next.

    Args:
        config: the cell.
        count: number of cells N.
        threads: worker threads of the physics; results do not depend on it.

    Raises:
        ConfigError: some pick or compartment of the config is out of the robot's reach.
    """

    def __init__(self, config: TrayConfig, count: int, threads: int = 1) -> None:
        self.config, self.count = config, count
        self.planner = TossPlanner(config)
        self._check_reach()
        self.plant = TrayPlant(config, count, threads)
        self._generators: Generators = [np.random.default_rng(0) for _ in range(count)]
        self.context: Context = self._drawn(np.arange(count))

    def reset(self, rows: Ints, generators: Generators) -> None:
        """Begin anew in some rows, each with its own generator."""
        for row, generator in zip(rows, generators, strict=True):
            self._generators[int(row)] = generator
        put(self.context, rows, self._drawn(rows))

    def plan(self, correction: Floats | None = None) -> TossPlans:
        """Plans of the coming throws, feasible or not.

        Args:
            correction: release point along the throw and to its left [m], opening later [s] (N, 3); none if not given.
        """
        return self.planner.plan(self.context.kind, self.context.place, correction)

    def corrected(self, correction: Floats) -> tuple[TossPlans, Bools]:
        """Feasible plans of the coming throws, and which corrections had to be shortened (N,).

        Args:
            correction: as for `plan`; an infeasible one is scaled down, in the worst case to nothing.
        """
        plans = self.plan(correction)
        clipped = ~plans.feasible
        for share in SHARES:
            rows = np.flatnonzero(~plans.feasible)
            if rows.size == 0:
                break
            put(plans, rows, take(self.plan(share * correction), rows))
        return plans, clipped

    def throw(self, plans: TossPlans, clipped: Bools | None = None) -> Outcome:
        """Throw in every cell and move on to the next throws.

        Args:
            plans: feasible plans, one per cell.
            clipped: which of them are shortened corrections (N,), passed on to the outcome.

        Raises:
            ValueError: a plan is not feasible.
        """
        outcome = self.preview(plans, jitter=True)
        if clipped is not None:
            outcome = replace(outcome, clipped=clipped)
        self.context = self._drawn(np.arange(self.count))
        return outcome

    def preview(self, plans: TossPlans, jitter: bool = False) -> Outcome:
        """What the coming throws would do, without moving on.

        Args:
            plans: feasible plans, one per cell.
            jitter: whether the throw's own scatter is included, as `throw` will have it; without, the objects are the
                average ones of their kind.

        Raises:
            ValueError: a plan is not feasible.
        """
        if not plans.feasible.all():
            row = int(np.flatnonzero(~plans.feasible)[0])
            raise ValueError(f"the plan of cell {row} is not feasible; throw only plans whose `feasible` is True")
        context = self.context
        hidden = context.hidden if jitter else expected_hidden(context.kind, self.config)
        simulated = self.plant.throw(plans, context.kind, context.place, hidden)
        return judge(simulated, plans, self.config, self.planner.return_time(plans))

    def pose(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation as it stands before the coming throw, for a picture."""
        context = self.context
        self.plant.write(context.plans, context.kind, context.place, context.hidden)
        return self.plant.pose(row)

    def _check_reach(self) -> None:
        """Every kind from a grid over the picks: between its points, reach is safe by far more than the spacing."""
        table, things = self.config.table, self.config.things
        axes = np.linspace(*table.pick_x, _PROBES), np.linspace(*table.pick_y, _PROBES)
        place = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        kind = np.repeat(np.arange(len(things)), len(place))
        places = np.tile(place, (len(things), 1))
        plans = self.planner.plan(kind, places)
        missed = np.flatnonzero(~plans.feasible)
        if missed.size > 0:
            row = int(missed[0])
            x, y = places[row]
            raise ConfigError(
                f"cell {self.config.name!r}: the {things[int(kind[row])].name} cannot be brought from x {x:.3f} m, "
                f"y {y:.3f} m to its compartment: {self.planner.fault(plans, row)}"
            )

    def _drawn(self, rows: Ints) -> Context:
        """The coming throws of some rows, each from its own generator."""
        generators, table = [self._generators[int(r)] for r in rows], self.config.table
        kind = np.array([g.integers(len(self.config.things)) for g in generators], dtype=np.int64)
        share = np.stack([g.random(2) for g in generators])
        low, high = np.array([table.pick_x, table.pick_y]).T
        place = low + share * (high - low)
        hidden, measured = draw_hidden(generators, kind, place, self.config)
        return Context(kind, place, measured, self.planner.plan(kind, place), hidden)
