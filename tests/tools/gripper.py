"""Poses and cells of the gripper robot for its tests."""

import numpy as np

from pnt_gym.cells.base.action import corrected
from pnt_gym.cells.gripper.action import MODES
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig


def pose(x, y, z, degrees):
    """A pose from mm and degrees."""
    return np.array([x / 1e3, y / 1e3, z / 1e3, np.deg2rad(degrees)])


DOWN, UP = pose(0, 0, -250, -45), pose(0, 0, -200, -45)


def made(level="nominal", count=16, threads=1, seed=0, **changes):
    """Cells with their first throws drawn from seeds that count on from one."""
    cell = GripperCell(GripperConfig.load(level, **changes), count, threads)
    cell.reset(np.arange(count), [np.random.default_rng(seed + row) for row in range(count)])
    return cell


def planned(cell, correction):
    """Plans of the coming throws for corrections (N, 3) in metres and seconds, feasible or not."""
    return cell.planner.plan(cell.context.kind, cell.context.place, correction)


def shortened(cell, correction):
    """Feasible plans nearest to corrections (N, 3) in metres and seconds, and which had to be shortened."""
    return corrected(MODES["release"], cell.planner, cell.context, correction, np.ones(3))


def oracle(cell, rounds=2):
    """Corrections that a controller with a perfect model would make: preview, move against the error, repeat."""
    correction = np.zeros((cell.count, 3))
    correction[:, 2] = -cell.context.hidden.delay
    for _ in range(rounds):
        outcome = cell.preview(shortened(cell, correction)[0], jitter=True)
        correction[:, 0] -= outcome.landing_along
        correction[:, 1] -= outcome.landing_across
    return shortened(cell, correction)


def fields_equal(one, other):
    """Whether two records of arrays are the same to the last bit."""
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in vars(one))
