"""The conveyor's residual: an action in [-1, 1] corrects the release of a plan; zero is the plan itself.

Modes, all but the last on the same planner:

* `release_point` (2 numbers): the release point moves along the throw line and sideways at the planned elevation, so
  that the drag-free landing moves by `action x (along, across)`. Well conditioned: one action unit is the same offset
  of the landing for every target.
* `release_xyz` (3 numbers): the release point moves by raw metres along, sideways and up. The same centimetre may move
  the landing by one centimetre or by ten.
* `virtual_goal` (2 numbers): the target is moved and the throw planned from scratch, as in Miyashita et al.
  The minimum-time plan can jump between its flat and its steep branch when the goal moves a little.
* `throw_or_place` (3 numbers, where the planner is `auto`): as `release_point`, and a third number above 1/2 puts the
  object down where the rule would throw it, or throws the object where the rule would put it down.
* `fixed_throw` (3 numbers, where the planner throws on straight lines): the release itself, as bearing, way and rise
  from the pick. Zero is one throw for all picks, straight across the belt. Nothing depends on the target, but a throw
  that would carry its object into a bin is shortened. The observation shows nothing of the planner's throw.
"""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints, join_columns, recompute_rows
from pnt_gym.cells.base.action import ActionMode, Correction, Modes, by_name, mode_of, quarter_names
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.observation import decode
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.errors import PlanningError
from pnt_gym.planning.straight.plan import ReleaseBatch

ERRORS: Final = ("landing_along", "landing_across")
CHOICE_THRESHOLD: Final = 0.5
"""Value of the third number above which throw and place are swapped."""
EXPLORATION: Final = (0.015, 0.0075)
"""Standard deviation of the offset that a learner adds in practice, along and across [m]."""


FIXED_THROW: Final = "fixed_throw"
"""Name of the mode in which actions do not correct the planner's throw."""
STRAIGHT_PLANNERS: Final = ("straight", "straight_flying")
"""Planners whose hands move straight to the release, at a speed that follows from the way alone."""
FIXED_WAY: Final = 0.10
"""Horizontal way from the pick to the release of the fixed throw [m]; with half the rise to the ceiling, the throw is
feasible at all picks of the levels that ship."""
WIDEST: Final = np.pi / 3.0
"""Bearing of an action of 1, against straight across the belt [rad]; the planner's throws on `waste` stay within it."""
WAY_FACTOR: Final = 8.0
"""Way of an action of 1 over that of the fixed throw: 0.80 m, and 0.0125 m at -1; the planner's ways lie between."""
FROM_PLANNER: Final = (
    "release_speed", "elevation", "release_distance", "flight_time", "last_shift_along", "last_shift_across"
)  # fmt: skip
"""Entries of an observation that tell something of the planner's throw."""


def _aim(planner: PickPlanner, context: Context, residual: Floats) -> ReleaseBatch:
    slack = planner.config.motion.ceiling_slack
    return planner.mark_feasible(context, planner.mover.aim_at(context, _goal(context, residual), slack))


def _move_release(planner: PickPlanner, context: Context, residual: Floats) -> ReleaseBatch:
    point = context.plan.position + context.from_throw_frame(residual[:, 0], residual[:, 1])
    point[:, 2] += residual[:, 2]
    return planner.mark_feasible(context, planner.mover.release_at(context, point))


def _replan(planner: PickPlanner, context: Context, residual: Floats) -> ReleaseBatch:
    return planner.mark_feasible(context, planner.replan(context, _goal(context, residual)))


def _aim_or_swap(planner: PickPlanner, context: Context, residual: Floats) -> ReleaseBatch:
    aimed, is_swapped = _aim(planner, context, residual), residual[:, 2] > CHOICE_THRESHOLD
    swapped = partial(planner.replan, is_swapped=True)
    return planner.mark_feasible(context, recompute_rows(aimed, is_swapped, swapped, context, _goal(context, residual)))


