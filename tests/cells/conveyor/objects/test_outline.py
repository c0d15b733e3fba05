"""Footprints of objects on the belt against outlines drawn point by point."""

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.base.items import BOX, CYLINDER, ELLIPSOID
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.records import half_extent
from pnt_gym.cells.conveyor.planner import PickPlanner
from tests.tools.outlines import outlines


@pytest.fixture(scope="module")
def objects():
    planner = PickPlanner(ConveyorConfig.load("waste"))
    drawn = planner.draw([np.random.default_rng(3)], np.zeros(1, dtype=np.int64), 400)
    assert {ELLIPSOID, CYLINDER, BOX} == set(drawn.shape.ravel())
    return take(drawn, 0)


@pytest.mark.parametrize("heading", [0.0, 0.3, np.pi / 2, 2.0, -1.1])
def test_the_extent_is_that_of_the_outline(objects, heading):
    points = outlines(objects, np.zeros((len(objects.kind), 2)))
    reach = (points @ np.array([np.cos(heading), np.sin(heading)])).max(axis=1)
    # The ellipse is drawn with 24 corners, inside of the true one by up to 0.9 %.
    assert np.allclose(half_extent(objects, heading), reach, rtol=9e-3, atol=0.0)
    assert np.allclose(half_extent(objects, heading + np.pi), half_extent(objects, heading), rtol=1e-12)


def test_every_object_may_have_a_heading_of_its_own(objects):
    """Along its own length an object reaches as far as it is long, across it as far as it is wide."""
    assert np.allclose(half_extent(objects, objects.yaw), objects.size[:, 0] / 2, rtol=1e-12)
    assert np.allclose(half_extent(objects, objects.yaw + np.pi / 2), objects.size[:, 1] / 2, rtol=1e-12)
