"""Falls near bins that end early: decided as the engine decides, and flown as the engine flies."""

from typing import Any

import numpy as np
import pytest

from benchmarks.studies.cells import CELLS
from benchmarks.studies.flights import EngineCheck
from pnt_gym.arrays import take
from pnt_gym.cells.base.airborne import Airborne, BinShape, Body, Ground, Solid, Vicinity
from pnt_gym.cells.base.bodies import contact_solref
from pnt_gym.cells.base.settle_kernel import FALLING, OVER, STAYS, fill_rebounds, follow
from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core

STEP = 0.001
BALL = Solid.zeros(1, half=0.03, spin=4e-4, rebound=0.4, farthest=0.03)
BINS = BinShape.zeros(1, 1, half_x=0.1, half_y=0.1, depth=0.3)
EMPTY_BELT = Ground.zeros(1, floor=-0.4, belt=-0.5, min_x=5.0, max_x=6.0, min_y=5.0, max_y=6.0)
BELT = Ground.zeros(1, floor=-0.4, belt=-0.06, min_x=0.4, max_x=1.0, min_y=-1.0, max_y=1.0)


def judge(place, velocity, spin=(0.0, 0.0, 0.0), *, solid=BALL, bins=BINS, ground=EMPTY_BELT, steps=1000, energy=-9.0):
    """Verdict on an object at a bin whose rim is at height 0, its last state, and the steps left to it."""
    state = np.array([[*place, 1.0, 0.0, 0.0, 0.0, *velocity, *spin]])
    left, verdict, body = np.array([steps]), np.array([FALLING]), Body.zeros(1, mass=0.02)
    body["inertia"], body["attitude"][:, 0], body["semi_axes"] = 0.02 * solid["spin"], 1.0, solid["half"]
    objects, vicinity = Airborne(body, np.zeros((1, 2)), 0.0), Vicinity(solid, bins, np.zeros(1), ground)
    follow(state, objects, vicinity, STEP, np.full(1, energy), left, verdict)
    return verdict[0], state[0], left[0]


def changed(rows, **values):
    """The rows with other values of some fields."""
    rows = rows.copy()
    for name, value in values.items():
        rows[name] = value
    return rows


class Flights:
    """Throws of a level near openings, with the arguments and the ends of their falls."""

    def __init__(self, level, steps, seed=0):
        core = make_core({"base": level, "fidelity": "flight"}, CELLS, seed=seed)
        cell: Any = core.cell
        self.free: Any = cell.plant.free
        self.check: Any = EngineCheck(self.free, core.config)
        self.falls, self.free.settle = [], self.settle
        actions = np.random.default_rng(seed).uniform(-0.4, 0.4, (steps, CELLS, 2))
        for step in range(steps):
            core.step(actions[step])

    def settle(self, *arguments):
        end = self.check.settle(*arguments)
        self.falls.append((arguments, end))
        return end


@pytest.mark.parametrize("level", with_nightly(["waste", "nominal", "tight", "unseen", "light"], ["waste", "nominal"]))
def test_the_engine_decides_nothing_otherwise(level):
    flights = Flights(level, 8)
    assert flights.check.near > 200
    assert flights.check.early > 0.8 * flights.check.near
    assert flights.check.untouched > 0
    assert flights.check.differing == 0


def test_the_check_sees_an_object_that_leaves_its_bin():
    flights = Flights("waste", 1)
    (rows, context, flying, state, steps), end = flights.falls[0]
    stays = np.flatnonzero(end.stays & (end.position[:, 2] < context.target[:, 2]))
    end.state[stays, 9] = 6.0  # upwards, far beyond the rim
    flights.check._settle = lambda *_: end
    before = flights.check.differing
    flights.check.settle(rows, context, flying, state, steps)
    assert flights.check.differing - before > stays.size / 2


def test_a_flight_without_contact_is_the_engines():
    """So no contact was missed: the engine comes to the same state with as many steps."""
    flights = Flights("nominal", 4)
    count = 0
    for (rows, context, _, state, steps), end in flights.falls:
        free = np.flatnonzero((end.simulated == 0) & (steps > end.steps))
        free = free[np.argsort(steps[free] - end.steps[free])]
        for row in free[-3:]:
            taken = int(steps[row] - end.steps[row])
            one = [row]
            flights.free._write(rows[one], take(context, one), state[one, :7], state[one, 7:])
            batch = flights.free.batch
            batch.rollout(taken, record=(), ids=rows[one])
            found = np.concatenate([batch.bind("qpos")[rows[row]], batch.bind("qvel")[rows[row]]])
            np.testing.assert_allclose(found, end.state[row], rtol=0.0, atol=5e-6)  # a contact changes more
            count += taken
    assert count > 300


