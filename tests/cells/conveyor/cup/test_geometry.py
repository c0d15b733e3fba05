"""Compiled geometry of cups and objects, held to NumPy's formulas and to scipy's rotations on random rows."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pnt_gym.cells.base.airborne import STATE
from pnt_gym.cells.base.bodies import vertical
from pnt_gym.cells.base.items import BOX, CYLINDER, ELLIPSOID
from pnt_gym.cells.conveyor.config import LIP_GAP
from pnt_gym.cells.conveyor.cup.clearance import Bodies, Passage, may_touch
from pnt_gym.cells.conveyor.cup.hold import Parting
from pnt_gym.cells.conveyor.cup.swing import TILT_COSINE, Swing, find_solid, part_objects
from tests.tools.throws import make_core

COUNT, MOMENTS, STRIDE, LIP = 60, 12, 4, 0.01


@pytest.fixture(scope="module")
def objects():
    drawn = make_core("waste", COUNT, seed=3).context.objects
    assert {ELLIPSOID, CYLINDER, BOX} == set(drawn.shape)
    return drawn


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def quaternions(turns, *shape):
    return turns.as_quat(scalar_first=True).reshape(*shape, 4)


def support(objects, up):
    """Extents of boxes, cylinders along x and ellipsoids from their middles along `up` (N, K, 3)."""
    parts = np.abs(up) * objects.extents[:, None] / 2.0
    round_part, shape = np.linalg.norm(parts[..., 1:], axis=-1), objects.shape[:, None]
    return np.select(
        [shape == BOX, shape == CYLINDER], [parts.sum(axis=-1), parts[..., 0] + round_part],
        np.linalg.norm(parts, axis=-1),
    )  # fmt: skip


def is_near(objects, passage, gap, margin, lip):
    """Which moments may have a touch: the object rises to the solid part of the cup and is not beside it."""
    room = margin + gap / 2.0 * np.linalg.norm(passage.drift, axis=-1)
    height, radius = objects.extents[:, None, 2], objects.cup_radius[:, None]
    middle, upright = objects.com_depth[:, None] - LIP_GAP - height / 2.0, passage.up[..., 2]
    sideways, tilt = np.linalg.norm(passage.centre[..., :2], axis=-1), np.sqrt(np.maximum(1.0 - upright**2, 0.0))
    face = (height / 2.0 + tilt * (sideways + np.abs(middle) * tilt + radius)) / np.maximum(np.abs(upright), 1e-9)
    top = passage.centre[..., 2] - lip + middle * upright + np.minimum(support(objects, passage.up), face)
    wide = radius + np.abs(middle) + np.linalg.norm(objects.extents, axis=1)[:, None] / 2.0
    return (top > -room) & (sideways < wide + room)


def passages(rng):
    centre = rng.normal(0.0, 0.08, (COUNT, MOMENTS, 3)) - [0.0, 0.0, 0.05]
    up = vertical(quaternions(Rotation.random(COUNT * MOMENTS, rng=rng), COUNT, MOMENTS))
    return Passage(centre, rng.normal(0.0, 2.0, centre.shape), up)


@pytest.mark.parametrize("lip", [0.0, LIP])
def test_possible_touches_are_those_of_the_formula(objects, rng, lip):
    passage = passages(rng)
    near = may_touch(Bodies.of(objects), passage, 0.004, 0.002, lip)
    np.testing.assert_array_equal(near, is_near(objects, passage, 0.004, 0.002, lip))
    assert 0.2 < near.mean() < 0.8


def test_the_vertical_is_that_of_the_attitude(rng):
    turns = Rotation.random(COUNT * MOMENTS, rng=rng)
    up = vertical(quaternions(turns, COUNT, MOMENTS))
    np.testing.assert_allclose(up.reshape(-1, 3), turns.inv().apply([0, 0, 1]), atol=1e-12)


def test_objects_leave_with_the_turn_and_the_speed_of_their_swing(rng):
    yaw, turns = rng.uniform(-4.0, 4.0, COUNT), Rotation.random(COUNT, rng=rng)
    rate, arm, before = rng.normal(size=(3, COUNT, 3))
    rest = Rotation.from_euler("z", yaw[:, None])
    state, none = np.zeros((COUNT, STATE)), np.zeros(COUNT)
    state[:, 3:7], state[:, 10:] = quaternions(turns, COUNT), rate
    hanging = Parting(arm, before, quaternions(rest, COUNT), np.zeros_like(rate), none, none > 0.0)
    parting = part_objects(state, arm, hanging, np.cos(yaw), np.sin(yaw), none > 0.0)
    np.testing.assert_array_equal(parting.rate, rate)
    np.testing.assert_allclose(parting.centre, (rest * turns).apply(arm), atol=1e-12)
    np.testing.assert_allclose(parting.velocity, before + (rest * turns).apply(np.cross(rate, arm)), atol=1e-12)
    parted = Rotation.from_quat(parting.attitude, scalar_first=True)
    np.testing.assert_allclose((parted.inv() * rest * turns).magnitude(), 0.0, atol=1e-7)


def test_objects_that_touch_the_belt_or_their_cups_are_those_of_the_formula(objects, rng):
    turns = Rotation.from_rotvec(rng.normal(0.0, 0.2, (COUNT * MOMENTS, 3)))
    attitudes, up = quaternions(turns, COUNT, MOMENTS), turns.inv().apply([0, 0, 1]).reshape(COUNT, MOMENTS, 3)
    steps, floor = rng.integers(1, MOMENTS * STRIDE, COUNT), -0.9
    hand = rng.uniform(-0.82, -0.5, (COUNT, MOMENTS * STRIDE, 3))
    arm, middle = rng.normal(0.0, 0.01, (COUNT, 3)) - [0.0, 0.0, 0.03], rng.normal(0.0, 0.003, COUNT)
    swing = Swing(attitudes, hand, steps, STRIDE)
    touched = find_solid(Bodies.of(objects), arm, middle, swing, LIP, floor)
    moments = np.minimum(np.arange(MOMENTS) * STRIDE, steps[:, None])
    tip = np.take_along_axis(hand[..., 2], moments, axis=1)
    below = ((arm + np.stack([0 * middle, 0 * middle, middle], axis=1))[:, None] * up).sum(axis=-1)
    low = tip + below - support(objects, up)
    tilt = np.arccos(up[..., 2])
    steep = (objects.cup_radius[:, None] * np.sin(tilt) > LIP) | (tilt > np.arccos(TILT_COSINE))
    touches_cup, touches_belt = steep.any(axis=1), (low < floor).any(axis=1)
    np.testing.assert_array_equal(touched, touches_cup | touches_belt)
    assert (touches_cup & ~touches_belt).any()
    assert (touches_belt & ~touches_cup).any()
    assert not touched.all()
