"""A serial arm in a MuJoCo model specification, made anew from the numbers of its model file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.engine import MjData, MjModel, MjsBody, MjSpec, mujoco
from pnt_gym.palette import STEEL
from pnt_gym.robots.arm.chain import Chain, add_mass
from pnt_gym.robots.arm.poses import Poses
from pnt_gym.robots.arm.shapes import draw
from pnt_gym.robots.brush import Brush
from pnt_gym.robots.joints import JointMotion, MotorLimits, Place
from pnt_gym.robots.specification import add_motor, add_site

STIFFNESS: Final = 80.0
"""Natural frequency of the motors' position control, critically damped [rad/s].

Feed-forward torques carry the motion, so softer motors follow it as well. A tilted object that presses on the belt at
its lift pushes the hand aside; at 120 rad/s a joint sprang back at 103 % of its speed once in 10,000 throws."""
STEM_RADIUS: Final = 0.012
"""Radius of the drawn stem between the tool and the cup [m]."""


@final
@dataclass(frozen=True, eq=False)
class SerialArm:
    """Kinematics and dynamics of an arm, and the names of the elements that `add_serial_arm` added."""

    branch: Poses
    mount: Place
    """Place of the arm's base [m]."""
    joints: tuple[str, ...]
    """Joints from the base to the hand; each has a motor."""
    actuators: tuple[str, ...]
    """Motors; each motor takes three consecutive controls: position, velocity, feed-forward torque."""
    platform: str = "platform"
    """Body whose origin is the tip of the cup, and whose z axis points up."""
    tcp: str = "tcp"
    """Site at the tip of the cup."""

    @classmethod
    def of(cls, poses: Poses, mount: Place) -> Self:
        """The arm with the names that `add_serial_arm` gives."""
        count = range(len(poses.chain.links))
        return cls(poses, mount, tuple(f"joint_{k}" for k in count), tuple(f"motor_{k}" for k in count))

    @property
    def motor_joints(self) -> tuple[str, ...]:
        """Joints that the motors drive."""
        return self.joints

    @property
    def limits(self) -> MotorLimits:
        """Limits of the motors."""
        return self.branch.chain.limits

    def with_prefix(self, prefix: str) -> Self:
        """The names of the elements after the specification is attached to another one with a prefix."""
        lists = {name: tuple(prefix + entry for entry in getattr(self, name)) for name in ("joints", "actuators")}
        return replace(self, platform=prefix + self.platform, tcp=prefix + self.tcp, **lists)

    def pose(self, hand: ArrayLike) -> Floats:
        """Joint positions (N, n) with the hand at points (N, 3) [m]; NaN out of reach."""
        return self.branch.at(np.asarray(hand, dtype=np.float64))

    def rates(self, hand: ArrayLike, velocity: ArrayLike) -> Floats:
        """Joint velocities (N, n) while the hand at points (N, 3) [m] moves with velocities (N, 3) [m/s]."""
        place, speed = np.asarray(hand, dtype=np.float64), np.asarray(velocity, dtype=np.float64)
        return self.motion(place, speed, np.zeros_like(place)).velocity.T

    def motion(self, position: Floats, velocity: Floats, acceleration: Floats) -> JointMotion:
        """Motion and torques of the motors, each (n, ...), for the hand's motion (..., 3), without its object."""
        hand = np.concatenate([position, velocity, acceleration], axis=-1)
        values = self.branch.motion(hand.reshape(-1, 9))
        return JointMotion(*values.reshape(4, len(self.joints), *hand.shape[:-1]))

    def holding(self, mass: float) -> Self:
        """The arm with a mass at the tip of its cup [kg]."""
        chain, tool = self.branch.chain, self.branch.tool
        links = chain.links.copy()
        add_mass(links, len(links) - 1, tool["offset"][0], mass)
        return replace(self, branch=replace(self.branch, chain=replace(chain, links=links)))


def add_serial_arm(spec: MjSpec, arm: SerialArm) -> SerialArm:
    """Add the arm to a model specification and return its names."""
    chain, tool = arm.branch.chain, arm.branch.tool
    bodies = _add_links(spec, chain, arm)
    hand = bodies[-1].add_body(name="platform", pos=tool["offset"][0], quat=_quaternion(tool["turn"][0]))
    add_site(hand, "tcp")
    gains = _gains(arm)
    for k, (motor, joint) in enumerate(zip(arm.actuators, arm.joints, strict=True)):
        add_motor(spec, motor, joint, float(chain.limits.torque[k]), *gains[k])
    draw(spec, bodies, spec.worldbody, chain.shapes)
    if float(np.linalg.norm(tool["offset"][0] - chain.flange)) > STEM_RADIUS:
        Brush(bodies[-1]).cylinder(chain.flange, tool["offset"][0], STEM_RADIUS, STEEL)
    return arm


def _add_links(spec: MjSpec, chain: Chain, arm: SerialArm) -> list[MjsBody]:
    """Add the bodies that the joints move (n,); joints without a mass between them move one and the same."""
    bodies, parent, first = list[MjsBody](), spec.worldbody, 0
    for k in range(len(arm.joints)):
        link = chain.links[k]
        if float(link["mass"]) == 0.0:
            continue
        before = np.cumsum(chain.links["offset"][first : k + 1], axis=0)
        parent = parent.add_body(name=f"link_{k}", pos=before[-1])
        for joint, place in zip(range(first, k + 1), before - before[-1], strict=True):
            _add_joint(parent, arm.joints[joint], chain.links[joint], place)
            bodies.append(parent)
        _set_inertia(parent, float(link["mass"]), link["centre"], link["inertia"].reshape(3, 3))
        first = k + 1
    return bodies


def _add_joint(body: MjsBody, name: str, link: Any, place: Floats) -> None:
    """Add the joint of a link at a place of a body's frame (3,) [m]."""
    kinds = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
    damping = np.array([link["damping"], 0.0, 0.0])
    kind = kinds[int(link["slides"])]
    body.add_joint(name=name, type=kind, pos=place, axis=link["axis"], armature=link["armature"], damping=damping)


def _set_inertia(body: MjsBody, mass: float, centre: Floats, tensor: Floats) -> None:
    """Set mass, centre and inertia of a body, the latter by its principal axes."""
    moments, axes = np.linalg.eigh(tensor)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    body.explicitinertial = True
    body.mass, body.ipos, body.inertia, body.iquat = mass, centre, moments, _quaternion(axes.ravel())


def _quaternion(matrix: Floats) -> Floats:
    """Quaternion of a rotation (9,)."""
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(matrix))
    return quat


def _gains(arm: SerialArm) -> Sequence[tuple[float, float]]:
    """Stiffness and damping of each motor, by the inertia that it moves at home."""
    chain = arm.branch.chain
    model, data = _alone(arm)
    data.qpos[:] = chain.home
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    own = np.diag(inertia)
    return [(float(value * STIFFNESS**2), float(2.0 * value * STIFFNESS)) for value in own]


def _alone(arm: SerialArm) -> tuple[MjModel, MjData]:
    """The arm alone, without motors."""
    spec = mujoco.MjSpec()
    _add_links(spec, arm.branch.chain, arm)
    model = spec.compile()
    return model, mujoco.MjData(model)
