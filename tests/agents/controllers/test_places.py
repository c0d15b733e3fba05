"""Places of further tries: away from the place that failed, and with the scores by which they are chosen."""

import numpy as np
import pytest

from agents.controllers import make_controller
from agents.ground.cli import UsageError
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import observed
from pnt_gym.cells.grasp.observation import TABLE

LEVEL = {"base": "grasp", "fidelity": "flight"}
CHOOSERS = ("centroid", "flattest", "local_mlp")


@pytest.fixture(scope="module")
def failed():
    """Cells whose first tries went beside the objects, so that all failed; and what controllers see of them."""
    env = make_vector("PnTGrasp-v0", LEVEL, num_envs=24, threads=1)
    env.reset(seed=4)
    action = np.zeros((24, 6), dtype=np.float32)
    action[:, 1] = 0.3
    features, *_, info = env.step(action)
    observation = observed(features, info["kind"])
    values = TABLE.decode(observation.features)
    goes_on = (values["holds"] < 0.5) & (np.rint(values["tries_left"]) == 1)
    assert goes_on.sum() > 8
    yield env, observation, np.flatnonzero(goes_on), values
    env.close()


def places_of(env, observation, name, **options):
    """Places that a controller chooses (N, 2) [m]."""
    actions = make_controller(name, env, **options).act(observation)
    return core_of(env).config.grasp.reach * actions[:, :2].astype(np.float64)


@pytest.mark.parametrize("name", CHOOSERS)
def test_a_further_try_keeps_away_from_the_place_that_failed(failed, name):
    env, observation, rows, values = failed
    place = np.stack([values["failed_x"], values["failed_y"]], axis=-1)
    for share in (1.0, 2.0):
        away = np.hypot(*(places_of(env, observation, name, avoid=share) - place)[rows].T)
        assert (away > share * values["cup_radius"][rows] - 0.0036).mean() > 0.9  # but where nothing else is left


@pytest.mark.parametrize("name", CHOOSERS)
def test_only_the_failed_place_is_avoided(failed, name):
    env, observation, rows, values = failed
    near, far = (places_of(env, observation, name, avoid=share) for share in (0.0, 1.0))
    place = np.stack([values["failed_x"], values["failed_y"]], axis=-1)
    clear = np.hypot(*(near - place).T) > values["cup_radius"] + 0.02
    assert clear[rows].any()
    np.testing.assert_array_equal(near[clear], far[clear])


@pytest.mark.parametrize("name", CHOOSERS)
def test_the_chosen_place_has_the_highest_score(failed, name):
    env, observation, rows, _ = failed
    controller = make_controller(name, env)
    maps = controller.maps(observation, np.arange(24))
    places = places_of(env, observation, name)
    column = np.rint(places[:, 0] / 0.005 + 23.5).astype(int)
    row = np.rint(23.5 - places[:, 1] / 0.005).astype(int)
    chosen = maps[np.arange(24), row, column]
    np.testing.assert_allclose(chosen[rows], np.nanmax(maps, axis=(1, 2))[rows])


def test_a_negative_distance_is_refused(failed):
    env = failed[0]
    with pytest.raises(UsageError, match="avoid is -1; it must be 0 or a number of radii"):
        make_controller("flattest", env, avoid=-1.0)
