"""Controllers learn and act on one thread, networks from a seed, and the threads are as before afterwards."""

from collections.abc import Generator
from pathlib import Path

import numpy as np
import pytest
import torch
from threadpoolctl import threadpool_info, threadpool_limits

import agents
from agents.controllers.protocol import Actions, Observation, Outcome
from agents.ground.environments import make_vector
from agents.ground.fitting import fit_from
from agents.judging.loop import practise, throw_held_out


@pytest.fixture(autouse=True)
def two_threads() -> Generator[None]:
    """Two threads of torch within a test."""
    threads = torch.get_num_threads()
    torch.set_num_threads(2)
    yield
    torch.set_num_threads(threads)


def test_torch_is_as_before_after_a_fit() -> None:
    state = torch.random.get_rng_state()
    draws = []
    for seed in (3, 3, 4):
        with fit_from(seed):
            assert torch.get_num_threads() == 1
            draws.append(torch.rand(4).tolist())
    assert draws[0] == draws[1] != draws[2]
    assert torch.get_num_threads() == 2
    assert torch.equal(torch.random.get_rng_state(), state)


def test_threads_come_back_after_a_fit_that_failed() -> None:
    with pytest.raises(ZeroDivisionError), fit_from(0):
        raise ZeroDivisionError
    assert torch.get_num_threads() == 2


def test_networks_are_seeded_in_no_other_way() -> None:
    folder = Path(agents.__file__).parent
    found = [path.name for path in folder.rglob("*.py") if "manual_seed" in path.read_text(encoding="utf-8")]
    assert found == ["fitting.py"]


class Watched:
    """A controller that learns nothing and notes on how many threads linear algebra computes meanwhile."""

    name = "watched"

    def __init__(self) -> None:
        self.seen: set[tuple[str, int]] = set()

    def reset(self, seed: int) -> None:
        pass

    def act(self, observation: Observation) -> Actions:
        self._look("act")
        return np.zeros((len(observation.kind), 2), dtype=np.float32)

    def learn(self, outcome: Outcome) -> None:
        self._look("learn")

    def _look(self, when: str) -> None:
        self.seen |= {(when, count) for count in threads_of_linear_algebra()}


def threads_of_linear_algebra() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_controllers_learn_and_act_on_one_thread() -> None:
    watched, env = Watched(), make_vector("ToyThrow-v0", num_envs=4)
    with threadpool_limits(2, user_api="blas"):
        practise(watched, env, 8, 0)
        throw_held_out(watched, env, 8, 0)
        assert threads_of_linear_algebra() == {2}
    assert watched.seen == {("act", 1), ("learn", 1)}
