"""Motor references: the release falls in the middle of a step, and Euler's method follows them without error."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.planning.one_joint.grasp import joint_torque
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.planning.one_joint.parameters import Arm, Block
from pnt_gym.robots.one_joint.references import Clock, Load, motor_references

BLOCK, STEP, STEPS = Block(), 0.001, 260
RADIUS = np.array([0.278, 0.22])


def motions():
    rates = np.array([[30.0] + [60.0] * 10, [90.0] * 5 + [40.0] * 6])
    return ArmMotion.of(np.array([-0.5, -0.9]), np.array([0.015, 0.0173]), rates, np.array([-180.0, -150.0]))


def load():
    same = np.ones(2)
    return Load(BLOCK.mass * same, BLOCK.inertia * same, RADIUS, BLOCK.half_height * same)


@given(st.floats(0.001, 1.0), st.sampled_from([0.0004, 0.001, 0.002]))
def test_the_release_falls_in_the_middle_of_a_step(release, step):
    clock = Clock.releasing_at(np.array([release]), step)
    assert clock.start[0] + (clock.release_step[0] + 0.5) * step == pytest.approx(release, abs=1e-12)
    assert -step - 1e-9 < clock.start[0] <= 0.5 * step


def test_angles_are_what_eulers_method_makes_of_the_speeds():
    clock = Clock.releasing_at(motions().duration, STEP)
    angle, speed, _ = np.moveaxis(motor_references(motions(), load(), clock, Arm(), STEP, STEPS), -1, 0)
    np.testing.assert_allclose(np.diff(angle, axis=1), STEP * speed[:, 1:], atol=1e-15)


def test_references_stay_on_the_motion():
    motion, clock = motions(), Clock.releasing_at(motions().duration, STEP)
    time = clock.start[:, None] + STEP * np.arange(STEPS)
    angle, speed, _ = np.moveaxis(motor_references(motion, load(), clock, Arm(), STEP, STEPS), -1, 0)
    np.testing.assert_allclose(angle, motion.sample(time).angle, atol=1e-4)
    np.testing.assert_allclose(speed, motion.sample(time - STEP / 2).speed, atol=1e-12)


def test_the_speed_of_the_release_step_is_the_planned_one():
    motion, clock = motions(), Clock.releasing_at(motions().duration, STEP)
    speed = motor_references(motion, load(), clock, Arm(), STEP, STEPS)[..., 1]
    np.testing.assert_allclose(speed[np.arange(2), clock.release_step + 1], motion.release_speed, rtol=1e-12)


def test_the_torque_is_that_of_the_planner():
    """Away from the release, where the difference quotient of the speeds is the acceleration."""
    arm, motion = Arm(friction=0.3), motions()
    clock = Clock.releasing_at(motion.duration, STEP)
    torque = motor_references(motion, load(), clock, arm, STEP, STEPS)[..., 2]
    time = clock.start[:, None] + STEP * np.arange(STEPS)
    s = motion.sample(time)
    wanted = joint_torque(s.angle, s.speed, s.acceleration, RADIUS[:, None], arm, BLOCK)
    inside = (time > 0.002) & (time < motion.duration[:, None] - 0.002)
    np.testing.assert_allclose(torque[inside], wanted[inside], atol=0.05)


def test_after_the_release_the_arm_is_empty():
    arm, motion = Arm(), motions()
    clock = Clock.releasing_at(motion.duration, STEP)
    torque = motor_references(motion, load(), clock, arm, STEP, STEPS)[..., 2]
    time = clock.start[:, None] + STEP * np.arange(STEPS)
    braking = (time > motion.duration[:, None] + 0.002) & (time < motion.stop_time[:, None] - 0.002)
    wanted = np.broadcast_to(arm.inertia * motion.braking[:, None], torque.shape)
    np.testing.assert_allclose(torque[braking], wanted[braking], rtol=1e-9)
