"""Picks that fail: by kind and by where the cup stands, at the price of a cycle, and changing nothing else."""

from itertools import cycle, product

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym  # noqa: F401 - registers the environments
from agents.ground.metrics import wilson
from pnt_gym.arrays import take
from pnt_gym.cells.base.items import BOX, ELLIPSOID
from pnt_gym.cells.conveyor.action import MODES as PICK_MODES
from pnt_gym.cells.conveyor.cup.hold import fail_chance, picked
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.planning import MotionLimits, min_time_scurve
from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core, parts_of, planned, same_bits, vary

LIP = 0.018
FAILING = {"pick": {"fails": True}}
WASTE = vary("waste_plain", **FAILING)
HIDDEN_DRAWS = ("pick_draw",)


def some(count, config=WASTE, seed=0):
    """Picks of so many objects anywhere in the window."""
    objects = take(PickPlanner(config).draw([np.random.default_rng(seed)], np.arange(1), count), 0)
    return planned(config, objects, np.linspace(-0.2, 0.2, count))[0]


def moved(context, shape, place):
    """The same objects with another shape, and the cup at a place (N, 2) from the middle."""
    objects = context.objects.replace(shape=np.full(len(place), shape), grasp=-place)
    return context.replace(objects=objects, belt_shift=np.zeros(len(place)))


@pytest.mark.parametrize("shape", [BOX, ELLIPSOID])
def test_the_chance_falls_steadily_from_all_to_nothing_over_the_lip(shape):
    """Along a way outwards: its kind's inside, nothing from the lip's radius outside on, no jump between."""
    one, count = some(1), 2001
    context = take(one, np.zeros(count, dtype=int))
    wide = np.tile([0.10, 0.10, 0.05], (count, 1))
    context = context.replace(objects=context.objects.replace(size=wide, yaw=np.zeros(count)))
    out = np.linspace(0.0, 0.12, count)
    placed = moved(context, shape, np.stack([out, np.zeros(count)], axis=1))
    chance = 1.0 - fail_chance(placed, vary("waste_plain", mismatch=1.0, **FAILING))
    full = context.objects.pick_chance[0]
    np.testing.assert_allclose(chance[out <= 0.05 - LIP - 1e-9], full, rtol=1e-12)
    assert (chance[out >= 0.05 + LIP + 1e-9] == 0.0).all()
    assert (np.diff(chance) <= 0.0).all()
    assert np.abs(np.diff(chance)).max() < 0.01
    assert chance[np.abs(out - 0.05).argmin()] == pytest.approx(full / 2.0, abs=0.01)


@pytest.mark.parametrize("mismatch", [0.0, 0.5, 1.0, 3.0])
def test_as_many_picks_fail_as_the_chances_say(mismatch):
    config = vary("waste_plain", mismatch=mismatch, **FAILING)
    context = some(1500, config)
    expected = fail_chance(context, config).mean()
    failed = ~picked(context, config)
    found = wilson(int(failed.sum()), len(failed))
    assert found.low - 0.01 <= expected <= found.high + 0.01
    assert failed.any() == (mismatch > 0.0)


def test_crushed_and_porous_things_are_harder_to_pick():
    table = {item.name: item.pick_chance for item in WASTE.item_list()}
    assert max(table[name] for name in ("can_crushed", "pet_crushed", "paper_ball", "foil_ball")) <= 0.80
    assert min(table[name] for name in ("can", "pet_05", "jar_lid", "tray", "steel_tin")) >= 0.85


ENVS, FIDELITIES, MODES = ("PnTConveyor-v0", "PnTRelease-v0"), ("full", "flight"), [*PICK_MODES]
EVERY_PAIR = [
    (ENVS[first], FIDELITIES[second], MODES[(first + 2 * second + turn) % 4])
    for first, second in product(range(2), range(2))
    for turn in range(3)
]
"""Every two of environment, fidelity and action mode go together in some case."""


@pytest.mark.parametrize(("env_id", "fidelity", "mode"), EVERY_PAIR)
def test_a_failed_pick_is_no_throw(env_id, fidelity, mode):
    level = {"base": "waste_plain", "fidelity": fidelity, **FAILING}
    env = gym.make_vec(env_id, num_envs=12, level=level, action_mode=mode)
    env.reset(seed=1)
    told = []
    for _ in range(2):
        seen, reward, *_, info = env.step(np.zeros(env.action_space.shape))
        assert np.isfinite(seen).all()
        assert np.isfinite(reward).all()
        told.append({name: value for name, value in info.items() if isinstance(value, np.ndarray)})
    held = np.concatenate([one["picked"] for one in told])
    found = {name: np.concatenate([one[name] for one in told])[~held] for name in told[0] if name != "final_info"}
    assert held.any()
    assert not held.all()
    for name in ("is_success", "sorted", "in_opening", "in_bin", "rim", "recontact", "dropped", "belongs"):
        assert not found[name].any()
    for name in ("landing_error", "landing_along", "landing_across", "grip_margin"):
        assert np.isnan(found[name]).all()
    assert (found["ended_in"] == -1).all()
    assert (found["reward_success"] == 0.0).all()
    assert (found["reward_landing"] == 0.0).all()
    np.testing.assert_allclose(found["reward_time"], 0.1 * (1.0 - found["cycle_time"] / 3.0))


