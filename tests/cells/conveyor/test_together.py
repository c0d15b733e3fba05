"""All honest sections of a level at once: grip, cup, pick, belt, dispatch and bins do not get into each other's way."""

import pickle

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig

COUNT, STEPS = 8, 4
HONEST = {
    "grip": {"limit": True},
    "cup": {"stiffness": 1.0, "peel": True, "fitted": True, "blow_off": 0.1},
    "pick": {"fails": True},
    "belt": {"gap": "edge", "spacing": [0.02, 0.18], "tracking": True, "neighbours": "solid"},
    "dispatch": "atc",
    "bins": {"emptied": 10},
}
LEVELS = ("nominal", "waste", "light", "dense")
BOTH = pytest.mark.parametrize("picks", ["belt", "independent"])


def core_of(base, picks="belt", rows=range(COUNT), threads=1, **changes):
    config = ConveyorConfig.load({"base": base, **HONEST, **changes})
    core = Core(ConveyorCell(config, len(rows), picks, threads))
    core.reset(np.arange(len(rows)), [np.random.default_rng([3, row]) for row in rows], seeded=True)
    return core


def steps(core, count=STEPS):
    action = np.random.default_rng(0).uniform(-0.3, 0.3, (count, COUNT, 2))[:, : core.count]
    return [core.step(one) for one in action]


def same(one, other, rows=slice(None)):
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.observation[rows], b.observation)
        np.testing.assert_array_equal(a.reward[rows], b.reward)
        for name, values in b.info.items():
            np.testing.assert_array_equal(a.info[name][rows], values, err_msg=name)


@BOTH
@pytest.mark.parametrize("fidelity", ["full", "flight"])
def test_a_row_is_the_same_alone_in_a_batch_and_with_other_threads(picks, fidelity):
    batch = steps(core_of("waste", picks, fidelity=fidelity))
    same(batch, steps(core_of("waste", picks, threads=2, fidelity=fidelity)))
    same(batch, steps(core_of("waste", picks, rows=range(1), fidelity=fidelity)), slice(0, 1))


@pytest.mark.parametrize("base", LEVELS)
def test_copies_go_on_alike(base):
    core = core_of(base, fidelity="flight")
    steps(core, 2)
    copy = pickle.loads(pickle.dumps(core))
    same(steps(core), steps(copy))


@BOTH
@pytest.mark.parametrize("base", LEVELS)
def test_what_is_lost_is_lost_once_and_numbers_are_numbers(base, picks):
    core = core_of(base, picks)
    for step in steps(core):
        info = step.info
        assert np.isfinite(step.observation).all()
        assert np.isfinite(step.reward).all()
        assert not (info["dropped"] & ~info["picked"]).any()
        assert not (info["is_success"] & (info["dropped"] | ~info["picked"])).any()
        assert (np.isfinite(info["landing_error"]) | ~info["picked"]).all()
        assert (info["ended_in"][~info["picked"]] == -1).all()
        assert (info["sorted"] <= info["is_success"]).all()
        assert (info["energy"] > 0.0).all()


@BOTH
@pytest.mark.parametrize("base", LEVELS)
def test_the_planners_own_world_sorts_everything(base, picks):
    for step in steps(core_of(base, picks, mismatch=0.0), 3):
        info = step.info
        assert info["picked"].all()
        assert not info["dropped"].any()
        assert not info["slip"].any()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("env_id", ["PnTConveyor-v0", "PnTRelease-v0"])
def test_the_environments_are_good_citizens(env_id):
    env = gym.make(env_id, level={"base": "waste", **HONEST, "fidelity": "flight"})
    check_env(env.unwrapped, skip_render_check=True)
    env.close()
