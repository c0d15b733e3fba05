"""How exactly throws of the one-joint thrower and the gripper robot come true, and how reliable grips and tosses are.

Throws without any mismatch at several physics steps; on each level of the gripper robot its planner, and an oracle that
previews throws. With --cycles a long run looks for warnings of the physics engine, which the plant turns into errors.

Run: python benchmarks/study_robots.py --json robots.json      (a minute)
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from agents.ground.files import write_json
from benchmarks.study import Floats, draw_first, study_options, study_parser
from pnt_gym.cells.base.action import corrected
from pnt_gym.cells.gripper.action import MODES
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.motion import TossPlans
from pnt_gym.cells.one_joint.cell import OneJointCell
from pnt_gym.cells.one_joint.config import OneJointConfig

LEVELS: Final = ("nominal", "ideal", "patient", "late", "drop", "belt")


def one_joint_errors(step: float, options: Namespace) -> dict[str, float]:
    """Largest miss of throws to drawn goals without any mismatch."""
    cell = draw_first(
        OneJointCell(OneJointConfig.load("ideal", timestep=step), options.throws, options.threads), options.seed
    )
    outcome = cell.preview(cell.context.plans)
    x, y, phi, dy = np.abs(outcome.true_error).max(axis=0)
    return {
        "timestep_ms": 1e3 * step,
        "position_mm": 1e3 * float(np.hypot(x, y)),
        "angle_deg": float(np.rad2deg(phi)),
        "speed_mm_per_s": 1e3 * float(dy),
        "release_speed_mrad_per_s": 1e3 * float(np.abs(outcome.release_speed_error).max()),
    }


def tossing(level: str, options: Namespace, **changes: Any) -> GripperCell:
    """Cells of the gripper robot with their first throws drawn."""
    config = GripperConfig.load(level, **changes)
    return draw_first(GripperCell(config, options.throws, options.threads), options.seed)


def toss_plans(cell: GripperCell, correction: Floats) -> TossPlans:
    """Feasible plans nearest to corrections (N, 3) in metres and seconds."""
    return corrected(MODES["release"], cell.planner, cell.context, correction, np.ones(3))[0]


def toss_quality(level: str, options: Namespace) -> dict[str, float | str]:
    """Landing errors and success of the planner, and of an oracle that previews throws, within an action's range."""
    cell = tossing(level, options)
    correction, most = np.zeros((options.throws, 3)), cell.config.action.scale()
    planned = cell.preview(cell.context.plans, jitter=True)
    correction[:, 2] = -cell.context.hidden.delay
    for _ in range(2):
        correction = np.clip(correction, -most, most)
        outcome = cell.preview(toss_plans(cell, correction), jitter=True)
        correction[:, 0] -= outcome.landing_along
        correction[:, 1] -= outcome.landing_across
    best = cell.preview(toss_plans(cell, np.clip(correction, -most, most)), jitter=True)
    return {
        "level": level,
        "planner_success": float(planned.is_success.mean()),
        "planner_error_mm": 1e3 * float(planned.landing_error.mean()),
        "oracle_success": float(best.is_success.mean()),
        "oracle_error_mm": 1e3 * float(best.landing_error.mean()),
        "picked": float(planned.picked.mean()),
        "slip_max_mm": 1e3 * float(planned.slip.max()),
        "recontact": float(planned.recontact.mean()),
        "cycle_time_s": float(planned.cycle_time.mean()),
        "peak_torque_nm": float(planned.peak_torque.max()),
    }


def toss_errors(step: float, options: Namespace) -> dict[str, float]:
    """Landing error of throws without any mismatch."""
    cell = tossing("ideal", options, timestep=step)
    outcome = cell.preview(cell.context.plans)
    return {
        "timestep_ms": 1e3 * step,
        "along_mm": 1e3 * float(outcome.landing_along.mean()),
        "largest_mm": 1e3 * float(outcome.landing_error.max()),
    }


def toss_endurance(level: str, options: Namespace) -> dict[str, float | str]:
    """Share of successes in many cycles; a warning of the engine is an error that ends the run."""
    cells, rng = options.throws, np.random.default_rng(options.seed)
    cell, outcomes = tossing(level, options), list[tuple[float, float]]()
    while len(outcomes) * cells < options.cycles:
        # Random corrections, so that throws which go wrong are among them.
        correction = rng.uniform(-1.0, 1.0, (cells, 3)) * cell.config.action.scale()
        outcome = cell.throw(toss_plans(cell, correction))
        outcomes.append((float(outcome.is_success.mean()), float(outcome.picked.mean())))
    success, picked = np.mean(outcomes, axis=0)
    return {"level": level, "cycles": len(outcomes) * cells, "success": float(success), "picked": float(picked)}


def main() -> None:
    parser = study_parser(__doc__, 64, "level or physics step")
    parser.add_argument("--cycles", type=int, default=0, help="length of the long run; 0 leaves it out")
    options = study_options(parser)
    parts: dict[str, tuple[Callable[[Any, Namespace], dict[str, Any]], tuple[Any, ...]]] = {
        "one_joint_exactness": (one_joint_errors, (0.0005, 0.001, 0.002)),
        "gripper_exactness": (toss_errors, (0.00025, 0.0005, 0.001)),
        "gripper_quality": (toss_quality, LEVELS),
        "gripper_endurance": (toss_endurance, ("nominal", "belt") if options.cycles > 0 else ()),
    }
    result: dict[str, list[dict[str, Any]]] = {}
    for name, (study, cases) in parts.items():
        for case in cases:
            row = study(case, options)
            result.setdefault(name, []).append(row)
            said = ", ".join(f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items())
            print(f"{name}: {said}", flush=True)
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
