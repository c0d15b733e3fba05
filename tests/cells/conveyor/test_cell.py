"""Objects on the belt, the hand that meets them, and the throws that a cell takes on."""

from itertools import pairwise

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.limits import LimitRows, MotionLimits
from pnt_gym.planning.straight.release import plan_release_batch, release_at_elevation
from tests.tools.nightly import with_nightly
from tests.tools.throws import is_feasible, make_core, planned, same_bits, vary

COUNT, PICKS = 8, 15
SHIFTS = {
    "nominal": vary("nominal_plain", picks_per_shift=1000),
    "waste": vary("waste_plain", picks_per_shift=1000),
    "honest": vary("waste", picks_per_shift=1000),
    "soonest": vary("waste_plain", picks_per_shift=1000, dispatch="soonest"),
    "atc": vary("dense", picks_per_shift=1000, dispatch="atc"),
}


@pytest.fixture(scope="module", params=with_nightly(SHIFTS, ["honest", "soonest"]))
def shift(request):
    """A shift of 8 cells: the belt as it was at every lift, each throw's outcome, and the pick after it."""
    core = make_core(SHIFTS[request.param], COUNT, picks="belt", seed=1)
    source = core.cell.source
    rng, history = np.random.default_rng(0), []
    for _ in range(PICKS):
        before = core.context
        masses, x = source.stream.queue.mass.copy(), source.stream.queue_x.copy()
        info = core.step(rng.uniform(-0.5, 0.5, (COUNT, 2))).info
        history.append((before, masses, x, info, core.context, source.passed.copy()))
    return core, history


def test_the_chosen_object_is_under_the_hand_when_it_arrives(shift):
    """Belt speed times the time since the last lift brings the object to where the hand comes down, or rides to."""
    core, history = shift
    config, met = core.config, 0
    stands = 0.0 if config.belt.tracking else config.motion.dwell
    for _, masses, x, info, after, _ in history:
        travel = info["cycle_time"] - stands
        for row in range(COUNT):
            place = np.flatnonzero(masses[row] == after.objects.mass[row])
            if place.size == 0:
                continue  # farther upstream than the objects that were known at the lift
            met += 1
            assert after.pick[row, 0] == pytest.approx(x[row, place[0]] + config.belt.speed * travel[row], abs=1e-9)
    assert met > 0.9 * COUNT * PICKS


def test_objects_ride_on_with_the_belt(shift):
    """Objects that stay in the queue move by belt speed times the whole cycle, dwell included."""
    core, history = shift
    same = 0
    for (_, masses, x, info, *_), (_, later_masses, later_x, *_) in pairwise(history):
        for row in range(COUNT):
            for place, mass in enumerate(masses[row]):
                later = np.flatnonzero(later_masses[row] == mass)
                if later.size:
                    same += 1
                    travel = core.config.belt.speed * info["cycle_time"][row]
                    assert later_x[row, later[0]] == pytest.approx(x[row, place] + travel, abs=1e-9)
    assert same > COUNT * PICKS


def test_objects_keep_their_order_and_their_gaps(shift):
    """Where one is taken from between others, the gap it leaves is wider than any drawn."""
    core, history = shift
    low, high = core.config.belt.spacing
    for _, _, x, *_ in history:
        gaps = -np.diff(x, axis=1)
        assert (gaps >= low - 1e-9).all()
        assert (gaps <= high + 1e-9).all() or core.config.dispatch != "first"
    if core.config.dispatch == "first":
        stream = core.cell.source.stream
        np.testing.assert_allclose(-np.diff(stream.queue_x, axis=1), stream.queue.draws.gap[:, 1:], atol=1e-9)


def test_picks_lie_in_the_window_and_in_their_lane(shift):
    core, history = shift
    low, high = core.config.belt.pick_x
    for before, _, _, info, after, _ in history:
        assert (after.pick[:, 0] >= low - 1e-9).all()
        assert (after.pick[:, 0] <= high + 1e-9).all()
        np.testing.assert_array_equal(after.pick[:, 1], after.objects.draws.lane_y)
        height = core.config.belt.height + after.objects.size[:, 2]
        assert (np.abs(after.pick[:, 2] - height) < 0.001).all()
        assert (info["wait_time"] >= 0.0).all()
        thrown = info["cycle_time"] > before.plan.time + info["wait_time"] + core.config.motion.dwell
        assert (thrown | ~info["picked"]).all()


def test_a_slow_belt_makes_the_hand_wait_and_a_fast_one_lets_objects_pass():
    slow, fast = (
        make_core(vary("nominal_plain", belt={"speed": s}, picks_per_shift=1000), 6, picks="belt") for s in (0.1, 0.8)
    )
    waits, passed = [], []
    for core in (slow, fast):
        infos = [core.step(np.zeros((6, 2))).info for _ in range(4)]
        waits.append(np.mean([i["wait_time"] for i in infos]))
        passed.append(np.sum([i["passed"] for i in infos]))
    assert waits[0] > 0.3
    assert waits[1] < 0.1 * waits[0] + 0.15
    assert passed[1] > passed[0]


