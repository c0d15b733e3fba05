"""What is a throw and what is not: a memory of throws alone, and landings that are no throw's."""

from typing import Any

import numpy as np
import pytest
from gymnasium.spaces import Box
from stable_baselines3.common.buffers import ReplayBuffer

from agents.ground.infos import LANDING, results
from agents.learning.hyperparameters import hyperparameters
from agents.learning.sb3 import ThrownBuffer, build
from agents.learning.vec_env import SameStepVecEnv
from tests.tools.toy_cell import ToyVectorEnv

ROWS = 4
THROWN = {"picked": True, "dropped": False}
UNPICKED = {"picked": False, "dropped": False}
LOST = {"picked": True, "dropped": True}
FIELDS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")


def memory(kind: type[ReplayBuffer], steps: int = 8) -> ReplayBuffer:
    return kind(steps * ROWS, Box(-5.0, 5.0, (3,)), Box(-1.0, 1.0, (2,)), device="cpu", n_envs=ROWS)


def batch(seed: int, told: list[dict[str, bool]]) -> tuple[Any, ...]:
    """A step of all rows; a row in which anything differs is another one."""
    random = np.random.default_rng(seed)
    parts = [random.standard_normal((ROWS, size)).astype(np.float32) for size in (3, 3, 2)]
    done = np.array([True, False, True, False])
    infos = [{**one, "TimeLimit.truncated": row == 2} for row, one in enumerate(told)]
    return (*parts, random.standard_normal(ROWS).astype(np.float32), done, infos)


def same(one: ReplayBuffer, other: ReplayBuffer) -> bool:
    return (one.pos, one.full) == (other.pos, other.full) and all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in FIELDS
    )


@pytest.mark.parametrize(
    ("told", "kept"),
    [
        ([THROWN, UNPICKED, THROWN, LOST], [0, 0, 2, 2]),
        ([UNPICKED, LOST, THROWN, UNPICKED], [2, 2, 2, 2]),
        ([LOST, THROWN, THROWN, THROWN], [1, 1, 2, 3]),
        ([THROWN, THROWN, THROWN, THROWN], [0, 1, 2, 3]),
    ],
)
def test_throws_of_other_rows_stand_in_for_what_was_none(told: list[dict[str, bool]], kept: list[int]) -> None:
    """Whole rows, with how their episode ended; what was thrown stays in its own row."""
    ours, plain = memory(ThrownBuffer), memory(ReplayBuffer)
    *parts, infos = batch(3, told)
    ours.add(*parts, infos)
    plain.add(*(part[kept] for part in parts), [infos[row] for row in kept])
    assert ours.size() == 1
    assert same(ours, plain)


def test_a_batch_without_a_throw_is_not_kept() -> None:
    ours, plain = memory(ThrownBuffer), memory(ReplayBuffer)
    for seed, told in enumerate(([THROWN] * ROWS, [UNPICKED, LOST] * 2, [THROWN] * ROWS)):
        ours.add(*batch(seed, told))
        if told[0] is THROWN:
            plain.add(*batch(seed, told))
    assert ours.size() == 2
    assert same(ours, plain)


def test_an_empty_memory_takes_even_a_batch_without_a_throw() -> None:
    """Learning that begins with the first step has something to draw."""
    ours, plain = memory(ThrownBuffer), memory(ReplayBuffer)
    for one in (ours, plain):
        one.add(*batch(0, [UNPICKED, LOST] * 2))
    assert same(ours, plain)
    assert len(ours.sample(2).rewards) == 2


def test_what_was_stepped_is_left_as_it_was() -> None:
    """The learner goes on with these arrays."""
    told = [THROWN, UNPICKED, THROWN, LOST]
    *parts, infos = batch(3, told)
    memory(ThrownBuffer).add(*parts, infos)
    *expected, said = batch(3, told)
    assert infos == said
    assert all(np.array_equal(part, other) for part, other in zip(parts, expected, strict=True))


def test_where_a_cell_tells_nothing_it_is_the_common_memory() -> None:
    """Beyond its end too, where the oldest throws are written over."""
    ours, plain = memory(ThrownBuffer, 5), memory(ReplayBuffer, 5)
    for seed in range(8):
        for one in (ours, plain):
            one.add(*batch(seed, [{}] * ROWS))
        assert same(ours, plain)
    assert ours.full


