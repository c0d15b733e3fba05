"""Poses of a serial arm in its reach: one branch of the inverse kinematics, continued from home on a grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.errors import ConfigError
from pnt_gym.robots.arm import kernel
from pnt_gym.robots.arm.chain import Chain
from pnt_gym.robots.arm.rows import SeedGrid, Tool
from pnt_gym.rows import Rows

SPACING: Final = 0.06
"""Distance of neighbours on the grid [m]."""
MARGIN: Final = 0.08
"""Width of the grid beyond the box of the reach, as far as a hand may stray [m]."""
LEVEL_STEPS: Final = 400
"""Steps of Newton's method from home to a level hand at the reach."""
GRID_STEPS: Final = 40
"""Steps of Newton's method from one point of the grid to its neighbour."""
UPRIGHT: Final = 0.5
"""Least cosine of the angle between the tool's axis and the way down, at home."""


@final
@dataclass(frozen=True, eq=False)
class Poses:
    """The arm's poses with a level, unturned hand."""

    chain: Chain
    tool: Rows[Tool]
    """The hand, unturned at home."""
    grid: Rows[SeedGrid]
    seeds: Floats
    """Poses of the grid's points (K, n); NaN out of reach."""

    def at(self, hand: Floats) -> Floats:
        """Poses (N, n) with the hand at places (N, 3) [m]; NaN out of reach."""
        return kernel.poses(self.chain.links, self.tool, self.grid, self.seeds, np.ascontiguousarray(hand))

    def motion(self, hand: Floats) -> Floats:
        """Positions, velocities, accelerations and torques of the joints (4, n, N) for motions of the hand (N, 9)."""
        rows = np.ascontiguousarray(hand)
        return kernel.motion(self.chain.links, self.tool, self.grid, self.seeds, rows)


def poses_in(chain: Chain, low: Floats, high: Floats, middle: Floats) -> Poses:
    """Poses in a box of places, on the branch that holds the arm's home.

    Args:
        chain: the arm.
        low: least corner of the box (3,) [m].
        high: greatest corner of the box (3,) [m].
        middle: a place in the box from which all poses are continued (3,) [m].

    Raises:
        ConfigError: the hand is not upright at home, or cannot be level and unturned at the middle.
    """
    tool = _unturned(chain)
    counts = np.ceil((high - low + 2.0 * MARGIN) / SPACING).astype(np.int64) + 1
    step = (high - low + 2.0 * MARGIN) / (counts - 1)
    grid = SeedGrid.zeros(1)
    grid["low"][0], grid["step"][0] = low - MARGIN, step
    for axis, count in zip("xyz", counts, strict=True):
        grid[f"count_{axis}"] = count
    first, found = _improved(chain, tool, middle[None], chain.home[None].copy(), LEVEL_STEPS)
    if not found[0]:
        place = ", ".join(f"{value:.2f}" for value in middle)
        raise ConfigError(
            f"the arm finds no pose with a level and unturned hand at ({place}) m, the middle of robot.reach and "
            "height, from robot.model.home; move robot.model.base, robot.reach or home, or the arm has too few joints"
        )
    return Poses(chain, tool, grid, _continued(chain, tool, grid, (middle, first[0])))


def _unturned(chain: Chain) -> Rows[Tool]:
    """The hand with its z axis against the tool's, and its x axis along the cell's at home."""
    place = kernel.places(chain.links, chain.tool, np.ascontiguousarray(chain.home[None]))[0]
    axes = place[3:].reshape(3, 3)
    down = -axes[2, 2]
    if down < UPRIGHT:
        angle = np.degrees(np.arccos(np.clip(down, -1.0, 1.0)))
        raise ConfigError(
            f"at robot.model.home the tool's z axis points {angle:.0f} degrees from straight down; it may be "
            f"{np.degrees(np.arccos(UPRIGHT)):.0f}: give a home at which the cup hangs"
        )
    up = -axes[:, 2]
    ahead = np.array([1.0, 0.0, 0.0]) - up[0] * up
    ahead /= np.linalg.norm(ahead)
    hand = np.column_stack([ahead, np.cross(up, ahead), up])
    tool = chain.tool.copy()
    tool["turn"][0] = (tool["turn"][0].reshape(3, 3) @ axes.T @ hand).ravel()
    return tool


def _improved(chain: Chain, tool: Rows[Tool], hand: Floats, pose: Floats, steps: int) -> tuple[Floats, Bools]:
    """Poses (M, n) at places (M, 3) from near ones, and which were found (M,)."""
    found = kernel.improve(chain.links, tool, np.ascontiguousarray(hand), steps, pose)
    return pose, found > 0.0


def _continued(chain: Chain, tool: Rows[Tool], grid: Rows[SeedGrid], start: tuple[Floats, Floats]) -> Floats:
    """Poses of the grid's points (K, n), each continued from a neighbour, outward from a place with a known pose."""
    shape = tuple(int(grid[f"count_{axis}"][0]) for axis in "xyz")
    index = np.stack(np.unravel_index(np.arange(int(np.prod(shape))), shape), axis=-1)
    points = grid["low"][0] + index * grid["step"][0]
    poses, tried = np.full((len(points), len(chain.links)), np.nan), np.zeros(len(points), dtype=np.bool_)
    place, pose = start
    fresh, seeds = np.array([int(np.argmin(((points - place) ** 2).sum(axis=-1)))], dtype=np.int64), pose[None]
    while len(fresh):
        tried[fresh] = True
        pose, found = _improved(chain, tool, points[fresh], seeds.copy(), GRID_STEPS)
        reached = fresh[found]
        poses[reached] = pose[found]
        target, source = _neighbours(reached, index, shape)
        fresh, first = np.unique(target[~tried[target]], return_index=True)
        seeds = poses[source[~tried[target]][first]]
    return poses


def _neighbours(points: Ints, index: Ints, shape: tuple[int, ...]) -> tuple[Ints, Ints]:
    """Numbers of the neighbours of grid points on all sides, and of the points whose neighbours they are."""
    targets, sources = list[Ints](), list[Ints]()
    for axis in range(3):
        stride = int(np.prod(shape[axis + 1 :]))
        for side in (-1, 1):
            beside = index[points, axis] + side
            inside = points[(beside >= 0) & (beside < shape[axis])]
            targets.append(inside + side * stride)
            sources.append(inside)
    return np.concatenate(targets), np.concatenate(sources)