def test_an_object_above_the_middle_of_its_opening_flies_in_and_stays():
    verdict, state, left = judge((0.0, 0.0, 0.1), (0.0, 0.0, -2.0))
    assert verdict == STAYS
    assert -0.3 < state[2] < 0.0
    fallen = (np.sqrt(2.0**2 + 2 * 9.81 * (0.1 - state[2])) - 2.0) / 9.81
    assert (1000 - left) * STEP == pytest.approx(fallen, abs=0.002)


def test_an_object_above_a_rim_flies_to_the_rim():
    verdict, state, _ = judge((0.1, 0.0, 0.2), (0.0, 0.0, -2.0))
    assert verdict == FALLING
    assert 0.03 < state[2] < 0.03 + 0.006


@pytest.mark.parametrize(
    ("place", "velocity", "changes", "verdict"),
    [
        ((0.0, 0.0, -0.1), (0.0, 0.0, -2.0), {}, STAYS),
        ((0.0, 0.0, -0.1), (0.0, 0.0, -2.0), {"solid": changed(BALL, rebound=0.6)}, STAYS),
        ((0.0, 0.0, -0.1), (0.0, 0.0, -2.0), {"solid": changed(BALL, rebound=1.0)}, FALLING),
        ((0.0, 0.0, -0.035), (0.0, 0.0, -2.0), {}, STAYS),
        ((0.0, 0.0, -0.035), (0.0, 0.0, -2.0), {"bins": changed(BINS, depth=0.06)}, FALLING),
        ((0.069, 0.0, -0.1), (0.0, 0.0, 2.0), {}, FALLING),  # upwards, beside a wall
        ((0.069, 0.0, -0.1), (8.0, 0.0, -0.5), {}, FALLING),  # so fast that walls may send it up
        ((0.069, 0.0, -0.1), (0.0, 0.0, -0.5), {"spin": (400.0, 0.0, 0.0)}, FALLING),
        ((0.069, 0.0, -0.1), (0.0, 0.0, -2.0), {"energy": 2.0}, FALLING),  # a contact holds the difference
        ((0.15, 0.0, -0.1), (0.0, 0.0, -2.0), {}, STAYS),  # beside the bin
        ((0.15, 0.0, -0.035), (0.0, 0.0, -2.0), {"ground": changed(BELT, min_x=0.1)}, FALLING),
        ((0.15, 0.0, -0.035), (0.0, 0.0, -2.0), {"ground": BELT}, STAYS),
        ((0.0, 0.0, -0.1), (0.0, 0.0, 0.0), {}, OVER),  # too weak to rise to the rim
        ((0.0, 0.0, -0.1), (0.0, 0.0, -2.0), {"steps": 1}, OVER),
        ((0.069, 0.0, -0.1), (0.0, 0.0, -2.0), {"steps": 100}, FALLING),  # it may not be down when its time is over
    ],
)
def test_an_object_is_judged_where_no_rebound_can_lift_it_over_a_rim(place, velocity, changes, verdict):
    assert judge(place, velocity, **changes)[0] == verdict


@pytest.mark.parametrize(("restitution", "slack"), [(0.1, 0.01), (0.25, 0.01), (0.4, 0.01), (0.6, 0.01), (0.9, 0.01)])
def test_no_rebound_in_the_engine_is_greater_than_the_largest(restitution, slack):
    """Objects without spin that fall on the bottoms of their bins from a hundred heights."""
    core = make_core({"base": "waste", "fidelity": "flight", "items": ["paper_ball"], "mismatch": 0.001}, 100)
    cell: Any = core.cell
    free, context, rows = cell.plant.free, cell.context, np.arange(100)
    context = context.replace(objects=context.objects.replace(restitution=restitution))
    qpos, qvel = np.zeros((100, 7)), np.zeros((100, 6))
    qpos[:, :3], qpos[:, 3], qvel[:, 2] = context.target, 1.0, -2.5
    qpos[:, 2] -= np.linspace(0.06, 0.09, 100)
    free._write(rows, context, qpos, qvel)
    speed = free.batch.rollout(100, record=("qvel",), ids=rows)["qvel"][..., 2]
    largest = np.empty(1)
    fill_rebounds(contact_solref([restitution]), core.config.timestep, largest)
    assert largest[0] - slack < (speed.max(axis=1) / -speed.min(axis=1)).max() < largest[0] + 0.003


@pytest.mark.parametrize(("step", "restitution"), [(0.001, 0.87), (0.002, 0.32)])
def test_contacts_gain_speed_in_steps_of_the_engine_from_the_restitutions_that_the_settings_name(step, restitution):
    largest = np.empty(2)
    fill_rebounds(np.ascontiguousarray(contact_solref([restitution - 0.01, restitution])), step, largest)
    assert largest[0] < 1.0 < largest[1]
