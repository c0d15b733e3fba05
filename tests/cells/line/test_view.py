"""A line in pictures: hands are where the planner has them, objects where the physics left them, and nothing jumps."""

import copy
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.base.canvas import Picture
from pnt_gym.cells.line.acts import SAMPLE_TIME, RobotCycle
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.scene import belt_extent, bin_colours
from pnt_gym.cells.line.view import LineView
from pnt_gym.errors import ConfigError, OrderError
from pnt_gym.palette import ITEMS
from tests.tools.nightly import with_nightly
from tests.tools.throws import same_bits

LEVELS: dict[str, dict[str, Any]] = {
    "one": {"base": "single", "throws": "full", "duration": 7.0},
    "three": {"base": "skills3", "throws": "full", "duration": 5.0},
    "flight": {"base": "skills3", "throws": "flight", "duration": 5.0},
    "planned": {"base": "skills3", "throws": "table", "duration": 6.0},
    "partly known": {"base": "single", "cell": {"mismatch": 0.5}, "throws": "full", "duration": 6.0},
    "standing": {"base": "single", "cell": {"belt": {"tracking": False}}, "throws": "full", "duration": 6.0},
}
SMALL = Picture(width=96, height=54)


def begun(level: dict[str, Any], seed: int = 0) -> LineCore:
    core = LineCore(LineConfig.load(level), 1)
    core.reset(np.zeros(1, dtype=np.int64), [np.random.default_rng(seed)], True)
    return core


def small_view(core: LineCore) -> LineView:
    """A view with small frames and coarse shadows, which software draws five times as quickly."""
    view = core.view()
    view.aim(SMALL)
    quality = view._scene.model.vis.quality
    quality.shadowsize, quality.offsamples = 256, 0
    return view


@dataclass
class Seen:
    """One decision, what was planned and told of it, and what is shown."""

    act: RobotCycle
    pick: np.ndarray
    """Where the planner has the cup's tip when it lifts the object, from the base (3,)."""
    stood: np.ndarray
    """Where it had stood before (3,)."""
    info: dict[str, Any]
    shown: np.ndarray
    """The tip in the picture's model at the lift (3,)."""


@pytest.fixture(scope="module", params=with_nightly(LEVELS, ["three", "planned"]))
def shift(request) -> tuple[LineCore, list[Seen], list[np.ndarray]]:
    """A shift of best choices; its decisions, and the tips in the picture's model every `SAMPLE_TIME` (R, 3)."""
    core = begun(LEVELS[request.param])
    view, seen, tips = core.view(), list[Seen](), list[np.ndarray]()
    while not core.cell.over[0]:
        before = core.cell.state
        deep = core.cell.stream.objects.known_depth[0, before.choices["index"][0, 0]]
        info = {name: values[0] for name, values in core.step(np.zeros(1, dtype=np.int64)).info.items()}
        for _, data, _ in view.scenes(round(1.0 / SAMPLE_TIME)):
            tips.append(np.array([data.site(f"{robot}_tcp").xpos for robot in range(len(core.config.robots))]))
        if info["invalid_action"]:
            continue
        act = core.cell.acts.cycles[-1]
        _, data, _ = view.scene(act.lift)
        shown = data.site(f"{act.robot}_tcp").xpos - [core.config.robots[act.robot].x, 0.0, 0.0]
        pick = before.choices["pick"][0, 0] + [0.0, 0.0, deep]
        seen.append(Seen(act, pick, before.arms["hand"][0, act.robot], info, shown))
    view.close()
    return core, seen, tips


def bin_of(core: LineCore, robot: int, place: np.ndarray) -> int:
    """The bin of a robot inside whose walls a place is that is below the rim; -1 for none."""
    bins = core.config.cell_of(robot).bins
    for index, fixed in enumerate(bins.fixed):
        if np.all(np.abs(place[:2] - [fixed.x, fixed.y]) <= np.array(fixed.size) / 2) and place[2] < bins.rim:
            return index
    return -1


def test_hands_are_at_the_planners_picks_when_they_lift(shift):
    _, seen, _ = shift
    assert len(seen) > 5
    for one in seen:
        np.testing.assert_allclose(one.shown, one.pick, atol=1e-3)


