"""A swing under a hand: closed forms, energy, and the same motion integrated by other means."""

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from pnt_gym.cells.base.airborne import STATE, Carrying, Hanging, Pivot
from pnt_gym.cells.base.bodies import fluid_coefficients
from pnt_gym.cells.base.freefall import swing_down
from tests.cells.base.test_freefall import bodies

GRAVITY = 9.81
MASS, SIZE = 0.02, np.array([[0.12, 0.07, 0.05]])
ARM = np.array([0.012, -0.007, -0.03])
FALLING, RESTING = (0.0, 0.0, -GRAVITY), (0.0, 0.0, 0.0)


def inertia_about_the_lip(arm):
    moments = bodies(np.array([2]), SIZE, np.array([MASS]), np.array([1.0]), np.array([0.0]))["inertia"][0]
    return np.diag(moments) + MASS * (arm @ arm * np.eye(3) - np.outer(arm, arm))


def swing(arm, stiffness, damping, hand, seconds, *, step=0.001, tilt=(0.0, 0.0, 0.0), air=0.0):
    """Attitudes (K, 4) of a box every step, and its state at the end.

    `hand` is an acceleration, or a function of time that gives acceleration and velocity.
    """
    body = bodies(np.array([2]), SIZE, np.array([MASS]), np.array([1.0]), np.array([0.002]))
    steps, state = round(seconds / step), np.zeros((1, STATE))
    state[0, 3:7] = Rotation.from_rotvec(tilt).as_quat(scalar_first=True)
    motion = np.zeros((1, steps, 6))
    if callable(hand):
        motion[0] = [np.concatenate(hand(k * step)) for k in range(steps)]
    else:
        motion[0, :, :3] = hand
    pivot = Pivot.zeros(1, arm=arm, stiffness=stiffness, damping=damping)
    seen = np.zeros((1, steps + 1, 4))
    swing_down(state, Hanging(body, pivot, air), hands(motion), np.array([steps]), step, 1, seen)
    return seen[0], state[0]


def hands(motion, wind=(0.0, 0.0), yaw=0.0):
    """Hands with accelerations and velocities (N, K, 6) that carry objects of a yaw through a wind."""
    one = np.ones(len(motion))
    acceleration, velocity = motion[..., :3].copy(), motion[..., 3:].copy()
    return Carrying(acceleration, velocity, one[:, None] * wind, one * np.cos(yaw), one * np.sin(yaw))


def turns(attitudes):
    return Rotation.from_quat(attitudes, scalar_first=True).as_rotvec()


@pytest.mark.parametrize(("stiffness", "ratio"), [(0.3, 0.05), (1.0, 0.25), (0.1, 0.1)])
def test_a_small_swing_has_frequency_and_decay_of_the_closed_form(stiffness, ratio):
    """Inertia I + m z^2 about the lip, and gravity as well where the hand rests."""
    arm, step = np.array([0.0, 0.0, -0.03]), 2e-5
    inertia = inertia_about_the_lip(arm)[1, 1]
    for hand, gravity in ((FALLING, 0.0), (RESTING, MASS * GRAVITY * 0.03)):
        rate = np.sqrt((stiffness + gravity) / inertia)
        decay = ratio * np.sqrt(stiffness / inertia)
        damping = 2.0 * decay * inertia
        seen, _ = swing(arm, stiffness, damping, hand, 0.2, step=step, tilt=(0.0, 0.01, 0.0))
        t = np.arange(len(seen)) * step
        wave = np.sqrt(rate**2 - decay**2)
        expected = 0.01 * np.exp(-decay * t) * (np.cos(wave * t) + decay / wave * np.sin(wave * t))
        np.testing.assert_allclose(turns(seen)[:, 1], expected, atol=1e-4)


@pytest.mark.parametrize("acceleration", [5.0, 40.0])
def test_under_a_steady_acceleration_it_leans_back_by_moment_over_stiffness(acceleration):
    arm, stiffness = np.array([0.0, 0.0, -0.03]), 0.8
    seen, _ = swing(arm, stiffness, 0.01, (acceleration, 0.0, 0.0), 1.0)
    angle = turns(seen)[-1, 1]
    expected = MASS * 0.03 * (acceleration * np.cos(angle) - GRAVITY * np.sin(angle)) / stiffness
    assert angle == pytest.approx(expected, rel=1e-9)
    assert angle == pytest.approx(MASS * acceleration * 0.03 / stiffness, rel=0.02)


