"""Energy of a toss: what the motors put in is what robot and object gained, and what damping took."""

import numpy as np

from pnt_gym.cells.base.core import Core
from pnt_gym.cells.base.plant import roll_out
from pnt_gym.cells.base.recorded import MotorRecord, loads_of_steps
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from tests.tools.throws import engine_energy

COUNT = 5


def test_motors_put_in_what_is_gained_and_what_damping_takes():
    """Until the claws are told to open; the air and the pads' friction take next to nothing."""
    core = Core(GripperCell(GripperConfig.load("nominal"), COUNT))
    core.reset(np.arange(COUNT), [np.random.default_rng(row) for row in range(COUNT)], seeded=True)
    cell, throws = core.cell, core.context
    plant, plans, step = cell.plant, throws.plans, cell.config.timestep
    steps = np.floor(plans.open_time / step).astype(np.int64)
    plant.write(throws, plans)
    control = plant._controls(plans, throws.kind, throws.hidden, int(steps.max()))
    models = [plant.batch.get_model(row) for row in range(COUNT)]
    states = zip(models, plant.batch.bind("qpos"), plant.batch.bind("qvel"), strict=True)
    begin = [engine_energy(*state) for state in states]
    record = roll_out(plant.batch, control, steps, ("sensordata", "qpos", "qvel"))
    put_in, taken = (
        loads_of_steps(
            MotorRecord(sign * record["sensordata"], plant.torques, record["qvel"], plant.motors), steps, step
        )[1]
        for sign in (1.0, -1.0)
    )
    for row in range(COUNT):
        last, model = steps[row] - 1, models[row]
        gained = engine_energy(model, record["qpos"][row, last], record["qvel"][row, last]) - begin[row]
        damped = (model.dof_damping * record["qvel"][row, : last + 1] ** 2).sum() * step
        assert gained > 0.05
        np.testing.assert_allclose(put_in[row] - taken[row], gained + damped, rtol=0.03)


def test_a_throw_tells_more_than_what_it_gains():
    core = Core(GripperCell(GripperConfig.load("nominal"), COUNT))
    core.reset(np.arange(COUNT), [np.random.default_rng(row) for row in range(COUNT)], seeded=True)
    told = core.step(np.zeros((COUNT, 3))).info["energy"]
    assert (told > 1.0).all()
    assert (told < 20.0).all()
