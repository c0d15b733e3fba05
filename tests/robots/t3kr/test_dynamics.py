"""Joint rates and motor torques against finite differences, the energy balance, and MuJoCo itself."""

import mujoco
import numpy as np
import pytest

from pnt_gym.robots.joints import qpos_columns
from pnt_gym.robots.specification import set_options
from pnt_gym.robots.t3kr.geometry import T3KR
from pnt_gym.robots.t3kr.kinematics import closed_pose, inverse_kinematics
from pnt_gym.robots.t3kr.model import add_t3kr
from tests.tools.t3kr import WORKSPACE, control_columns, joint_acceleration, joint_velocity, motor_torque

G = 9.81


def states(count, seed=0, g_level=6.0):
    rng = np.random.default_rng(seed)
    points = rng.uniform([-0.45, -0.8, -0.95], [0.45, 0.8, 0.0], (4 * count, 3))
    points = points[WORKSPACE.contains(points)][:count]
    return points, rng.normal(size=points.shape) * 2.0, rng.normal(size=points.shape) * g_level * G


def path(point, velocity, acceleration, t):
    return point + velocity * t + acceleration * t**2 / 2


def test_joint_rates_match_finite_differences():
    x, v, a = states(300)
    h = 1e-5
    before, at, after = (inverse_kinematics(path(x, v, a, t)) for t in (-h, 0.0, h))
    np.testing.assert_allclose(joint_velocity(x, v), (after - before) / (2 * h), atol=1e-5)
    faster, slower = (joint_velocity(path(x, v, a, t), v + a * t) for t in (h, -h))
    np.testing.assert_allclose(joint_acceleration(x, v, a), (faster - slower) / (2 * h), rtol=1e-6, atol=1e-4)
    assert np.isfinite(at).all()


def energy(x, v, payload):
    """Kinetic and potential energy (N,) of arms, rods, platform and payload, by summing over points."""
    q, q_dot = inverse_kinematics(x), joint_velocity(x, v)
    frames = T3KR.arms
    out = np.stack([np.cos(frames.azimuth), np.sin(frames.azimuth), np.zeros(4)], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    radial = np.cos(q)[..., None] * out + np.sin(q)[..., None] * up
    tangent = np.cos(q)[..., None] * up - np.sin(q)[..., None] * out
    elbow = frames.pivot + T3KR.arm_length * radial
    elbow_v = T3KR.arm_length * q_dot[..., None] * tangent
    foot = x[:, None] + frames.attach
    total = (T3KR.armature + T3KR.arm_inertia + T3KR.arm_mass * T3KR.arm_com**2) * (q_dot**2).sum(axis=1) / 2
    total += T3KR.arm_mass * G * T3KR.arm_com * np.sin(q).sum(axis=1)
    mass = T3KR.platform_mass + payload
    total += mass * ((v**2).sum(axis=1) / 2 + G * x[:, 2])
    # Two-point Gauss quadrature integrates a slender rod's quadratic energy exactly.
    for share in (0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12)):
        point_v = (1 - share) * elbow_v + share * v[:, None]
        height = ((1 - share) * elbow + share * foot)[..., 2]
        total += T3KR.rod_mass * ((point_v**2).sum(axis=2) / 2 + G * height).sum(axis=1)
    return total


def test_motor_power_is_the_change_of_energy():
    x, v, a = states(300)
    payload, h = 0.3, 1e-5
    power = (motor_torque(x, v, a, payload) * joint_velocity(x, v)).sum(axis=1)
    energies = [energy(path(x, v, a, t), v + a * t, payload) for t in (-h, h)]
    np.testing.assert_allclose(power, (energies[1] - energies[0]) / (2 * h), rtol=1e-5, atol=1e-3)


@pytest.mark.parametrize("payload", [0.0, 0.5])
def test_mujoco_moves_as_the_torques_ask(payload):
    spec = mujoco.MjSpec()
    handles = add_t3kr(spec)
    set_options(spec, 0.0004, density=0.0, viscosity=0.0)
    spec.body("platform").mass = T3KR.platform_mass + payload
    model = spec.compile()
    # Loops a hundred times more rigid than in use, so that only the dynamics is left to disagree.
    model.eq_solimp[:, :2] = 0.99999
    data = mujoco.MjData(model)
    columns, controls = qpos_columns(model, handles), control_columns(model, handles)
    slides = [int(model.joint(f"platform_{axis}").dofadr[0]) for axis in "xyz"]
    x, v, a = states(40, seed=5, g_level=4.0)
    q, q_dot, torque = inverse_kinematics(x), joint_velocity(x, v), motor_torque(x, v, a, payload)
    h = 1e-6

    def pose_of(tcp):
        return closed_pose(tcp, handles.rods_per_arm, handles.geometry)

    rates = (pose_of(x + h * v) - pose_of(x - h * v)) / (2 * h)
    for k, pose in enumerate(pose_of(x)):
        data.qpos[columns], data.qvel[:] = pose, rates[k]
        data.ctrl[controls] = np.stack([q[k], q_dot[k], torque[k]], axis=-1).ravel()
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.actuator_force, np.clip(torque[k], -530, 530), rtol=1e-4, atol=1e-3)
        if np.abs(torque[k]).max() < T3KR.torque_limit:
            np.testing.assert_allclose(data.qacc[slides], a[k], atol=1e-3 * np.linalg.norm(a[k]))


def test_published_rating_is_plausible():
    """Along the belt at 12 g, 530 N m move an empty hand in every direction and 5 kg in some of them only."""
    turn = np.linspace(0.0, 2 * np.pi, 72)
    a = 12 * G * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=-1)
    x, rest = np.array([0.0, 0.0, -0.6]), np.zeros(3)
    empty, loaded = (np.abs(motor_torque(x, rest, a, mass)).max(axis=1) for mass in (0.0, 5.0))
    assert empty.max() < 530.0
    assert loaded.min() < 530.0 < loaded.max()


def test_out_of_reach_is_nan():
    torque = motor_torque([[0.0, 0.0, -1.6], [0.0, 0.0, -0.6]], np.zeros(3), np.zeros(3))
    assert np.isnan(torque[0]).all()
    assert np.isfinite(torque[1]).all()


def test_shapes_broadcast():
    x = np.broadcast_to([0.1, -0.2, -0.6], (2, 5, 3))
    assert motor_torque(x, np.zeros(3), [0, 0, 1.0], np.arange(5.0)).shape == (2, 5, 4)
    assert joint_velocity(x[0, 0], np.ones(3)).shape == (4,)
    assert joint_acceleration(x[0], np.ones(3), np.ones((5, 3))).shape == (5, 4)


def test_unreachable_and_singular_poses_are_silent():
    """No floating-point warning from far out of reach to a stretched arm, where torques are without bound."""
    x = np.zeros((400, 3))
    x[:, 2] = np.linspace(-2.0, 2.0, 400)
    with np.errstate(all="raise"):
        torque = motor_torque(x, np.ones(3), np.ones(3))
    assert np.isnan(torque).any() and np.isfinite(torque).any()
