"""A serial arm as numbers: links, joints and hand, from the engine's model of a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Point
from pnt_gym.engine import MjData, MjModel, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.names import list_names, unknown_name
from pnt_gym.robots.arm.reading import ModelFile
from pnt_gym.robots.arm.rows import Link, Tool
from pnt_gym.robots.arm.settings import ArmSettings, fitting, joint_limits
from pnt_gym.robots.arm.shapes import Shape, shapes_of
from pnt_gym.robots.joints import MotorLimits
from pnt_gym.rows import Rows

MOST_JOINTS: Final = 6
"""Joints of an arm: with more, a place of the hand does not say the pose."""
LARGEST: Final = 1e6
"""Bound of every number of a link."""
HAND_RADIUS: Final = 0.03
"""Radius of the cup and its mount as a cylinder [m]."""


@final
@dataclass(frozen=True, eq=False)
class Chain:
    """A serial arm of n joints in the axes of the cell."""

    names: tuple[str, ...]
    """Names of the joints from the base to the tool, as the file has them."""
    links: Rows[Link]
    tool: Rows[Tool]
    """The hand with the tool's axes."""
    flange: Floats
    """Place of the tool in the last link's frame (3,) [m]."""
    limits: MotorLimits
    home: Floats
    """Positions of the joints at home (n,)."""
    shapes: tuple[Shape, ...]


def chain_of(file: ModelFile, settings: ArmSettings) -> Chain:
    """The arm of a model file.

    Raises:
        ConfigError: the file describes no serial arm of hinges and slides, or its limits are not known.
    """
    model = file.model
    joints = _joints(model)
    names = tuple(_name(model.joint(joint).name, joint) for joint in joints)
    data = _at_zero(model)
    tool_body, point, axes = _tool(model, data, settings.tool)
    on_way = _way(model, tool_body)
    if aside := [name for name, joint in zip(names, joints, strict=True) if joint not in on_way]:
        raise ConfigError(f"{_joint_names(aside)} not between the base and the tool; an arm is one chain")
    owner = _owners(model, joints)
    frame = _matrix(settings.turn)
    base = np.asarray(settings.base)
    links = _links(model, data, joints, owner, (base, frame))
    limits = joint_limits(file, joints, names, settings)
    tip = point + settings.stem * axes[:, 2]
    last = base - links["offset"].sum(axis=0)
    flange, tip = last + frame @ point, last + frame @ tip
    along = frame @ axes[:, 2]
    add_mass(links, len(joints) - 1, (flange + tip) / 2.0, settings.hand, _rod(settings.hand, settings.stem, along))
    if float(links["mass"][-1]) == 0.0:
        raise ConfigError("its last body has no mass; give it one, or give robot.model.hand")
    if not (np.abs(np.concatenate([links[name].ravel() for name in links.dtype.names or ()])) < LARGEST).all():
        raise ConfigError(f"it has lengths or masses that are not finite, or not below {LARGEST:g} in SI units")
    tool = Tool.zeros(1, offset=tip, turn=(frame @ axes).ravel())
    home = _home(joints, settings)
    shapes = tuple(shapes_of(model, data, owner, links, (base, frame)))
    return Chain(names, links, tool, flange, limits, home, shapes)


def _name(name: str, joint: int) -> str:
    return name or f"number {joint + 1}"


def _joint_names(names: Sequence[str]) -> str:
    """Joints as the subject of a sentence."""
    return f"joint {list_names(names)} is" if len(names) == 1 else f"joints {list_names(names)} are"


def _joints(model: MjModel) -> list[int]:
    """Ids of all joints, which the engine keeps from the base outward."""
    kinds = mujoco.mjtJoint
    words = {int(kinds.mjJNT_FREE): "a free joint", int(kinds.mjJNT_BALL): "a ball joint"}
    for joint in range(int(model.njnt)):
        if (word := words.get(int(model.jnt_type[joint]))) is not None:
            body = model.body(int(model.jnt_bodyid[joint])).name
            raise ConfigError(f"body {body!r} has {word}; an arm has hinges and slides, and stands on its base")
        if float(np.ravel(model.jnt_stiffness[joint])[0]) != 0.0:
            raise ConfigError(f"joint {model.joint(joint).name!r} has a spring, which is not simulated; leave it out")
    count = int(model.njnt)
    if not 1 <= count <= MOST_JOINTS:
        raise ConfigError(f"it has {count} joints; an arm has 1 to {MOST_JOINTS}, as many as its hand's place needs")
    if int(model.neq) or int(model.ntendon):
        raise ConfigError("it has equalities or tendons; an arm is a chain of joints")
    return list(range(count))


def _at_zero(model: MjModel) -> MjData:
    """The model with all joints at 0."""
    data = mujoco.MjData(model)
    data.qpos[:] = 0.0
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data


