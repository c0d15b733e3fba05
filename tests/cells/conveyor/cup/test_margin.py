"""What a cup can hold, against forces and moments added up one by one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.cells.base.items import SURFACES
from pnt_gym.cells.conveyor.cup.hold import Hold, smallest_margin

GRAVITY = 9.81
RADIUS = 0.018


def hold(force=15.0, mass=0.03, friction=0.5, depth=0.03, offset=0.004):
    return Hold(*(np.array([value]) for value in (force, mass, friction, depth, offset, RADIUS)))


def margin(one, acceleration):
    return least(one, np.array([acceleration]))


def least(one, accelerations):
    return float(smallest_margin(one, accelerations[None], np.array([len(accelerations)]), 1.0)[0][0])


def stays(one, acceleration):
    """Whether friction and the moment about the lip's edge suffice, in newtons and newton metres."""
    f, m, mu, z, e = (float(v[0]) for v in (one.force, one.mass, one.friction, one.depth, one.offset))
    down, sideways = m * (GRAVITY + acceleration[2]), m * float(np.hypot(*acceleration[:2]))
    pressed = f - down
    return pressed * mu > sideways and f * RADIUS > sideways * z + down * (e + RADIUS)


def test_a_hand_that_falls_faster_than_its_object_loses_nothing():
    assert margin(hold(), (0.0, 0.0, -20.0)) > 1e6


@given(
    st.floats(1.0, 60.0), st.floats(0.002, 0.5), st.floats(0.2, 0.8), st.floats(0.001, 0.15), st.floats(0.0, 0.03),
    st.tuples(*[st.floats(-60.0, 60.0)] * 3),
)  # fmt: skip
def test_a_margin_of_one_is_where_it_leaves(force, mass, friction, depth, offset, acceleration):
    one = hold(force, mass, friction, depth, offset)
    value = margin(one, acceleration)
    if abs(value - 1.0) > 1e-6:
        assert stays(one, acceleration) == (value > 1.0)


@given(st.floats(5.0, 60.0), st.floats(0.002, 0.2), st.floats(0.2, 0.8), st.floats(0.001, 0.15), st.floats(1.0, 3.0))
def test_no_direction_asks_for_more_than_the_safety(force, mass, friction, depth, safety):
    one = hold(force, mass, friction, depth)
    most = float(one.acceleration(safety)[0])
    if most <= 0.0:
        assert margin(one, (0.0, 0.0, 0.0)) <= safety * (1.0 + 1e-9)
        return
    tilt, turn = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, 721), np.linspace(0.0, np.pi, 3))
    ways = np.stack([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)], axis=-1).reshape(-1, 3)
    found = least(one, most * ways)
    assert found == pytest.approx(safety, rel=1e-4)
    assert found >= safety * (1.0 - 1e-9)


def test_rough_surfaces_need_more_safety_and_wet_ones_slip():
    assert SURFACES["rough"].safety > SURFACES["smooth"].safety
    assert SURFACES["wet"].friction < SURFACES["smooth"].friction < SURFACES["rough"].friction


def test_the_smallest_margin_and_the_first_below_one_are_those_of_arrays():
    rng = np.random.default_rng(0)
    fields = rng.uniform(
        [[5.0], [0.05], [0.3], [0.01], [0.0], [0.01]], [[30.0], [0.2], [0.8], [0.1], [0.02], [0.02]], (6, 80)
    )
    accelerations, counts, scale = rng.normal(scale=15.0, size=(80, 25, 3)), rng.integers(0, 26, 80), 0.8
    force, mass, friction, depth, offset, radius = fields[:, :, None]
    x, y, z = np.moveaxis(accelerations, 2, 0)
    sideways, down = mass * np.sqrt(x**2 + y**2), mass * (GRAVITY + z)
    peel = sideways * depth / radius + down * (offset / radius + 1.0)
    margins = force / np.maximum(np.maximum(down + sideways / friction, peel), 1e-9) / scale
    within = np.arange(25) < counts[:, None]
    low = (margins < 1.0) & within
    margin, lost_at = smallest_margin(Hold(*fields), accelerations, counts, scale)
    np.testing.assert_array_equal(margin, np.where(within, margins, np.inf).min(axis=1))
    np.testing.assert_array_equal(lost_at, np.where(low.any(axis=1), low.argmax(axis=1), -1))
    assert 0.1 < (lost_at >= 0).mean() < 0.9


@given(st.floats(1.0, 60.0), st.floats(0.002, 0.5), st.floats(0.2, 0.8), st.floats(0.0, 0.03), st.floats(1.0, 3.0))
def test_the_worst_direction_undoes_the_largest_acceleration(force, mass, friction, offset, safety):
    one = hold(force, mass, friction, 0.04, offset)
    most = one.acceleration(safety)
    if most[0] > 0.0:
        assert one.least_margin(most)[0] == pytest.approx(safety)


@given(st.floats(0.0, 6.3), st.floats(-1.5, 1.5), st.floats(0.1, 60.0))
def test_no_direction_is_worse_than_the_worst(azimuth, rise, size):
    level = size * np.cos(rise)
    towards = level * np.cos(azimuth), level * np.sin(azimuth), size * np.sin(rise)
    assert margin(hold(), towards) >= hold().least_margin(np.array([size]))[0] * (1.0 - 1e-12)
