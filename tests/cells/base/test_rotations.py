"""Rotations of many bodies at once, held to scipy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pnt_gym.cells.base.bodies import level_axes, turn_back, vertical, yaw_attitude

RANDOM = np.random.default_rng(3)
TURNS = Rotation.random(20, rng=RANDOM)
VECTORS = RANDOM.normal(size=(20, 3))
YAW = RANDOM.uniform(-4.0, 4.0, 20)


def quaternions(turns):
    return turns.as_quat(scalar_first=True)


def test_a_vector_in_the_axes_of_a_body_is_turned_back_by_its_yaw():
    expected = Rotation.from_euler("z", YAW[:, None]).inv().apply(VECTORS)
    assert turn_back(VECTORS, np.cos(YAW), np.sin(YAW)) == pytest.approx(expected, abs=1e-12)


def test_an_upright_body_is_turned_about_the_vertical_alone():
    turned = Rotation.from_quat(yaw_attitude(YAW), scalar_first=True)
    assert turned.as_rotvec() == pytest.approx(Rotation.from_euler("z", YAW[:, None]).as_rotvec(), abs=1e-12)


def test_axes_of_the_world_are_seen_by_a_body_as_turned_back():
    attitude = quaternions(TURNS)
    seen = np.stack([*level_axes(attitude), vertical(attitude[None])[0]], axis=1)
    assert seen == pytest.approx(TURNS.as_matrix(), abs=1e-12)
