"""Cells of the gripper robot for its tests."""

import numpy as np

from pnt_gym.cells.tray.cell import TrayCell
from pnt_gym.cells.tray.config import load


def made(level="nominal", count=16, threads=1, seed=0, **changes):
    """Cells with their first throws drawn from seeds that count on from one."""
    cell = TrayCell(load(level, **changes), count, threads)
    cell.reset(np.arange(count), [np.random.default_rng(seed + row) for row in range(count)])
    return cell


def oracle(cell, rounds=2):
    """Corrections that a controller with a perfect model would make: preview, move against the error, repeat."""
    correction = np.zeros((cell.count, 3))
    correction[:, 2] = -cell.context.hidden.delay
    for _ in range(rounds):
        outcome = cell.preview(cell.corrected(correction)[0], jitter=True)
        correction[:, 0] -= outcome.landing_along
        correction[:, 1] -= outcome.landing_across
    return cell.corrected(correction)


def fields_equal(one, other):
    """Whether two records of arrays are the same to the last bit."""
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in vars(one))