def energy(state_or_states, stiffness):
    quats, rates = state_or_states
    turn = Rotation.from_quat(quats, scalar_first=True)
    kinetic = 0.5 * np.einsum("ki,ij,kj->k", rates, inertia_about_the_lip(ARM), rates)
    return kinetic + 0.5 * stiffness * (turn.as_rotvec() ** 2).sum(axis=1) + MASS * GRAVITY * turn.apply(ARM)[:, 2]


def states(damping, count=20, every=40):
    """Attitudes and angular velocities at some moments of a large swing in three dimensions."""
    ends = [
        swing(ARM, 0.3, damping, RESTING, k * every * 2e-5, step=2e-5, tilt=(0.5, 0.4, -0.3))[1] for k in range(count)
    ]
    return np.array([end[3:7] for end in ends]), np.array([end[10:13] for end in ends])


def test_energy_stays_without_damping_and_only_falls_with_it():
    kept = energy(states(0.0), 0.3)
    swung = 0.5 * 0.3 * (0.5**2 + 0.4**2 + 0.3**2)
    np.testing.assert_allclose(kept, kept[0], atol=0.003 * swung)
    lost = energy(states(5e-4), 0.3)
    assert (np.diff(lost) < 1e-6).all()
    assert lost[-1] < lost[0] - 0.1 * swung


def shaken(t):
    """Acceleration and velocity of a hand that shakes in all directions."""
    rates, size = np.array([40.0, 55.0, 23.0]), np.array([30.0, 20.0, 15.0])
    return size * np.cos(rates * t), size / rates * np.sin(rates * t)


def integrated(arm, stiffness, damping, seconds):
    """The same by Newton and Euler on positions of the hand, rotation matrices and an adaptive integrator."""
    inertia = inertia_about_the_lip(arm)

    def slope(t, y):
        turn, rate = Rotation.from_matrix(y[:9].reshape(3, 3)), y[9:]
        spring = -stiffness * turn.as_rotvec() - damping * turn.apply(rate)
        weight = np.cross(arm, turn.inv().apply(-MASS * (shaken(t)[0] + [0, 0, GRAVITY])))
        moment = turn.inv().apply(spring) + weight - np.cross(rate, inertia @ rate)
        skew = np.cross(np.eye(3), rate)
        return np.concatenate([(turn.as_matrix() @ skew).ravel(), np.linalg.solve(inertia, moment)])

    begin = np.concatenate([np.eye(3).ravel(), np.zeros(3)])
    end = solve_ivp(slope, (0.0, seconds), begin, rtol=1e-10, atol=1e-12).y[:, -1]
    return Rotation.from_matrix(end[:9].reshape(3, 3)), end[9:]


def test_a_large_swing_under_a_shaken_hand_is_that_of_an_adaptive_integrator():
    turn, rate = integrated(ARM, 0.2, 3e-4, 0.22)
    assert turn.magnitude() > 0.1
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4, 1.25e-4):
        _, state = swing(ARM, 0.2, 3e-4, shaken, 0.22, step=step)
        apart = Rotation.from_quat(state[3:7], scalar_first=True) * turn.inv()
        errors.append(apart.magnitude())
    assert errors[0] < 0.01
    assert errors[-1] < 0.002
    np.testing.assert_array_less(np.array(errors[1:]) / errors[:-1], 0.6)  # of first order
    np.testing.assert_allclose(state[10:13], rate, atol=0.03 * np.abs(rate).max())


