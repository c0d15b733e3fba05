"""Trackers of a shift against shifts on paper with a known truth."""

from collections.abc import Callable

import numpy as np
import pytest

from agents.controllers.filters import BIN_CAMERA, NOISE, SURPRISE, landing_noise
from agents.controllers.in_context import InContext
from agents.controllers.recurrent import LAYERS
from agents.controllers.trackers import RIDGE_FEATURES, Kalman, RecursiveRidge, RunningMean, Tracker, drift_effects
from pnt_gym.cells.conveyor.drift import Feedback
from pnt_gym.cells.conveyor.observation import FEATURES, TABLE

CAMERA = -1.2
PRIOR = np.array([0.004, 0.008, 0.008, 0.008])
COLUMNS = [[one.name for one in FEATURES].index(name) for name in RIDGE_FEATURES]


def network(size: int = 8) -> dict[str, np.ndarray]:
    """A network that has learned nothing, but answers."""
    random, inputs = np.random.default_rng(0), {"memory_in": 28, "memory_kept": size, "head": size + 26, "answer": size}
    outputs = {"memory_in": 3 * size, "memory_kept": 3 * size, "head": size, "answer": 2}
    state: dict[str, np.ndarray] = {}
    for layer in LAYERS:
        state[f"{layer}_weight"] = random.normal(0.0, 0.3, (outputs[layer], inputs[layer]))
        state[f"{layer}_bias"] = random.normal(0.0, 0.3, outputs[layer])
    return state


def in_context() -> InContext:
    tracker = InContext(CAMERA, False, size=8)
    tracker.restore(network())
    return tracker


TRACKERS: dict[str, Callable[[], Tracker]] = {
    "ema": RunningMean,
    "kalman": lambda: Kalman(CAMERA),
    "recursive_ridge": RecursiveRidge,
    "in_context": in_context,
}


def throws(count: int, seed: int = 0) -> np.ndarray:
    """Observations of throws that could be (count, 26)."""
    return np.random.default_rng(seed).uniform(-0.8, 0.8, (count, len(FEATURES)))


def noise(count: int, seed: int) -> np.ndarray:
    return np.random.default_rng([9, seed]).standard_normal((count, 2)) * NOISE


def everyone(count: int) -> np.ndarray:
    return np.full(count, True)


def off_by(thrown: np.ndarray, state: np.ndarray) -> np.ndarray:
    """What delay, camera x and y, and encoder (N, 4) do to throws (N, 2)."""
    return np.einsum("nij,nj->ni", drift_effects(thrown, CAMERA), state)


def test_effects_are_those_of_pencil_and_paper() -> None:
    """A camera moves the landing as itself, an encoder as what it has added up to, a delay along the throw only."""
    thrown = throws(50)
    seen, effect = TABLE.decode(thrown), drift_effects(thrown, CAMERA)
    heading = np.arctan2(seen["target_y"] - seen["pick_y"], seen["target_x"] - seen["pick_x"])
    along, across = effect[:, 0], effect[:, 1]
    np.testing.assert_allclose(along[:, 1:3], np.stack([np.cos(heading), np.sin(heading)], axis=1), atol=1e-12)
    np.testing.assert_allclose(across[:, 1:3], np.stack([-np.sin(heading), np.cos(heading)], axis=1), atol=1e-12)
    way = seen["pick_x"] - CAMERA
    assert (way > 0.0).all()
    np.testing.assert_allclose(effect[:, :, 3], way[:, None] * effect[:, :, 1], atol=1e-12)
    assert not across[:, 0].any()
    assert (along[:, 0] > seen["release_speed"] * np.cos(seen["elevation"]) * 0.99).all()  # later is also higher


def test_a_running_mean_is_the_mean() -> None:
    tracker, z = RunningMean(rate=0.0, prior=0.0), 0.004 * np.random.default_rng(1).standard_normal((30, 5, 2))
    tracker.begin(everyone(5))
    for one in z:
        tracker.learn(throws(5), one, everyone(5))
    np.testing.assert_allclose(tracker.effect(throws(5, 1)), z.mean(axis=0), atol=1e-15)


