"""The timed paths carried out by the closed-chain robot in MuJoCo."""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.reproduce.choe_cases import Case, long_cases, motion
from agents.reproduce.findings import Findings, Part, Row
from pnt_gym.engine import Batch, mujoco
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.trajectory import HandPath, Samples
from pnt_gym.robots.specification import set_options
from pnt_gym.robots.t3kr.geometry import T3KR
from pnt_gym.robots.t3kr.model import add_t3kr
from pnt_gym.robots.t3kr.pose import closed_pose, control_columns, qpos_columns
from pnt_gym.robots.t3kr.reference import joint_references

TIMESTEP: Final = 0.0004
"""Step of the engine [s]."""
SETTLE: Final = 0.1
"""How long the hand is watched after the motion [s]."""
PLAYED: Final = ("rectangle", "ellipse-50mm-strict", "ellipse-50mm-relaxed", "lame-50mm-level")


def simulated_findings() -> Findings:
    """Tracking and torque of four motions over the long way."""
    cases = [case for case in long_cases() if case.name in PLAYED]
    errors, torques = play([motion(case) for case in cases])
    rows = [
        row for case, error, torque in zip(cases, errors, torques, strict=True) for row in _rows(case, error, torque)
    ]
    return Findings(tuple(rows))


def _rows(case: Case, error: Floats, torque: float) -> list[Row]:
    rule = "continuous acceleration" if case.joints == "strict" else "acceleration steps at the tangent points"
    name = f"choe/simulated/{case.name}"
    note = f"{case.label}, {rule}, motors with feed-forward, robot without an object"
    end = f"largest distance of the hand from its reference; {1e6 * float(error[-1]):.2f} micrometres in the end"
    return [
        Row(f"{name}/tracking", None, float(error.max()), "m", "ours", f"{note}: {end}"),
        Row(
            f"{name}/torque", None, torque, "N m", "ours", f"{note}: largest of a motor, {T3KR.torque_limit:g} allowed"
        ),
    ]


def play(paths: list[HandPath]) -> tuple[Floats, Floats]:
    """Carry out motions of one row each, side by side.

    Returns:
        Distance of the hand from its reference (N, steps) [m] and the largest motor torque (N,) [N m].
    """
    spec = mujoco.MjSpec()
    handles = add_t3kr(spec)
    set_options(spec, TIMESTEP)
    model = spec.compile()
    steps = int(np.ceil((max(float(path.duration[0]) for path in paths) + SETTLE) / TIMESTEP))
    times = TIMESTEP * np.arange(steps + 1)
    wanted = Samples(
        *(np.concatenate(columns) for columns in zip(*(path.sample(times) for path in paths), strict=True))
    )
    control = np.ones((len(paths), steps, model.nu + model.neq))
    control[:, :, control_columns(model, handles)] = joint_references(*(part[:, :-1] for part in wanted))
    batch = Batch(model, len(paths), nthread=1)
    batch.bind("qpos")[:, qpos_columns(model, handles)] = closed_pose(wanted.position[:, 0], handles)
    state = mujoco.mjtState.mjSTATE_CTRL.value | mujoco.mjtState.mjSTATE_EQ_ACTIVE.value
    out = batch.rollout(steps, control, state, record=("qpos", "actuator_force"))
    columns = [int(model.joint(f"platform_{axis}").qposadr[0]) for axis in "xyz"]
    hand = np.asarray(out["qpos"])[:, :, columns]
    error = np.linalg.norm(hand - wanted.position[:, 1:], axis=2)
    return error, np.abs(np.asarray(out["actuator_force"])).max(axis=(1, 2))


PARTS = (Part("simulated", simulated_findings),)
