"""The compiled cell: bins and belt where the config says, and walls that hold what is thrown at them."""

from itertools import product

import mujoco
import numpy as np
import pytest

from pnt_gym.cells.base.catalogue import CATALOGUE, HELD_OUT_ITEMS, SEEN_ITEMS
from pnt_gym.cells.base.sorting import Bins
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.scene import SENSORS, bin_panels, build_scene
from tests.tools.nightly import with_nightly
from tests.tools.t3kr import control_columns
from tests.tools.throws import make_core, vary, with_objects

SPEED = 9.0
ITEMS = (*SEEN_ITEMS, *HELD_OUT_ITEMS)


def test_panels_leave_exactly_the_opening_free():
    bins = Bins(fixed=ConveyorConfig.load("nominal").bins.fixed, depth=0.3, wall=0.01)
    size = np.array([[0.2, 0.1], [0.12, 0.14]])
    half, centre = bin_panels(size, bins)
    low, high = centre - half, centre + half
    for k in range(2):
        np.testing.assert_allclose(low[k, 0, 0], size[k, 0] / 2)  # +x wall starts where the opening ends
        np.testing.assert_allclose(high[k, 1, 0], -size[k, 0] / 2)
        np.testing.assert_allclose(low[k, 2, 1], size[k, 1] / 2)
        np.testing.assert_allclose(high[k, 3, 1], -size[k, 1] / 2)
        np.testing.assert_allclose(high[k, :4, 2], 0.0, atol=1e-15)  # walls end at the rim
        np.testing.assert_allclose(high[k, 4, 2], -0.3)  # the bottom lies a depth below it
    np.testing.assert_allclose((high - low)[:, :2, 0], 0.01)
    np.testing.assert_allclose((high - low)[:, 4, 2], 0.01)


def test_bins_and_belt_stand_where_the_config_says():
    config = ConveyorConfig.load("nominal")
    scene = build_scene(config)
    model, data = scene.model, mujoco.MjData(scene.model)
    mujoco.mj_kinematics(model, data)
    assert len(scene.bin_bodies) == len(config.bins.fixed)
    for body, b in zip(scene.bin_bodies, config.bins.fixed, strict=True):
        np.testing.assert_allclose(data.xpos[body], [b.x, b.y, config.bins.rim])
    belt = model.geom("belt")
    top = data.geom_xpos[belt.id][2] + belt.size[2]
    assert top == pytest.approx(config.belt.height)
    assert model.opt.timestep == config.timestep
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE


@pytest.mark.parametrize(("mismatch", "air"), [(0.0, 0.0), (1.0, 1.2), (1.5, 1.8)])
def test_the_air_scales_with_the_dial(mismatch, air):
    assert build_scene(vary("nominal", mismatch=mismatch)).model.opt.density == pytest.approx(air)


def test_sensor_columns_are_those_of_the_model():
    scene = build_scene(ConveyorConfig.load("nominal"))
    model, data = scene.model, mujoco.MjData(scene.model)
    ends = [columns.stop for columns in SENSORS.values()]
    assert model.nsensordata == SENSORS["torque"].start + len(scene.robot.actuators)
    assert ends == [*sorted(ends[:-1]), None]
    first = scene.object_qpos
    data.qpos[first : first + 3] = 0.1, 0.2, 0.3
    data.qvel[scene.object_qvel : scene.object_qvel + 3] = 1.0, 2.0, 3.0
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.sensordata[SENSORS["object_position"]], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(data.sensordata[SENSORS["object_velocity"]], [1, 2, 3])
    np.testing.assert_allclose(data.sensordata[SENSORS["hand_position"]], data.site(scene.robot.tcp).xpos)


def test_the_eight_rod_robot_stands_in_the_same_cell():
    four, eight = build_scene(ConveyorConfig.load("nominal")), build_scene(ConveyorConfig.load("nominal"), rods="eight")
    assert eight.model.nbody > four.model.nbody
    assert eight.bin_bodies != ()
    assert eight.model.nsensordata == four.model.nsensordata


def test_a_belt_carries_an_object_along_at_its_speed():
    core = make_core(vary("nominal", items=["plastic_package"], belt={"speed": 0.4}), 1)
    model, data = free_object(core)
    q = core.cell.plant.scene.object_qpos
    data.qpos[q : q + 3] = -0.9, -0.3, core.config.belt.height + core.context.objects.size[0, 2] / 2 + 0.001
    for _ in range(300):
        mujoco.mj_step(model, data)
    velocity = data.qvel[core.cell.plant.scene.object_qvel]
    assert velocity == pytest.approx(0.4, rel=0.02)


def free_object(core):
    """Model and data of the first cell with the object let go and the robot held where it is."""
    plant = core.cell.plant
    model, data = core.cell.pose(0)
    scene = plant.scene
    control = control_columns(model, scene.robot)
    joints = [int(model.joint(name).qposadr[0]) for name in scene.robot.arm_joints]
    data.ctrl[:] = 0.0
    data.ctrl[control[::3]] = data.qpos[joints]
    data.eq_active[scene.grip_equality] = 0
    return model, data


def shoot(model, data, scene, start, attitude, velocity, duration=0.12):
    """Positions of the object (M, 3) after it is shot from a place, and the engine's warnings."""
    q, v = scene.object_qpos, scene.object_qvel
    data.qpos[q : q + 7] = *start, *attitude
    data.qvel[v : v + 6] = *velocity, 0.0, 0.0, 0.0
    places = []
    for _ in range(round(duration / model.opt.timestep)):
        mujoco.mj_step(model, data)
        places.append(data.qpos[q : q + 3].copy())
    return np.array(places), int(sum(w.number for w in data.warning))


