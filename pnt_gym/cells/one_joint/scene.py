"""MuJoCo model of the one-joint thrower's cell: arm, pallets, and the thrown parts.

Fields that differ between throws (the place of the part on the arm, the part itself) are overwritten per simulation by
the plant; the model is compiled once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Ints
from pnt_gym.cells.base.stage import add_contact_sensor, add_floor, add_torque_sensors, light_stage
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.pallets import Pallet, add_pallets
from pnt_gym.cells.one_joint.parts import PART_BIT, Part, add_part
from pnt_gym.constants import AIR_DENSITY, AIR_VISCOSITY
from pnt_gym.engine import MjModel, MjsBody, MjSpec, mujoco
from pnt_gym.palette import BOARD
from pnt_gym.robots.one_joint.model import ARM_BIT, Drive, add_grip, add_one_joint, add_plane_joints
from pnt_gym.robots.one_joint.visuals import FLOOR
from pnt_gym.robots.specification import set_options

TORQUE: Final = 0
"""Column of sensordata with the motor's torque. Contacts follow, (number found, smallest distance [m]) each."""
BACKBOARD: Final = 0.30
"""Distance of a board behind the plane of the throw, for pictures only [m]."""
BOARD_WIDTH, BOARD_HEIGHT = 1.8, 1.4
"""Width and height of the board behind the plane of the throw [m]."""

_BLUNT_SHARE = 0.5 / (np.pi / 4.0)
"""Correction of MuJoCo's drag, which has no factor 1/2 and models a box as the ellipsoid inside it, with pi/4 of its
frontal area."""
_SLENDER_SHARE = 0.35
"""Share of the blunt coefficient, as for the conveyor's objects; the coefficient of rotation is the blunt one. No
lift."""
_ADDED_MASS = slice(6, 12)
"""Columns of geom_fluid with the added mass."""


@final
@dataclass(frozen=True)
class Scene:
    """The compiled cell and the ids that the plant needs; arrays have one entry or row per part."""

    model: MjModel
    parts: tuple[Part, ...]
    pallets: tuple[Pallet, ...]
    bodies: Ints
    """Bodies of the parts (P,)."""
    first_qpos: Ints
    """Address of each part's x in qpos; y and phi follow (P,)."""
    seats: Ints
    """Sites of the arm at which the parts' centres are held (P,)."""
    grips: Ints
    """Equalities that hold each part (P, 2)."""
    stoppers: tuple[int, int] | None
    """Bodies of the inner and the outer stopper, if the parts lie on the arm by contact; else None."""


def build_scene(config: OneJointConfig, parts: Sequence[Part], pallets: Sequence[Pallet]) -> Scene:
    """Compile the model of the cell.

    Args:
        config: level of the cell.
        parts: all thrown parts.
        pallets: all pallets.
    """
    spec = mujoco.MjSpec()
    touches = config.release == "contact"
    air = config.mismatch if config.errors.drag > 0.0 else 0.0
    set_options(spec, config.timestep, density=AIR_DENSITY * air, viscosity=AIR_VISCOSITY * air)
    if not touches and not pallets:
        # No two bodies can touch here; collision detection would take a tenth of the time.
        spec.option.disableflags = int(spec.option.disableflags) | int(mujoco.mjtDisableBit.mjDSBL_CONTACT.value)
    _add_stage(spec)
    m, errors = config.mismatch, config.errors
    drive = Drive(
        kp=config.servo.kp,
        kv=config.servo.kv,
        inertia_factor=1.0 + m * errors.inertia,
        friction=config.arm.friction + m * errors.friction,
        viscous=m * errors.viscous,
    )
    arm = add_one_joint(spec, config.arm.arm(), drive, touches)
    add_pallets(spec, pallets)
    grips = [_add_part(spec, arm, part, config, touches) for part in parts]
    add_torque_sensors(spec, ("motor",))
    for part in parts:
        for partner in (*pallets, *(p for p in parts if p is not part)):
            add_contact_sensor(spec, mujoco.mjtObj.mjOBJ_BODY, part.name, partner.name)
    model = spec.compile()
    # In potential flow an ellipsoid's added mass turns it (Munk's moment); behind a block the flow separates.
    model.geom_fluid[:, _ADDED_MASS] = 0.0
    stoppers = ("stopper_inner", "stopper_outer")
    return Scene(
        model=model,
        parts=tuple(parts),
        pallets=tuple(pallets),
        bodies=_ids(model.body(p.name).id for p in parts),
        first_qpos=_ids(int(model.joint(f"{p.name}_x").qposadr[0]) for p in parts),
        seats=_ids(model.site(seat).id for seat, _ in grips),
        grips=_ids(model.equality(name).id for _, names in grips for name in names).reshape(len(parts), 2),
        stoppers=(model.body(stoppers[0]).id, model.body(stoppers[1]).id) if touches else None,
    )


def contact_columns(scene: Scene, part: int) -> tuple[Ints, Ints]:
    """Columns of sensordata with the contacts of one part with each pallet, then with each other part.

    Returns:
        The columns of the number found (Q + P - 1,) and of the smallest distance (Q + P - 1,).
    """
    partners = len(scene.pallets) + len(scene.parts) - 1
    first = TORQUE + 1 + 2 * partners * part
    columns = first + 2 * np.arange(partners, dtype=np.int64)
    return columns, columns + 1


def _ids(values: Iterable[int]) -> Ints:
    return np.array(list(values), dtype=np.int64)


def _add_part(
    spec: MjSpec, arm: MjsBody, part: Part, config: OneJointConfig, touches: bool
) -> tuple[str, tuple[str, str]]:
    """Add a part, free in the plane, and its grip; returns names of its seat and of the grip's equalities."""
    body = spec.worldbody.add_body(name=part.name)
    # Waiting parts float without weight; the plant gives the other parts their weight.
    body.gravcomp = 1.0
    add_plane_joints(body, part.name)
    add_part(body, part, PART_BIT | ARM_BIT if touches else PART_BIT)
    for geom in body.geoms:
        geom.fluid_ellipsoid = 1
        blunt = _BLUNT_SHARE * config.errors.drag
        geom.fluid_coefs = np.array([blunt, _SLENDER_SHARE * blunt, blunt, 0.0, 0.0])
    names = add_grip(spec, arm, body, part.name)
    return names.seat, names.equalities


def _add_stage(spec: MjSpec) -> None:
    """Add light, floor, and a board behind the arm, for pictures only."""
    light_stage(spec)
    spec.worldbody.add_light(
        pos=[0.9, -1.8, 1.5], dir=[-0.45, 0.85, -0.7], diffuse=np.full(3, 0.40), specular=np.zeros(3)
    )
    add_floor(spec, FLOOR, 2.0, contype=0, conaffinity=PART_BIT, group=1)
    spec.worldbody.add_geom(
        name="backboard",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[BOARD_WIDTH / 2, BOARD_HEIGHT / 2, 0.01],
        pos=[-0.05, BACKBOARD, FLOOR + BOARD_HEIGHT / 2],
        quat=[np.sqrt(0.5), np.sqrt(0.5), 0, 0],  # its face with squares of 0.1 m looks along -y
        rgba=BOARD,
        contype=0,
        conaffinity=0,
        group=1,
    )