class Slippery(ToyVectorEnv):
    """A third of the picks fail and a third of the rest is lost: no reward of a throw is as bad as theirs."""

    BAD = -7.0

    def step(self, actions: np.ndarray) -> Any:
        observation, reward, *ends, info = super().step(actions)
        chance = np.random.default_rng(int(1e6 * info["landing_error"].sum())).random((2, self.num_envs))
        info["picked"] = chance[0] > 1 / 3
        info["dropped"] = info["picked"] & (chance[1] < 1 / 3)
        return observation, np.where(info["picked"] & ~info["dropped"], reward, self.BAD), *ends, info


@pytest.mark.parametrize("algo", ["sac", "td3", "tqc"])
def test_those_with_a_memory_learn_from_throws_alone(algo: str) -> None:
    env = SameStepVecEnv(Slippery(ROWS))
    settings = {**hyperparameters(algo, "PnTRelease-v0"), "learning_starts": 1000}
    model: Any = build(algo, env, settings, 0)
    model.learn(200)
    kept = model.replay_buffer.rewards[: model.replay_buffer.size()]
    assert 0.75 * 200 < kept.size < 200  # some steps had no throw at all
    assert kept.min() > Slippery.BAD


@pytest.mark.parametrize(
    ("told", "expected"),
    [
        ([THROWN, UNPICKED, THROWN, LOST], [1.0, 2.0, 3.0, 2.0]),
        ([UNPICKED, LOST, THROWN, UNPICKED], [3.0, 3.0, 3.0, 3.0]),
        ([THROWN] * 4, [1.0, -7.0, 3.0, -9.0]),
        ([UNPICKED] * 4, [1.0, -7.0, 3.0, -9.0]),
    ],
)
def test_without_a_memory_what_was_none_counts_like_the_throws_beside_it(
    told: list[dict[str, bool]], expected: list[float]
) -> None:
    class Told(ToyVectorEnv):
        def step(self, actions: np.ndarray) -> Any:
            observation, _, *ends, info = super().step(actions)
            info |= {name: np.array([one[name] for one in told]) for name in THROWN}
            return observation, np.array([1.0, -7.0, 3.0, -9.0]), *ends, info

    for even, rewards in ((True, expected), (False, [1.0, -7.0, 3.0, -9.0])):
        env = SameStepVecEnv(Told(ROWS), even=even)
        env.reset()
        _, reward, _, infos = env.step(np.zeros((ROWS, 2), dtype=np.float32))
        assert reward.tolist() == rewards
        assert [info["episode"]["r"] for info in infos] == [1.0, -7.0, 3.0, -9.0]


def told(**changes: Any) -> dict[str, Any]:
    """The info of four throws: near and in, near and out, far, and lost on the way, right above a bin."""
    return {
        "item": np.zeros(4, dtype=np.int64),
        "kind": np.ones(4, dtype=np.int64),
        "landing_error": np.array([0.01, 0.02, 0.3, 0.004]),
        "landing_along": np.array([0.01, 0.0, -0.3, 0.004]),
        "landing_across": np.array([0.0, -0.02, 0.0, 0.0]),
        "target_x": np.arange(4.0),
        "is_success": np.array([True, False, False, False]),
        "cycle_time": np.full(4, 0.5),
        "residual_clipped": np.zeros(4, dtype=bool),
        "picked": np.ones(4, dtype=bool),
        "dropped": np.array([False, False, False, True]),
        **changes,
    }


def test_the_landing_of_what_was_lost_is_masked_and_nothing_else() -> None:
    given, info = told(), told()
    found = results(given, 4)
    assert given["landing_error"][3] == 0.004, "what a cell tells is never written over"
    assert found.keys() == info.keys() - {"kind"}
    for name, values in found.items():
        if name in LANDING:
            assert np.isnan(values[3])
            assert np.array_equal(values[:3], info[name][:3])
        else:
            assert np.array_equal(values, info[name])
            assert values.dtype == info[name].dtype


@pytest.mark.parametrize("changes", [{}, {"dropped": np.zeros(4, dtype=bool)}])
def test_without_a_drop_every_landing_stays(changes: dict[str, Any]) -> None:
    info = told() | changes
    if not changes:
        del info["dropped"]
    found = results(info, 4)
    assert all(np.array_equal(found[name], info[name]) for name in LANDING)


def test_a_drop_that_ended_its_episode_is_masked_too() -> None:
    """Gymnasium's own vector environments tell it apart, with zeros for the rows that go on."""
    over = np.array([False, True, False, True])
    final = {name: np.where(over, values, 0) for name, values in told().items()}
    final["dropped"] = final["dropped"].astype(bool)
    going = told(dropped=np.array([True, False, False, False]))
    found = results({**going, "final_info": final, "_final_info": over}, 4)
    assert np.isnan(found["landing_error"]).tolist() == [True, False, False, True]
    assert found["landing_error"][1:3].tolist() == [0.02, 0.3]