def test_hands_move_and_never_jump(shift):
    """No faster than the planner's limits, of which 40 % of 6 m/s are the shipped ones, and the belt's speed."""
    core, _, tips = shift
    way = np.linalg.norm(np.diff(np.stack(tips), axis=0), axis=2)
    fastest = 6.0 * max(core.config.cell.limits.percent) / 100.0 + core.config.cell.belt.speed
    assert way.max() <= fastest * SAMPLE_TIME + 5e-4  # a hand that was simulated is not quite where it was planned
    assert (way.max(axis=0) > 0.003).all()


def test_objects_end_in_the_bin_that_info_tells_of(shift):
    core, seen, _ = shift
    ended = 0
    for one in seen:
        assert (one.act.object_track is None) != bool(one.info["picked"])
        if one.act.object_track is None:
            continue
        last = one.act.object_track.pose[-1]
        if one.info["ended_in"] >= 0:
            assert bin_of(core, one.act.robot, last) == one.info["ended_in"]
            assert one.act.object_pose(one.act.object_track.time[-1] + 60.0) is not None
            ended += 1
        elif core.config.throws == "table":
            assert one.act.object_pose(one.act.object_track.time[-1] + 0.001) is None
        else:
            assert bin_of(core, one.act.robot, last) == -1
    assert ended > 3


def test_objects_hang_under_the_cup_and_then_fly(shift):
    _, seen, _ = shift
    for one in seen:
        if one.act.object_track is None:
            continue
        assert one.act.object_pose(one.act.lift - 1e-6) is None
        hung = one.act.object_pose(one.act.lift) - np.array([*one.pick, 1.0, 0.0, 0.0, 0.0])
        assert np.hypot(*hung[:2]) < 0.06  # off by the grasp
        assert -0.12 < hung[2] < 0.0
        moments = np.arange(one.act.lift, one.act.object_track.time[-1], SAMPLE_TIME)
        apart = [np.linalg.norm(one.act.object_pose(t)[:3] - one.act.hand.at(t)) for t in moments if t < one.act.end]
        assert apart[0] < 0.08
        alone = [t for t in moments if np.linalg.norm(one.act.object_pose(t)[:3] - one.act.hand.at(t)) > 0.2]
        assert alone, "it never leaves the hand"
        poses = np.array([one.act.object_pose(t) for t in moments])
        assert np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1).max() < 6.0 * SAMPLE_TIME
        np.testing.assert_allclose(np.linalg.norm(poses[:, 3:], axis=1), 1.0, atol=1e-2)


@pytest.mark.parametrize("late", [0, 4])
def test_every_object_is_shown_once_where_it_is(late):
    """By a count of its own: what rides is where the stream and the belt's speed have it, the rest was lifted.

    Who looks late sees all but what has been taken before.
    """
    core = begun(LEVELS["three"])
    for _ in range(late):
        core.step(np.zeros(1, dtype=np.int64))
    taken = set(np.flatnonzero(np.isinf(core.cell.state.accounts["since"][0])))
    lifted: dict[int, float] = {}
    view = core.view()
    low, high = belt_extent(core.config)
    for _ in range(12):
        info = core.step(np.zeros(1, dtype=np.int64)).info
        if info["picked"][0]:
            lifted[int(info["object"][0])] = core.cell.acts.cycles[-1].lift
        now = float(core.cell.state.clock[0])
        x = core.cell.stream.x[0] + core.config.cell.belt.speed * now + core.cell.stream.objects.grasp[0, :, 0]
        rides = [k for k in range(len(x)) if k not in taken and low <= x[k] <= high and lifted.get(k, np.inf) > now]
        flown = [k for k, lift in lifted.items() if lift <= now]
        _, _, markers = view.scene(now)
        things = [m for m in markers if (m.rgba == ITEMS).all(axis=1).any()]
        assert len(things) == len(rides) + len(flown)
        np.testing.assert_allclose(sorted(m.position[0] for m in things[: len(rides)]), sorted(x[rides]), atol=1e-9)
    assert flown


