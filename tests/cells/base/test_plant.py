"""What is read from a recorded flight, on flights made by hand."""

import numpy as np
import pytest

from pnt_gym.cells.base.plant import roll_out, touching
from pnt_gym.cells.base.recorded import ObjectFlight, joined_touchdown, lies_in, touchdown
from pnt_gym.engine import Batch, mujoco
from pnt_gym.errors import PhysicsError
from pnt_gym.planning.motion.ballistics import landing_point
from tests.tools.commands import run_python

STEP, STEPS, RELEASE, GRAVITY, RIM = 1e-3, 400, 50, 9.81, -0.85
OPENING = np.array([[0.3, 0.4, RIM]])
START, VELOCITY = np.array([0.0, 0.0, -0.75]), np.array([1.0, 2.0, 0.8])


def parabola():
    """A flight that is released in step 50, (1, 400, 3)."""
    t = np.maximum(np.arange(STEPS) - RELEASE, 0)[:, None] * STEP
    position = START + VELOCITY * t - [0, 0, 0.5 * GRAVITY] * t**2
    velocity = np.broadcast_to(VELOCITY, position.shape) - [0, 0, GRAVITY] * t
    return position[None], velocity[None].copy()


def flight(position=None, velocity=None, cup=(), anything=()):
    good = parabola()
    hand_touch, any_touch = np.zeros((1, STEPS), dtype=bool), np.zeros((1, STEPS), dtype=bool)
    hand_touch[0, list(cup)] = True
    any_touch[0, [*cup, *anything]] = True
    return ObjectFlight(
        position=good[0] if position is None else position,
        velocity=good[1] if velocity is None else velocity,
        hand_touch=hand_touch,
        any_touch=any_touch,
        release_step=np.array([RELEASE]),
        last_step=np.array([STEPS - 1]),
    )


EXPECTED = landing_point(START, VELOCITY, RIM)[:2]


def test_a_free_flight_lands_where_the_parabola_does():
    np.testing.assert_allclose(touchdown(flight(), OPENING).landing[0], EXPECTED, atol=1e-9)


@pytest.mark.parametrize("touched", [60, 150, 200])
def test_a_touched_flight_is_carried_on_from_before_the_touch(touched):
    position, velocity = parabola()
    position[0, touched:] = position[0, touched]  # caught by something
    velocity[0, touched:] = 0.0
    assert position[0, touched, 2] > RIM
    caught = flight(position, velocity, anything=range(touched, STEPS))
    np.testing.assert_allclose(touchdown(caught, OPENING).landing[0], EXPECTED, atol=1e-9)


def test_contacts_in_the_grip_do_not_count():
    held = flight(cup=range(RELEASE + 1), anything=range(RELEASE))
    assert not touchdown(held, OPENING).recontact[0]
    np.testing.assert_allclose(touchdown(held, OPENING).landing[0], EXPECTED, atol=1e-9)


def test_a_cup_that_touches_again_is_reported_and_its_push_counts():
    """A second touch by the cup belongs to the throw: the flight after it is measured."""
    position, velocity = parabola()
    t = np.arange(STEPS - 80)[:, None] * STEP
    pushed = velocity[0, 80] + [0.5, 0.0, 0.0]
    position[0, 80:] = position[0, 80] + pushed * t - [0, 0, 0.5 * GRAVITY] * t**2
    velocity[0, 80:] = pushed - [0, 0, GRAVITY] * t
    again = flight(position, velocity, cup=[79])
    assert touchdown(again, OPENING).recontact[0]
    expected = landing_point(position[0, 80], pushed, RIM)[:2]
    np.testing.assert_allclose(touchdown(again, OPENING).landing[0], expected, atol=1e-9)
    assert np.linalg.norm(expected - EXPECTED) > 0.05


def test_what_happens_after_the_last_step_does_not_count():
    late = flight(cup=[390])
    assert touchdown(late, OPENING).recontact[0]
    cut = late._replace(last_step=np.array([380]))
    assert not touchdown(cut, OPENING).recontact[0]
    np.testing.assert_array_equal(touchdown(cut, OPENING).position, late.position[:, 380])


def sensed(flight, steps):
    """What sensors tell of some steps of a flight: motion, and closed contacts of the object and of the cup."""
    touches = [
        np.stack([touch[0] * 1.0, np.full(STEPS, -1e-6)], axis=1) for touch in (flight.any_touch, flight.hand_touch)
    ]
    return np.concatenate([flight.position[0], flight.velocity[0], *touches], axis=1)[None, steps]


