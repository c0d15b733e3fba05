"""PnTLine-v0 as Gymnasium sees it: masks, rewards, the end of a shift, and what a manual says of all that."""

import re
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.base.features import CLIP
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.observation import CHOICE_TABLE, ENTRIES, LINE_TABLE
from pnt_gym.envs.line import PnTLineEnv
from pnt_gym.errors import ConfigError
from pnt_gym.names import keywords
from tests.test_docs import section, table, words
from tests.tools.line import with_table
from tests.tools.throws import SHORT_LINE, same_bits

SHORT: dict[str, Any] = {"base": "single", "duration": 10.0}


def made(level: Any = SHORT, **given: Any) -> Any:
    return gym.make("PnTLine-v0", level=level, **given).unwrapped


def shift(env: Any, seed: int, invalid: float = 0.0) -> list[tuple[float, dict[str, Any]]]:
    """Rewards and infos of a shift of decisions at random."""
    random, steps, over = np.random.default_rng(seed), [], False
    _, info = env.reset(seed=seed)
    while not over:
        there = np.flatnonzero(info["action_mask"])
        if random.random() < invalid:
            there = np.flatnonzero(~info["action_mask"])
        _, reward, terminated, over, info = env.step(random.choice(there) if there.size else 15)
        assert not terminated
        steps.append((reward, info))
    return steps


LEVELS = {
    "single": SHORT,
    "price": {"base": "value", "duration": 8.0, "price_of_time": 0.25},
    "line": {"base": "skills3_burst", "duration": 6.0},
    "flight": SHORT_LINE,
}


@pytest.mark.parametrize("name", LEVELS)
@pytest.mark.parametrize("invalid", [0.0, 0.3])
def test_rewards_add_up_to_the_value_less_the_price_of_the_shift(name, invalid, tmp_path):
    level = LEVELS[name] if name == "flight" else with_table(LEVELS[name], tmp_path)
    env = made(level)
    config = env.core.config
    for seed in range(2):
        first = (env.reset(seed=seed), float(env.core.cell.state.clock[0]))[1]
        steps = shift(env, seed, invalid)
        value = sum(info["value"] for _, info in steps)
        paid = config.price_of_time * (config.duration - first)
        assert sum(reward for reward, _ in steps) == pytest.approx(value - paid, abs=1e-9)
        assert sum(info["dt"] for _, info in steps) == pytest.approx(config.duration - first, abs=1e-9)
        for reward, info in steps:
            assert reward == pytest.approx(info["value"] - config.price_of_time * info["dt"], abs=1e-12)
            assert info["dt"] >= 0.0
            assert (info["value"] > 0.0) <= info["sorted"]
            assert info["invalid_action"] == (info["object"] == -1)
        last = steps[-1][1]
        assert last["shift_value_per_min"] == pytest.approx(value / (config.duration / 60.0))
        ours = [info for _, info in steps if info["sorted"] and info["start"] + info["cycle_time"] <= config.duration]
        assert last["shift_sorted"] == len(ours)
        assert last["shift_attempts"] == sum(not info["invalid_action"] for _, info in steps)
        assert not any(name.startswith("shift_") for _, info in steps[:-1] for name in info)


def test_what_brings_nothing_costs_the_same_whatever_is_done():
    """A robot that never takes anything pays for its shift, no more and no less."""
    env = made({**SHORT, "throws": "flight"})
    steps = shift(env, 1, 1.0)
    assert sum(reward for reward, _ in steps) == pytest.approx(-10.0)
    assert all(info["invalid_action"] for _, info in steps)
    assert steps[-1][1]["shift_attempts"] == 0
    assert steps[-1][1]["shift_objects"] == steps[-1][1]["shift_passed"] > 0


def test_the_mask_is_that_of_the_info_and_of_the_method():
    env = made()
    observation, info = env.reset(seed=0)
    each = observation[len(LINE_TABLE) :].reshape(16, len(CHOICE_TABLE))
    for _ in range(5):
        assert info["action_mask"].dtype == np.bool_
        assert info["action_mask"].shape == (16,)
        assert same_bits(env.action_masks(), info["action_mask"])
        assert same_bits(each[:, 0] == 1.0, info["action_mask"])
        mask = env.action_masks()
        mask[:] = False  # the caller's own
        observation, _, _, _, info = env.step(0)
        each = observation[len(LINE_TABLE) :].reshape(16, len(CHOICE_TABLE))
        assert info["action_mask"].any()


def test_an_action_that_the_mask_rules_out_is_standing_still_and_counted():
    env = made()
    _, info = env.reset(seed=0)
    assert not info["action_mask"][15]
    before = env.core.cell.state
    _, reward, _, _, info = env.step(15)
    assert info["invalid_action"]
    assert info["object"] == -1
    assert (info["value"], info["picked"], info["is_success"], info["ended_in"]) == (0.0, False, False, -1)
    assert info["cycle_time"] == pytest.approx(0.1, abs=1e-12)
    assert info["wait_time"] == 0.0
    assert info["dt"] == pytest.approx(0.1, abs=1e-9)  # a belt that is full has something for who looks again
    assert reward == -info["dt"]
    after = env.core.cell.state
    assert after.clock[0] == before.clock[0] + info["dt"]
    assert same_bits(after.accounts["attempts"], before.accounts["attempts"])
    assert env.step(0)[4]["invalid_action"] is False


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int32, np.int64, np.uint64])
def test_a_choice_may_be_any_whole_number_of_numpy(kind):
    one, other = made(), made()
    one.reset(seed=2)
    other.reset(seed=2)
    assert same_bits(one.step(2)[0], other.step(kind(2))[0])


