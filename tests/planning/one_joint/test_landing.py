"""From a release to the goal and back: against an integrated flight, a dense scan and finite differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.planning.one_joint import Arm, Block, ThrowReason, landing_state, release_states, release_states_batch
from pnt_gym.planning.one_joint.flight import landing_jacobian

G = 9.81
D = 0.015
EXAMPLE = np.array([0.0, 0.4, np.deg2rad(150.0), 0.0])
PHI = np.array([0.0, 0.0, 1.0, 0.0])


def random_releases(count, seed):
    rng = np.random.default_rng(seed)
    radius = rng.uniform(0.02, 0.28, count)
    columns = [rng.uniform(-1.5, 1.5, count), rng.uniform(0.5, 12.5, count), np.hypot(radius, D)]
    return np.stack([*columns, rng.uniform(0.03, 0.7, count)], axis=1)


releases = st.tuples(
    st.floats(-1.5, 1.5),
    st.floats(0.5, 12.5),
    st.floats(0.02, 0.28).map(lambda r: float(np.hypot(r, D))),
    st.floats(0.03, 0.7),
)


@given(releases)
def test_landing_state_is_where_a_body_flies(u):
    angle, speed, length, time = u
    along = np.sqrt(length**2 - D**2)
    place = np.array([along * np.cos(angle) - D * np.sin(angle), along * np.sin(angle) + D * np.cos(angle)])
    velocity = speed * np.array([-place[1], place[0]])
    steps = 64
    for _ in range(steps):
        place = place + time / steps * velocity + 0.5 * (time / steps) ** 2 * np.array([0.0, -G])
        velocity = velocity + time / steps * np.array([0.0, -G])
    expected = [place[0], place[1], angle + speed * time, velocity[1]]
    assert landing_state(u) == pytest.approx(expected, abs=1e-11)


@given(releases)
def test_a_release_comes_back_from_its_landing_state(u):
    z = landing_state(u)
    found = release_states(z)
    here = found.u[found.turns == 0]
    assert np.abs(here - np.array(u)).max(axis=1).min() < 1e-6
    for row, turns in zip(found.u, found.turns, strict=True):
        assert landing_state(row) == pytest.approx(z + 2.0 * np.pi * turns * PHI, abs=1e-9)


def test_no_release_of_hundreds_of_random_goals_is_missed():
    """The scan steps through flight times and knows nothing of the turned angle that the solver steps through."""
    z = landing_state(random_releases(400, seed=3))
    row, root, angle = scan(z, np.linspace(1e-4, 1.6, 4001))
    for k, goal in enumerate(z):
        ours = release_states(goal).u
        times, angles = root[row == k, None], angle[row == k, None]
        away = np.abs(ours[:, 3] - times) + np.abs(np.angle(np.exp(1j * (ours[:, 0] - angles))))
        assert (away.min(axis=1) < 1e-6).all(), (goal, times, angles)
    assert len(row) > 1200


def scan(z, time):
    """Roots (goal, t_f, theta) with up to two extra turns: changes of sign over flight times, then bisection."""
    found = []
    for row, goal in enumerate(z):
        for sign in (1.0, -1.0):
            angle, turned, good = flight_from(goal, time, sign)
            for turns in range(-2, 3):
                miss = angle + turned - goal[2] - 2.0 * np.pi * turns
                both = good[1:] & good[:-1] & (np.abs(np.diff(miss)) < 1.0)
                found += [(row, sign, turns, k) for k in np.nonzero(both & (miss[1:] * miss[:-1] < 0.0))[0]]
    row, sign, turns, k = np.array(found).T
    row, k = row.astype(int), k.astype(int)
    goal = z[row].T

    def miss_at(flight):
        angle, turned, _ = flight_from(goal, flight, sign)
        return angle + turned - goal[2] - 2.0 * np.pi * turns

    low, high = time[k], time[k + 1]
    below = miss_at(low) < 0.0
    for _ in range(45):
        middle = 0.5 * (low + high)
        same = (miss_at(middle) < 0.0) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    real = np.abs(miss_at(low)) < 1e-6
    return row[real], low[real], flight_from(goal, low, sign)[0][real]


def flight_from(goal, time, sign):
    """Release angle and angle turned in flight for a flight time, on one of two branches, and where they are real."""
    x, y, _, dy = goal
    up, rise = y - dy * time - 0.5 * G * time**2, dy + G * time
    inside = x * x + 4.0 * rise * time * up
    across = 0.5 * (x + sign * np.sqrt(np.maximum(inside, 0.0)))
    length = np.hypot(across, up)
    good = (inside > 0.0) & (length > D) & (np.abs(across) > 1e-9)
    angle = np.arctan2(up, across) - np.arcsin(D / np.where(good, length, 1.0))
    # Within half a turn, as the solver's.
    angle = np.where(angle <= -np.pi, angle + 2.0 * np.pi, angle)
    return angle, rise / np.where(good, across, 1.0) * time, good


def test_the_papers_goal_has_five_releases_and_one_that_the_arm_can_do():
    found = release_states(EXAMPLE)
    assert found.turns.tolist() == [-2, -1, 0, 1, 2]
    assert found.feasible.tolist() == [False, False, True, False, False]
    angle, speed, length, time = found.u[2]
    assert np.rad2deg(angle) == pytest.approx(20.835, abs=1e-3)
    assert (speed, length, time) == pytest.approx((9.3190, 0.27858, 0.24191), abs=1e-4)
    assert "speed 31.77 rad/s" in found.reasons[3][0] and "12.57 rad/s" in found.reasons[3][0]
    assert any("angle" in said for said in found.reasons[0])


def test_a_radius_beyond_the_arm_is_said_with_value_and_limit():
    found = release_states([0.25, 0.1, np.pi, -2.0])
    (said,) = found.reasons[int(np.flatnonzero(found.turns == 0)[0])]
    assert "0.3324 m is too long" in said and "0.28 m" in said


def test_phi_is_not_wrapped():
    once = release_states(EXAMPLE)
    turned = release_states(EXAMPLE + 2.0 * np.pi * PHI)
    assert np.abs(turned.u[turned.turns == 0] - once.u[once.turns == 1]).max() < 1e-9
    assert not turned.feasible[turned.turns == 0].any()


def test_the_batch_finds_what_the_single_search_finds():
    z = landing_state(random_releases(300, seed=5))
    batch = release_states_batch(z)
    for k, goal in enumerate(z):
        one = release_states(goal)
        fits = one.u[one.feasible & (one.turns == 0)]
        assert batch.feasible[k] == bool(len(fits))
        if len(fits):
            assert np.abs(fits - batch.u[k]).max(axis=1).min() < 1e-8
    assert 100 < batch.feasible.sum() < 300
    assert np.isnan(batch.u[~batch.feasible]).all()
    assert (batch.reason[batch.feasible] == ThrowReason.FEASIBLE).all()


def test_the_jacobian_is_the_derivative():
    u = random_releases(50, seed=7)
    for k in range(4):
        step = np.zeros(4)
        step[k] = 1e-6
        slope = (landing_state(u + step) - landing_state(u - step)) / 2e-6
        assert landing_jacobian(u, D)[..., k] == pytest.approx(slope, abs=1e-5, rel=1e-6)


def test_a_stronger_need_is_a_reason():
    weak = Arm(torque=1.5)
    found = release_states(EXAMPLE, arm=weak)
    (said,) = found.reasons[2]
    assert "rad/s2" in said
    assert release_states_batch(EXAMPLE[None], arm=weak).reason[0] in (ThrowReason.WINDOW, ThrowReason.HELD)


def test_another_half_height_gives_another_release():
    for d in (0.0, 0.02):
        found = release_states(EXAMPLE, half_height=d)
        assert landing_state(found.u[found.turns == 0][0], half_height=d) == pytest.approx(EXAMPLE, abs=1e-9)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: landing_state([0.1, 9.0, np.nan, 0.2]), "finite"),
        (lambda: landing_state([0.1, 9.0, 0.2]), "shape"),
        (lambda: landing_state([0.1, 9.0, 0.2, 0.2], half_height=-0.1), "half_height"),
        (lambda: landing_state([0.1, 9.0, 0.01, 0.2]), "l_t is 0.01 m"),
        (lambda: landing_state("abc"), "numbers"),
        (lambda: release_states([0.0, 0.4, np.inf, 0.0]), "finite"),
        (lambda: release_states([[0.0, 0.4, 1.0, 0.0]]), r"\(4,\)"),
        (lambda: release_states(EXAMPLE, half_height=-1e-3), "at least 0"),
        (lambda: release_states_batch(EXAMPLE), r"\(N, 4\)"),
        (lambda: Block(half_height=-0.01), "at least 0"),
    ],
)
def test_bad_input_is_said_in_one_sentence(call, words):
    with pytest.raises(ValueError, match=words) as error:
        call()
    assert "\n" not in str(error.value)
