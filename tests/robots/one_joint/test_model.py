"""The thrower's model against closed forms: which way it turns, how heavy it is, what its motor gives."""

import mujoco
import numpy as np
import pytest

from pnt_gym.planning.one_joint.parameters import Arm
from pnt_gym.robots.one_joint.model import STOPPER_HEIGHT, Drive, add_grip, add_one_joint, add_plane_joints
from pnt_gym.robots.specification import set_options

ARM, RIGID = Arm(), Drive(kp=2000.0, kv=20.0)
STEP = 0.001


def build(drive=RIGID, touches=False, part=False):
    spec = mujoco.MjSpec()
    set_options(spec, STEP, density=0.0, viscosity=0.0)
    arm = add_one_joint(spec, ARM, drive, touches)
    if part:
        body = spec.worldbody.add_body(name="stone")
        add_plane_joints(body, "stone")
        body.explicitinertial, body.mass, body.inertia = True, 0.03, np.full(3, 1e-5)
        add_grip(spec, arm, body, "stone")
    return spec.compile()


def acceleration(drive, torque, speed=0.0, angle=0.0):
    """Of the arm under a feed-forward torque alone [rad/s2]."""
    model = build(drive)
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = angle, speed
    data.ctrl[:] = angle, speed, torque
    mujoco.mj_forward(model, data)
    return float(data.qacc[0])


def test_a_positive_angle_is_anticlockwise_with_x_to_the_right_and_z_up():
    model = build()
    data = mujoco.MjData(model)
    data.qpos[0] = 0.3
    mujoco.mj_forward(model, data)
    tip = data.xmat[model.body("arm").id].reshape(3, 3) @ np.array([0.31, 0.0, 0.0])
    np.testing.assert_allclose(tip, 0.31 * np.array([np.cos(0.3), 0.0, np.sin(0.3)]), atol=1e-12)


@pytest.mark.parametrize("factor", [1.0, 1.1])
def test_the_motor_turns_the_planned_inertia_times_its_factor(factor):
    drive = Drive(kp=2000.0, kv=20.0, inertia_factor=factor)
    assert acceleration(drive, 6.0) == pytest.approx(6.0 / (factor * ARM.inertia), rel=1e-9)


@pytest.mark.parametrize("angle", [-1.2, 0.0, 0.7])
def test_the_arm_is_balanced(angle):
    assert acceleration(RIGID, 0.0, angle=angle) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("torque", [25.0, -1e3])
def test_the_motor_gives_no_more_than_its_limit(torque):
    assert acceleration(RIGID, torque) == pytest.approx(np.sign(torque) * ARM.torque / ARM.inertia, rel=1e-9)


def test_friction_takes_its_torque_from_a_turning_arm():
    drive = Drive(kp=2000.0, kv=20.0, friction=0.6, viscous=0.05)
    slow = acceleration(RIGID, 5.0, speed=8.0) - acceleration(drive, 5.0, speed=8.0)
    assert slow * ARM.inertia == pytest.approx(0.6 + 0.05 * 8.0, rel=0.01)


def test_feedback_pulls_the_arm_to_its_reference():
    model = build()
    data = mujoco.MjData(model)
    data.ctrl[:] = 0.05, 0.0, 0.0
    for _ in range(300):
        mujoco.mj_step(model, data)
    assert data.qpos[0] == pytest.approx(0.05, abs=1e-6)
    assert data.qvel[0] == pytest.approx(0.0, abs=1e-4)


def test_the_grip_holds_a_part_through_whole_turns():
    model = build(part=True)
    data = mujoco.MjData(model)
    seat = model.site("seat_stone").id
    model.site_pos[seat] = 0.25, 0.0, 0.015
    data.qpos[1:3] = 0.25, 0.015
    for k in range(1500):
        speed = min(12.0, 60.0 * k * STEP)
        data.ctrl[:] = data.qpos[0], speed, 0.0
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    assert data.qpos[0] > 2.0 * np.pi
    assert data.qpos[3] == pytest.approx(data.qpos[0], abs=1e-4)
    np.testing.assert_allclose(data.qpos[1:3], data.site_xpos[seat][[0, 2]], atol=5e-5)


def test_an_arm_that_touches_has_two_low_stoppers_and_one_that_does_not_has_no_contact_at_all():
    model = build(touches=True)
    for name in ("stopper_inner", "stopper_outer"):
        geom = model.geom(name)
        assert geom.pos[2] + geom.size[2] == pytest.approx(STOPPER_HEIGHT)
        assert geom.condim == 1
    model = build()
    assert not model.geom_contype.any()
