"""The one-joint thrower in a MuJoCo model specification.

The plane of the throw is the world's x and z; the paper's y is the world's z. The arm is a plate on a hinge about the
world's -y through the origin, so that angles count anticlockwise with x to the right and z up, and its upper surface
passes through the pivot. A thrown part is a body with two slides and a hinge about -y: its angle is never wrapped.

Of the actuator's limits (Eqs. 8-10) the engine keeps the torque bound tau_max on the whole motor torque, position and
speed feedback and feed-forward together. The plan keeps the two other limits: the bound that falls with speed beyond
the knee of the torque-speed curve, and the largest speed. Saturation of the simulated motor shows in its torque.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.engine import MjsBody, MjSpec, mujoco
from pnt_gym.palette import ACCENT
from pnt_gym.planning.one_joint.parameters import Arm
from pnt_gym.robots.one_joint.visuals import dress_arm, dress_stand
from pnt_gym.robots.specification import add_motor, add_site, join_angles, join_sites, set_inertia

GRIP_SOLREF: Final = (0.002, 1.0)
"""Time constant [s] and damping ratio of the grip: two steps of 1 ms, the stiffest that MuJoCo allows there."""
GRIP_SOLIMP: Final = (0.999, 0.9999, 0.001, 0.5, 2.0)
"""Impedance of the grip: nearly rigid from the first micrometre on."""
STOPPER_HEIGHT: Final = 0.002
"""Height of the two stoppers that keep the object from sliding (Miyashita et al., section 6) [m]."""
STOPPER_WIDTH: Final = 0.004
"""Width of a stopper along the arm [m]; without effect as long as the object does not pass over the stopper."""
STOPPER_GAP: Final = 5e-5
"""Clearance between a stopper and the object, so that laying the object down is not a collision [m]."""
SURFACE_FRICTION: Final = 0.4
"""Friction coefficient of wood on aluminium, assumed."""
PART_BIT: Final = 1
"""Contact bit of thrown parts and of all bodies that catch thrown parts."""
ARM_BIT: Final = 2
"""Contact bit of the arm, for parts that lie on the arm."""

_CONTACT_SOLREF = (0.002, 1.0)
_CONTACT_SOLIMP = (0.99, 0.999, 0.0001, 0.5, 2.0)
_LONG_AXIS_INERTIA = 0.0025
"""Inertia of the plate about its long axis, about which the plate never turns [kg m2]."""


@final
@dataclass(frozen=True)
class Drive:
    """Gains of the joint's controller, and the joint's true inertia and friction.

    Attributes:
        kp: position feedback [N m/rad].
        kv: speed feedback [N m s/rad].
        inertia_factor: true inertia of plate and actuator over the planned inertia.
        friction: true Coulomb friction [N m].
        viscous: true viscous friction [N m s/rad].
    """

    kp: float
    kv: float
    inertia_factor: float = 1.0
    friction: float = 0.0
    viscous: float = 0.0


@final
@dataclass(frozen=True)
class GripNames:
    """Names of the elements that hold one part on the arm: the site on the arm and the two equalities."""

    seat: str
    equalities: tuple[str, str]


def add_one_joint(spec: MjSpec, arm: Arm, drive: Drive, touches: bool) -> MjsBody:
    """Add stand, arm and motor: body and joint are named "arm", the actuator "motor".

    The motor takes three consecutive controls: angle, speed and feed-forward torque.

    Args:
        spec: a mujoco.MjSpec.
        arm: the arm as the planner knows it.
        drive: controller and true joint.
        touches: whether a part lies on the arm by contact, between two stoppers named "stopper_inner" and
            "stopper_outer"; if not, the arm touches nothing.

    Returns:
        The arm's body.
    """
    dress_stand(spec, arm)
    body = spec.worldbody.add_body(name="arm")
    factor = drive.inertia_factor
    body.add_joint(
        name="arm",
        axis=[0, -1, 0],
        armature=arm.actuator_inertia * factor,
        frictionloss=drive.friction,
        damping=np.array([drive.viscous, 0.0, 0.0]),
    )
    # The plate is balanced on the shaft: its centre of mass is taken to be the pivot, as in the planner.
    plate = (arm.inertia - arm.actuator_inertia) * factor
    mass = arm.density * arm.length * arm.width * arm.thickness
    set_inertia(body, mass, (0, 0, 0), (_LONG_AXIS_INERTIA, plate, plate))
    dress_arm(body, arm)
    if touches:
        _add_surface(body, arm)
    add_motor(spec, "motor", "arm", arm.torque, drive.kp, drive.kv)
    return body


def add_plane_joints(body: MjsBody, name: str) -> None:
    """Add the joints of motion in the plane: slides "NAME_x" and "NAME_z" [m], and the hinge "NAME_phi" [rad]."""
    body.add_joint(name=f"{name}_x", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
    body.add_joint(name=f"{name}_z", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
    body.add_joint(name=f"{name}_phi", axis=[0, -1, 0])


def add_grip(spec: MjSpec, arm: MjsBody, body: MjsBody, name: str) -> GripNames:
    """Add equalities that hold a part rigidly on the arm: its centre of mass at a site, its angle equal to the arm's.

    Two equalities couple a point and an angle instead of a weld, so that the angle is exact over whole turns. The
    part's body has the joints that `add_plane_joints` adds for the same name.
    """
    names = GripNames(f"seat_{name}", (f"hold_{name}", f"turn_{name}"))
    add_site(arm, names.seat)
    add_site(body, f"centre_{name}")
    soft = {"solref": GRIP_SOLREF, "solimp": GRIP_SOLIMP}
    join_sites(spec, names.equalities[0], names.seat, f"centre_{name}", soft)
    join_angles(spec, names.equalities[1], f"{name}_phi", "arm", soft)
    return names


def _add_surface(body: MjsBody, arm: Arm) -> None:
    """Add the plate's surface for contacts, and the stoppers, which the simulation moves to the object."""
    shared = {
        "type": mujoco.mjtGeom.mjGEOM_BOX,
        "mass": 0,
        "contype": ARM_BIT,
        "conaffinity": 0,
        "priority": 2,
        "solref": _CONTACT_SOLREF,
        "solimp": _CONTACT_SOLIMP,
    }
    body.add_geom(
        name="surface",
        size=[arm.length / 2, arm.width / 2, arm.thickness / 2],
        pos=[0, 0, -arm.thickness / 2],
        condim=3,
        friction=[SURFACE_FRICTION, 0.005, 0.0001],
        group=3,
        **shared,
    )
    for name in ("stopper_inner", "stopper_outer"):
        # Each stopper is a body, because a body that is moved takes its collision tree along and a geom does not.
        body.add_body(name=name).add_geom(
            name=name,
            size=[STOPPER_WIDTH / 2, arm.width / 2, STOPPER_HEIGHT / 2],
            pos=[0, 0, STOPPER_HEIGHT / 2],
            condim=1,  # no friction on the stoppers (section 2)
            rgba=ACCENT,
            group=2,
            **shared,
        )
