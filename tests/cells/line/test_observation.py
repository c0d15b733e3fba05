"""What the robot whose turn it is sees: the line as it stands, decodable, and nothing that no sensor tells."""

import copy
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.base.features import CLIP
from pnt_gym.cells.line.observation import CHOICE_TABLE, ENTRIES, LINE_TABLE, decoded
from pnt_gym.cells.line.rows import CHOICES
from tests.cells.conveyor.test_observation import HIDDEN, changed
from tests.tools.line import decided, seen_values, stream_with, with_table
from tests.tools.movers import choices_anew
from tests.tools.throws import parts_of, same_bits, with_part

LEVEL: dict[str, Any] = {"base": "skills3_burst", "duration": 20.0}
UNSEEN = ("pick_chance", "pick_draw", "kind", "cup_friction", "cup_radius", "shape")
"""What the conveyor's test of what is hidden leaves alone, and no choice may tell either."""


@pytest.fixture
def line(tmp_path):
    """Some lines in mid-shift."""
    env: Any = gym.make_vec("PnTLine-v0", num_envs=4, level=with_table(LEVEL, tmp_path)).unwrapped
    env.reset(seed=0)
    random = np.random.default_rng(0)
    for _ in range(6):
        env.step(decided(env.core.cell, random))
    return env.core


def looked_again(core):
    """What is seen of the same state when choices are looked for anew."""
    cell = core.cell
    cell.state = choices_anew(cell)
    return core.observe()


def test_looking_again_shows_the_same(line):
    before = line.observe()
    assert same_bits(looked_again(line), before)


def test_an_observation_is_read_back(line):
    observation, (of_line, of_choices) = line.observe(), seen_values(line)
    assert observation.shape == (4, ENTRIES) == (4, len(LINE_TABLE) + CHOICES * len(CHOICE_TABLE))
    seen, real = decoded(observation), of_choices["real"]
    low, high = (decoded(np.full(ENTRIES, border)) for border in (-CLIP, CLIP))
    assert set(of_line) == set(seen.line)
    for name, values in of_line.items():
        wanted = np.clip(values, low.line[name], high.line[name])
        np.testing.assert_allclose(seen.line[name], wanted, atol=1e-5, err_msg=name)
    assert set(of_choices) == set(seen.choices)
    for name, values in of_choices.items():
        wanted = np.clip(values, low.choices[name], high.choices[name])
        np.testing.assert_allclose(seen.choices[name][real], wanted[real], atol=1e-4, err_msg=name)
    each = observation[:, len(LINE_TABLE) :].reshape(4, CHOICES, -1)
    assert (each[~real] == 0.0).all()
    assert real.any() and not real.all()


def test_observations_stay_inside_their_box_and_rarely_at_its_border(tmp_path):
    seen = []
    for level in (LEVEL, {"base": "speed", "duration": 20.0}):
        env: Any = gym.make_vec("PnTLine-v0", num_envs=4, level=with_table(level, tmp_path)).unwrapped
        seen.append(env.reset(seed=0)[0])
        random = np.random.default_rng(0)
        for _ in range(15):
            seen.append(env.step(decided(env.core.cell, random))[0])
            assert env.observation_space.contains(seen[-1])
    assert (np.abs(np.concatenate(seen)) == CLIP).mean() < 0.01


@pytest.mark.parametrize("name", [*HIDDEN, *UNSEEN])
def test_a_hidden_value_of_objects_leaves_the_observation_as_it_is(line, name):
    before, stream = line.observe(), line.cell.stream
    if name in UNSEEN:
        values = getattr(stream.objects, name)
        turned = np.roll(values, 1, axis=1) if name in ("kind", "shape") else values * 0.37
        objects = stream.objects.replace(**{name: turned})
    else:
        objects = changed(stream.objects, name)
    line.cell.stream = stream_with(stream, objects, luck=1.0 - stream.riders["luck"])
    after = looked_again(line)
    if name == "grasp":  # measured = true + noise: the sum is the same up to rounding
        np.testing.assert_allclose(after, before, atol=1e-6)
    else:
        assert same_bits(after, before)


@pytest.mark.parametrize("name", ["measured.kind", "draws.lane_y", "worth"])
def test_what_is_known_does_reach_the_observation(line, name):
    """So that the test above can fail."""
    before, stream = line.observe(), line.cell.stream
    if name == "worth":
        changes: dict[str, Any] = {"worth": stream.riders["worth"] * 1.1}
    else:
        values = np.roll(parts_of(stream.objects)[name], 1, axis=1)
        changes = {"objects": with_part(stream.objects, name, values)}
    line.cell.stream = stream_with(stream, **changes)
    assert not same_bits(looked_again(line), before)


def test_a_cup_that_will_not_seal_is_not_seen_before_it_fails(line):
    """Two worlds that differ in nothing but whether the pick that was just chosen fails."""
    one, cell = line, line.cell
    other = copy.deepcopy(line)
    cores, known = (one, other), 0
    for core, draw in zip(cores, (1.0, 0.0), strict=True):
        objects = core.cell.stream.objects
        core.cell.stream = stream_with(core.cell.stream, objects.replace(pick_draw=0.0 * objects.mass + draw))
        looked_again(core)
    start, lift = cell.state.clock.copy(), cell.state.choices["lift"][:, 0].copy()
    steps = [core.step(np.zeros(4, dtype=np.int64)) for core in cores]
    assert steps[0].info["picked"].all()
    assert not steps[1].info["picked"].any()
    for row in range(4):
        clocks = [core.cell.state.clock[row] for core in cores]
        if max(clocks) >= start[row] + lift[row]:
            continue
        assert clocks[0] == clocks[1]
        assert same_bits(steps[0].observation[row], steps[1].observation[row])
        assert (steps[0].info["action_mask"][row] == steps[1].info["action_mask"][row]).all()
        known += 1
    assert known >= 2


def test_what_nobody_takes_and_what_is_past_or_not_yet_in_sight_is_not_seen(line):
    """Objects that are out of the game are moved about and changed: nothing that is shown changes."""
    before, stream, state = line.observe(), line.cell.stream, line.cell.state
    x = stream.x + line.config.cell.belt.speed * state.clock[:, None]
    low, high = line.config.reach
    out = (x > high + 0.01) | (x < low - 0.3) | np.isinf(state.accounts["since"])
    assert out.any(axis=1).all()
    worth = np.where(out, 77.0, stream.riders["worth"])
    seen = np.where(out, 0, stream.objects.measured.kind)
    line.cell.stream = stream_with(stream, with_part(stream.objects, "measured.kind", seen), worth=worth)
    assert same_bits(looked_again(line), before)