def test_the_belt_speed_error_grows_with_the_way_from_the_camera():
    config = ConveyorConfig.load("nominal_plain")
    objects = take(PickPlanner(config).draw([np.random.default_rng(0)], np.arange(1), 50), 0)
    x = np.linspace(-0.3, 0.3, 50)
    context, _ = planned(config, objects, x)
    np.testing.assert_allclose(context.belt_shift, objects.belt_error * (x + 0.8), rtol=1e-12)
    np.testing.assert_allclose(context.grasp - objects.grasp, np.stack([context.belt_shift, 0 * x], axis=1), atol=1e-15)


@pytest.fixture(scope="module", params=["nominal_plain", "waste_plain", "tight_plain"])
def contexts(request):
    return make_core(request.param, 300, seed=11)


def test_a_taken_throw_stays_inside_and_has_room_for_the_reserve(contexts):
    context, config = contexts.context, contexts.config
    points = np.stack([context.pick, context.plan.position], axis=1)
    assert ((points[..., 0] / 0.45) ** 2 + (points[..., 1] / 0.80) ** 2 <= 1.0).all()
    assert (context.plan.position[:, 2] <= context.pick[:, 2] + config.motion.ceiling + 1e-9).all()
    assert context.plan.feasible.all()
    assert is_feasible(contexts, context.plan).all()
    for sign in (-1.0, 1.0):
        target = context.target.copy()
        target[:, :2] += sign * config.motion.reserve * context.direction
        moved = release_at_elevation(context.pick, target, LimitRows.t3kr(context.objects.percent), context.plan.angle)
        assert is_feasible(contexts, moved).all()


def test_the_plan_is_the_planners_own(contexts):
    context = contexts.context
    percent = context.objects.percent
    plan = plan_release_batch(context.pick, context.target, MotionLimits.t3kr(percent), ceiling=context.ceiling)
    assert same_bits(plan.position, context.plan.position)
    assert set(percent) == set(contexts.config.limits.percent)


def test_random_bins_fill_their_ranges():
    core, r = make_core("tight_plain", 400), ConveyorConfig.load("tight_plain").bins.random
    x, y = core.context.target[:, 0], core.context.target[:, 1]
    assert r.x[0] <= x.min() < r.x[0] + 0.1
    assert r.x[1] - 0.1 < x.max() <= r.x[1]
    assert r.y[0] <= y.min() < r.y[0] + 0.1
    assert (core.context.opening >= r.side[0]).all()
    same_side = core.context.opening[:, 0] == core.context.opening[:, 1]
    assert same_side.all()
    np.testing.assert_array_equal(core.context.target[:, 2], core.config.bins.rim)


def test_items_go_to_bins_that_accept_them():
    bins = {
        "fixed": [
            {"name": "any", "x": -0.30, "y": 0.40},
            {"name": "paper", "x": 0.0, "y": 0.40, "accepts": ["paper"]},
            {"name": "metal", "x": 0.30, "y": 0.40, "accepts": ["metal_can"]},
        ]
    }
    context = make_core(vary("nominal_plain", bins=bins), 400).context
    pairs = set(zip(context.objects.kind.tolist(), context.bin.tolist(), strict=True))
    assert pairs == {(0, 0), (0, 1), (1, 0), (1, 2), (2, 0)}
    places = np.array([[-0.30, 0.40], [0.0, 0.40], [0.30, 0.40]])
    np.testing.assert_array_equal(context.target[:, :2], places[context.bin])


@pytest.mark.filterwarnings("ignore:level .* bin 'moon' .* stays empty")
def test_a_cell_whose_bins_are_out_of_reach_says_so():
    far = {"fixed": [{"name": "moon", "x": 0.0, "y": 9.0}]}
    with pytest.raises(ConfigError, match="no object has a feasible throw; check that the bins are in reach") as e:
        make_core(vary("nominal_plain", bins=far), 1)
    assert "\n" not in str(e.value)
    with pytest.raises(ConfigError, match="no object has a feasible throw"):
        make_core(vary("nominal_plain", bins=far), 1, picks="belt")


def test_a_belt_on_which_objects_are_too_far_apart_says_so():
    belt = {"spacing": [9.0, 9.5], "speed": 0.2}
    with pytest.raises(ConfigError, match=r"spacing starts at 9 m and belt.speed is 0.2 m/s.* at 6 m or less"):
        make_core(vary("nominal", belt=belt), 1, picks="belt")


def test_preview_changes_nothing():
    one, two = (make_core("nominal", 3, picks="belt", seed=2) for _ in range(2))
    one.preview(np.ones((3, 2)))
    for _ in range(3):
        a, b = one.step(np.zeros((3, 2))), two.step(np.zeros((3, 2)))
        assert same_bits(a.observation, b.observation)
        assert same_bits(a.reward, b.reward)