def test_a_shift_is_truncated_when_the_next_decision_falls_after_its_end():
    env = made()
    steps = shift(env, 3)
    starts = [info["start"] for _, info in steps]
    assert starts == sorted(starts)
    assert starts[-1] < 10.0
    assert env.core.cell.state.clock[0] >= 10.0
    assert not env.action_masks().any()
    env.reset()
    assert env.core.cell.state.clock[0] < 1.0


def test_the_default_is_the_single_robot_and_its_shift_is_two_minutes():
    env = gym.make("PnTLine-v0").unwrapped
    assert env.core.config == LineConfig.load("single")
    assert env.core.config.duration == 120.0
    assert "`" + '"single"' + "`" in section(PnTLineEnv, "Arguments")


def test_a_line_has_no_window_and_no_other_way_to_act():
    env = made()
    assert env.metadata["render_modes"] == ["rgb_array", "rgb_array_list"]
    assert env.render() is None
    with pytest.raises(ConfigError, match="unknown render_mode 'human'; known are rgb_array, rgb_array_list, None"):
        PnTLineEnv(render_mode="human")
    with pytest.raises(ConfigError, match="unknown action_mode 'release_point'; known are choice"):
        made(action_mode="release_point")
    assert made(action_mode="choice").core.action_mode == "choice"


def test_a_release_corrects_throws_where_there_are_any():
    told = []

    def release(observation, kind):
        told.append((observation.shape, kind.shape))
        return np.full((len(kind), 2), 0.5)

    plain, corrected = made(SHORT_LINE), made(SHORT_LINE)
    corrected.core.use(release)
    errors = []
    for env in (plain, corrected):
        env.reset(seed=1)
        errors.append([env.step(0)[4]["landing_error"] for _ in range(4)])
    assert told
    assert {shape for shape, _ in told} == {(1, 26)}
    assert not np.array_equal(*errors, equal_nan=True)
    with pytest.raises(ConfigError, match="level 'custom' takes the results of throws from a table, so"):
        made().core.use(release)


def test_the_zero_correction_is_the_planners_own_throw():
    plain, zero = made(SHORT_LINE), made(SHORT_LINE)
    zero.core.use(lambda observation, kind: np.zeros((len(kind), 2)))
    for env in (plain, zero):
        env.reset(seed=1)
    for _ in range(6):
        one, other = (env.step(0) for env in (plain, zero))
        assert same_bits(one[0], other[0])
        assert repr(one[1:]) == repr(other[1:])


# The manual.


def tables(title: str) -> list[list[list[str]]]:
    """Rows of every table of a section."""
    blocks = re.findall(r"(?:^\|.*\n)+", section(PnTLineEnv, title), flags=re.MULTILINE)
    return [table(block) for block in blocks]


def test_the_action_space_is_the_written_one():
    assert words(PnTLineEnv, "Action Space").startswith("`Discrete(16)`")
    assert made().action_space == gym.spaces.Discrete(16)


def test_the_observation_is_read_with_no_more_than_the_manual_prints():
    line, choice = tables("Observation Space")
    head, each = len(line), len(choice)
    assert f"has the {each} entries from {head} + {each} k on" in words(PnTLineEnv, "Observation Space")
    assert head + 16 * each == ENTRIES
    env = made()
    observation, info = env.reset(seed=0)
    state = env.core.cell.state
    for rows, first, wanted in (
        (line, 0, {"possible": info["action_mask"].sum(), "hand_y": state.arms["hand"][0, 0, 1], "turn_0": 1.0}),
        (choice, head, {"lift": state.choices["lift"][0, 0], "pick_y": state.choices["pick"][0, 0, 1]}),
        (choice, head + each, {"lift": state.choices["lift"][0, 1], "stop_x": state.choices["stop"][0, 1, 0]}),
    ):
        for place, (number, name, unit, meaning, centre, scale, low, high) in enumerate(rows):
            assert int(number) == place
            assert (float(low), float(high)) == (-CLIP, CLIP)
            assert unit
            assert meaning
            if name in wanted:
                value = float(observation[first + place]) * float(scale) + float(centre)
                assert value == pytest.approx(float(wanted.pop(name)), abs=1e-5)
        assert not wanted


@pytest.mark.parametrize("throws", ["table", "flight"])
def test_the_infos_are_the_written_ones(throws):
    """Both ways: what is named exists, and what exists is named."""
    text = words(PnTLineEnv, "Rewards")
    listed = text[text.index("`info` also has") :]
    named = set(re.findall(r"`(\w+)`", listed)) - {"info", "items"}
    simulated = {"landing_error", "energy"}
    steps = shift(made({**SHORT, "throws": throws}), 0)
    seen = {name for _, info in steps for name in info}
    assert named | {"action_mask", "invalid_action"} == seen | simulated
    assert (simulated <= seen) == (throws == "flight")


def test_the_arguments_are_those_of_the_constructor():
    rows = {row[0].strip("`"): row for row in tables("Arguments")[0]}
    single = set(keywords(PnTLineEnv.__init__))
    assert set(rows) == single | {"num_envs", "autoreset_mode", "max_episode_steps", "disable_env_checker"}
    levels = LineConfig.load("single")
    assert f"{levels.duration:g} s unless the level says otherwise" in words(PnTLineEnv, "Episode End")
    assert f"lifted within {levels.horizon:g} s" in words(PnTLineEnv, "Action Space")
    assert f"`price_of_time` of the level, {levels.price_of_time:g} a second" in words(PnTLineEnv, "Rewards")
