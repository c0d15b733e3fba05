"""Parts of all cells' scenes: light, colours, floor, a free object, and sensors."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from pnt_gym.cells.base.canvas import LARGEST_SIZE
from pnt_gym.engine import MjsBody, MjSpec, mujoco
from pnt_gym.palette import FLOOR, SKY

SURROUNDINGS_SOLREF: Final = (0.004, 1.0)
"""Time constant [s] and damping ratio of contacts with fixed surroundings."""
BELT_THICKNESS: Final = 0.04
"""Thickness of a belt's plate [m]."""


def light_stage(spec: MjSpec, ambient: float = 0.38, diffuse: float = 0.42) -> None:
    """Set size and shadows of pictures, the light at the camera, and a plain bright sky.

    MuJoCo's black default background hides carbon rods.

    Args:
        spec: a mujoco.MjSpec.
        ambient: intensity of the camera light's ambient part, the same in every direction.
        diffuse: intensity of the camera light's diffuse part.
    """
    visual = spec.visual
    visual.global_.offheight, visual.global_.offwidth = LARGEST_SIZE
    visual.headlight.ambient, visual.headlight.diffuse = np.full(3, ambient), np.full(3, diffuse)
    visual.quality.shadowsize = 4096
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=list(SKY[0]),
        rgb2=list(SKY[1]),
        width=64,
        height=384,
    )


def add_floor(spec: MjSpec, height: float, half: float, **attributes: Any) -> None:
    """Add a plane that pictures show and on which objects may fall.

    Args:
        spec: a mujoco.MjSpec.
        height: z of the plane [m].
        half: half of the plane's side in pictures [m].
        attributes: further attributes of the geom.
    """
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(
        name="floor", type=plane, size=[half, half, 0.1], pos=[0, 0, height], rgba=FLOOR, **attributes
    )


def add_free_object(spec: MjSpec, mass: float, inertia: float, half: float, **geom: Any) -> MjsBody:
    """Add a free body `object` whose frame is at its centre of mass, with one geom `object` of any shape.

    The plant overwrites mass, inertia, shape and size in every simulation.

    Args:
        spec: a mujoco.MjSpec.
        mass: mass at compile time [kg].
        inertia: inertia at compile time, about every axis [kg m2].
        half: half extent at compile time [m].
        geom: further attributes of the geom.
    """
    body = spec.worldbody.add_body(name="object", pos=[0, 0, 0])
    body.add_freejoint(name="object")
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = mass, np.full(3, inertia), np.zeros(3)
    box = mujoco.mjtGeom.mjGEOM_BOX
    body.add_geom(name="object", type=box, size=[half] * 3, fluid_ellipsoid=1, **geom)
    return body


def add_motion_sensors(spec: MjSpec) -> None:
    """Add sensors of the free object's position and velocity: three columns each."""
    for kind in (mujoco.mjtSensor.mjSENS_FRAMEPOS, mujoco.mjtSensor.mjSENS_FRAMELINVEL):
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_XBODY, objname="object")


def add_place_sensor(spec: MjSpec, site: str) -> None:
    """Add a sensor of a site's position: three columns."""
    spec.add_sensor(type=mujoco.mjtSensor.mjSENS_FRAMEPOS, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=site)


def add_contact_sensor(spec: MjSpec, kind: Any, name: str, partner: str | None = None) -> None:
    """Add a sensor of contacts, two columns: number of contacts and smallest distance [m].

    Args:
        spec: a mujoco.MjSpec.
        kind: mujoco.mjtObj type of both objects.
        name: name of the object whose contacts count.
        partner: name of the object that is touched; None for any.
    """
    found_and_distance, nearest, contacts = 0b1001, 1, 1
    pair = {} if partner is None else {"reftype": kind, "refname": partner}
    spec.add_sensor(
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=kind,
        objname=name,
        intprm=[found_and_distance, nearest, contacts],
        **pair,
    )


def add_torque_sensors(spec: MjSpec, motors: Iterable[str]) -> None:
    """Add one sensor column per motor: the motor's torque [N m]."""
    for motor in motors:
        spec.add_sensor(type=mujoco.mjtSensor.mjSENS_ACTUATORFRC, objtype=mujoco.mjtObj.mjOBJ_ACTUATOR, objname=motor)
