"""The robot is simulated until the object is clear of the cup: what geometry lets pass must be none of a touch."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pnt_gym.cells.base.bodies import geom_placement, lying_size, vertical
from pnt_gym.cells.conveyor.config import LIP_GAP
from pnt_gym.cells.conveyor.cup.clearance import MARGIN, Bodies, Passage, may_touch, predict_passage
from pnt_gym.cells.conveyor.cup.hold import Parting
from pnt_gym.cells.conveyor.scene import CUP_LENGTH
from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core, whole_cycle

COUNT = 40
TOUCHY = {"base": "waste_plain", "motion": {"follow_through": {"window": 0.0}}}
"""Without a window after the release the cup brakes onto every other object."""
SOFT = {"base": "waste_plain", "cup": {"stiffness": 0.3}}
"""Objects leave swinging, under a lip that touches nothing."""


def both_ways(level, seed=0):
    """The same throws with the robot until the objects are clear, and to the end."""
    core = make_core(level, COUNT, seed=seed)
    context, plant = core.context, core.cell.plant
    plans, _ = core.plan(np.random.default_rng(seed).uniform(-0.5, 0.5, (COUNT, 2)))
    _, cycle = whole_cycle(core, plans)
    return context, plant.fly(context, cycle), plant.follow(context, cycle).flown


@pytest.mark.parametrize(
    "level", with_nightly(("nominal_plain", "waste_plain", "fast_plain", TOUCHY, SOFT), ["waste_plain", SOFT])
)
def test_without_the_robot_the_object_flies_and_lands_as_with_it(level):
    _, two, whole = both_ways(level)
    np.testing.assert_allclose(two.touchdown.landing, whole.touchdown.landing, atol=1e-9)
    np.testing.assert_array_equal(two.touchdown.recontact, whole.touchdown.recontact)
    np.testing.assert_array_equal(two.tracking_error, whole.tracking_error)
    np.testing.assert_allclose(two.effort.torque, whole.effort.torque, atol=6.0)


@pytest.mark.parametrize("level", with_nightly(("waste_plain", "tight_plain"), ["tight_plain"]))
def test_what_is_decided_early_stays_so(level):
    """In 80 throws one at most may differ: an object that rolls on a rim goes either way by a rounding."""
    differing = 0
    for seed in range(2):
        context, *both = both_ways(level, seed)
        lies = [
            flown.touchdown.landing_fields(context.target, context.opening, np.array([0.3]), context.direction)[
                "in_bin"
            ]
            for flown in both
        ]
        differing += int((lies[0] != lies[1]).sum())
    assert differing <= 1


def test_a_cup_that_comes_back_is_simulated():
    _, two, whole = both_ways(TOUCHY)
    assert whole.touchdown.recontact.sum() > COUNT / 10
    np.testing.assert_array_equal(two.touchdown.recontact, whole.touchdown.recontact)


def objects_like(count, seed):
    return make_core("waste", count, seed=seed).context.objects


def true_distance(objects, row, apart, attitude):
    """Of cup and object by the engine's own collision code [m]."""
    kind = ["ellipsoid", "cylinder", "box"][objects.shape[row]]
    full = lying_size(objects.shape, objects.size)
    placed = geom_placement(objects.shape, full)
    sizes = " ".join(map(str, placed.size[row]))
    turn = " ".join(map(str, placed.quat[row]))
    below = objects.com_depth[row] - LIP_GAP - full[row, 2] / 2
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>
      <geom name="cup" type="cylinder" size="{objects.cup_radius[row]} {CUP_LENGTH / 2}" pos="0 0 {CUP_LENGTH / 2}"/>
      <body pos="{" ".join(map(str, apart))}" quat="{" ".join(map(str, attitude))}">
        <geom name="object" type="{kind}" size="{sizes}" quat="{turn}" pos="0 0 {below}"/></body>
      </worldbody></mujoco>""")
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return mujoco.mj_geomDistance(model, data, model.geom("cup").id, model.geom("object").id, 1.0, None)


def test_what_passes_as_clear_is_farther_away_than_the_margin():
    rng, count = np.random.default_rng(0), 400
    objects = objects_like(count, 3)
    apart = rng.normal(0.0, 0.08, (count, 1, 3)) - [0.0, 0.0, 0.05]
    attitude = rng.normal(size=(count, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    passage = Passage(apart, np.zeros_like(apart), vertical(attitude[:, None]))
    possible = may_touch(Bodies.of(objects), passage, 0.0, MARGIN, 0.0)[:, 0]
    distance = np.array([true_distance(objects, row, apart[row, 0], attitude[row]) for row in range(count)])
    assert (distance[~possible] > MARGIN - 1e-6).all()
    assert (~possible).sum() > count / 4
    assert possible.sum() > count / 4


def test_objects_are_foreseen_to_fall_and_turn_as_they_were_let_go():
    rng, since = np.random.default_rng(0), np.array([0.0, 0.05, 0.1])
    place, velocity = rng.normal(size=(5, 3, 3)), rng.normal(size=(5, 3, 3))
    attitude, spin = Rotation.random(5, random_state=2), rng.normal(0.0, 4.0, (5, 3))
    apart, drift = rng.normal(0.0, 0.03, (5, 3)), rng.normal(0.0, 0.2, (5, 3))
    parting = Parting(apart, drift, attitude.as_quat(scalar_first=True), spin, np.zeros(5), np.zeros(5, dtype=bool))
    turned = np.linalg.norm(spin, axis=1)[:, None] * since
    passage = predict_passage(parting, place, velocity, since, np.cos(turned), np.sin(turned))
    for k, t in enumerate(since):
        began = velocity[:, 0] + drift
        free = place[:, 0] + apart + began * t - [0, 0, 9.81 / 2 * t**2]
        np.testing.assert_allclose(passage.centre[:, k], free - place[:, k], atol=1e-12)
        np.testing.assert_allclose(passage.drift[:, k], began - [0, 0, 9.81 * t] - velocity[:, k], atol=1e-12)
        turn = attitude * Rotation.from_rotvec(spin * t)
        np.testing.assert_allclose(passage.up[:, k], turn.inv().apply([0, 0, 1]), atol=1e-12)
    resting = parting._replace(rate=np.zeros((5, 3)))
    still = predict_passage(resting, place, velocity, since, np.ones((5, 3)), np.zeros((5, 3)))
    np.testing.assert_allclose(still.up, np.repeat(still.up[:, :1], 3, axis=1), atol=1e-12)
