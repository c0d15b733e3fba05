"""Kinematics and dynamics of serial arms, against the engine's and against the table that one is made from."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import toppra
import toppra.algorithm
import toppra.constraint

from pnt_gym.cells.conveyor.arm import arm_of, places_of
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.robot import RobotSheet
from pnt_gym.planning import JerkTrajectory, MotionLimits, rest_to_rest
from pnt_gym.robots.arm import ur10e
from pnt_gym.robots.arm.bounds import SHARE, Loads
from pnt_gym.robots.arm.model import SerialArm, add_serial_arm
from pnt_gym.robots.collection import MODELS
from pnt_gym.robots.joints import knot_count, qpos_columns, qvel_columns, upsample
from pnt_gym.robots.specification import set_options
from tests.tools.arms import SIX, scara, six_axis


@pytest.fixture(scope="module", params=["ur10e_class", "scara", "six"])
def case(request, tmp_path_factory) -> Iterator[tuple[RobotSheet, SerialArm]]:
    """A sheet and its arm: the shipped one, four axes with two joints in one body, and six axes from a URDF."""
    if request.param == "ur10e_class":
        sheet = RobotSheet.model_validate("ur10e_class")
    else:
        write = {"scara": scara, "six": six_axis}[request.param]
        sheet = ConveyorConfig.load(write(tmp_path_factory.mktemp("arm"))).robot
    yield sheet, arm_of(sheet)


def engine(arm: SerialArm) -> tuple[Any, Any]:
    """The arm alone in the engine, without drag, as every cell has it."""
    spec = mujoco.MjSpec()
    set_options(spec, 0.001, density=0.0, viscosity=0.0)
    add_serial_arm(spec, arm)
    model = spec.compile()
    return model, mujoco.MjData(model)


def hands(sheet: RobotSheet, count: int = 60) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places in the reach, velocities and accelerations of hands at their limits, in random directions (N, 3) each."""
    random = np.random.default_rng(5)
    place = random.permutation(places_of(sheet))[:count]
    ways = random.standard_normal((2, count, 3))
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    return place, sheet.velocity * ways[0], sheet.acceleration * ways[1]


def straight(sheet: RobotSheet, start: np.ndarray, end: np.ndarray) -> JerkTrajectory:
    """The quickest straight motion from rest to rest."""
    limits = MotionLimits(sheet.velocity, sheet.acceleration, sheet.full_jerk)
    return JerkTrajectory.concatenate(start[None], [rest_to_rest([end - start], limits)])


def test_the_hand_is_where_it_should_be_level_and_unturned(case):
    sheet, arm = case
    model, data = engine(arm)
    place = hands(sheet)[0]
    for hand, pose in zip(place, arm.pose(place), strict=True):
        data.qpos[qpos_columns(model, arm)] = pose
        mujoco.mj_kinematics(model, data)
        np.testing.assert_allclose(data.site(arm.tcp).xpos, hand, atol=1e-9)
        np.testing.assert_allclose(data.body(arm.platform).xmat.reshape(3, 3), np.eye(3), atol=1e-9)
        np.testing.assert_allclose(data.body(arm.platform).xpos, hand, atol=1e-9)


def test_velocities_and_accelerations_are_those_of_the_poses(case):
    sheet, arm = case
    place, velocity, acceleration = hands(sheet)
    step = 1e-4
    times = step * np.arange(-2, 3)[:, None, None]
    poses = np.stack([arm.pose(part) for part in place + velocity * times + acceleration * times**2 / 2])
    motion = arm.motion(place, velocity, acceleration)
    rate = (poses[3] - poses[1]) / (2 * step)
    change = (poses[3] - 2 * poses[2] + poses[1]) / step**2
    np.testing.assert_allclose(motion.position.T, poses[2], atol=1e-12)
    np.testing.assert_allclose(motion.velocity.T, rate, atol=1e-5)
    np.testing.assert_allclose(motion.acceleration.T, change, atol=2e-3)
    np.testing.assert_allclose(arm.rates(place, velocity), motion.velocity.T, atol=1e-12)