def on_a_ball_joint(arm, stiffness, damping, wind, steps):
    """The same box on a ball joint of the engine, in a wind that blows against a hand at rest."""
    moments = bodies(np.array([2]), SIZE, np.array([MASS]), np.array([1.0]), np.array([0.0]))["inertia"][0]
    text = [" ".join(map(str, values)) for values in (arm, moments, SIZE[0] / 2.0, arm + np.array([0.0, 0.0, 0.002]))]
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><option timestep="0.001" density="1.2" viscosity="1.8e-5"
      gravity="0 0 -9.81" wind="{-wind} 0 0" integrator="Euler"><flag eulerdamp="disable"/></option><worldbody><body>
      <joint type="ball" stiffness="{stiffness}" damping="{damping}"/>
      <inertial pos="{text[0]}" mass="{MASS}" diaginertia="{text[1]}"/>
      <geom type="box" size="{text[2]}" pos="{text[3]}" fluidshape="ellipsoid"/></body></worldbody></mujoco>""")
    model.geom_fluid[0] = fluid_coefficients(np.array([2]), SIZE, np.array([1.0]))[0]
    data = mujoco.MjData(model)
    for _ in range(steps):
        mujoco.mj_step(model, data)
    return data.qpos, data.qvel


@pytest.mark.parametrize("speed", [0.0, 5.0])
def test_a_swing_through_air_is_that_of_a_ball_joint_in_the_wind(speed):
    def motion(_):
        return np.zeros(3), np.array([speed, 0.0, 0.0])

    _, state = swing(ARM, 0.05, 1e-5, motion, 0.3, air=1.0)
    turned, rate = on_a_ball_joint(ARM, 0.05, 1e-5, speed, 300)
    assert np.abs(rate).max() > 0.1
    np.testing.assert_allclose(state[3:7], turned, atol=1e-7)
    np.testing.assert_allclose(state[10:13], rate, atol=1e-6)


def test_a_hand_in_a_wind_carries_a_turned_object_as_a_hand_that_moves_against_still_air():
    """Motion and wind are in the world's axes, attitudes are in those of the object."""
    rng, yaw, wind = np.random.default_rng(5), 0.7, np.array([1.5, -0.8])
    body = bodies(np.array([2]), SIZE, np.array([MASS]), np.array([1.0]), np.array([0.002]))
    pivot, motion = Pivot.zeros(1, arm=ARM, stiffness=0.1), rng.normal(0.0, 5.0, (1, 60, 6))
    turned = np.concatenate([Rotation.from_euler("z", -yaw).apply(part) for part in (
        motion[0, :, :3], motion[0, :, 3:] - [*wind, 0.0])], axis=1)[None]  # fmt: skip
    ends = []
    for carried in (hands(motion, wind, yaw), hands(turned)):
        state, seen = np.zeros((1, STATE)), np.zeros((1, 61, 4))
        state[:, 3] = 1.0
        swing_down(state, Hanging(body, pivot, 1.0), carried, np.array([60]), 1e-3, 1, seen)
        ends.append(seen)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)
    assert np.abs(ends[0][..., 1:]).max() > 1e-3


def test_a_row_does_not_depend_on_the_others():
    rng, count = np.random.default_rng(3), 4
    index = np.full(count, 2)
    body = bodies(index, np.repeat(SIZE, count, 0), np.full(count, MASS), np.ones(count), np.zeros(count))
    pivot = Pivot.zeros(count, arm=rng.normal(0, 0.02, (count, 3)), stiffness=rng.uniform(0.1, 1.0, (count, 3)))
    hand, steps = rng.normal(0.0, 20.0, (count, 50, 6)), np.array([50, 13, 0, 31])

    def run(rows):
        state, seen = np.zeros((len(rows), STATE)), np.zeros((len(rows), 14, 4))
        state[:, 3] = 1.0
        swing_down(state, Hanging(body[rows], pivot[rows], 1.0), hands(hand[rows]), steps[rows], 1e-3, 4, seen)
        return state, seen

    together, looks = run(np.arange(count))
    for row in range(count):
        alone, look = run(np.array([row]))
        np.testing.assert_array_equal(alone[0], together[row])
        np.testing.assert_array_equal(look[0], looks[row])
        np.testing.assert_array_equal(
            look[0, -(-steps[row] // 4) :, :], np.broadcast_to(alone[0, 3:7], (14 - -(-steps[row] // 4), 4))
        )
    np.testing.assert_array_equal(together[2, 3:7], [1.0, 0.0, 0.0, 0.0])