@pytest.mark.parametrize(
    ("clear", "touches"),
    [
        (RELEASE, {}),
        (RELEASE + 1, {"cup": [RELEASE], "anything": [150]}),
        (95, {"cup": [10, 80], "anything": [150]}),
        (95, {"anything": [90]}),
    ],
)
def test_a_flight_that_is_recorded_in_two_parts_lands_as_one(clear, touches):
    """With the robot, which moves on until the longest throw ends, and from `clear` on without it."""
    whole, left = flight(**touches), np.array([STEPS - clear])
    held, alone = sensed(whole, slice(0, clear + 7)), sensed(whole, slice(clear, None))[..., :8].copy()
    held[:, clear:] = np.nan
    joined = joined_touchdown(held, alone, np.array([clear]), left, whole.release_step, 8, OPENING)
    for ours, expected in zip(joined, touchdown(whole, OPENING), strict=True):
        np.testing.assert_array_equal(ours, expected)


def test_an_object_that_never_comes_up_to_the_rim_counts_where_it_lies():
    position, velocity = parabola()
    position[..., 2] -= 0.5
    velocity[..., 2] = -np.abs(velocity[..., 2])
    low = flight(position, velocity)
    np.testing.assert_array_equal(touchdown(low, OPENING).landing[0], position[0, -1, :2])


def test_touch_needs_a_found_contact_that_is_closed():
    """A contact that the engine only predicts for a fast object is still open and does not count."""
    found, distance = (0.0, 1.0, 1.0), (0.0, 0.004, -1e-6)
    np.testing.assert_array_equal(touching(np.array([found, distance]).T), [False, False, True])


@pytest.mark.parametrize(
    ("position", "velocity", "inside"),
    [
        ((0.30, 0.40, -1.0), (0, 0, 0), True),
        ((0.409, 0.291, -1.0), (0, 0, 0), True),
        ((0.411, 0.40, -1.0), (0, 0, 0), False),  # in the wall
        ((0.30, 0.40, -0.84), (0, 0, 0), False),  # above the rim
        ((0.30, 0.40, -0.95), (0, 0, 1.3), True),  # rises 86 mm, to 14 mm below the rim
        ((0.30, 0.40, -0.95), (0, 0, 1.5), False),  # rises 115 mm
        ((0.30, 0.40, -0.86), (0, 0, -2.0), False),  # a rebound could lift it out again
        ((0.30, 0.40, -1.16), (0, 0, 0), False),  # below the bottom
    ],
)  # fmt: skip
def test_lying_in_a_bin(position, velocity, inside):
    positions, velocities = parabola()
    positions[0, -1], velocities[0, -1] = position, velocity
    arrived = touchdown(flight(positions, velocities), OPENING)
    lies = lies_in(arrived, OPENING, np.array([[0.22, 0.22]]), np.array([0.30]))
    assert lies.tolist() == [inside]


def test_a_record_depends_on_no_other_row_and_has_zeros_after_its_own_steps():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><joint type='slide' axis='0 0 1'/><geom size='0.1'/></body></worldbody></mujoco>"
    )
    steps = np.arange(3, 40, 3)
    many = roll_out(Batch(model, nsim=len(steps)), np.zeros((len(steps), 39, 0)), steps, ("qpos",))["qpos"]
    for row, own in enumerate(steps):
        one = roll_out(Batch(model, nsim=1), np.zeros((1, own, 0)), steps[row : row + 1], ("qpos",))["qpos"]
        assert (one < 0.0).all()
        np.testing.assert_array_equal(many[row, :own], one[0])
        assert not many[row, own:].any()


def test_an_unknown_field_of_a_record_is_one_sentence():
    batch = Batch(mujoco.MjModel.from_xml_string("<mujoco/>"), nsim=1)
    with pytest.raises(PhysicsError, match=r"unknown recorded field 'xpos'; .* known are sensordata, qpos, qvel, act"):
        roll_out(batch, np.zeros((1, 3, 0)), np.array([3]), ("qpos", "xpos"))


STEPPED = """
from pnt_gym.engine import mujoco
body = "<body><freejoint/><geom size='1'/></body>"
model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
data = mujoco.MjData(model)
mujoco.mj_step(model, data)
print(data.timer[0].number, sum(timer.duration for timer in data.timer))
"""


def test_a_step_reads_no_clock():
    # In a process of its own, since whoever imports MuJoCo anew sets its clock again.
    assert run_python("-c", STEPPED, check=True).stdout == "1 0.0\n"
