"""Where a generator comes to what is asked for, and that looking for it leaves the cell alone."""

import pickle

import numpy as np
import pytest

from pnt_gym.cells.base import request
from pnt_gym.cells.base.request import advance_to_request
from pnt_gym.errors import ConfigError
from tests.tools.throws import make_core

PICKS = ("belt", "independent")


def generators(*seeds: int) -> list[np.random.Generator]:
    return [np.random.default_rng(seed) for seed in seeds]


def states(made: list[np.random.Generator]) -> list[int]:
    return [one.bit_generator.state["state"]["state"] for one in made]


@pytest.mark.parametrize("picks", PICKS)
def test_the_next_first_throw_is_the_first_of_the_jumps_that_fits(picks: str) -> None:
    core = make_core("waste", 1, picks=picks)
    (led,) = generators(3)
    advance_to_request(core.cell, [led], {"item": "can"})
    came = []
    for jumps in range(200):  # one by one, with nothing but the cell's own draw
        (one,) = generators(3)
        one.bit_generator.state = one.bit_generator.jumped(jumps).state
        before = states([one])
        core.reset(np.arange(1), [one], seeded=True)
        came.append(core.item_names[core.context.kind[0]] == "can")
        if before == states([led]):
            break
    assert came == [False] * (len(came) - 1) + [True]


@pytest.mark.parametrize("picks", PICKS)
def test_it_depends_on_nothing_but_the_generator(picks: str, monkeypatch: pytest.MonkeyPatch) -> None:
    cell, together = make_core("waste", 2, picks=picks).cell, generators(*range(12))
    advance_to_request(cell, together, {"item": "cork"})
    monkeypatch.setattr(request, "FIRST_BATCH", 3)
    monkeypatch.setattr(request, "LARGEST_BATCH", 7)
    for seed, led in enumerate(together):
        (alone,) = generators(seed)
        advance_to_request(cell, [alone], {"item": "cork"})
        assert states([alone]) == states([led])


@pytest.mark.parametrize("asked", [{"item": "paper"}, {"target": "outside"}])
@pytest.mark.parametrize("picks", PICKS)
def test_the_cell_is_left_as_it_is(picks: str, asked: dict[str, str]) -> None:
    """Found or not: on the level `ideal` nothing goes outside."""
    core, made = make_core("ideal", 2, picks=picks), generators(5, 6)
    before, drawn = pickle.dumps(core), states(made)
    if "target" in asked:
        with pytest.raises(ConfigError, match=r"target 'outside' did not come .* which has targets inside, outside"):
            advance_to_request(core.cell, made, asked)
        assert states(made) == drawn
    else:
        advance_to_request(core.cell, made, asked)
    assert pickle.dumps(core) == before
