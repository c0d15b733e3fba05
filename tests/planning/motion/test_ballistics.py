import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.constants import AIR_DENSITY
from pnt_gym.planning import GRAVITY, apex, flight_state, flight_time, landing_point
from pnt_gym.planning.motion.ballistics import drag_shift

coordinate = st.floats(-3.0, 3.0)
vector = st.tuples(coordinate, coordinate, coordinate).map(np.array)


@given(vector, vector, coordinate)
def test_flight_ends_on_the_plane_on_its_way_down(position, velocity, plane):
    time = float(flight_time(position, velocity, plane))
    top_time, top = apex(position, velocity)
    if np.isnan(time):
        assert top[2] < plane + 1e-12 or (velocity[2] <= 0.0 and position[2] < plane)
        assert np.isnan(landing_point(position, velocity, plane)).all()
        return
    assert time >= 0.0
    end, speed = flight_state(position, velocity, time)
    assert abs(end[2] - plane) < 1e-12
    assert speed[2] <= 1e-6
    assert time >= top_time - 1e-7
    landing = landing_point(position, velocity, plane)
    np.testing.assert_allclose(landing[:2], end[:2], rtol=0, atol=1e-12)
    assert landing[2] == plane


@given(vector, vector)
def test_apex_is_the_highest_point(position, velocity):
    time, top = apex(position, velocity)
    later = flight_state(np.tile(position, (50, 1)), np.tile(velocity, (50, 1)), np.linspace(0.0, 2.0, 50))[0]
    assert (later[:, 2] <= top[2] + 1e-12).all()
    assert time == max(velocity[2], 0.0) / GRAVITY


def test_steep_descent_keeps_its_digits():
    # 1 mm above the plane at 1000 m/s down: the printed Eq. 9 subtracts two nearly equal numbers.
    time = flight_time(np.array([0.0, 0.0, 1e-3]), np.array([0.0, 0.0, -1e3]), 0.0)
    np.testing.assert_allclose(time, 1e-6 * (1.0 - 0.5 * GRAVITY * 1e-9), rtol=1e-15)


def test_batches_mix_reached_and_missed_planes():
    position = np.zeros((3, 3))
    velocity = np.array([[1.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, 0.0, -1.0]])
    time = flight_time(position, velocity, np.array([0.1, 0.5, 0.1]))
    assert np.isfinite(time[0])
    assert np.isnan(time[1:]).all()
    start, speed = flight_state(position, velocity, 0.0)
    np.testing.assert_array_equal(start, position)
    np.testing.assert_array_equal(speed, velocity)


def test_release_on_the_plane_without_rise_lands_at_once():
    assert flight_time(np.zeros(3), np.array([1.0, 0.0, 0.0]), 0.0) == 0.0


def landing_in_air(position, velocity, plane, drag_area, step=1e-4):
    """By small steps, second order."""
    x, v = position.copy(), velocity.copy()

    def pull(v):
        return np.array([0.0, 0.0, -GRAVITY]) - 0.5 * AIR_DENSITY * drag_area * np.linalg.norm(v) * v

    while True:
        middle = v + 0.5 * step * pull(v)
        ahead = x + step * middle
        if ahead[2] <= plane and middle[2] < 0.0:
            return x + (plane - x[2]) / middle[2] * middle
        x, v = ahead, v + step * pull(middle)


@pytest.mark.parametrize("velocity", [(2.0, 1.0, 1.5), (3.0, 0.0, -0.5), (0.5, -0.5, 3.0)])
def test_air_moves_the_landing_as_small_steps_say(velocity):
    position, velocity, plane = np.array([0.1, -0.3, -0.75]), np.array(velocity), -0.85
    free = landing_point(position, velocity, plane)
    for drag_area, tolerance in ((0.01, 0.01), (0.2, 0.15)):  # the second order grows with the drag
        shift = drag_shift(position, velocity, plane, np.asarray(drag_area))
        found = landing_in_air(position, velocity, plane, drag_area) - free
        assert shift[2] == pytest.approx(0.0, abs=1e-12)
        assert np.linalg.norm(shift[:2] - found[:2]) < tolerance * np.linalg.norm(found[:2])


def test_without_a_landing_air_moves_none():
    shift = drag_shift(np.array([[0.0, 0.0, -1.0]]), np.array([[1.0, 0.0, 0.1]]), 0.0, np.array([1.0]))
    assert np.isnan(shift).all()
