"""Networks are fitted from a seed on one thread, and torch is as before afterwards."""

from collections.abc import Generator
from pathlib import Path

import pytest
import torch

import agents
from agents.ground.fitting import fit_from


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