def _tool(model: MjModel, data: MjData, name: str | None) -> tuple[int, Floats, Floats]:
    """Body, place (3,) and axes (3, 3) of the tool in the axes of the model."""
    sites = {model.site(i).name: i for i in range(int(model.nsite))}
    bodies = {model.body(i).name: i for i in range(int(model.nbody))}
    if name is None:
        body = int(model.jnt_bodyid[-1])
        return body, data.xpos[body].copy(), data.xmat[body].reshape(3, 3).copy()
    if name in sites:
        site = sites[name]
        return int(model.site_bodyid[site]), data.site_xpos[site].copy(), data.site_xmat[site].reshape(3, 3).copy()
    if name in bodies:
        body = bodies[name]
        return body, data.xpos[body].copy(), data.xmat[body].reshape(3, 3).copy()
    raise ConfigError(unknown_name("tool", name, [*sites, *bodies]))


def _way(model: MjModel, body: int) -> set[int]:
    """Ids of the joints between the base and a body."""
    found = set[int]()
    while body > 0:
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        found.update(range(first, first + count))
        body = int(model.body_parentid[body])
    return found


def _owners(model: MjModel, joints: Sequence[int]) -> list[int]:
    """Index of the last joint that moves each body; -1 for none."""
    owner = [-1] * int(model.nbody)
    for body in range(1, int(model.nbody)):
        own = [joint for joint in joints if int(model.jnt_bodyid[joint]) == body]
        owner[body] = own[-1] if own else owner[int(model.body_parentid[body])]
    return owner


def _links(
    model: MjModel, data: MjData, joints: Sequence[int], owner: Sequence[int], placed: tuple[Floats, Floats]
) -> Rows[Link]:
    """Rows of the joints (n,)."""
    base, frame = placed
    links, before = Link.zeros(len(joints)), np.zeros(3)
    for k, joint in enumerate(joints):
        anchor = base + frame @ data.xanchor[joint]
        links["offset"][k], before = anchor - before, anchor
        links["axis"][k] = frame @ data.xaxis[joint]
        links["slides"][k] = float(int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE))
        degree = int(model.jnt_dofadr[joint])
        links["armature"][k] = model.dof_armature[degree]
        links["damping"][k] = float(np.ravel(model.dof_damping[degree])[0])
        for body in (body for body in range(1, int(model.nbody)) if owner[body] == joint):
            inertia = frame @ data.ximat[body].reshape(3, 3)
            tensor = inertia @ np.diag(model.body_inertia[body]) @ inertia.T
            centre = base + frame @ data.xipos[body] - anchor
            add_mass(links, k, centre, float(model.body_mass[body]), tensor)
    return links


def _rod(mass: float, length: float, axis: Floats) -> Floats:
    """Inertia of a cylinder about its centre (3, 3) [kg m2]."""
    slim, across = mass * HAND_RADIUS**2 / 2.0, mass * (3.0 * HAND_RADIUS**2 + length**2) / 12.0
    return across * np.eye(3) + (slim - across) * np.outer(axis, axis)


@np.errstate(over="ignore", invalid="ignore")  # what is not finite is refused later
def add_mass(links: Rows[Link], k: int, centre: Floats, mass: float, inertia: Floats | None = None) -> None:
    """Add a body to a link, in place.

    Args:
        links: the arm (n,).
        k: index of the link.
        centre: centre of mass in the link's frame (3,) [m].
        mass: mass [kg].
        inertia: about the centre of mass (3, 3) [kg m2]; None for a point.
    """
    own, old = float(links["mass"][k]), links["centre"][k].copy()
    total = own + mass
    if total <= 0.0:
        return
    middle = (own * old + mass * centre) / total
    tensor = links["inertia"][k].reshape(3, 3) + (0.0 if inertia is None else inertia)
    for part, place in ((own, old - middle), (mass, centre - middle)):
        tensor = tensor + part * (place @ place * np.eye(3) - np.outer(place, place))
    links["mass"][k], links["centre"][k], links["inertia"][k] = total, middle, tensor.ravel()


def _matrix(vector: Point) -> Floats:
    """Rotation (3, 3) by a rotation vector [rad]."""
    angle, quat, out = float(np.linalg.norm(vector)), np.zeros(4), np.zeros(9)
    mujoco.mju_axisAngle2Quat(quat, np.asarray(vector) / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0]), angle)
    mujoco.mju_quat2Mat(out, quat)
    return out.reshape(3, 3)


def _home(joints: Sequence[int], settings: ArmSettings) -> Floats:
    """Positions of the joints at home (n,)."""
    if settings.home is None:
        return np.zeros(len(joints))
    return np.array(fitting("home", settings.home, len(joints)))
