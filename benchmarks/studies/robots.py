"""How exactly throws of the one-joint thrower and the gripper robot come true, and how reliable tosses are."""

from __future__ import annotations

import numpy as np

from benchmarks.studies.cells import Amount, Figures, Floats, Settings, draw_first
from pnt_gym.cells.base.action import corrected
from pnt_gym.cells.gripper.action import MODES
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.motion import TossPlans
from pnt_gym.cells.one_joint.cell import OneJointCell
from pnt_gym.cells.one_joint.config import OneJointConfig


def one_joint(settings: Settings, amount: Amount) -> Figures:
    """Largest miss of throws to drawn goals; of the `level` of the settings."""
    cell = OneJointCell(OneJointConfig.load(settings["level"]), amount.throws, amount.threads)
    outcome = draw_first(cell, amount.seed).preview(cell.context.plans)
    x, y, phi, dy = np.abs(outcome.true_error).max(axis=0)
    return {
        "position_m": float(np.hypot(x, y)),
        "angle_rad": float(phi),
        "speed_m_per_s": float(dy),
        "release_speed_rad_per_s": float(np.abs(outcome.release_speed_error).max()),
    }


def toss(settings: Settings, amount: Amount) -> Figures:
    """Landing error of the planner's tosses; of the `level` of the settings."""
    cell = _tossing(settings, amount)
    outcome = cell.preview(cell.context.plans)
    return {"along_m": float(outcome.landing_along.mean()), "largest_m": float(outcome.landing_error.max())}


def quality(settings: Settings, amount: Amount) -> Figures:
    """Landing errors and success of the planner, and of an oracle that previews throws, within an action's range."""
    cell = _tossing(settings, amount)
    correction, limit = np.zeros((amount.throws, 3)), cell.config.action.scale()
    planned = cell.preview(cell.context.plans, jitter=True)
    correction[:, 2] = -cell.context.hidden.delay
    for _ in range(2):
        correction = np.clip(correction, -limit, limit)
        outcome = cell.preview(_plans(cell, correction), jitter=True)
        correction[:, 0] -= outcome.landing_along
        correction[:, 1] -= outcome.landing_across
    best = cell.preview(_plans(cell, np.clip(correction, -limit, limit)), jitter=True)
    return {
        "planner_success": float(planned.is_success.mean()),
        "planner_error_m": float(planned.landing_error.mean()),
        "oracle_success": float(best.is_success.mean()),
        "oracle_error_m": float(best.landing_error.mean()),
        "picked": float(planned.picked.mean()),
        "slip_max_m": float(planned.slip.max()),
        "recontact": float(planned.recontact.mean()),
        "cycle_time": float(planned.cycle_time.mean()),
        "peak_torque": float(planned.peak_torque.max()),
    }


def endurance(settings: Settings, amount: Amount) -> Figures:
    """Share of successes in `rounds` of throws; a warning of the engine is an error that ends the run."""
    cell, rng = _tossing(settings, amount), np.random.default_rng(amount.seed)
    success, picked = np.zeros(settings["rounds"]), np.zeros(settings["rounds"])
    for turn in range(settings["rounds"]):
        # Random corrections, so that throws which go wrong are among them.
        correction = rng.uniform(-1.0, 1.0, (amount.throws, 3)) * cell.config.action.scale()
        outcome = cell.throw(_plans(cell, correction))
        success[turn], picked[turn] = outcome.is_success.mean(), outcome.picked.mean()
    return {"cycles": amount.throws * len(success), "success": float(success.mean()), "picked": float(picked.mean())}


def _tossing(settings: Settings, amount: Amount) -> GripperCell:
    """Cells of the gripper robot with their first throws drawn."""
    config = GripperConfig.load(settings["level"])
    return draw_first(GripperCell(config, amount.throws, amount.threads), amount.seed)


def _plans(cell: GripperCell, correction: Floats) -> TossPlans:
    """Feasible plans nearest to corrections (N, 3) in metres and seconds."""
    return corrected(MODES["release"], cell.planner, cell.context, correction, np.ones(3))[0]
