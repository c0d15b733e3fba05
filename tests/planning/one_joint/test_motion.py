"""Spline motions of the arm, and the forces on the block against Newton and Euler."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from pnt_gym.arrays import take
from pnt_gym.errors import PlanningError
from pnt_gym.planning.one_joint import Arm, ArmMotion, Block
from pnt_gym.planning.one_joint.grasp import (
    acceleration_window,
    braking_acceleration,
    joint_torque,
    reactions,
    tipping_margin,
    torque_limit,
)
from pnt_gym.planning.one_joint.margins import margin_units, motion_margins

ARM, BLOCK, G = Arm(), Block(), 9.81


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Arm(torque=0.0), "arm torque is 0.0; it must be positive and finite"),
        (lambda: Arm(friction=-0.1), "arm friction is -0.1; it must be at least 0"),
        (lambda: Arm(knee=1.0), "arm knee is 1.0; it must lie between 0 and 1"),
        (lambda: Arm(angle=(1.0, 1.0)), "arm angle is (1.0, 1.0); it must be two rising angles [rad]"),
        (lambda: Block(mass=np.nan), "block mass is nan; it must be positive and finite"),
        (lambda: Block(half_height=-0.01), "block half_height is -0.01; it must be at least 0"),
    ],
)
def test_an_arm_or_a_block_that_cannot_be_is_refused(make, sentence):
    with pytest.raises(PlanningError) as refusal:
        make()
    assert str(refusal.value) == sentence


def some_motions(count=5, seed=0):
    rng = np.random.default_rng(seed)
    accelerations = rng.uniform(10.0, 90.0, (count, 11))
    return ArmMotion.of(
        rng.uniform(-0.8, 0.0, count), rng.uniform(0.01, 0.05, count), accelerations, np.full(count, -150.0)
    ), accelerations


def test_the_spline_is_the_uniform_cubic_b_spline():
    motion, _ = some_motions()
    n = motion.intervals
    for row in range(5):
        step = motion.time_step[row]
        spline = BSpline(step * np.arange(-3, n + 4), motion.knots[row], 3)
        times = np.linspace(0.0, motion.duration[row] * (1 - 1e-12), 57)
        got = motion.sample(np.tile(times, (5, 1)))
        for k, part in enumerate(got):
            assert part[row] == pytest.approx(spline(times, k), rel=1e-9, abs=1e-9)


def test_accelerations_and_ends_are_those_given():
    motion, accelerations = some_motions()
    times = motion.time_step[:, None] * np.arange(11)
    state = motion.sample(times)
    assert state.acceleration == pytest.approx(accelerations, rel=1e-8)
    assert state.speed[:, 0] == pytest.approx(np.zeros(5), abs=1e-12)
    assert state.angle[:, -1] == pytest.approx(motion.release_angle, abs=1e-12)
    assert state.speed[:, -1] == pytest.approx(motion.release_speed, rel=1e-9)
    assert state.acceleration[:, -1] == pytest.approx(motion.release_acceleration, rel=1e-8)


def test_the_arm_rests_before_and_after():
    motion, _ = some_motions()
    before = motion.sample([-1.0, -1e-9])
    assert (before.speed == 0.0).all() and (before.acceleration == 0.0).all()
    assert before.angle[:, 0] == pytest.approx(motion.start_angle, abs=1e-12)
    after = motion.sample(motion.stop_time[:, None] + np.array([1e-9, 3.0]))
    assert (after.speed == 0.0).all() and (after.acceleration == 0.0).all()
    assert after.angle == pytest.approx(np.tile(motion.stop_angle[:, None], 2), abs=1e-12)


def test_speed_and_angle_are_integrals_across_the_release():
    motion, _ = some_motions()
    times = np.linspace(-0.01, 1.0, 200_001)
    state = motion.sample(times)
    step = times[1] - times[0]
    speed = np.cumsum(0.5 * (state.acceleration[:, 1:] + state.acceleration[:, :-1]) * step, axis=1)
    angle = np.cumsum(0.5 * (state.speed[:, 1:] + state.speed[:, :-1]) * step, axis=1)
    assert np.abs(state.speed[:, 1:] - speed).max() < 3e-3
    assert np.abs(state.angle[:, 1:] - state.angle[:, :1] - angle).max() < 1e-5


def test_rows_are_independent_and_may_hold_nothing():
    motion, _ = some_motions()
    times = np.linspace(-0.1, 0.8, 91)
    whole, one = motion.sample(times), take(motion, np.array([3])).sample(times)
    assert all(np.array_equal(a[3], b[0]) for a, b in zip(whole, one, strict=True))
    empty = ArmMotion(np.full((1, 13), np.nan), np.full(1, np.nan), np.full(1, np.nan))
    assert all(np.isnan(part).all() for part in empty.sample(times))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"knots": np.zeros((2, 3))}, "knots"),
        ({"time_step": np.zeros(1)}, "positive"),
        ({"time_step": np.ones(2)}, "shape"),
        ({"braking": np.array([5.0])}, "other way"),
    ],
)
def test_motions_that_are_none_are_refused(changes, words):
    parts = {"knots": np.arange(13.0)[None] ** 2 / 100.0, "time_step": np.ones(1) * 0.02, "braking": np.array([-9.0])}
    with pytest.raises(ValueError, match=words):
        ArmMotion(**{**parts, **changes})


states = st.tuples(st.floats(-1.5, 1.5), st.floats(-12, 12), st.floats(-200, 200), st.floats(0.03, 0.28))


@given(states)
def test_forces_are_those_of_newton_and_euler(state):
    """Contact forces act at the vertices; accelerations come from differentiating the place of the centre of mass."""
    angle, speed, rate, radius = state
    e, n = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    d, side, mass = BLOCK.half_height, BLOCK.half_length, BLOCK.mass
    place = radius * e + d * n
    acceleration = rate * np.array([-place[1], place[0]]) - speed**2 * place
    force = mass * (acceleration + np.array([0.0, G]))
    got = reactions(*(np.array(v) for v in state), BLOCK)
    # Moment of the contact about the centre of mass turns the block; moved to a vertex at (+-side, -d).
    spin = BLOCK.inertia * rate

    def about(vertex):
        arm = -(vertex * e - d * n)
        return spin + arm[0] * force[1] - arm[1] * force[0]

    scale = mass * G
    assert got.normal == pytest.approx(force @ n, abs=1e-12 * max(scale, abs(force @ n)) + 1e-13)
    assert got.moment_a == pytest.approx(about(side), abs=1e-12)
    assert got.moment_b == pytest.approx(about(-side), abs=1e-12)
    whole = (ARM.inertia + BLOCK.inertia) * rate + place[0] * force[1] - place[1] * force[0]
    assert joint_torque(*(np.array(v) for v in state), ARM, BLOCK) == pytest.approx(whole, abs=1e-12, rel=1e-12)


@given(st.floats(-1.5, 1.5), st.floats(0, 12.5), st.floats(0.005, 0.28))
def test_the_window_is_where_all_limits_hold(angle, speed, radius):
    args = np.array(angle), np.array(speed)
    window = acceleration_window(*args, np.array(radius), ARM, BLOCK)
    rates = np.linspace(-400.0, 400.0, 4001)
    held = reactions(args[0], args[1], rates, np.array(radius), BLOCK)
    torque = joint_torque(args[0], args[1], rates, np.array(radius), ARM, BLOCK)
    good = (held.normal > 0) & (held.moment_a < 0) & (held.moment_b > 0)
    good &= np.abs(torque) < torque_limit(args[1], ARM)
    inside = (rates > window.low) & (rates < window.high)
    away = np.minimum(np.abs(rates - window.low), np.abs(rates - window.high)) > 1e-6
    assert (good == inside)[away].all()


def test_the_torque_curve_is_whole_then_falls_to_its_value_at_full_speed():
    speeds = np.array([0.0, 0.8 * ARM.speed, 0.9 * ARM.speed, ARM.speed, -ARM.speed, 9 * ARM.speed])
    assert torque_limit(speeds, ARM) == pytest.approx([18.0, 18.0, 13.5, 9.0, 9.0, 0.0])
    assert torque_limit(speeds[:4], Arm(torque=4.7)) == pytest.approx([4.7] * 4)


def test_a_block_tips_on_the_resting_arm_beyond_its_corner():
    limit = np.arctan2(BLOCK.half_length, BLOCK.half_height)
    assert np.rad2deg(limit) == pytest.approx(63.435, abs=1e-3)
    assert tipping_margin(np.array([0.0, limit - 1e-6, limit + 1e-6, -limit - 1e-6]), BLOCK).round(9).tolist()[0] == 1.0
    assert (tipping_margin(np.array([limit - 1e-6, 1e-6 - limit]), BLOCK) > 0).all()
    assert (tipping_margin(np.array([limit + 1e-6, -limit - 1e-6]), BLOCK) < 0).all()


def test_braking_lets_the_block_go_at_the_papers_release():
    speed = np.array(9.319)
    brake = braking_acceleration(speed, ARM)
    assert brake == pytest.approx(-18.0 / ARM.inertia)
    assert reactions(np.array(0.3636), speed, brake, np.array(0.2782), BLOCK).normal < 0


def test_margins_are_distances_to_the_limits():
    motion, _ = some_motions(count=1)
    radius = np.array([0.25])
    margins = motion_margins(motion, radius, ARM, BLOCK)[0] * margin_units(ARM, BLOCK)
    times = np.append(np.arange(0.0, motion.duration[0], 1e-3), motion.duration[0])
    state = motion.sample(times)
    held = reactions(*state, radius, BLOCK)
    torque = joint_torque(*state, radius, ARM, BLOCK)
    expected = [
        held.normal.min(),
        held.moment_a.max(),
        held.moment_b.min(),
        min((state.angle + np.pi / 2).min(), (np.pi / 2 - state.angle).min()),
        (ARM.speed - np.abs(state.speed)).min(),
        (torque_limit(state.speed, ARM) - np.abs(torque)).min(),
    ]
    assert margins == pytest.approx(expected, abs=1e-12)
