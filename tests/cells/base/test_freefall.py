"""Flights in machine code are those of MuJoCo: the same fluid model, the same steps."""

import mujoco
import numpy as np
import pytest

from pnt_gym.cells.base.airborne import STATE, Airborne, Body
from pnt_gym.cells.base.bodies import fluid_coefficients, geom_placement, lying_size, solid_shell_inertia
from pnt_gym.cells.base.freefall import end_settled, fly_down

COUNT, STEP, STRIDE = 9, 0.001, 4
SHAPES = ("ellipsoid", "cylinder", "box")


def things(rng):
    """Shape, extents, mass, drag and height of the geom above the centre of mass of nine objects."""
    shape = np.arange(COUNT) % 3
    size = lying_size(shape, rng.uniform(0.01, 0.2, (COUNT, 3)))
    return shape, size, rng.uniform(0.002, 0.2, COUNT), rng.uniform(0.4, 1.4, COUNT), rng.normal(0.0, 0.01, COUNT)


def bodies(shape, size, mass, drag, up):
    placed = geom_placement(shape, size)
    semi = np.where((shape == 1)[:, None], placed.size[:, [0, 0, 1]], placed.size)
    inertia, fluid = solid_shell_inertia(mass, size, shape), fluid_coefficients(shape, size, drag)
    columns = np.concatenate([mass[:, None], inertia, up[:, None], placed.quat, semi, fluid], axis=1)
    return columns.view(Body.dtype)[:, 0]


def in_the_engine(things_, row, state, steps, air, wind=(0.0, 0.0)):
    """The same flight stepped by MuJoCo, in a wind along x and y."""
    shape, size, mass, drag, up = (each[row : row + 1] for each in things_)
    placed, inertia = geom_placement(shape, size), solid_shell_inertia(mass, size, shape)[0]
    sizes, turn = " ".join(map(str, placed.size[0])), " ".join(map(str, placed.quat[0]))
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><option timestep="{STEP}" density="{1.2 * air}"
      viscosity="{1.8e-5 * air}" gravity="0 0 -9.81" integrator="Euler"
      wind="{wind[0]} {wind[1]} 0"/><worldbody><body pos="0 0 0"><freejoint/>
      <inertial pos="0 0 0" mass="{mass[0]}" diaginertia="{" ".join(map(str, inertia))}"/>
      <geom type="{SHAPES[shape[0]]}" size="{sizes}" quat="{turn}" pos="0 0 {up[0]}" fluidshape="ellipsoid"/>
      </body></worldbody></mujoco>""")
    model.geom_fluid[0] = fluid_coefficients(shape, size, drag)[0]
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = state[:7], state[7:]
    for _ in range(steps):
        mujoco.mj_step(model, data)
    return np.concatenate([data.qpos, data.qvel])


def thrown(rng):
    state = np.zeros((COUNT, STATE))
    state[:, :3] = rng.normal(size=(COUNT, 3)) + np.array([0.0, 0.0, 2.0])
    state[:, 3:7] = rng.normal(size=(COUNT, 4))
    state[:, 3:7] /= np.linalg.norm(state[:, 3:7], axis=1, keepdims=True)
    state[:, 7:10], state[:, 10:] = rng.normal(0.0, 2.0, (COUNT, 3)), rng.normal(0.0, 8.0, (COUNT, 3))
    state[0, 7:] = 0.0  # at rest, where directions of flow do not exist
    return state


def flown(state, body, floor, air, records, wind=0.0):
    seen, steps = np.zeros((COUNT, records, STATE)), np.zeros(COUNT, dtype=np.int64)
    after = state.copy()
    fly_down(after, Airborne(body, np.zeros((COUNT, 2)) + wind, air), np.full(COUNT, floor), STEP, STRIDE, seen, steps)
    return after, seen, steps


@pytest.mark.parametrize("air", [0.0, 1.0, 2.5])
def test_a_flight_in_a_wind_is_that_of_the_engine(air):
    """Each object in its own; one without wind is as it was, and one that goes with it feels none."""
    rng = np.random.default_rng(6)
    objects, state, wind = things(rng), thrown(rng), rng.normal(0.0, 1.5, (COUNT, 2))
    wind[1] = 0.0
    body = bodies(*objects)
    after, seen, taken = flown(state, body, -50.0, air, 76, wind)
    still, *_ = flown(state, body, -50.0, air, 76)
    assert (taken == 300).all()
    for row in range(COUNT):
        for found, steps in ((after[row], 300), (seen[row, 10], 10 * STRIDE)):
            expected = in_the_engine(objects, row, state[row], steps, air, wind[row])
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(still[row], in_the_engine(objects, row, state[row], 300, air), rtol=1e-9, atol=1e-9)
        assert np.array_equal(after[row], still[row]) == (row == 1 or air == 0.0)
    carried = state.copy()
    carried[:, 7:9] += wind
    moving, *_ = flown(carried, body, -50.0, air, 76, wind)
    with_it = still.copy()
    with_it[:, :2] += 0.3 * wind
    with_it[:, 7:9] += wind
    np.testing.assert_allclose(moving, with_it, rtol=1e-9, atol=1e-8)


def test_it_ends_below_its_height_and_keeps_its_last_state():
    rng = np.random.default_rng(4)
    objects, state = things(rng), thrown(rng)
    after, seen, steps = flown(state, bodies(*objects), 0.5, 1.0, 500)
    assert ((after[:, 2] < 0.5) & (after[:, 9] < 0.0)).all()
    assert ((after[:, 2] - STEP * after[:, 9] >= 0.5) | (steps <= 1)).all()
    for row, count in enumerate(steps):
        np.testing.assert_array_equal(seen[row, 0], state[row])
        np.testing.assert_array_equal(
            seen[row, -(-count // STRIDE) :], np.broadcast_to(after[row], (500 - -(-count // STRIDE), STATE))
        )


def test_a_fall_ends_where_the_energy_no_longer_lifts_the_object_to_the_rim():
    """Kinetic and potential energy per weight, of objects that are some of many."""
    rng = np.random.default_rng(8)
    count, rows = 200, np.flatnonzero(rng.random(200) < 0.7)
    steps = rng.integers(50, 200, count)
    sensors, rate = rng.normal(size=(rows.size, 3, 8)), 5.0 * rng.normal(size=(rows.size, 3))
    inertia, mass, rim = (
        rng.uniform(1e-5, 1e-3, (count, 3)),
        rng.uniform(0.01, 0.1, count),
        rng.uniform(0.0, 0.6, count),
    )
    last = steps.copy()
    end_settled(sensors, rate, rows, inertia / mass[:, None], rim, 128, last)
    velocity = sensors[:, -1, 3:6]
    kinetic = (mass[rows, None] * velocity**2 + inertia[rows] * rate**2).sum(axis=1) / 2.0
    settled = sensors[:, -1, 2] + kinetic / (mass[rows] * 9.81) < rim[rows]
    expected = steps.copy()
    expected[rows[settled]] = np.minimum(steps[rows[settled]], 128)
    assert 20 < settled.sum() < rows.size - 20
    np.testing.assert_array_equal(last, expected)
