"""The cell of the gripper robot: N robots that pick and toss in step."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter
from typing import Any, ClassVar, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.action import Correction, require_feasible
from pnt_gym.cells.base.cell import Cell
from pnt_gym.cells.base.recorded import REWARD_TERMS
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.gripper.action import MODES, correction
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.context import Context
from pnt_gym.cells.gripper.hidden import draw_hidden, expected_hidden
from pnt_gym.cells.gripper.motion import TossPlans
from pnt_gym.cells.gripper.observation import HIDDEN, TABLE, feature_table
from pnt_gym.cells.gripper.outcome import Outcome, judge
from pnt_gym.cells.gripper.planner import TossPlanner
from pnt_gym.cells.gripper.plant import GripperPlant
from pnt_gym.cells.gripper.view import DOTS, camera
from pnt_gym.engine import MjData, MjModel
from pnt_gym.errors import ConfigError

_PROBES: Final = 9
RESULTS: Final = (
    "landing_along", "landing_across", "release_delay", "in_opening", "in_bin", "rim", "picked", "slip", "recontact",
    "peak_torque", "energy",
)  # fmt: skip
"""Fields of an outcome that become infos of the same name."""


@final
class GripperCell(Cell[GripperConfig, Context, TossPlans, Outcome]):
    """N cells in step: `context` holds the coming throws, `throw` carries them out and draws the next ones.

    Args:
        config: level of the cell.
        count: number of cells N.
        threads: worker threads of the physics; results do not depend on their number.

    Raises:
        ConfigError: a pick or a compartment of the level is out of the robot's reach.
    """

    modes = MODES
    reward_terms: ClassVar[tuple[str, ...]] = REWARD_TERMS
    table = TABLE
    """Features with the default centres and scales; a level may set its own, see `feature_table`."""
    hidden = HIDDEN

    def __init__(self, config: GripperConfig, count: int, threads: int = 1) -> None:
        super().__init__(config, count, threads)
        self.item_names = self.target_names = config.items  # a compartment is called by what belongs in it
        self.dwell = config.grip.closing + config.grip.hold
        self.planner = TossPlanner(config)
        # Check throws of every kind from a grid of picks; between grid points reach is safe by a wide margin.
        table, items = self.config.table, self.config.items
        axes = np.linspace(*table.pick_x, _PROBES), np.linspace(*table.pick_y, _PROBES)
        place = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        kind = np.repeat(np.arange(len(items)), len(place))
        places = np.tile(place, (len(items), 1))
        plans = self.planner.plan(kind, places)
        missed = np.flatnonzero(~plans.feasible)
        if missed.size > 0:
            row = int(missed[0])
            x, y = places[row]
            fault = next(words for words, bad in self.planner.faults(plans).items() if bad[row])
            raise ConfigError(
                f"cell {self.config.name!r}: the {items[int(kind[row])]} cannot be brought from x {x:.3f} m, "
                f"y {y:.3f} m to its compartment: {fault}"
            )
        self.plant = GripperPlant(config, count, threads)
        feature_table(config)  # tells of an unknown feature now and not at the first throw
        self.context = self.first(np.arange(count))

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming throws (N, 15), by the level's centres and scales."""
        return feature_table(self.config).encode(self.context)

    def preview(self, plans: TossPlans, jitter: bool = False) -> Outcome:
        """Outcome of the coming throws; without `jitter` every object is the average one of its kind.

        Raises:
            PlanningError: a plan is not feasible.
        """
        require_feasible(plans)
        context = self.context
        if not jitter:
            context = replace(context, hidden=expected_hidden(context.kind, self.config))
        return judge(self.plant.fly(context, plans), plans, self.config, self.planner.return_time(plans))

    def reward(self, outcome: Outcome) -> dict[str, Floats]:
        """Weighted reward terms by name, each (N,); before weighting every term lies in [0, 1]."""
        return outcome.rewards(self.config.reward)

    def info(self, outcome: Outcome, throws: Context) -> dict[str, NDArray[Any]]:
        """Infos of throws that only the gripper robot's cell has, (N,) each."""
        target = {"target_x": throws.target[:, 0].copy(), "target_y": throws.target[:, 1].copy()}
        return {**dict(zip(RESULTS, attrgetter(*RESULTS)(outcome), strict=True)), **target}

    def correction(self, mode: str) -> Correction:
        """Meaning of an action as an offset of the landing and of the moment of the release."""
        return correction(self.config, mode)

    def view(self) -> ThrowView:
        """Pictures of the cells; row 0 is recorded from now on."""
        size = self.config.robot.size
        return ThrowView(self, camera(size), DOTS * size)

    def pose(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation as it stands before the coming throw."""
        self.plant.write(self.context, self.context.plans)
        return self.plant.current_state(row)

    def target(self, row: int) -> Floats:
        """Target of the coming throw (3,) [m]."""
        return self.context.target[row]

    def first(self, rows: Ints) -> Context:
        """Coming throws of some rows, independent of the previous throws."""
        generators, table = [self.generators[int(r)] for r in rows], self.config.table
        kind = np.array([g.integers(len(self.config.items)) for g in generators], dtype=np.int64)
        share = np.stack([g.random(2) for g in generators])
        low, high = np.array([table.pick_x, table.pick_y]).T
        place = low + share * (high - low)
        hidden, measured = draw_hidden(generators, kind, place, self.config)
        return Context(kind, place, measured, self.planner.plan(kind, place), hidden)
