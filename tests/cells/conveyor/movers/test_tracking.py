"""A hand that rides with the belt: at the belt's speed when it touches and lifts, within limits and window, no slip."""

from itertools import product

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.action import FIXED_THROW, MODES
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.cup.hold import Grips, Parting
from pnt_gym.cells.conveyor.hand import ThrowClock
from pnt_gym.cells.conveyor.scene import SENSORS
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.trajectory import JerkTrajectory
from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core, same_bits, spy_on_plant, vary, whole_cycle

COUNT, DWELL, FAST = 14, 0.1, 0.8
PLANNERS = ("straight", "free_direction")
ALL_PLANNERS = (*PLANNERS, "horizontal", "pick_and_place", "ellipse")
MOST_DAILY = with_nightly(ALL_PLANNERS, {*ALL_PLANNERS} - {"free_direction", "ellipse"})
"""Two searches take much longer on a belt than the others."""
EVERY_PAIR = [
    (planner, mode, ("belt", "independent")[(row + column) % 2])
    for row, planner in enumerate(ALL_PLANNERS)
    for column, mode in enumerate(MODES)
    if mode != FIXED_THROW or planner == "straight"
]
"""Every planner with every action mode, and either of them with picks of both kinds."""
DAILY_PAIRS = [case for case in EVERY_PAIR if case[0] == "straight" or case[1] == next(iter(MODES))]
"""Every planner with the default mode, and one planner with all modes."""


def core_of(
    level="nominal_plain", picks="belt", count=COUNT, mode="release_point", tracking=True, speed=FAST, **changes
):
    belt = {"tracking": tracking, "speed": speed}
    return make_core(vary(level, belt=belt, **changes), count, picks=picks, mode=mode, threads=2)


@pytest.mark.parametrize(
    ("planner", "mode", "picks"),
    with_nightly(EVERY_PAIR, [case for case in DAILY_PAIRS if case[::2] != ("free_direction", "belt")]),
)
def test_paths_begin_and_end_with_the_belt_and_keep_every_limit(planner, mode, picks):
    count = 12
    core = core_of("waste_plain", picks, count, mode, planner=planner, fidelity="flight")
    calls, rng = spy_on_plant(core), np.random.default_rng(0)
    for _ in range(2):
        core.step(rng.uniform(-1, 1, (count, *core.action_space.shape)))
    belt = np.tile([FAST, 0.0, 0.0], (count, 1))
    for context, cycle, _ in calls:
        path = cycle.path
        for ratio in path.peak_ratios(LimitRows.t3kr(context.objects.percent)):
            assert ratio.max() <= 1.0 + 1e-9
        np.testing.assert_allclose(path.start, context.pick, atol=1e-12)
        for border in (0, -1):
            np.testing.assert_allclose(path.knots.velocity[:, border], belt, atol=1e-9)
            np.testing.assert_allclose(path.knots.acceleration[:, border], 0.0, atol=1e-7)
        released = path.sample(cycle.release_time[:, None])
        np.testing.assert_allclose(released.position[:, 0], cycle.release.position, atol=1e-9)
        np.testing.assert_allclose(released.velocity[:, 0], cycle.release.velocity, atol=1e-9)
        np.testing.assert_allclose(released.acceleration[:, 0], 0.0, atol=1e-6)


SPEEDS = [("straight", 0.25), ("straight", FAST), ("free_direction", 0.25), ("free_direction", FAST)]


@pytest.mark.parametrize(("planner", "speed"), with_nightly(SPEEDS, SPEEDS[:3]))
def test_the_hand_touches_and_lifts_the_object_inside_the_window(planner, speed):
    core = core_of(planner=planner, fidelity="flight", speed=speed)
    calls, waits = spy_on_plant(core), []
    low, high = core.config.belt.pick_x
    for _ in range(5):
        source = core.cell.source
        before = source.stream.queue_x.copy()
        info = core.step(np.zeros((COUNT, 2))).info
        waits.append(info["wait_time"])
        path, lift = calls[-1][1].path, core.context.pick
        touch = path.end
        np.testing.assert_allclose(lift - touch, np.tile([speed * DWELL, 0.0, 0.0], (COUNT, 1)), atol=1e-9)
        assert touch[:, 0].min() >= low - 1e-9
        assert lift[:, 0].max() <= high + 1e-9
        # The object has ridden the belt since the last lift, for as long as the hand moved.
        place = source.passed
        known = place < before.shape[1]
        there = before[np.arange(COUNT), np.minimum(place, before.shape[1] - 1)] + speed * path.duration
        np.testing.assert_allclose(there[known], touch[known, 0], atol=1e-9)
        np.testing.assert_allclose(info["cycle_time"], path.duration + DWELL, atol=1e-12)
    assert (np.concatenate(waits) > 0.0).any() == (speed < FAST)