def _release_anywhere(planner: PickPlanner, context: Context, residual: Floats) -> ReleaseBatch:
    bearing, way = residual[:, 0], FIXED_WAY * np.exp(residual[:, 1])
    rise = 0.5 * planner.config.motion.ceiling + residual[:, 2]
    point = context.pick + join_columns(-np.sin(bearing) * way, np.cos(bearing) * way, rise)
    plans = planner.mark_feasible(context, planner.mover.release_at(context, point))
    is_fixed = ~residual.any(axis=1)  # far enough from a bin by its short way, also where the rule, which errs, refuses
    plans = plans.replace(feasible=plans.feasible & (planner.clears_bins(context, plans) | is_fixed))
    if (away := is_fixed & ~plans.feasible).any():
        x, y, _ = context.pick[away][0]
        raise PlanningError(
            f"the fixed throw from the pick at x {x:.3f} m, y {y:.3f} m leaves the workspace; use another action_mode"
        )
    return plans


def _goal(context: Context, residual: Floats) -> Floats:
    """The targets (N, 3) moved along the throw and to its left [m]."""
    return context.target + context.from_throw_frame(residual[:, 0], residual[:, 1])


def _offset_scale(config: ConveyorConfig) -> Floats:
    return np.array([config.action.along, config.action.across])


def _xyz_scale(config: ConveyorConfig) -> Floats:
    return np.array(config.action.xyz)


def _offset_and_choice_scale(config: ConveyorConfig) -> Floats:
    return np.array([*_offset_scale(config), 1.0])


def _release_scale(config: ConveyorConfig) -> Floats:
    return np.array([WIDEST, np.log(WAY_FACTOR), 0.5 * config.motion.ceiling])


_ALL_MODES: Final = by_name(
    ActionMode(
        "release_point",
        ("release point along the throw line", "release point sideways, at the planned elevation"),
        _offset_scale,
        _aim,
        ERRORS,
    ),
    ActionMode(
        "release_xyz",
        ("release point along the throw", "release point sideways", "release point up"),
        _xyz_scale,
        _move_release,
    ),
    ActionMode("virtual_goal", ("target along the throw", "target to its left"), _offset_scale, _replan, ERRORS),
    ActionMode(
        FIXED_THROW,
        (
            "bearing of the throw, to the left of straight across the belt",
            "logarithm of the way",
            "rise of the release",
        ),
        _release_scale,
        _release_anywhere,
        unseen=FROM_PLANNER,
        planners=STRAIGHT_PLANNERS,
    ),
    ActionMode(
        "throw_or_place",
        ("release point along the throw line", "release point sideways", "above 1/2: the other way of throw and place"),
        _offset_and_choice_scale,
        _aim_or_swap,
        planners=("auto",),
    ),
)


def modes_of(planner: str) -> Modes:
    """The action modes of cells with a planner, the default first."""
    return {name: mode for name, mode in _ALL_MODES.items() if not mode.planners or planner in mode.planners}


MODES: Final = modes_of(STRAIGHT_PLANNERS[0])
"""Action modes for the default planner."""


def correction(config: ConveyorConfig, mode: str, info_errors: tuple[str, ...] = ()) -> Correction | None:
    """How an action moves the landing along and across the throw; None where the mode's numbers do not one to one.

    Args:
        config: the cell.
        mode: name of the action mode.
        info_errors: info keys of measured landing errors; empty: the true errors.
    """
    if not mode_of(modes_of(config.planner), mode).errors:
        return None
    return Correction(
        errors=ERRORS,
        scale=_offset_scale(config),
        exploration=np.array(EXPLORATION),
        tolerance=np.ones(2),
        buckets=partial(_buckets, config),
        info_errors=info_errors,
    )


def _buckets(config: ConveyorConfig, features: NDArray[np.float32], kind: Ints) -> list[tuple[str, str]]:
    """Item and bin of each throw: the bin's name, or the quarter of the area in which a random bin stands."""
    values = decode(features)
    x, y = values["target_x"], values["target_y"]
    if config.bins.random is not None:
        area = config.bins.random
        places = quarter_names(x, y, (float(np.mean(area.x)), float(np.mean(area.y))), ("far", "near"))
    else:
        bins = config.bins.fixed
        gap = np.hypot(x[:, None] - [b.x for b in bins], y[:, None] - [b.y for b in bins])
        places = [bins[int(i)].name for i in gap.argmin(axis=1)]
    return [(config.items[k], place) for k, place in zip(kind, places, strict=True)]
