"""Cases of robots: the T3KR's motor references and models, the gripper robot's kinematics and indices."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import mujoco
import numpy as np
from mujoco.batch import Batch

from benchmarks.timing import Count, Options, Row, Timing
from papers.leveziel.motion import line
from papers.leveziel.scan import scan_workspace, tau_hull
from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper import (
    check_pose,
    conditioning,
    forward_kinematics,
    inverse_kinematics,
    jacobian,
    kappa,
)
from pnt_gym.robots.specification import set_options
from pnt_gym.robots.t3kr.kinematics import closed_pose
from pnt_gym.robots.t3kr.model import Rods, add_t3kr, control_columns, qpos_columns
from pnt_gym.robots.t3kr.references import exact_references, joint_knots, knot_count, upsample

ROWS, STEPS, RADIUS = 64, 1000, 0.02
POSES, SINGLE = 200_000, 500
# Gives 51 491 positions, next to the paper's 51 624, for which no round step exists.
PAPER_STEP = 0.00467


def t3kr(options: Options) -> Iterator[Row]:
    """The T3KR's motor references by sample, and both of its models by physics step on one thread."""
    for timestep, stride in ((1e-3, 4), (4e-4, 10)):
        yield from references(options.size(ROWS), timestep, stride)
    rows = options.size(ROWS)
    motion = circles(rows, np.arange(STEPS) * 1e-3)
    exact, count = ("references", "exact_us_per_sample"), rows * STEPS
    yield Timing(exact, lambda: exact_references(joint_knots(*motion, RADIUS)), count=count, repeats=3)
    for rods in ("four", "eight"):
        for timestep in (4e-4, 1e-3):
            place = "models", f"{rods}_rods", f"us_per_step_at_{1e3 * timestep:.1f}_ms"
            yield Timing(place, rollout(rods, timestep), count=2 * STEPS, repeats=3)


def references(rows: int, timestep: float, stride: int) -> Iterator[Row]:
    """References at a timestep [s]: solved at every `stride`-th sample and interpolated."""
    knots, spacing = knot_count(STEPS, stride), timestep * stride
    motion, out = circles(rows, np.arange(knots) * spacing), np.ones((rows, STEPS, 17))
    solved, place = joint_knots(*motion, RADIUS), ("references", f"{1e3 * timestep:.1f}_ms")
    yield Count((*place, "knots_every_ms"), 1e3 * spacing)
    solve, sample = partial(joint_knots, *motion, RADIUS), partial(upsample, solved, spacing, stride, out)
    both_steps = lambda: upsample(solve(), spacing, stride, out)  # noqa: E731
    yield Timing((*place, "us_per_sample"), both_steps, count=rows * STEPS)
    yield Timing((*place, "solve_us_per_knot"), solve, count=rows * knots)
    yield Timing((*place, "upsample_us_per_sample"), sample, count=rows * STEPS)


def circles(rows: int, times: Floats) -> tuple[Floats, Floats, Floats]:
    """Position, velocity and acceleration of the hand on tilted circles, (rows, times, 3), about 2 g."""
    radius, rate = np.linspace(0.10, 0.15, rows)[:, None], 12.0
    cos, sin = radius * np.cos(rate * times), radius * np.sin(rate * times)
    centre = np.array([0.0, -0.2, -0.6])
    return (
        np.stack([cos, sin, 0.5 * sin], axis=-1) + centre,
        rate * np.stack([-sin, cos, 0.5 * cos], axis=-1),
        rate**2 * np.stack([-cos, -sin, -0.5 * sin], axis=-1),
    )


def rollout(rods: Rods, timestep: float) -> Callable[[], None]:
    """Rolls out two circles."""
    spec = mujoco.MjSpec()
    handles = add_t3kr(spec, rods=rods)
    set_options(spec, timestep)
    model = spec.compile()
    motion = circles(2, np.arange(STEPS) * timestep)
    control = np.zeros((2, STEPS, model.nu))
    control[..., control_columns(model, handles)] = exact_references(joint_knots(*motion))
    start = closed_pose(motion[0][:, 0], handles.rods_per_arm, handles.geometry)
    batch, columns = Batch(model, 2, nthread=1), qpos_columns(model, handles)
    qpos = batch.bind("qpos")

    def roll() -> None:
        batch.reset()
        qpos[:, columns] = start
        batch.rollout(STEPS, control)

    return roll


def gripper_kinematics(options: Options) -> Iterator[Row]:
    """The gripper robot's kinematics and indices, in batches and alone."""
    poses = reachable(options.size(POSES))
    q, warm, count = inverse_kinematics(poses), poses + 1e-3, len(poses)
    batches: dict[str, tuple[Callable[[], object], int]] = {
        "inverse_kinematics": (partial(inverse_kinematics, poses), 7),
        "inverse_kinematics_strokes": (partial(inverse_kinematics, poses, strokes=True), 7),
        "forward_kinematics": (partial(forward_kinematics, q), 3),
        "forward_kinematics_warm": (partial(forward_kinematics, q, start=warm), 3),
        "conditioning": (partial(conditioning, poses), 7),
        "kappa": (partial(kappa, poses), 7),
        "jacobian": (partial(jacobian, poses), 7),
        "check_pose": (partial(check_pose, poses), 7),
    }
    yield Count(("poses",), float(count))
    for name, (call, repeats) in batches.items():
        yield Timing((f"{name}_poses_per_s",), call, "1/s", count, repeats)
    alone, alone_warm = partial(forward_kinematics, q[0]), partial(forward_kinematics, q[0], start=warm[0])
    yield Timing(("single_inverse_kinematics_us",), partial(inverse_kinematics, poses[0]), repeats=SINGLE)
    yield Timing(("single_forward_kinematics_us",), alone, repeats=SINGLE)
    yield Timing(("single_forward_kinematics_warm_us",), alone_warm, repeats=SINGLE)
    ends = [0, 0, -0.25, -0.8], [0, 0.05, -0.2, -0.8]
    yield Timing(("line_motion_ms",), partial(line, *ends), "ms", repeats=50)
    yield Timing(("workspace_scan_5_mm_ms",), scan_workspace, "ms", repeats=3)
    positions, hull = scan_workspace(PAPER_STEP).positions, ("tau_hull_101_angles_s",)
    yield Count(("tau_hull_positions",), float(len(positions)))
    yield Timing(hull, partial(tau_hull, positions), "s", repeats=3)
    yield Timing(("tau_hull_poses_per_s",), hull, "1/s", 101 * len(positions))


def reachable(count: int) -> Floats:
    """Poses of the reduced workspace at the angles the prototype grips with, fixed seed."""
    low, high = np.deg2rad(-60.0), np.deg2rad(-30.0)
    poses = np.random.default_rng(1).uniform([-0.16, -0.15, -0.28, low], [0.16, 0.15, -0.12, high], (6 * count, 4))
    return poses[np.isfinite(inverse_kinematics(poses, strokes=True)[:, 0])][:count]