@pytest.mark.parametrize("fidelity", ["full", "flight"])
def test_independent_picks_are_lifted_inside_the_window_too(fidelity):
    core = core_of(picks="independent", count=400, fidelity=fidelity, timestep=0.002)
    x, (low, high) = core.context.pick[:, 0], core.config.belt.pick_x
    assert low + FAST * DWELL <= x.min() < low + FAST * DWELL + 0.02
    assert high - 0.02 < x.max() <= high


def resting_ride(context, config):
    """Hands that ride with the belt from where they lift, and hold nothing."""
    count, step = len(context.pick), config.timestep
    still = np.zeros((count, 1, 3))
    belt = np.tile([config.belt.speed, 0.0, 0.0], (count, 1))
    path = JerkTrajectory(context.pick, np.full((count, 1), DWELL), still, belt, rides=True)
    zero, never = np.zeros(count), np.full(count, -1)
    end = np.full(count, round(DWELL / step) + 1)
    held = Grips(zero + np.inf, never, np.full(count, True))
    parting = Parting.hanging(context, zero)
    return ThrowClock(path, context.cup_offset, zero, zero, 0 * end, end, step, held, parting, 0.0)


@pytest.mark.parametrize("mismatch", [0.0, 1.0])
def test_in_the_simulator_cup_and_object_stay_together_over_the_dwell(mismatch):
    """Robot and object ride free of each other, the one by its motors, the other on the belt: 80 mm in 0.1 s."""
    core = core_of(mismatch=mismatch, picks="independent")
    plant, context = core.cell.plant, core.context.without_spin(np.full(COUNT, True))
    clock = resting_ride(context, core.config)
    plant.write(context, np.arange(COUNT), clock)
    sensors = plant._roll_out_robot(np.arange(COUNT), context, clock, clock.end)["sensordata"]
    hand, thing = (sensors[..., SENSORS[name]] for name in ("hand_position", "object_position"))
    np.testing.assert_allclose(hand[:, -1, 0] - hand[:, 0, 0], FAST * DWELL, atol=0.5e-3)
    slip = (thing - hand)[..., :2] - (thing - hand)[:, :1, :2]
    assert np.linalg.norm(slip, axis=-1).max() < 1e-3


@pytest.mark.parametrize("planner", PLANNERS)
def test_the_hand_comes_to_the_belt_and_rides_as_planned(planner):
    """The whole cycle in the simulator: descent, touch, and the dwell after it."""
    core = core_of(planner=planner, count=60)
    context, (_, cycle) = core.context, whole_cycle(core, core.plan(np.zeros((60, 2)))[0])
    followed, path = core.cell.plant.follow(context, cycle), cycle.path
    clock = ThrowClock.of(context, cycle, core.config)
    steps = np.arange(followed.hand.shape[1])
    astray = np.linalg.norm(followed.hand - clock.hand(steps).position, axis=-1)
    assert astray[:, : round(0.010 / clock.step)].max() < 0.2e-3
    times = steps * clock.step - clock.path_delay[:, None]
    dwells = (times > path.duration[:, None]) & (times < path.duration[:, None] + DWELL) & (steps < clock.end[:, None])
    assert dwells.sum(axis=1).max() > 0.9 * DWELL / clock.step
    assert astray[dwells].max() < 0.3e-3


@pytest.mark.parametrize(
    ("planner", "level"),
    with_nightly(product(PLANNERS, ("nominal_plain", "waste_plain")), [("straight", "waste_plain")]),
)
def test_a_throw_begins_without_a_jerk_of_the_robot(planner, level):
    """At the release the hand is as near its path as after a start from rest."""
    errors = {}
    for tracking in (False, True):
        core = core_of(level, "independent", 60, tracking=tracking, planner=planner)
        outcome = core.preview(np.zeros((60, 2)))
        errors[tracking] = outcome.tracking_error
        assert outcome.peak_torque.max() < 530.0
    assert errors[True].mean() < 1.1 * errors[False].mean()
    assert errors[True].max() < 0.2e-3


def test_what_is_told_of_the_slip():
    for tracking in (False, True):
        core = core_of("waste_plain", "independent", tracking=tracking, fidelity="flight")
        error = core.hidden()["belt_error"]
        slip = core.step(np.zeros((COUNT, 2))).info["slip"]
        true = FAST * (1.0 + error)
        np.testing.assert_allclose(slip, DWELL * np.abs(true - FAST * tracking), atol=1e-12)
    # Half a percent of 80 mm.
    assert np.quantile(slip, 0.9) < 1e-3
    assert not core_of("ideal", "independent", fidelity="flight").step(np.zeros((COUNT, 2))).info["slip"].any()


@pytest.mark.parametrize("picks", with_nightly(("belt", "independent"), ["belt"]))
def test_flights_and_the_full_physics_agree_as_they_do_for_a_hand_at_rest(picks):
    landings = {}
    for tracking in (False, True):
        found = [
            core_of("waste_plain", picks, 60, tracking=tracking, fidelity=fidelity).preview(
                np.zeros((60, 2)), jitter=True
            )
            for fidelity in ("full", "flight")
        ]
        landings[tracking] = np.linalg.norm(found[0].landing - found[1].landing, axis=1)
    assert np.median(landings[True]) < 1.5 * np.median(landings[False])