def test_torques_are_the_engines(case):
    """`mj_inverse` of the model that the cell simulates, gravity, gears and all."""
    sheet, arm = case
    model, data = engine(arm)
    motion = arm.motion(*hands(sheet))
    columns, rates = qpos_columns(model, arm), qvel_columns(model, arm)
    for k in range(motion.position.shape[1]):
        data.qpos[columns], data.qvel[rates] = motion.position[:, k], motion.velocity[:, k]
        data.qacc[rates] = motion.acceleration[:, k]
        mujoco.mj_inverse(model, data)
        np.testing.assert_allclose(motion.torque[:, k], data.qfrc_inverse[rates], rtol=1e-9, atol=1e-7)


def test_a_pose_does_not_depend_on_what_is_asked_beside_it(case):
    sheet, arm = case
    place = hands(sheet)[0]
    together = arm.pose(place)
    assert all(np.array_equal(arm.pose(place[k : k + 1])[0], together[k]) for k in range(0, len(place), 7))
    assert np.isnan(arm.pose([[0.0, 9.0, 0.0]])).all()


def test_no_motion_within_the_sheets_limits_takes_more_than_the_bound(case):
    """5,000 motions at both limits, at random places and in random directions; the worst of them come near."""
    sheet, arm = case
    loaded = arm.holding(sheet.payload)
    place, velocity, acceleration = hands(sheet, len(places_of(sheet)))
    shares = arm.limits.shares(loaded.motion(place, velocity, acceleration)).max(axis=1)
    assert (shares[1:] <= SHARE).all()
    assert shares[0] <= 1.0
    loads = Loads.of(loaded.motion, places_of(sheet))
    fastest = loads.speed(arm.limits)
    directions = np.random.default_rng(0).standard_normal((2000, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    at = np.tile(fastest.place, (2000, 1))
    turned = arm.motion(at, fastest.value * directions, np.zeros_like(at))
    assert arm.limits.shares(turned)[1].max() == pytest.approx(SHARE, rel=0.01)
    strongest = loads.acceleration(arm.limits, 0.0)
    at = np.tile(strongest.place, (2000, 1))
    pulled = loaded.motion(at, np.zeros_like(at), strongest.value * directions)
    assert arm.limits.shares(pulled)[2].max() == pytest.approx(SHARE, rel=0.02)


def test_toppra_finds_no_fault_with_a_motion_and_no_slower_one(case):
    """The joints' path of a straight stroke, timed by another library under the same limits of speed and torque."""
    sheet, arm = case
    space = sheet.workspace
    start = np.array([space.x - 0.2, space.y - 0.1, space.z_min + 0.1])
    end = np.array([space.x + 0.2, space.y + 0.1, space.z_min + 0.25])
    stroke = straight(sheet, start, end)
    times = np.linspace(0.0, float(stroke.duration[0]), 401)
    ours = stroke.sample(times)
    motion = arm.motion(ours.position[0], ours.velocity[0], ours.acceleration[0])
    assert arm.limits.shares(motion).max() <= 1.0
    shares = np.linspace(0.0, 1.0, 101)
    path = toppra.SplineInterpolator(shares, arm.pose(start + shares[:, None] * (end - start)))
    limits = arm.limits

    def torque(position, velocity, acceleration):
        data.qpos[:], data.qvel[:], data.qacc[:] = position, velocity, acceleration
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse.copy()

    model, data = engine(arm)
    wanted = [
        toppra.constraint.JointVelocityConstraint(np.stack([-limits.speed, limits.speed], axis=1)),
        toppra.constraint.JointTorqueConstraint(
            torque, np.stack([-limits.torque, limits.torque], axis=1), np.zeros(len(limits.torque))
        ),
    ]
    quickest = toppra.algorithm.TOPPRA(wanted, path, solver_wrapper="seidel").compute_trajectory()
    assert quickest is not None, "toppra finds the path feasible"
    assert quickest.duration <= times[-1]
    tight = [toppra.constraint.JointVelocityConstraint(np.abs(motion.velocity).max(axis=1)[:, None] * [-0.2, 0.2])]
    slowest = toppra.algorithm.TOPPRA(tight, path, solver_wrapper="seidel").compute_trajectory()
    assert slowest is not None
    assert slowest.duration > times[-1]


def test_the_hand_follows_its_path_in_the_engine(case):
    """Feed-forward and position control, with knots every 4 ms: a stroke at full limits, 1 kHz."""
    sheet, arm = case
    space, (model, data) = sheet.workspace, engine(arm)
    start = np.array([space.x - 0.15, space.y, space.z_min + 0.1])
    stroke = straight(sheet, start, start + np.array([0.3, 0.0, 0.1]))
    steps = int(float(stroke.duration[0]) / 0.001)
    knots = np.arange(knot_count(steps, 4)) * 0.004
    ours = stroke.sample(knots)
    control = np.zeros((1, steps, model.nu))
    upsample(arm.motion(ours.position, ours.velocity, ours.acceleration), 0.004, 4, control)
    data.qpos[qpos_columns(model, arm)] = arm.pose(start[None])[0]
    apart = []
    for k in range(steps):
        data.ctrl[:] = control[0, k]
        mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        wanted = stroke.sample([0.001 * (k + 1)]).position[0, 0]
        apart.append(np.linalg.norm(data.site(arm.tcp).xpos - wanted))
    assert max(apart) < 0.001


def test_the_shipped_arm_is_that_of_the_makers_table():
    """Place and axes of the flange by the products of the table's matrices, at random poses."""
    model = MODELS["ur10e_class"]().spec.compile()
    data = mujoco.MjData(model)
    for pose in np.random.default_rng(2).uniform(-3.0, 3.0, (20, 6)):
        frame = np.eye(4)
        for axis, angle in zip(ur10e.AXES, pose, strict=True):
            c, s, a = np.cos(angle), np.sin(angle), axis.twist * np.pi / 2
            frame = frame @ np.array([
                [c, -s * np.cos(a), s * np.sin(a), axis.along * c],
                [s, c * np.cos(a), -c * np.sin(a), axis.along * s],
                [0, np.sin(a), np.cos(a), axis.offset], [0, 0, 0, 1],
            ])  # fmt: skip
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        np.testing.assert_allclose(data.site("tool").xpos, frame[:3, 3], atol=1e-12)
        np.testing.assert_allclose(data.site("tool").xmat.reshape(3, 3), frame[:3, :3], atol=1e-12)


def test_the_shipped_file_is_the_model_that_the_package_makes():
    """The file's decimals are rounded."""
    made = MODELS["ur10e_class"]().spec.compile()
    section = RobotSheet.model_validate("ur10e_class").model
    assert section is not None
    file = mujoco.MjModel.from_xml_string(Path(section.file).read_text())
    for name in ("body_pos", "body_quat", "body_mass", "body_ipos", "body_inertia", "jnt_range", "dof_armature"):
        np.testing.assert_allclose(getattr(file, name), getattr(made, name), atol=1e-5, err_msg=name)
    np.testing.assert_allclose(file.actuator_forcerange, made.actuator_forcerange)
    assert sum(axis.mass for axis in ur10e.AXES) == pytest.approx(29.1, abs=0.1)


def test_limits_of_a_urdf_are_read(tmp_path):
    limits = arm_of(ConveyorConfig.load(six_axis(tmp_path)).robot).limits
    assert limits.torque.tolist() == [float(row[6]) for row in SIX]
    assert limits.speed.tolist() == [row[7] for row in SIX]