def test_a_cup_that_does_not_seal_leaves_its_object_to_the_belt():
    core, failed = begun(LEVELS["three"]), 0
    core.view()
    for _ in range(12):
        info = core.step(np.zeros(1, dtype=np.int64)).info
        act = core.cell.acts.cycles[-1]
        if not info["picked"][0]:
            failed += 1
            assert act.off_belt == np.inf
            assert all(act.object_pose(time) is None for time in np.linspace(act.start, act.end + 1.0, 50))
    assert failed


def test_bins_have_the_colours_of_what_comes_into_them():
    config = LineConfig.load("skills3")
    first, third = bin_colours(config, 0), bin_colours(config, 2)
    kinds = [config.cell.items.index(bin_.accepts[0]) for bin_ in config.cell.bins.fixed]
    for colour, kind in zip(first, kinds, strict=True):
        np.testing.assert_allclose(colour[:3] / colour[:3].max(), ITEMS[kind, :3] / ITEMS[kind, :3].max())
    assert same_bits(third[1], first[1])
    assert np.ptp(third[[0, 2, 3]], axis=0).max() == 0.0


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("name", with_nightly(("one", "three"), ["one"]))
def test_frames_of_one_decision_after_the_other_are_one_film(name):
    core = begun(LEVELS[name])
    view, frames = small_view(core), []
    while core.cell.state.clock[0] < 2.0:
        core.step(np.zeros(1, dtype=np.int64))
        frames += view.last_throw(10)
        assert len(frames) == int(np.ceil(10 * core.cell.state.clock[0] - 1e-9))
    assert all(frame.shape == (54, 96, 3) for frame in frames)
    assert all((one != other).any() for one, other in pairwise(frames))
    assert same_bits(view.at(np.inf, 10**6), view.frame())
    view.close()
    view.close()


@pytest.mark.usefixtures("opengl")
def test_looking_changes_nothing_and_a_copy_shows_the_same():
    level = {"base": "skills3", "throws": "full", "duration": 5.0}
    seen = gym.make("PnTLine-v0", level=level, render_mode="rgb_array", width=96, height=54).unwrapped
    unseen = gym.make("PnTLine-v0", level=level).unwrapped
    assert same_bits(seen.reset(seed=3)[0], unseen.reset(seed=3)[0])
    for _ in range(6):
        one, other = seen.step(0), unseen.step(0)
        assert same_bits(one[0], other[0])
        assert one[1] == other[1]
    copied = copy.deepcopy(seen)
    assert same_bits(copied.render(), seen.render())
    seen.step(0), copied.step(0)
    assert same_bits(copied.render(), seen.render())
    copied.reset(seed=3)
    assert not copied.core.cell.acts.cycles
    seen.close(), copied.close()


@pytest.mark.nightly
@pytest.mark.usefixtures("opengl")
def test_the_list_of_an_environment_is_what_happened_since_the_last_decision():
    env = gym.make("PnTLine-v0", level=LEVELS["three"], render_mode="rgb_array_list", width=96, height=54).unwrapped
    env.reset(seed=0)
    assert env.render() == []
    count = 0
    for _ in range(3):
        *_, info = env.step(0)
        frames = env.render()
        assert abs(len(frames) - env.metadata["render_fps"] * info["dt"]) <= 1.0
        count += len(frames)
    assert count == int(np.ceil(env.metadata["render_fps"] * env.core.cell.state.clock[0] - 1e-9))
    env.close()


def test_pictures_are_of_one_line():
    core = LineCore(LineConfig.load(LEVELS["one"]), 3)
    with pytest.raises(ConfigError, match="num_envs is 3; pictures show a single line: set num_envs to 1"):
        core.view()
    with pytest.raises(ConfigError, match="unknown render_mode 'rgb_array'; known are None"):
        gym.make_vec("PnTLine-v0", num_envs=3, render_mode="rgb_array")


def test_there_is_no_window_and_nothing_kept_that_nobody_watches():
    core = begun(LEVELS["one"])
    with pytest.raises(OrderError, match="open a view"):
        _ = core.cell.acts
    view = core.view()
    with pytest.raises(ConfigError, match="window"):
        view.show()
    core.step(np.zeros(1, dtype=np.int64))
    assert len(core.cell.acts.cycles) == 1
    view.close()
    with pytest.raises(OrderError, match="open a view"):
        list(view.scenes())