@pytest.mark.parametrize("planner", MOST_DAILY)
def test_in_the_planners_own_world_every_throw_lands(planner):
    core = core_of("ideal", planner=planner)
    for _ in range(2):
        info = core.step(np.zeros((COUNT, 2))).info
        assert info["is_success"].all()
        assert info["landing_error"].max() < 0.010


def test_objects_that_must_be_thrown_slowly_fade_slowly_or_ride_on():
    """A grip that asks for less acceleration gets it, the fading included."""
    core = core_of("waste_plain", fidelity="flight", grip={"safety": 2.0, "limit": True})
    calls = spy_on_plant(core)
    for _ in range(3):
        core.step(np.zeros((COUNT, 2)))
    slowed = 0
    for context, cycle, _ in calls:
        times = np.linspace(0.0, 1.0, 200) * cycle.release_time[:, None]
        acceleration = np.linalg.norm(cycle.path.sample(times).acceleration, axis=-1).max(axis=1)
        assert (acceleration <= context.throw_limits.acceleration * (1 + 1e-9)).all()
        slowed += (context.throw_limits.acceleration < LimitRows.t3kr(context.objects.percent).acceleration).sum()
    assert slowed > 0


REFUSED = {
    "faster than 40 %": ({"belt": {"speed": 2.0}}, r"belt.speed is 2 m/s; a hand at 40 % .* belts up to 1.44 m/s"),
    "slowest counts": ({"belt": {"speed": 1.0}, "limits": {"percent": [30, 45]}}, r"at 30 % .* up to 0.93 m/s"),
    "out of the window": (
        {"belt": {"speed": 0.8}, "motion": {"dwell": 1.0}},
        r"motion.dwell is 1 s; a hand that rides with the belt at 0.8 m/s leaves .* after at most 0.75 s",
    ),
    "not a switch": ({"belt": {"tracking": 3}}, r"belt.tracking is 3"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_belt_that_no_hand_can_ride_with_is_refused(case):
    level, message = REFUSED[case]
    level = {**level, "belt": {"tracking": True, **level.get("belt", {})}}
    with pytest.raises(ConfigError, match=message):
        ConveyorConfig.load(level)
    if case != "not a switch":  # a hand that stands still does not mind
        ConveyorConfig.load({**level, "belt": {**level["belt"], "tracking": False}})


def test_the_fastest_belt_that_is_not_refused_can_be_sorted_from():
    core = core_of("nominal_plain", "independent", 12, speed=1.43, fidelity="flight")
    assert core.step(np.zeros((12, 2))).info["is_success"].mean() > 0.8


@pytest.mark.parametrize("planner", MOST_DAILY)
def test_a_hand_that_lifts_nothing_stops_and_goes_on(planner):
    changes = {"pick": {"fails": True}, "planner": planner, "fidelity": "flight"}
    core = core_of("waste_plain", picks="belt", **changes)
    calls, failed = spy_on_plant(core), 0
    for _ in range(3):
        picked = core.step(np.zeros((COUNT, 2))).info["picked"]
        context, cycle, _ = calls[-1]
        for ratio in cycle.path.peak_ratios(LimitRows.t3kr(context.objects.percent)):
            assert ratio.max() <= 1.0 + 1e-9
        np.testing.assert_allclose(cycle.path.end[:, 0], core.context.pick[:, 0] - FAST * DWELL, atol=1e-9)
        np.testing.assert_allclose(cycle.path.end[:, 1:], core.context.pick[:, 1:], atol=1e-9)
        failed += (~picked).sum()
    assert failed > 0


def test_the_clock_of_some_rows_rides_as_well():
    core = core_of(picks="independent", fidelity="flight")
    calls = spy_on_plant(core)
    core.step(np.zeros((COUNT, 2)))
    context, cycle, _ = calls[0]
    clock = ThrowClock.of(context, cycle, core.config)
    some, late = np.array([3, 7]), clock.end[:, None] + np.arange(5)
    whole, part = clock.hand(late), take(clock, some).hand(late[some])
    assert same_bits(whole.position[some], part.position)
    np.testing.assert_allclose(part.velocity, np.tile([FAST, 0.0, 0.0], (2, 5, 1)), atol=1e-9)


def test_a_short_throw_beside_a_long_wait_is_simulated_to_its_own_end():
    """A hand that rides does not ride on, out of the robot's reach, until the longest throw of the batch is over."""
    core = make_core(vary("nominal", belt={"spacing": [0.02, 4.0]}), 6, picks="belt", threads=2)
    calls, plant = spy_on_plant(core), core.cell.plant
    for _ in range(2):
        core.step(np.zeros((6, 2)))
    durations = np.concatenate([plans.path.duration for _, plans, _ in calls])
    assert durations.max() > 8.0
    assert durations.min() < 2.0
    for thrown, plans, _ in calls:
        hand = plant.follow(thrown, plans).hand
        assert np.isfinite(hand).all()
