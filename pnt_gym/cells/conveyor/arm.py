"""A serial arm in a cell: read from its model file, and held against the sheet that promises its limits."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from hashlib import sha256
from typing import Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.conveyor.robot import RobotSheet
from pnt_gym.errors import ConfigError
from pnt_gym.robots.arm.bounds import Loads
from pnt_gym.robots.arm.chain import chain_of
from pnt_gym.robots.arm.model import SerialArm
from pnt_gym.robots.arm.poses import poses_in
from pnt_gym.robots.arm.reading import read_model
from pnt_gym.robots.arm.settings import ArmSettings

RADII: Final = 9
"""Circles of places at which limits are held, from the middle of a reach to its border."""
ANGLES: Final = 32
"""Places on a circle."""
HEIGHTS: Final = 9
"""Heights of the places."""
JUMP: Final = 1.0
"""Largest difference of a joint between neighbouring places on one branch of the inverse kinematics [rad, m]."""


def arm_of(sheet: RobotSheet) -> SerialArm:
    """The arm of a sheet with a model.

    Raises:
        ConfigError: the file cannot be read, or is no arm that works there.
    """
    return _arm(_Case(sheet))


def arm_problems(sheet: RobotSheet) -> Iterator[str]:
    """What is wrong with the arm of a sheet, in sentences; nothing where there is no arm."""
    if sheet.model is None:
        return
    if sheet.reach.shape == "ring":
        yield (
            f"robot {sheet.name!r} has a model and a reach of shape 'ring', whose hole hands cross on their ways back; "
            "give the reach as a circle or an ellipse beside the base"
        )
        return
    try:
        yield from _limit_problems(_Case(sheet))
    except ConfigError as error:
        yield f"robot {sheet.name!r}: {error}"


def content_of(sheet: RobotSheet) -> str:
    """Digest of the model file of a sheet and of its meshes; empty where there is no model."""
    if sheet.model is None:
        return ""
    parts = read_model(sheet.model.file).parts
    return sha256(b"".join(sha256(part).digest() for _, part in sorted(parts.items()))).hexdigest()


class _Case:
    """A sheet and the content of its model file; equal ones share what is computed from them."""

    def __init__(self, sheet: RobotSheet) -> None:
        assert sheet.model is not None
        self.sheet, self.section, self.file = sheet, sheet.model, read_model(sheet.model.file)
        self._key = tuple(sorted(self.file.parts.items()))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Case) and (self._key, self.sheet) == (other._key, other.sheet)

    def __hash__(self) -> int:
        return hash(self._key)


@lru_cache(maxsize=8)
def _arm(case: _Case) -> SerialArm:
    space, settings = case.sheet.workspace, ArmSettings(**case.section.model_dump(exclude={"file"}))
    middle = np.array([space.x, space.y, (space.z_min + space.z_max) / 2.0])
    half = np.array([space.semi_x, space.semi_y, (space.z_max - space.z_min) / 2.0])
    chain = chain_of(case.file, settings)
    return SerialArm.of(poses_in(chain, middle - half, middle + half, middle), case.section.base)


def places_of(sheet: RobotSheet) -> Floats:
    """Places all over a robot's reach and on its border (M, 3) [m]."""
    space = sheet.workspace
    share, angle = np.linspace(0.0, 1.0, RADII), np.linspace(0.0, 2.0 * np.pi, ANGLES, endpoint=False)
    height = np.linspace(space.z_min, space.z_max, HEIGHTS)
    share, angle, height = (part.ravel() for part in np.meshgrid(share, angle, height))
    x, y = space.x + space.semi_x * share * np.cos(angle), space.y + space.semi_y * share * np.sin(angle)
    return np.stack([x, y, height], axis=-1)


@lru_cache(maxsize=8)
def _limit_problems(case: _Case) -> tuple[str, ...]:
    """Which of a sheet's limits the joints of its arm do not keep."""
    sheet = case.sheet
    arm, places = _arm(case), places_of(sheet)
    names, limits = arm.branch.chain.names, arm.limits
    if (lost := np.isnan(arm.pose(places)).any(axis=1)).any():
        return (
            f"the arm of robot {sheet.name!r} does not get to {lost.mean():.0%} of robot.reach and height, as "
            f"({_point(places[lost][0])}) m, with a level and unturned hand; narrow them, or move robot.model.base",
        )
    loads, problems = Loads.of(arm.holding(sheet.payload).motion, places), list[str]()
    if (jump := _largest_jump(loads.position)) > JUMP:
        problems.append(
            f"the arm of robot {sheet.name!r} changes its posture within robot.reach, where a joint jumps by "
            f"{jump:.1f} rad; narrow the reach, or move it away from the base"
        )
    nearest = loads.range(limits)
    if nearest.value < 0.0:
        problems.append(
            f"robot {sheet.name!r}: joint {names[nearest.joint]!r} would be {-nearest.value:.2f} rad or m beyond its "
            f"range with the hand at ({_point(nearest.place)}) m; narrow robot.reach, or give another robot.model.home"
        )
    fastest = loads.speed(limits)
    if fastest.value < sheet.velocity:
        problems.append(
            f"robot.velocity is {sheet.velocity:g} m/s; joint {names[fastest.joint]!r} of {sheet.name!r} allows "
            f"{_down(fastest.value)} m/s with the hand at ({_point(fastest.place)}) m, whichever way it moves"
        )
    strongest = loads.acceleration(limits, min(sheet.velocity, fastest.value))
    if strongest.value < sheet.acceleration:
        allowed = f"allows {_down(strongest.value)} m/s2" if strongest.value > 0.0 else "cannot hold it"
        problems.append(
            f"robot.acceleration is {sheet.acceleration:g} m/s2 with a payload of {sheet.payload:g} kg; joint "
            f"{names[strongest.joint]!r} of {sheet.name!r} {allowed} with the hand at ({_point(strongest.place)}) m"
        )
    return tuple(problems)


def _largest_jump(position: Floats) -> float:
    """Largest difference of a joint at neighbouring places of the mesh, by positions (n, M) [rad]."""
    mesh = position.reshape(-1, ANGLES, RADII, HEIGHTS)
    mesh = np.concatenate([mesh, mesh[:, :1]], axis=1)  # around the border
    return max(float(np.abs(np.diff(mesh, axis=axis)).max()) for axis in (1, 2, 3))


def _point(place: Floats) -> str:
    return ", ".join(f"{value:.2f}" for value in place)


def _down(value: float) -> str:
    """A limit with two digits, rounded down."""
    if value <= 0.0:
        return "0"
    scale = 10.0 ** (np.floor(np.log10(value)) - 1)
    return f"{np.floor(value / scale) * scale:.3g}"
