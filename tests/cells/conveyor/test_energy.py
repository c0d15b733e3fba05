"""Energy of a cycle: work in less work out is what the machine gained, by the engine's own account of its energy."""

import numpy as np
import pytest

from pnt_gym.arrays import in_order
from pnt_gym.cells.base.plant import roll_out
from pnt_gym.cells.base.recorded import loads_between
from pnt_gym.cells.conveyor.hand import ThrowClock
from pnt_gym.robots.t3kr.kinematics import closed_pose
from tests.tools.throws import engine_energy, make_core, same_bits, vary, whole_cycle

COUNT = 6
ROWS = np.arange(COUNT)


@pytest.fixture(scope="module")
def begun():
    """A cell of the planner's own world, its coming throws, and their clock."""
    core = make_core("ideal", COUNT, seed=3)
    picks, elsewhere = core.context, core.context.pick + np.array([0.05, 0.02, 0.03])
    clock = ThrowClock.of(picks, whole_cycle(core, following=elsewhere)[1], core.config)
    return core, picks, clock, elsewhere


def test_motors_put_in_what_robot_and_object_gain(begun):
    """Up to the release, in vacuum: fast, and higher than before."""
    core, picks, clock, _ = begun
    plant = core.cell.plant
    plant.write(picks)
    models = [plant.batch.get_model(row) for row in ROWS]
    states = zip(models, plant.batch.bind("qpos"), plant.batch.bind("qvel"), strict=True)
    before = np.array([engine_energy(*state) for state in states])
    control = plant._references(ROWS, picks, clock, clock.release + 1)
    record = roll_out(plant.batch, control, clock.release + 1, ("sensordata", "qpos", "qvel"), ROWS)
    places, rates = (record[name][ROWS, clock.release - 1] for name in ("qpos", "qvel"))
    gained = np.array([engine_energy(*state) for state in zip(models, places, rates, strict=True)]) - before
    put_in, taken = (
        plant._effort(
            {"sensordata": sign * record["sensordata"], "qvel": record["qvel"]}, clock.release, clock.step
        ).energy
        for sign in (1.0, -1.0)
    )
    assert (gained > 5.0).all()
    np.testing.assert_allclose(put_in - taken, gained, rtol=0.01)


def test_a_planned_cycle_from_rest_to_rest_gains_only_height(begun):
    core, picks, clock, elsewhere = begun
    plant = core.cell.plant
    steps = np.minimum(np.arange(0, clock.end.max() + clock.stride, clock.stride), clock.end[:, None])
    knots = plant.scene.robot.motion(*clock.hand(steps)).within_reach()
    put_in, taken = (
        loads_between(*in_order(sign * knots.torque, knots.velocity, steps * clock.step))[1] for sign in (1.0, -1.0)
    )
    model = plant.scene.model
    lifted = np.empty((2, COUNT))
    for k, place in enumerate((picks.pick, elsewhere)):
        for row in ROWS:
            pose = model.qpos0.copy()
            pose[plant._robot_qpos] = closed_pose((place + picks.cup_offset)[row], 1, plant.scene.robot.geometry)
            lifted[k, row] = engine_energy(model, pose, 0.0)
    np.testing.assert_allclose(put_in - taken, lifted[1] - lifted[0], atol=0.01 * put_in.min())
    assert same_bits(plant._effort_of_plan(clock, np.zeros(COUNT, dtype=np.int64)).energy, put_in)


@pytest.mark.parametrize("level", ["nominal_plain", "waste_plain"])
def test_flights_cost_what_the_robot_does(level):
    """As planned, without the object and without what the controller adds: a few per cent less."""
    found = [
        make_core(vary(level, fidelity=fidelity), 24).step(np.zeros((24, 2))).info["energy"]
        for fidelity in ("full", "flight")
    ]
    np.testing.assert_allclose(found[1], found[0], rtol=0.06)
    assert (found[0] > 10.0).all()


def test_a_faster_throw_costs_more():
    slow, fast = (
        make_core(vary("waste_plain", limits={"percent": [percent]}), 24).step(np.zeros((24, 2))).info["energy"]
        for percent in (30, 45)
    )
    assert (fast > slow).mean() > 0.9