def test_a_running_mean_leans_on_its_prior_and_follows_at_its_rate() -> None:
    tracker, z = RunningMean(rate=0.25, prior=2.0), np.array([[0.009, -0.006]])
    tracker.begin(everyone(1))
    tracker.learn(throws(1), z, everyone(1))
    np.testing.assert_allclose(tracker.effect(throws(1)), z / 3.0)
    for _ in range(100):
        tracker.learn(throws(1), z, everyone(1))
    np.testing.assert_allclose(tracker.effect(throws(1)), z, atol=1e-6)
    tracker.learn(throws(1), z + 0.004, everyone(1))
    np.testing.assert_allclose(tracker.effect(throws(1)), z + 0.001, atol=1e-6)


def kalmans(rows: int, picks: int, walk: tuple[float, float, float, float]) -> tuple[Kalman, np.ndarray]:
    """A filter that has seen constant drifts, one of each row (rows, 4)."""
    truth = PRIOR * np.random.default_rng(2).standard_normal((rows, 4))
    tracker = Kalman(CAMERA, walk=walk)
    tracker.begin(everyone(rows))
    for pick in range(picks):
        thrown = throws(rows, pick)
        tracker.learn(thrown, off_by(thrown, truth) + noise(rows, pick), everyone(rows))
    return tracker, truth


def test_kalman_converges_to_a_constant_drift() -> None:
    left = []
    for picks in (3, 15, 60):
        tracker, truth = kalmans(200, picks, (0.0, 0.0, 0.0, 0.0))
        fresh = throws(200, 999)
        left.append(np.sqrt(np.square(tracker.effect(fresh) - off_by(fresh, truth)).mean()))
    nothing = np.sqrt(np.square(off_by(fresh, truth)).mean())
    assert left[2] < 0.6 * left[1] < 0.5 * left[0] < 0.5 * nothing
    assert left[2] < 0.0025


def test_kalmans_error_is_what_its_own_covariance_says() -> None:
    """The squared error in units of the covariance is the number of unknowns on average: no more, no less."""
    for picks in (2, 10, 50):
        tracker, truth = kalmans(300, picks, (0.0, 0.0, 0.0, 0.0))
        error = tracker._filters.state - truth[:, None]
        found = np.einsum("nfi,nfij,nfj->nf", error, np.linalg.inv(tracker._filters.spread), error)
        assert found.mean() == pytest.approx(4.0, rel=0.2), picks
    tracker, truth = kalmans(300, 50, (0.0006, 0.0007, 0.0007, 0.0005))
    error = tracker._filters.state - truth[:, None]
    still, wandering = np.einsum("nfi,nfij,nfj->fn", error, np.linalg.inv(tracker._filters.spread), error)
    assert still.mean() == pytest.approx(4.0, rel=0.2)
    assert wandering.mean() < 4.0  # of what might have moved it is less sure than it needs to be


def test_kalman_goes_by_how_noisy_the_camera_over_the_bins_is() -> None:
    rows, usual, poor = 300, 0.005, 0.020
    truth = PRIOR * np.random.default_rng(2).standard_normal((rows, 4))
    left = []
    for told in (poor, usual):
        tracker = Kalman(CAMERA, noise=told)
        tracker.begin(everyone(rows))
        for pick in range(15):
            thrown, blur = throws(rows, pick), np.random.default_rng([7, pick]).standard_normal((rows, 2))
            more = np.sqrt(poor**2 - usual**2) * blur
            tracker.learn(thrown, off_by(thrown, truth) + noise(rows, pick) + more, everyone(rows))
        fresh = throws(rows, 999)
        left.append(np.sqrt(np.square(tracker.effect(fresh) - off_by(fresh, truth)).mean()))
    assert left[0] < 0.85 * left[1]


def test_a_camera_of_the_usual_noise_is_part_of_what_is_usual() -> None:
    assert Feedback().noise == BIN_CAMERA
    np.testing.assert_array_equal(landing_noise(BIN_CAMERA), np.diag(np.square(NOISE)))
    assert np.linalg.eigvalsh(landing_noise(0.0)).min() > 0.0


