"""The timed paths carried out by the closed-chain robot in MuJoCo."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Floats, joined
from pnt_gym.cells.base.plant import staged_rollout
from pnt_gym.engine import Batch, mujoco
from pnt_gym.planning.motion.trajectory import HandPath
from pnt_gym.robots.specification import set_options
from pnt_gym.robots.t3kr.geometry import T3KR
from pnt_gym.robots.t3kr.kinematics import closed_pose
from pnt_gym.robots.t3kr.model import add_t3kr, control_columns, qpos_columns
from pnt_gym.robots.t3kr.references import exact_references, joint_knots

from ...ground.tables import Grid
from ..finding import Findings, Row
from .cases import long_cases, motion

TIMESTEP: Final = 0.0004
"""Step of the engine [s]."""
SETTLE: Final = 0.1
"""How long the hand is watched after the motion [s]."""
PLAYED: Final = ("rectangle", "ellipse-50mm-strict", "ellipse-50mm-relaxed", "lame-50mm-level")


def simulated_findings() -> Findings:
    """Tracking and torque of four motions over the long way."""
    cases = [long_cases()[name] for name in PLAYED]
    errors, torques = play([motion(case) for case in cases])
    rows: list[Row] = []
    lines: list[list[str]] = []
    for case, error, torque in zip(cases, errors, torques, strict=True):
        most, last = float(error.max()), f"{1e6 * float(error[-1]):.2f} micrometres"
        rule = "continuous acceleration" if case.joints == "strict" else "acceleration steps at the tangent points"
        name = f"choe/simulated/{case.name}"
        note = f"{case.label}, {rule}, motors with feed-forward, robot without an object"
        end = f"largest distance of the hand from its reference; {last} in the end"
        limit = f"largest of a motor, {T3KR.torque_limit:g} allowed"
        rows.append(Row.ours(f"{name}/tracking", most, "m", note=f"{note}: {end}"))
        rows.append(Row.ours(f"{name}/torque", torque, "N m", note=f"{note}: {limit}"))
        lines.append([case.name.replace("-", " "), f"{most:.5f} m", last, f"{torque:.0f} N m"])
    header = ("path", "tracking", "in the end", f"torque, {T3KR.torque_limit:g} N m allowed")
    return Findings(tuple(rows), grids=(Grid("The motions carried out by the robot in MuJoCo", header, lines),))


def play(paths: list[HandPath]) -> tuple[Floats, Floats]:
    """Carry out motions of one row each, side by side.

    Returns:
        Distance of the hand from its reference (N, steps) [m] and the largest motor torque (N,) [N m].

    Raises:
        PhysicsError: the engine warned.
    """
    spec = mujoco.MjSpec()
    handles = add_t3kr(spec)
    set_options(spec, TIMESTEP)
    model = spec.compile()
    steps = int(np.ceil((max(float(path.duration[0]) for path in paths) + SETTLE) / TIMESTEP))
    times = TIMESTEP * np.arange(steps + 1)
    wanted = joined([path.sample(times) for path in paths])
    control = np.ones((len(paths), steps, model.nu + model.neq))
    knots = joint_knots(*(part[:, :-1] for part in wanted))
    control[:, :, control_columns(model, handles)] = exact_references(knots)
    batch = Batch(model, len(paths), nthread=1)
    batch.bind("qpos")[:, qpos_columns(model, handles)] = closed_pose(
        wanted.position[:, 0], handles.rods_per_arm, handles.geometry
    )
    out = staged_rollout(batch, control, np.full(len(paths), steps), ("qpos", "actuator_force"))
    columns = [int(model.joint(f"platform_{axis}").qposadr[0]) for axis in "xyz"]
    error = np.linalg.norm(out["qpos"][:, :, columns] - wanted.position[:, 1:], axis=2)
    return error, np.abs(out["actuator_force"]).max(axis=(1, 2))
