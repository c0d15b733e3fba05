"""Moments and links bound what a line can do: every executed decision has a moment no worse, and follows a link."""

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from agents.dispatchers import registry
from agents.dispatchers.decisions import work_single_shifts
from agents.dispatchers.prices import make_network
from agents.dispatchers.registry import line_core
from agents.ground.environments import make_vector
from pnt_gym.cells.line.links import EMPTY, THROWN, Links

STEP = 0.02
LEVELS: list[dict[str, Any]] = [
    {"base": "single", "duration": 20.0},
    {"base": "speed", "duration": 60.0},
    {"base": "skills3_burst", "duration": 15.0},
]


def decisions(level: dict[str, Any], name: str, seed: int) -> Iterator[dict[str, Any]]:
    """What each executed decision of one shift was and brought."""
    with closing(make_vector("PnTLine-v0", level, 1, 1)) as env:
        core = line_core(env)
        controller = registry.make(name, core)
        controller.reset(seed)
        stations, settings = core.cell.chooser.tables.stations, core.cell.chooser.tables.settings
        before = None
        for step in work_single_shifts(controller.act, env, np.array([seed])):
            if before is None:
                before = core.cell.stream.riders[0].copy()
            last = core.last
            assert last is not None
            if step.shift[0] > 0 or not last.valid[0]:
                continue
            robot, chosen = int(last.robot[0]), last.attempt.chosen[0]
            first, end = int(stations["first_setting"][robot]), int(stations["end_setting"][robot])
            yield {
                "riders": before,
                "tables": core.cell.chooser.tables,
                "robot": robot,
                "index": int(chosen["index"]),
                "site": int(stations["first_site"][robot] + chosen["bin"]),
                "setting": first + int(np.argmin(np.abs(settings["percent"][first:end] - chosen["percent"]))),
                "lift": float(last.start[0] + chosen["lift"]),
                "picked": bool(last.results["picked"][0]),
                "end": float(last.end[0]),
                "value": float(last.value[0]),
            }


def follows(links: Links, moment: tuple[int, int], target: int, begin: int, step: int) -> bool:
    """Whether a moment, of a passage that begins at a row and a step, may follow an end of another one."""
    end, row = moment
    reached = links.target[links.first[end, row] : links.first[end, row + 1]]
    return bool(((reached >= begin) & (reached <= target)).any() or 0 <= links.far[moment] <= step)


@pytest.mark.parametrize("level", LEVELS, ids=[level["base"] for level in LEVELS])
@pytest.mark.parametrize("name", ["random", "price", "spt"])
def test_every_decision_is_a_moment_and_follows_a_link(level: dict[str, Any], name: str) -> None:
    done = list(decisions(level, name, seed=5))
    network = make_network(done[0]["tables"], done[0]["riders"], STEP, is_drawn=True)
    passages, moments = network.passages, network.moments
    before, count, duration = dict[int, tuple[int, int]](), 0, level["duration"]
    for one in (one for one in done if one["lift"] <= duration):
        is_own = passages["seal"] == float(one["picked"])
        for field in ("robot", "index", "site", "setting"):
            is_own &= passages[field] == one[field]
        if not is_own.any():  # of an item that the bin does not take: doing nothing is no worse
            assert one["value"] == 0.0
            continue
        passage, count = passages[int(np.argmax(is_own))], count + 1
        assert is_own.sum() == 1
        moment = int(passage["first_row"] + np.floor(one["lift"] / STEP) - passage["first_step"])
        assert passage["begin"] - 1e-9 <= one["lift"] <= passage["end"] + 1e-9
        assert moments["can_throw"][moment]
        assert moments["worth"][moment] >= one["value"] - 1e-9
        assert moments["free" if one["picked"] else "empty_free"][moment] <= one["end"] + 1e-9
        if (last := before.get(one["robot"])) is not None:
            assert follows(network.links, last, moment, int(passage["first_row"]), int(passage["first_step"]))
        before[one["robot"]] = THROWN if one["picked"] else EMPTY, moment
    assert count > 8