@pytest.mark.parametrize("walks", [True, False])
def test_kalman_finds_out_whether_a_drift_walks(walks: bool) -> None:
    """It does as well as a filter that knows, and better than one that takes the other thing for granted."""
    rows, walk = 200, np.array([0.0012, 0.0014, 0.0014, 0.0010])
    random, truth = np.random.default_rng(3), PRIOR * np.random.default_rng(5).standard_normal((rows, 4))
    both, sure = Kalman(CAMERA), {"still": Kalman(CAMERA), "wanders": Kalman(CAMERA)}
    sure["still"]._make_filters.keywords["beliefs"], sure["wanders"]._make_filters.keywords["beliefs"] = (
        (1.0, 0.0),
        (0.0, 1.0),
    )
    off: dict[str, list[float]] = {name: [] for name in ("both", *sure)}
    for one in sure.values():
        one._make_filters.keywords["turning"] = 0.0
    for one in (both, *sure.values()):
        one.begin(everyone(rows))
    for pick in range(120):
        truth = truth + walks * walk * random.standard_normal((rows, 4))
        thrown = throws(rows, pick)
        for name, one in {"both": both, **sure}.items():
            off[name].append(np.abs(one.effect(thrown) - off_by(thrown, truth)).mean())
            one.learn(thrown, off_by(thrown, truth) + noise(rows, pick), everyone(rows))
    late = {name: np.mean(errors[60:]) for name, errors in off.items()}
    right, wrong = ("wanders", "still") if walks else ("still", "wanders")
    assert late["both"] < 1.25 * late[right]
    assert late["both"] < 0.75 * late[wrong]
    belief = both._filters.belief.mean(axis=0)
    assert belief[1 if walks else 0] > 0.75


def test_recursive_ridge_recovers_what_is_linear_in_the_plan() -> None:
    rows = 6
    weights = 0.006 * np.random.default_rng(4).standard_normal((rows, len(RIDGE_FEATURES) + 1, 2))

    def linear(thrown: np.ndarray) -> np.ndarray:
        one = np.concatenate([np.ones((rows, 1)), thrown[:, COLUMNS]], axis=1)
        return np.einsum("nf,nfe->ne", one, weights)

    tracker = RecursiveRidge(forget=1.0, penalty=1e-6)
    tracker.begin(everyone(rows))
    for pick in range(25):
        tracker.learn(throws(rows, pick), linear(throws(rows, pick)), everyone(rows))
    np.testing.assert_allclose(tracker.effect(throws(rows, 99)), linear(throws(rows, 99)), atol=1e-6)
    held = RecursiveRidge(penalty=1e9)
    held.begin(everyone(rows))
    held.learn(throws(rows), np.full((rows, 2), 0.02), everyone(rows))
    assert np.abs(held.effect(throws(rows))).max() < 1e-6


def learned(name: str, count: int, picks: int = 12, start: int = 0) -> Tracker:
    """A tracker that has seen some throws of rows that differ."""
    tracker = TRACKERS[name]()
    tracker.begin(everyone(count))
    for pick in range(start, start + picks):
        z = np.linspace(-0.02, 0.02, count)[:, None] + noise(count, pick)
        tracker.learn(throws(count, pick), z, everyone(count))
    return tracker


@pytest.mark.parametrize("name", ["ema", "kalman", "recursive_ridge"])
def test_a_landing_that_a_rim_threw_off_moves_the_estimate_little(name: str) -> None:
    """By no more than one that is some deviations off, however far it went."""
    asked, moved = throws(3, 77), []
    for far in (3.0 * SURPRISE * np.array(NOISE), np.array([0.4, -0.4])):
        tracker = learned(name, 3, picks=20)
        before = tracker.effect(asked)
        tracker.learn(throws(3, 50), before + far * [1.0, -1.0], everyone(3))
        moved.append(np.abs(tracker.effect(asked) - before).max())
    assert moved[1] < 0.012
    assert moved[1] < 2.0 * moved[0]