LEVEL, ON_X, ON_Y = (1.0, 0.0, 0.0, 0.0), (0.5**0.5, 0.0, 0.5**0.5, 0.0), (0.5**0.5, 0.5**0.5, 0.0, 0.0)
SHOTS = [
    (LEVEL, (0, 0, -1)), (LEVEL, (1, 0, 0)), (LEVEL, (0, -1, 0)), (LEVEL, (1, 1, 0)), (LEVEL, (1, -1, -1)),
    (LEVEL, (0.3, 1, -0.2)), (ON_X, (1, 0, 0)), (ON_X, (-1, 0, 0)), (ON_Y, (0, 1, 0)), (ON_Y, (0, -1, 0)),
    (ON_X, (0, 0, -1)),
]  # fmt: skip
"""Attitude and direction: on the bottom, on the walls and into the corners, edge on and with the largest face first."""


def escapes(core, centre, opening):
    """Shots after which the object has passed a wall or the bottom, by attitude and direction."""
    model, data = free_object(core)
    scene, bins = core.cell.plant.scene, core.config.bins
    initial = mujoco.MjData(model)
    mujoco.mj_copyData(initial, model, data)
    start = np.array([*centre, bins.rim - 0.55 * bins.depth])
    out = []
    for attitude, direction in SHOTS:
        mujoco.mj_copyData(data, model, initial)
        velocity = SPEED * np.array(direction) / np.linalg.norm(direction)
        places, warnings = shoot(model, data, scene, start, attitude, velocity)
        assert warnings == 0
        assert np.abs(places - start).max() > 0.02, "the shot did not happen"
        # An object that bounces out over the rim has left by the opening: that is no tunnelling.
        above = np.maximum.accumulate(places[:, 2] > bins.rim)
        beside = np.abs(places[:, :2] - centre) - opening / 2
        below = bins.rim - bins.depth - places[:, 2]
        depth = np.maximum(beside.max(axis=1), below)
        if (depth > bins.wall)[~above].any() or (depth[-1] > 0.0 and not above[-1]):
            out.append((attitude, direction, round(float(depth[~above].max()), 4)))
    return out


@pytest.mark.parametrize(
    ("name", "timestep"), with_nightly(product(ITEMS, (0.001, 0.0004)), [(name, 0.001) for name in ITEMS])
)
def test_nothing_passes_a_wall_at_9_metres_per_second(name, timestep):
    side = max(CATALOGUE[name].size) * 1.4 + 0.03
    bins = {"fixed": [{"name": "box", "x": 0.3, "y": 0.45, "size": [side, side]}], "depth": 0.40}
    core = make_core(vary("nominal_plain", items=[name], bins=bins, timestep=timestep), 1)
    assert escapes(core, np.array([0.3, 0.45]), np.array([side, side])) == []


@pytest.mark.parametrize("timestep", [0.001, 0.0004])
def test_a_bin_drawn_per_throw_holds_too(timestep):
    """The walls of a random bin are overwritten per simulation, with their bounds."""
    core = make_core(vary("waste_plain", items=["can"], timestep=timestep), 1)
    target = core.context.target[0]
    model, _ = free_object(core)
    np.testing.assert_allclose(model.body_pos[core.cell.plant.scene.bin_bodies[0]], target)
    assert escapes(core, target[:2], core.context.opening[0]) == []


def test_the_object_hangs_under_the_cup_by_its_top():
    """Top of the object at the cup, its centre of mass where grasp and depth say, its yaw kept by the grip."""
    core = make_core("waste", 12, seed=5)
    context, plant = core.context, core.cell.plant
    for row in range(12):
        model, data = core.cell.pose(row)
        o = context.objects
        cup = context.pick[row] + context.cup_offset[row]
        centre = data.xpos[plant.scene.object_body]
        np.testing.assert_allclose(data.site(plant.scene.robot.tcp).xpos, cup, atol=1e-9)
        np.testing.assert_allclose(centre[:2], cup[:2] + context.grasp[row], atol=1e-12)
        np.testing.assert_allclose(cup[2] - centre[2], o.com_depth[row], atol=1e-12)
        geom = plant.scene.object_geom
        top = data.geom_xpos[geom][2] + o.size[row, 2] / 2
        assert 0.0 <= cup[2] - top < 0.001
        grip = data.site_xpos[plant.scene.grip_site]
        np.testing.assert_allclose(grip, cup, atol=1e-9)
        np.testing.assert_allclose(model.body_mass[plant.scene.object_body], o.mass[row])


def test_an_object_held_still_stays_where_it_is():
    """The grip does not pull: gripped off centre and turned, the object does not move under a hand at rest."""
    core = make_core("waste", 1, seed=3)
    with_objects(core, grasp=np.array([[0.012, -0.009]]), yaw=np.array([0.8]))
    model, data = core.cell.pose(0)
    scene = core.cell.plant.scene
    joints = [int(model.joint(name).qposadr[0]) for name in scene.robot.arm_joints]
    data.ctrl[control_columns(model, scene.robot)[::3]] = data.qpos[joints]
    tcp = data.site(scene.robot.tcp).xpos.copy()
    before = data.xpos[scene.object_body] - tcp
    quat = data.xquat[scene.object_body].copy()
    for _ in range(200):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.xpos[scene.object_body] - data.site(scene.robot.tcp).xpos, before, atol=2e-4)
    np.testing.assert_allclose(np.abs(data.xquat[scene.object_body] @ quat), 1.0, atol=1e-5)
