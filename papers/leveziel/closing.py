"""Closing of the gripper from -45 to -60 deg (section VI-B): limits by the motors' speed and by their servos."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats, take
from pnt_gym.robots.gripper import forward_kinematics, inverse_kinematics
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD, Build
from pnt_gym.robots.gripper.references import MotorReferences, motor_references

from .cases import CENTRE, CLOSED, HOME_THETA, PAPER_STEP, STEP, follow, is_reachable, poses_at, reduced
from .motion import Profile, closing_time

PUBLISHED: Final = 0.060
"""Published time within which the gripper closes [s]."""
BOUND: Final = f"< {PUBLISHED:g} s"
OPENED, SHUT = (poses_at(np.array(CENTRE), theta) for theta in (HOME_THETA, CLOSED))
"""Poses before and after the closing."""
TIMES: Final[Floats] = STEP * np.arange(round(0.16 / STEP), dtype=np.float64)
"""Simulated times [s]."""
NEAR: Final = float(np.deg2rad(0.5))
"""Distance from -60 deg at which the gripper counts as closed [rad]."""
FACTORY_GAIN: Final = 13.8
"""Gain of the XM430-W210's position controller as delivered [N m/rad]: P gain 800 and no D gain, so 100 % of the
voltage, and with it the stall torque of 3 N m at 12 V, at an error of 12.5 deg."""
ARMATURES: Final = (0.0025, 0.01)
"""Inertia of the motors at which the closing is repeated [kg m2]: half and twice the assumed inertia."""


def closing_findings(step: float = PAPER_STEP) -> Findings:
    """Closing times by motor speed alone, for a command of 60 ms, and for a step command of the closed angle."""
    soft, ours = PROTOTYPE_BUILD.with_servo(kp=FACTORY_GAIN, kv=1e-6), f"gain {PROTOTYPE_BUILD.servo.kp:g} N m/rad"
    full_speed = _full_speed_poses()
    # Half of the published time to speed up, half to slow down.
    share = Profile("trapezoid", 0.5).sample(np.minimum(TIMES / PUBLISHED, 1.0))[0][:, None]
    curves = {
        f"told to turn at 70 rpm, {ours}": _closing_angle(motor_references(full_speed, STEP)),
        "told from rest to rest in 60 ms": _closing_angle(motor_references(OPENED + share * (SHUT - OPENED), STEP)),
        f"told at once, {ours}": _step_response(PROTOTYPE_BUILD),
        f"told at once, gain {FACTORY_GAIN:g} N m/rad": _step_response(soft),
    }
    spread = [arrival(_step_response(soft.with_servo(armature=value))) for value in ARMATURES]
    rows = (*_speed_rows(step), *_servo_rows([arrival(curve) for curve in curves.values()], spread))
    drawn = closing_figure({"70 rpm at once, closed form": full_speed[:, 3], **curves})
    return table_findings("The closing of the gripper", rows, {"leveziel_closing.svg": drawn}, drop="leveziel/")


def arrival(theta: Floats) -> float:
    """First time [s] at which theta (S,) is near the closed angle; NaN if never."""
    near = theta <= CLOSED + NEAR
    return STEP * float(near.argmax() + 1) if near.any() else float("nan")


def _closing_angle(references: MotorReferences, build: Build = PROTOTYPE_BUILD) -> Floats:
    """Simulated angle of the halves (S,) [rad] after every step."""
    return follow(OPENED[None], take(references, None), build).pose[0, :, 3]


def _full_speed_poses() -> Floats:
    """Poses (S, 4) for motors that turn at 70 rpm without acceleration, which no servo can follow."""
    first, last = inverse_kinematics(np.stack([OPENED, SHUT]))
    share = np.clip(TIMES / float(closing_time(CENTRE)), 0.0, 1.0)[:, None]
    return forward_kinematics(first + share * (last - first))


def _step_response(build: Build) -> Floats:
    """Angle of the halves (S,) [rad] after a step command of the closed angle; torque feed-forward bears the weight."""
    torque = motor_references(np.tile(OPENED, (TIMES.size, 1)), STEP, build=build).torque
    angle = np.tile(inverse_kinematics(SHUT), (TIMES.size, 1))
    return _closing_angle(MotorReferences(angle, np.zeros_like(angle), torque), build)


def _speed_rows(step: float) -> Iterator[Row]:
    positions = reduced(step).positions
    seconds = closing_time(positions)
    within = seconds[is_reachable(poses_at(positions, CLOSED))]
    centre = float(closing_time(CENTRE))
    travel = float(np.rad2deg(np.abs(inverse_kinematics(SHUT) - inverse_kinematics(OPENED))).max())
    low, high, beyond = float(within.min()), float(within.max()), float(np.nanmax(seconds))
    yield Row.compared(
        "leveziel/closing/speed-limited",
        BOUND,
        centre,
        "s",
        holds=centre < PUBLISHED,
        note=f"from -45 to -60 deg at x = y = 0, z = -200 mm, {travel:.2f} deg of motor at 70 rpm all the way; "
        f"{1e3 * low:.1f} to {1e3 * high:.1f} ms over the reduced workspace, at the {within.size:,} of "
        f"{len(positions):,} positions whose closed pose keeps the motors' strokes (up to {1e3 * beyond:.0f} ms at the "
        "others), so the speed does not explain 60 ms",
        smallest=low,
        largest=high,
        largest_beyond_the_strokes=beyond,
        travel_deg=travel,
    )
    note = "of the motors, speeding up for half of 60 ms and braking for the other half, at the same place"
    yield Row.ours("leveziel/closing/acceleration-for-60-ms", 4.0 * travel / PUBLISHED**2, "deg/s2", note=note)


def _servo_rows(times: list[float], spread: list[float]) -> Iterator[Row]:
    """Rows with the closing time by the servos, whose gains and inertia are assumed here."""
    ramp, smooth, stiff, factory = times
    low, high = (1e3 * value for value in spread)
    end = f"first within 0.5 deg of -60 deg in MuJoCo, steps of {1e3 * STEP:g} ms"
    note = (
        f"motors told the closed angle at once, our gain of {PROTOTYPE_BUILD.servo.kp:g} N m/rad; {end}, "
        f"{1e3 * ramp:.1f} ms if told to turn at 70 rpm, {1e3 * smooth:.1f} ms if told that of 60 ms"
    )
    yield Row.ours("leveziel/closing/servo-limited", stiff, "s", beside=BOUND, note=note, ramp=ramp, smooth=smooth)
    yield Row.ours(
        "leveziel/closing/servo-limited-factory-gain",
        factory,
        "s",
        beside=BOUND,
        note=f"the same with the gain that the servos are delivered with, {FACTORY_GAIN:g} N m/rad: next to the "
        f"published time; {low:.0f} and {high:.0f} ms with half and twice the assumed inertia of the motors; {end}",
        armatures=dict(zip((f"{a:g}" for a in ARMATURES), spread, strict=True)),
    )


def closing_figure(curves: Mapping[str, Floats]) -> Figure:
    """Drawing of the halves' angle over time for different closing commands."""
    figure, (axes,) = subplots(1, 1, (WIDTH, 4.4))
    for colour, (name, theta) in zip(("gray", *COLOURS), curves.items(), strict=False):
        axes.plot(1e3 * STEP * np.arange(1, theta.size + 1), np.rad2deg(theta), color=colour, label=name)
    axes.axvline(1e3 * PUBLISHED, color="black", linestyle="--", linewidth=0.9, label="published, 60 ms")
    axes.axhline(-60.0, color="black", linestyle=":", linewidth=0.8)
    title = "closing at x = y = 0, z = -200 mm, in MuJoCo"
    dress(axes, "time [ms]", "angle of the platform's halves θ [°]", title, legend="best", xlim=(0.0, 120.0))
    return figure
