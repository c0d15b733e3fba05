"""Time per sample of the T3KR's motor references, and per physics step of both of its models.

Run: python benchmarks/bench_robot.py
"""

from __future__ import annotations

import time
from collections.abc import Callable

import mujoco
import numpy as np
from mujoco.batch import Batch

from pnt_gym.robots.specification import set_options
from pnt_gym.robots.t3kr.kinematics import closed_pose
from pnt_gym.robots.t3kr.model import Rods, add_t3kr, control_columns, qpos_columns
from pnt_gym.robots.t3kr.references import exact_references, joint_knots, knot_count, upsample

ROWS, STEPS = 64, 1000


def best(action: Callable[[], object], repeats: int = 7) -> float:
    """Shortest of several runs, s: the one that other processes disturbed least."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return min(times)


def circles(rows: int, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration of the hand on tilted circles, (rows, times, 3), about 2 g."""
    radius, rate = np.linspace(0.10, 0.15, rows)[:, None], 12.0
    cos, sin = radius * np.cos(rate * times), radius * np.sin(rate * times)
    centre = np.array([0.0, -0.2, -0.6])
    return (
        np.stack([cos, sin, 0.5 * sin], axis=-1) + centre,
        rate * np.stack([-sin, cos, 0.5 * cos], axis=-1),
        rate**2 * np.stack([-cos, -sin, -0.5 * sin], axis=-1),
    )


def bench_references(timestep: float, stride: int) -> None:
    knots = knot_count(STEPS, stride)
    motion = circles(ROWS, np.arange(knots) * timestep * stride)
    out = np.ones((ROWS, STEPS, 17))
    solved = joint_knots(*motion, 0.02)
    spacing, samples = timestep * stride, ROWS * STEPS
    at_knots = best(lambda: joint_knots(*motion, 0.02)) / (ROWS * knots)
    fine = best(lambda: upsample(solved, spacing, stride, out)) / samples
    total = best(lambda: upsample(joint_knots(*motion, 0.02), spacing, stride, out)) / samples
    print(
        f"references {timestep * 1e3:.1f} ms, knots every {spacing * 1e3:.1f} ms: "
        f"{total * 1e6:.3f} us/sample (solve {at_knots * 1e6:.3f} us/knot, sample {fine * 1e6:.3f} us)"
    )


def bench_exact() -> None:
    motion = circles(ROWS, np.arange(STEPS) * 1e-3)
    each = best(lambda: exact_references(joint_knots(*motion, 0.02)), 3) / (ROWS * STEPS)
    print(f"references without interpolation: {each * 1e6:.3f} us/sample")


def bench_model(rods: Rods, timestep: float) -> None:
    spec = mujoco.MjSpec()
    handles = add_t3kr(spec, rods=rods)
    set_options(spec, timestep)
    model = spec.compile()
    motion = circles(2, np.arange(STEPS) * timestep)
    control = np.zeros((2, STEPS, model.nu))
    control[..., control_columns(model, handles)] = exact_references(joint_knots(*motion))
    batch = Batch(model, 2, nthread=1)
    qpos = batch.bind("qpos")

    def roll() -> None:
        batch.reset()
        qpos[:, qpos_columns(model, handles)] = closed_pose(motion[0][:, 0], handles.rods_per_arm, handles.geometry)
        batch.rollout(STEPS, control)

    print(f"{rods} rods, {timestep * 1e3:.1f} ms: {best(roll, 3) / (2 * STEPS) * 1e6:.2f} us/step, one thread")


def main() -> None:
    bench_references(1e-3, 4)
    bench_references(4e-4, 10)
    bench_exact()
    for rods in ("four", "eight"):
        for timestep in (4e-4, 1e-3):
            bench_model(rods, timestep)


if __name__ == "__main__":
    main()
