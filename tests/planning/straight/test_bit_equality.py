"""A row of a batch is the same, bit for bit, whatever the other rows are."""

import dataclasses

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.planning import (
    EllipticWorkspace,
    MotionLimits,
    min_time_scurve,
    plan_intercept,
    plan_release_batch,
    release_at_elevation,
    release_at_point,
)
from pnt_gym.planning.straight import release
from pnt_gym.rows import Columns
from tests.tools.planning import random_throws
from tests.tools.throws import same_bits

COUNT = 1000
PICKS, TARGETS, NUMBERS = random_throws(COUNT, seed=41)
LIMITS = MotionLimits(*NUMBERS)
SPACE = EllipticWorkspace(z_max=-0.7)


def free(rows):
    return plan_release_batch(PICKS[rows], TARGETS[rows], take(LIMITS, rows))


def ceiling(rows):
    return plan_release_batch(PICKS[rows], TARGETS[rows], take(LIMITS, rows), ceiling=-0.8, tolerance=0.005)


def workspace(rows):
    return plan_release_batch(PICKS[rows], TARGETS[rows], take(LIMITS, rows), ceiling=-0.7, workspace=SPACE)


def elevation(rows):
    return release_at_elevation(PICKS[rows], TARGETS[rows], take(LIMITS, rows), 0.3)


def point(rows):
    half = 0.5 * (PICKS[rows] + TARGETS[rows])
    return release_at_point(PICKS[rows], half, take(LIMITS, rows), plane_z=-1.0)


def curve(rows):
    return min_time_scurve(np.linalg.norm(TARGETS - PICKS, axis=1)[rows], take(LIMITS, rows))


def meeting(rows):
    upstream = PICKS[rows] - [0.5, 0.0, 0.1]
    return plan_intercept(
        TARGETS[rows], upstream, (0.4, 0.1, 0.0), take(LIMITS, rows), clearance=0.05, window=(-0.4, 0.4)
    )


@pytest.mark.parametrize("plan", [free, ceiling, workspace, elevation, point, curve, meeting])
def test_row_does_not_depend_on_its_batch(plan):
    whole = plan(slice(None))
    shuffled = np.random.default_rng(5).permutation(COUNT)
    parts = [np.array([k]) for k in range(0, COUNT, 25)]
    parts += [np.arange(64), np.arange(3, 70), np.arange(1, COUNT), shuffled]
    for rows in parts:
        part = plan(rows)
        for name in _columns(part):
            np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[rows], name)


@pytest.mark.parametrize("plan", [free, ceiling, workspace])
def test_a_batch_is_planned_in_pieces_that_ctrl_c_gets_in_between_of(monkeypatch, plan):
    whole, rows, sizes = plan(np.arange(COUNT)), release.kernel.choose_slopes, []

    def counted(given, *others):
        sizes.append(len(given))
        return rows(given, *others)

    monkeypatch.setattr(release.kernel, "choose_slopes", counted)
    monkeypatch.setattr(release, "PIECE", 300)
    pieces = plan(np.arange(COUNT))
    assert sizes[-4:] == [300, 300, 300, 100]
    assert all(same_bits(getattr(pieces, name), getattr(whole, name)) for name in _columns(whole))


def _columns(plans):
    """Names of the columns of releases, or of a dataclass of arrays."""
    return list(plans.fields) if isinstance(plans, Columns) else [field.name for field in dataclasses.fields(plans)]