def test_a_failed_pick_costs_the_way_to_the_next_object():
    """Dwell, straight above the next pick, and down: by the public S-curve, row by row."""
    core = make_core(vary("nominal_plain", **FAILING), 40, seed=2)
    before, config = core.context, core.config
    info = core.step(np.zeros((40, 2))).info
    low, high = np.array([config.belt.pick_x, config.belt.lane_y]).T
    for row in np.flatnonzero(~info["picked"]):
        limits = MotionLimits.t3kr(percent=before.objects.percent[row])
        place = low + (high - low) * before.objects.draws.place[row, 1:3]
        over = np.array([*place, config.belt.height + 0.05 + config.motion.clearance])
        ways = np.linalg.norm(over - before.pick[row]), config.motion.clearance
        expected = config.motion.dwell + sum(min_time_scurve(way, limits).duration for way in ways)
        assert info["cycle_time"][row] == pytest.approx(expected, abs=1e-9)
        assert 0.0 < info["energy"][row] < info["energy"][info["picked"]].min()


def test_what_is_picked_is_thrown_as_if_nothing_could_fail():
    """To the last bit, and the objects are the same."""
    plain, failing = (make_core(level, 24, seed=4) for level in ("waste_plain", WASTE))
    for name, values in parts_of(plain.context.objects).items():
        assert name in HIDDEN_DRAWS or same_bits(values, parts_of(failing.context.objects)[name])
    infos = [core.step(np.full((24, 2), 0.1)).info for core in (plain, failing)]
    held = infos[1]["picked"]
    assert infos[0]["picked"].all()
    assert 0 < held.sum() < 24
    for name, values in infos[0].items():
        if name not in ("kind", "picked"):
            assert same_bits(values[held], infos[1][name][held]), name


def test_the_oracle_looks_at_throws_that_are_picked():
    core = make_core(WASTE, 30, seed=4)
    actions = np.zeros((30, 2))
    assert np.isfinite(core.preview(actions).landing_error).all()
    assert np.isnan(core.preview(actions, jitter=True).landing_error).any()


def test_a_failed_pick_is_drawn_as_a_hand_that_leaves_its_object():
    core = make_core(WASTE, 12, seed=4)
    row = int(np.flatnonzero(~picked(core.context, core.config))[0])
    core.cell.plant.record_row = row
    belt = core.config.belt
    x = core.context.pick[row, 0]
    core.step(np.zeros((12, 2)))
    recording = core.cell.plant.recording
    for data, _ in recording.play(0.05):
        time, place = data.time, data.xpos[recording.body].copy()
    assert belt.height < place[2] < belt.height + 0.12
    assert 0.3 * belt.speed * time < place[0] - x < 1.1 * belt.speed * time


@pytest.mark.parametrize("gap", ["centre", "edge"])
def test_objects_of_one_belt_fail_one_by_one(gap):
    """Each has a draw of its own, whether objects are drawn together or one after the other."""
    core = make_core(vary("waste_plain", belt={"gap": gap}, **FAILING), 3, picks="belt")
    draws = core.cell.source.stream.queue.pick_draw
    assert len(np.unique(draws)) == draws.size


METHODS = ("straight", "free_direction", "horizontal", "pick_and_place", "ellipse", "auto")
BELTS = {"tracking": {"tracking": True}, "solid": {"neighbours": "solid", "gap": "edge"}}


@pytest.mark.parametrize(
    ("planner", "belt"), with_nightly(product(METHODS, BELTS), [*zip(METHODS, cycle(BELTS), strict=False)])
)
def test_failed_picks_go_with_every_way_to_a_bin_and_every_belt(planner, belt):
    """Everything that can fail at once: no numbers are missing but those of landings that never were."""
    level = {
        "base": "nominal_plain", "planner": planner, "belt": BELTS[belt], "fidelity": "flight", **FAILING,
        "bins": {"emptied": 5}, "grip": {"limit": True},
        "classifier": {"confusion": {"paper": {"paper": 0.8, "metal_can": 0.2}}},
    }  # fmt: skip
    env = gym.make_vec("PnTConveyor-v0", num_envs=12, level=level)
    env.reset(seed=2)
    held = []
    for _ in range(2):
        seen, reward, *_, info = env.step(np.zeros(env.action_space.shape))
        assert np.isfinite(seen).all()
        assert np.isfinite(reward).all()
        assert same_bits(np.isnan(info["landing_error"]), ~info["picked"])
        assert np.isfinite(info["energy"]).all()
        assert (info["cycle_time"] > 0.1).all()
        held.append(info["picked"])
    assert 0 < np.sum(held) < 24
