"""Closing of the gripper from -45 to -60 deg (section VI-B): limited by the motors' speed, and by their servos."""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.report.figures import svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.leveziel_cases import CENTRE, CLOSED, HOME_THETA, PAPER_STEP, posed, reduced
from agents.reproduce.leveziel_model import STEP, follow
from agents.reproduce.leveziel_motion_drawings import closing_figure
from pnt_gym.planning.arrays import Floats
from pnt_gym.robots.gripper4 import Profile, closing_time, forward_kinematics, inverse_kinematics
from pnt_gym.robots.gripper4.build import PROTOTYPE_BUILD, Build
from pnt_gym.robots.gripper4.references import MotorReferences, motor_references

PUBLISHED: Final = 0.060
"""The gripper closes within it [s]."""
SPAN: Final = 0.16
"""Simulated [s]."""
NEAR: Final = float(np.deg2rad(0.5))
"""The gripper is closed when it first comes this near to -60 deg [rad]."""
FACTORY_GAIN: Final = 13.8
"""Of the XM430-W210's position controller as delivered, P gain 800 and no D gain: 100 % of the voltage, and with it the
stall torque of 3 N m at 12 V, at an error of 12.5 deg [N m/rad]."""
ARMATURES: Final = (0.0025, 0.01)
"""Half and twice the assumed inertia of the motors [kg m2]."""


def closing_findings(step: float = PAPER_STEP) -> Findings:
    """Times by the speed of the motors alone, for a motion of 60 ms, and for servos told the closed angle at once."""
    home, closed = (posed(np.array(CENTRE), theta) for theta in (HOME_THETA, CLOSED))
    soft = PROTOTYPE_BUILD.with_servo(kp=FACTORY_GAIN, kv=1e-6)
    curves = {
        f"told to turn at 70 rpm, gain {PROTOTYPE_BUILD.servo.kp:g} N m/rad": _course(_ramp(home, closed)),
        "told from rest to rest in 60 ms": _course(_smooth(home, closed)),
        f"told at once, gain {PROTOTYPE_BUILD.servo.kp:g} N m/rad": _course(_jump(home, closed)),
        f"told at once, gain {FACTORY_GAIN:g} N m/rad": _course(_jump(home, closed, soft), soft),
    }
    others = [soft.with_servo(armature=value) for value in ARMATURES]
    spread = [arrival(_course(_jump(home, closed, build), build)) for build in others]
    rows = [*_speed_rows(step), *_servo_rows([arrival(curve) for curve in curves.values()], spread)]
    drawn = {"70 rpm at once, closed form": _full_speed(home, closed)[:, 3], **curves}
    figures = {"leveziel_closing.svg": svg(closing_figure(STEP, drawn, PUBLISHED))}
    return Findings(tuple(rows), {}, figures)


def arrival(theta: Floats) -> float:
    """When theta (S,) first comes near to the closed angle [s]."""
    near = theta <= CLOSED + NEAR
    return STEP * float(near.argmax() + 1) if near.any() else float("nan")


def _course(references: MotorReferences, build: Build = PROTOTYPE_BUILD) -> Floats:
    """Angle of the halves (S,) after every step, from home."""
    home = posed(np.array([CENTRE]), HOME_THETA)
    told = MotorReferences(references.angle[None], references.speed[None], references.torque[None])
    return follow(home, told, build).pose[0, :, 3]


def _steps() -> Floats:
    return STEP * np.arange(round(SPAN / STEP), dtype=np.float64)


def _ramp(home: Floats, closed: Floats) -> MotorReferences:
    """Motors at 70 rpm from the first moment to the last, which no servo can follow."""
    return motor_references(_full_speed(home, closed), STEP)


def _full_speed(home: Floats, closed: Floats) -> Floats:
    """Poses (S, 4) while the motors turn at 70 rpm."""
    first, last = inverse_kinematics(np.stack([home, closed]))
    share = np.clip(_steps() / float(closing_time(CENTRE)), 0.0, 1.0)[:, None]
    return forward_kinematics(first + share * (last - first))


def _smooth(home: Floats, closed: Floats) -> MotorReferences:
    """Half of the published time to speed up, half to slow down."""
    share = Profile("trapezoid", 0.5).sample(np.minimum(_steps() / PUBLISHED, 1.0))[0][:, None]
    return motor_references(home + share * (closed - home), STEP)


def _jump(home: Floats, closed: Floats, build: Build = PROTOTYPE_BUILD) -> MotorReferences:
    """The closed angle at once; weights are borne by the torque fed forward."""
    steps = _steps().size
    torque = motor_references(np.tile(home, (steps, 1)), STEP, build=build).torque
    angle = np.tile(inverse_kinematics(closed), (steps, 1))
    return MotorReferences(angle, np.zeros_like(angle), torque)


def _speed_rows(step: float) -> list[Row]:
    seconds = closing_time(reduced(step).positions)
    centre = float(closing_time(CENTRE))
    home, closed = (inverse_kinematics(posed(np.array(CENTRE), theta)) for theta in (HOME_THETA, CLOSED))
    travel = float(np.rad2deg(np.abs(closed - home)).max())
    needed = 4.0 * travel / PUBLISHED**2
    return [
        Row(
            "leveziel/closing/speed-limited",
            "< 0.06 s",
            centre,
            "s",
            "reproduced",
            f"from -45 to -60 deg at x = y = 0, z = -200 mm, {travel:.2f} deg of motor at 70 rpm all the way; "
            f"{1e3 * np.nanmin(seconds):.0f} to {1e3 * np.nanmax(seconds):.0f} ms over the reduced workspace, so the "
            "speed does not explain 60 ms",
            {"smallest": float(np.nanmin(seconds)), "largest": float(np.nanmax(seconds)), "travel_deg": travel},
        ),
        Row(
            "leveziel/closing/acceleration-for-60-ms",
            None,
            needed,
            "deg/s2",
            "ours",
            "of the motors, speeding up for half of 60 ms and braking for the other half, at the same place",
        ),
    ]


def _servo_rows(times: list[float], spread: list[float]) -> list[Row]:
    ramp, smooth, stiff, factory = times
    low, high = (1e3 * value for value in spread)
    end = f"first within 0.5 deg of -60 deg in MuJoCo, steps of {1e3 * STEP:g} ms"
    return [
        Row(
            "leveziel/closing/servo-limited",
            "< 0.06 s",
            stiff,
            "s",
            "reproduced" if stiff < PUBLISHED else "differs",
            f"motors told the closed angle at once, up to 3 N m, gain {PROTOTYPE_BUILD.servo.kp:g} N m/rad; {end}, "
            f"{1e3 * ramp:.1f} ms if told to turn at 70 rpm, {1e3 * smooth:.1f} ms if told the motion of 60 ms",
            {"ramp": ramp, "smooth": smooth},
        ),
        Row(
            "leveziel/closing/servo-limited-factory-gain",
            "< 0.06 s",
            factory,
            "s",
            "reproduced" if factory < PUBLISHED else "differs",
            f"the same with the gain that the servos are delivered with, {FACTORY_GAIN:g} N m/rad: next to the "
            f"published time; {low:.0f} and {high:.0f} ms with half and twice the assumed inertia of the motors; {end}",
            {"armatures": dict(zip((f"{a:g}" for a in ARMATURES), spread, strict=True))},
        ),
    ]


PARTS = (Part("closing", closing_findings),)
