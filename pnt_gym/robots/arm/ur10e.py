"""A six-axis arm of the class of the Universal Robots UR10e, from numbers that its maker publishes.

Lengths, masses and centres of mass: Universal Robots, "DH parameters for calculations of kinematics and dynamics",
UR10e. Ranges, speeds and torques of the joints: the maker's description for ROS (`ur10e/joint_limits.yaml`), after the
user manual 5.8 and "Max. joint torques". **Assumed by us:** the centre of the last link, inertias (cylinders of the
links' lengths), the motors' inertia at the joints, radii, and gains.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Point
from pnt_gym.engine import MjSpec, mujoco
from pnt_gym.palette import ACCENT, MOTOR, PAINT, STEEL
from pnt_gym.robots.brush import Brush
from pnt_gym.robots.specification import add_motor, add_site

HOME: Final = (-1.5708, -1.2, 1.8, -2.1708, -1.5708, 0.0)
"""Pose with the tool straight down in front of the base [rad]."""
STIFFNESS: Final = 120.0
"""Natural frequency of the motors' position control at their own inertia, critically damped [rad/s]; assumed."""


@final
@dataclass(frozen=True)
class Axis:
    """A row of the table of Denavit and Hartenberg (standard form), with its link and its motor."""

    name: str
    along: float
    """a [m]."""
    offset: float
    """d [m]."""
    twist: float
    """alpha, in right angles."""
    mass: float
    """[kg]."""
    centre: Point
    """Centre of mass in the frame behind the joint [m]."""
    torque: float
    """Largest torque of the motor [N m]."""
    range: float
    """Largest angle to both sides [rad]."""
    armature: float
    """Inertia of the motor at the joint; assumed [kg m2]."""
    radius: float
    """Of the link as a cylinder; assumed [m]."""


AXES: Final = (
    Axis("shoulder_pan", 0.0, 0.1807, 1, 7.369, (0.021, 0.0, 0.027), 330.0, 2 * np.pi, 1.0, 0.075),
    Axis("shoulder_lift", -0.6127, 0.0, 0, 13.051, (0.38, 0.0, 0.158), 330.0, 2 * np.pi, 1.0, 0.075),
    Axis("elbow", -0.57155, 0.0, 0, 3.989, (0.24, 0.0, 0.068), 150.0, np.pi, 0.5, 0.06),
    Axis("wrist_1", 0.0, 0.17415, 1, 2.1, (0.0, 0.007, 0.018), 56.0, 2 * np.pi, 0.1, 0.05),
    Axis("wrist_2", 0.0, 0.11985, -1, 1.98, (0.0, 0.007, 0.018), 56.0, 2 * np.pi, 0.1, 0.05),
    Axis("wrist_3", 0.0, 0.11655, 0, 0.615, (0.0, 0.0, -0.026), 56.0, 2 * np.pi, 0.1, 0.045),
)  # fmt: skip
SPEED: Final = tuple(np.radians([120.0, 120.0, 180.0, 180.0, 180.0, 180.0]).tolist())
"""Largest speeds of the joints [rad/s]."""
BESIDE: Final = (0.0, 0.176, 0.04, 0.0, 0.0, 0.0)
"""Distance of the drawn links from the table's lines, along the joints' axes [m]."""


def add_ur10e(spec: MjSpec) -> tuple[str, ...]:
    """Add the arm to a model specification, with the site "tool" at its flange; return the joints' names."""
    spec.compiler.degree = False
    body, turn = spec.worldbody.add_body(name="base"), np.array([1.0, 0.0, 0.0, 0.0])
    Brush(body).cylinder((0.0, 0.0, 0.0), (0.0, 0.0, 0.05), 0.095, STEEL)
    place: Point = (0.0, 0.0, 0.0)
    for axis, beside in zip(AXES, BESIDE, strict=True):
        body = body.add_body(name=axis.name, pos=place, quat=turn)
        body.add_joint(
            name=axis.name, axis=[0, 0, 1], armature=axis.armature, range=[-axis.range, axis.range],
            limited=mujoco.mjtLimited.mjLIMITED_TRUE,
        )  # fmt: skip
        half = axis.twist * np.pi / 4.0
        place, turn = (axis.along, 0.0, axis.offset), np.array([np.cos(half), np.sin(half), 0.0, 0.0])
        _set_mass(body, axis, turn)
        _draw(Brush(body), axis, beside)
        own = axis.armature + axis.mass * max(abs(axis.along), 0.1) ** 2
        add_motor(spec, axis.name, axis.name, axis.torque, own * STIFFNESS**2, 2.0 * own * STIFFNESS)
    tool = body.add_body(name="flange", pos=place, quat=turn)
    add_site(tool, "tool")
    return tuple(axis.name for axis in AXES)


def _set_mass(body: MjSpec, axis: Axis, turn: np.ndarray) -> None:
    """Set mass, centre and inertia of a link; the inertia is that of a cylinder along the link."""
    centre = np.zeros(3)
    mujoco.mju_rotVecQuat(centre, np.asarray(axis.centre, dtype=np.float64), turn)
    body.explicitinertial = True
    body.mass, body.ipos = axis.mass, centre + np.array([axis.along, 0.0, axis.offset])
    length = max(abs(axis.along), abs(axis.offset), 2.0 * axis.radius)
    slim, across = axis.mass * axis.radius**2 / 2.0, axis.mass * (3.0 * axis.radius**2 + length**2) / 12.0
    body.inertia = np.array([slim, across, across] if axis.along else [across, across, slim])


def _draw(brush: Brush, axis: Axis, beside: float) -> None:
    """Draw a link: its joint, and the tube to the next joint."""
    tube = axis.radius * 0.8
    brush.cylinder((0.0, 0.0, -0.05), (0.0, 0.0, max(beside, 0.05)), axis.radius, MOTOR if beside else PAINT)
    end = (axis.along, 0.0, axis.offset + beside)
    if abs(axis.along) + abs(axis.offset) > 0.0:
        brush.capsule((0.0, 0.0, beside), end, tube, PAINT if axis.along or axis.offset > 0.15 else ACCENT)
