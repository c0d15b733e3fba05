"""Time the gripper robot's kinematics and indices on one core: python benchmarks/bench_gripper.py [--json FILE]."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from agents.ground.files import write_json
from pnt_gym.robots.gripper import (
    check_pose,
    conditioning,
    forward_kinematics,
    inverse_kinematics,
    jacobian,
    kappa,
    line,
    scan_workspace,
    tau_hull,
)

BATCH, SINGLE, REPEATS = 200_000, 500, 7
# Gives 51 491 positions, next to the paper's 51 624, for which no round step exists.
PAPER_STEP = 0.00467


def seconds(action: Callable[[], object], repeats: int = REPEATS) -> float:
    """Shortest of several runs: the one that other processes disturbed least."""
    spent = []
    for _ in range(repeats):
        begin = time.perf_counter()
        action()
        spent.append(time.perf_counter() - begin)
    return min(spent)


def reachable(count: int) -> np.ndarray:
    """Poses of the reduced workspace at the angles the prototype grips with, fixed seed."""
    low, high = np.deg2rad(-60.0), np.deg2rad(-30.0)
    poses = np.random.default_rng(1).uniform([-0.16, -0.15, -0.28, low], [0.16, 0.15, -0.12, high], (6 * count, 4))
    return poses[np.isfinite(inverse_kinematics(poses, strokes=True)[:, 0])][:count]


def measure() -> dict[str, float]:
    """Run everything in one process and return the numbers."""
    poses = reachable(BATCH)
    q, warm, count = inverse_kinematics(poses), poses + 1e-3, len(poses)
    one, one_q = poses[0], q[0]
    near = warm[0]
    positions = scan_workspace(PAPER_STEP).positions
    hull = seconds(lambda: tau_hull(positions), 3)
    return {
        "poses": float(count),
        "inverse_kinematics_poses_per_s": count / seconds(lambda: inverse_kinematics(poses)),
        "inverse_kinematics_strokes_poses_per_s": count / seconds(lambda: inverse_kinematics(poses, strokes=True)),
        "forward_kinematics_poses_per_s": count / seconds(lambda: forward_kinematics(q), 3),
        "forward_kinematics_warm_poses_per_s": count / seconds(lambda: forward_kinematics(q, start=warm), 3),
        "conditioning_poses_per_s": count / seconds(lambda: conditioning(poses)),
        "kappa_poses_per_s": count / seconds(lambda: kappa(poses)),
        "jacobian_poses_per_s": count / seconds(lambda: jacobian(poses)),
        "check_pose_poses_per_s": count / seconds(lambda: check_pose(poses)),
        "single_inverse_kinematics_us": 1e6 * seconds(lambda: inverse_kinematics(one), SINGLE),
        "single_forward_kinematics_us": 1e6 * seconds(lambda: forward_kinematics(one_q), SINGLE),
        "single_forward_kinematics_warm_us": 1e6 * seconds(lambda: forward_kinematics(one_q, start=near), SINGLE),
        "line_motion_ms": 1e3 * seconds(lambda: line([0, 0, -0.25, -0.8], [0, 0.05, -0.2, -0.8]), 50),
        "workspace_scan_5_mm_ms": 1e3 * seconds(scan_workspace, 3),
        "tau_hull_positions": float(len(positions)),
        "tau_hull_101_angles_s": hull,
        "tau_hull_poses_per_s": 101 * len(positions) / hull,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="Time the gripper robot's kinematics and indices.")
    parser.add_argument("--json", type=Path, help="write the numbers to this file too")
    arguments = parser.parse_args()
    numbers = measure()
    for name, value in numbers.items():
        print(f"{name:40s} {value:16,.2f}")
    if arguments.json:
        write_json(arguments.json, numbers)


if __name__ == "__main__":
    main()
