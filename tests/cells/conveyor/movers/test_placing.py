"""Level throws, pick-and-place and the ellipse in the cell: the papers' cycles, legal motion, walls, meetings."""

from contextlib import closing
from itertools import cycle

import numpy as np
import pytest

from agents.controllers import make_controller
from agents.ground.environments import make_vector
from agents.judging.loop import throw_held_out
from papers.hassan.planning.cycle import CycleRules, CycleTask, horizontal_throw, pick_and_place
from pnt_gym.cells.base.recorded import lies_in
from pnt_gym.cells.conveyor.action import FIXED_THROW, MODES
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import LIP_GAP
from pnt_gym.cells.conveyor.movers.placing import first_not_late
from pnt_gym.errors import ConfigError
from pnt_gym.planning import EllipticWorkspace, MotionLimits
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.straight.plan import Reason
from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core, spy_on_plant, vary, whole_cycle, with_objects

COUNT = 8
PLACING = ("pick_and_place", "ellipse")
METHODS = ("horizontal", *PLACING)
CURVED = (*METHODS, "free_direction")
ENV_OF = {"belt": "PnTConveyor-v0", "independent": "PnTRelease-v0"}
ONLY_INSIDE = {"fixed": [{"name": "inside", "x": 0.30, "y": 0.40, "size": [0.24, 0.235]}]}


def core_of(
    planner, level="nominal_plain", picks="independent", count=COUNT, mode="release_point", threads=1, **changes
):
    return make_core(vary(level, planner=planner, **changes), count, picks=picks, mode=mode, threads=threads)


def to_the_next(core):
    """Cycles of a cell's picks, each back to the pick of another row."""
    return whole_cycle(core, following=np.roll(core.context.pick, 1, axis=0))


@pytest.mark.parametrize("planner", ["horizontal", "pick_and_place"])
def test_a_cycle_is_the_papers(planner):
    """Where objects are put down as high as they lie and nothing is waited for: the moves of `papers.hassan`."""
    placing = {"over_rim": -0.05, "clear": 0.0}  # the rim of `ideal` is 50 mm above its belt
    core = core_of(planner, "ideal", motion={"placing": placing, "follow_through": {"window": 0.0}}, bins=ONLY_INSIDE)
    context, (motion, cycle) = core.context, whole_cycle(core)
    targets = context.plan.position if planner in PLACING else context.target
    rules = CycleRules(lift=core.config.motion.ceiling, rise=None, tolerance=0.0, overlap="none")
    limits = MotionLimits(*(np.asarray(most) for most in LimitRows.t3kr(context.objects.percent)))
    build = pick_and_place if planner in PLACING else horizontal_throw
    found = build(CycleTask.of(context.pick, targets, context.pick, limits, rules, EllipticWorkspace()))
    np.testing.assert_allclose(motion.release_time, found.release_time, rtol=1e-9)
    np.testing.assert_allclose(cycle.path.duration, found.duration, rtol=1e-9)
    np.testing.assert_allclose(context.plan.velocity, found.release_velocity, atol=1e-9)


@pytest.mark.parametrize(("planner", "picks"), [*zip(METHODS, cycle(ENV_OF), strict=False)])
def test_limits_are_kept_by_finite_differences(planner, picks):
    core = core_of(planner, "waste_plain", picks=picks)
    calls, step = spy_on_plant(core), 2e-4
    core.step(np.zeros((COUNT, 2)))
    context, cycle, _ = calls[0]
    place = cycle.path.sample(np.arange(0.0, cycle.path.duration.max() + step, step)).position
    for order, most in enumerate(LimitRows.t3kr(context.objects.percent), start=1):
        change = np.diff(place, n=order, axis=1) / step**order
        assert (np.linalg.norm(change, axis=2).max(axis=1) / most).max() < 1.0 + 1e-3
    assert core.cell.planner.workspace.contains(place).all()
    at = cycle.path.sample(cycle.release_time[:, None])
    np.testing.assert_allclose(at.position[:, 0], cycle.release.position, atol=1e-9)
    np.testing.assert_allclose(at.velocity[:, 0], cycle.release.velocity, atol=1e-8)
    np.testing.assert_allclose(at.acceleration[:, 0], 0.0, atol=1e-6)


@pytest.mark.parametrize("planner", METHODS)
def test_a_level_throw_is_level_and_what_is_placed_is_let_go_at_rest(planner):
    plan, context = core_of(planner).context.plan, core_of(planner).context
    if planner == "horizontal":
        np.testing.assert_array_equal(plan.velocity[:, 2], 0.0)
        np.testing.assert_allclose(plan.position[:, 2], context.ceiling, atol=1e-12)
        assert (plan.speed > 0.5).all()
    else:
        np.testing.assert_array_equal(plan.velocity, 0.0)
        np.testing.assert_allclose(plan.position[:, :2], context.target[:, :2], atol=1e-12)
        lowest = plan.position[:, 2] + context.objects.known_depth - context.objects.size[:, 2] - LIP_GAP
        np.testing.assert_allclose(lowest, context.target[:, 2] + 0.01, atol=1e-9)


@pytest.mark.parametrize("planner", CURVED)
@pytest.mark.parametrize("mode", sorted({*MODES} - {FIXED_THROW}))
def test_zero_is_the_plan_and_an_action_shifts_the_landing(planner, mode):
    core = core_of(planner, mode=mode)
    numbers = len(MODES[mode].numbers)
    zero, clipped = core.plan(np.zeros((COUNT, numbers)))
    assert not clipped.any()
    for name in ("position", "velocity", "flight_time", "time"):
        wanted = getattr(core.context.plan, name)
        np.testing.assert_allclose(getattr(zero, name), wanted, rtol=1e-12, atol=1e-15, err_msg=name)
    action = np.zeros((COUNT, numbers))
    action[:, 0] = -0.25
    release, clipped = core.plan(action)
    assert clipped.mean() <= (0.3 if planner == "free_direction" else 0.0)
    scale = core.config.action.xyz[0] if mode == "release_xyz" else core.config.action.along
    landing = release.position + release.flight_time[:, None] * release.velocity
    before = zero.position + zero.flight_time[:, None] * zero.velocity
    along, across = np.array(core.context.to_throw_frame((landing - before)[:, :2]))[:, ~clipped]
    np.testing.assert_allclose(across, 0.0, atol=1e-9)
    if (planner, mode) == ("horizontal", "release_xyz"):
        assert (along <= -0.25 * scale + 1e-9).all()  # the hand may be slower there
    else:
        np.testing.assert_allclose(along, -0.25 * scale, atol=1e-9)


@pytest.mark.parametrize("planner", with_nightly(METHODS, ["ellipse"]))
def test_the_oracle_passes_and_a_deliberate_miss_fails(planner):
    level = {"base": "nominal_plain", "planner": planner, "bins": ONLY_INSIDE}
    with closing(make_vector("PnTRelease-v0", level, 16, threads=1)) as env:
        throws = throw_held_out(make_controller("oracle", env, previews=4), env, 16, 0)
    assert throws.is_success.mean() > 0.9
    assert throws.landing_error.max() < 0.02
    missed = core_of(planner, bins=ONLY_INSIDE).step(np.tile([-1.0, 0.0], (COUNT, 1)))
    assert not missed.info["is_success"].any()


@pytest.mark.parametrize(("planner", "fidelity"), [*zip(PLACING, ("full", "flight"), strict=True)])
def test_without_mismatch_everything_is_placed_in_the_middle(planner, fidelity):
    for picks in ENV_OF:
        core = core_of(planner, "ideal", picks=picks, fidelity=fidelity)
        for _ in range(2):
            info = core.step(np.zeros((COUNT, 2))).info
            assert info["landing_error"].max() < 0.001
            assert info["is_success"].all()
            assert not info["recontact"].any()
            assert info["peak_torque"].max() < 530.0


@pytest.mark.parametrize("planner", PLACING)
def test_flights_land_where_the_full_physics_does(planner):
    landing = {
        fidelity: core_of(planner, fidelity=fidelity).step(np.zeros((COUNT, 2))).info["landing_error"]
        for fidelity in ("full", "flight")
    }
    np.testing.assert_allclose(landing["flight"], landing["full"], atol=0.003)


@pytest.mark.parametrize("planner", METHODS)
def test_what_is_flown_is_what_is_planned(planner):
    """The simulated hand is at its next pick when the plan says so: within 3 %, and it stays within a millimetre."""
    core = core_of(planner, "nominal_plain")
    context, (_, cycle) = core.context, to_the_next(core)
    followed, path = core.cell.plant.follow(context, cycle), cycle.path
    steps = np.arange(followed.hand.shape[1])
    times = followed.start[:, None] + steps * core.config.timestep
    planned = path.sample(times).position + context.cup_offset[:, None]
    counts = times <= path.duration[:, None]
    assert np.where(counts, np.linalg.norm(followed.hand - planned, axis=2), 0.0).max() < 0.002
    end = (path.end + context.cup_offset)[:, None]
    away = counts & (np.linalg.norm(followed.hand - end, axis=2) > 0.002)
    arrived = times[np.arange(COUNT), away.shape[1] - 1 - away[:, ::-1].argmax(axis=1)]
    assert np.abs(arrived / path.duration - 1.0).max() < 0.03


@pytest.mark.parametrize("planner", CURVED)
def test_the_hand_arrives_where_and_when_the_object_does(planner):
    core = core_of(planner, picks="belt")
    calls = spy_on_plant(core)
    for _ in range(2):
        before = core.cell.source.stream.queue_x.copy()
        wait = core.step(np.zeros((COUNT, 2))).info["wait_time"]
        path, pick = calls[-1][1].path, core.context.pick
        np.testing.assert_allclose(path.end, pick, atol=1e-9)
        ridden = core.config.belt.speed * path.duration
        assert np.abs(before + ridden[:, None] - pick[:, :1]).min(axis=1).max() < 1e-9
        low, high = core.config.belt.pick_x
        assert ((pick[:, 0] >= low - 1e-9) & (pick[:, 0] <= high + 1e-9)).all()
        # What is left of the search is waited for; other waits are for objects that have not come yet.
        assert ((wait < 5e-3) | (np.abs(pick[:, 0] - low) < 1e-9)).all()


@pytest.mark.parametrize("planner", PLACING)
def test_what_is_carried_passes_over_every_rim(planner):
    """By its lowest point and its greatest width, over all bins of a level with many, at full and at low rims."""
    boxes = [
        {"name": f"{x}{y}", "x": 0.12 * x, "y": 0.06 + 0.12 * y, "size": [0.10, 0.10]}
        for x in (-2, -1, 0, 1, 2)
        for y in (0, 1, 2, 3)
    ]
    for rim, vertical in ((-0.85, 0.02), (-0.80, 0.12)):
        placing = {"over_rim": 0.0, "vertical": vertical}
        core = core_of(planner, "ideal", bins={"fixed": boxes, "rim": rim}, motion={"placing": placing})
        context, (motion, cycle) = core.context, to_the_next(core)
        times = np.linspace(0.0, 1.0, 801) * motion.release_time[:, None]
        place = cycle.path.sample(times).position
        low = place[..., 2] - (context.pick[:, 2] - core.config.belt.height)[:, None]
        size = context.objects.size
        half = np.hypot(size[:, 0], size[:, 1])[:, None] / 2.0
        # Bins begin at y = 0: where the object reaches over them and is not over the middle of its own, it is clear.
        over = place[..., 1] + half > 0.0
        aside = np.linalg.norm(place[..., :2] - context.target[:, None, :2], axis=2) > 1e-6
        assert (over & aside).any()
        assert (low[over & aside] > rim - 1e-9).all()
        assert (low[over] > rim - 1e-9).all()


@pytest.mark.parametrize("planner", METHODS)
def test_a_bin_out_of_reach_is_told(planner):
    far = {"fixed": [{"name": "far", "x": 0.0, "y": 1.6, "size": [0.2, 0.2]}]}
    config = vary("nominal_plain", planner=planner, bins=far)
    with (
        pytest.warns(UserWarning, match="bin 'far' .* stays empty"),
        pytest.raises(ConfigError, match="no object has a feasible throw"),
    ):
        ConveyorCell(config, 1, "independent")


def test_the_reason_is_the_workspace():
    core = core_of("pick_and_place")
    context, mover = core.context, core.cell.planner.mover
    target = context.target.copy()
    target[0, :2] = 0.45, 0.65
    target[1] = context.pick[1]
    found = mover.plan(context.pick, target, context.throw_limits, context.ceiling)
    assert found.reason[:3].tolist() == [Reason.WORKSPACE, Reason.NO_REACH, Reason.FEASIBLE]
    assert found.feasible.tolist() == [False, False, *[True] * (COUNT - 2)]
    assert np.isnan(found.position[:2]).all()
    np.testing.assert_array_equal(found.time[2:], context.plan.time[2:])


BOXES = {
    "rim": -0.70,
    "depth": 0.205,
    "fixed": [
        {"name": "one", "x": -0.16, "y": 0.10, "size": [0.20, 0.20]},
        {"name": "other", "x": 0.12, "y": 0.42, "size": [0.20, 0.20]},
    ],
}


@pytest.mark.parametrize("fidelity", ["full", "flight"])
@pytest.mark.parametrize("planner", PLACING)
def test_out_of_one_box_and_into_another(planner, fidelity):
    """The paper's title: walls 0.20 m high at either end are cleared, in the simulator, by the objects' bodies."""
    placing = {"over_rim": -0.10, "vertical": 0.23, "reserve": 0.0}
    level = vary("ideal", planner=planner, fidelity=fidelity, bins=BOXES, motion={"placing": placing, "ceiling": 0.25})
    core = make_core(level, COUNT)
    objects, planner_of = core.context.objects, core.cell.planner
    pick = core.context.pick.copy()
    pick[:, :2] = -0.16, 0.10
    context, good = planner_of.plan(objects, pick)
    assert good.all()
    assert (context.bin == 1).all()
    core.cell.context = context
    motion, cycle = to_the_next(core)
    low = cycle.path.sample(np.linspace(0.0, 1.0, 400) * motion.release_time[:, None]).position
    half = np.hypot(objects.size[:, 0], objects.size[:, 1])[:, None] / 2.0
    for x, y in ((-0.16, 0.10), (0.12, 0.42)):
        # An object that is not above the rims is far enough inside one of the boxes.
        inside = np.abs(low[..., :2] - (x, y)).max(axis=2) + half < 0.10 + 1e-9
        low_z = low[..., 2] - (pick[:, 2] - core.config.belt.height)[:, None]
        near = np.abs(low[..., :2] - (x, y)).max(axis=2) < 0.10
        assert (inside | (low_z > -0.70) | ~near)[half[:, 0] < 0.10].all()
    followed = core.cell.plant.follow(context, cycle)
    steps = np.arange(followed.hand.shape[1])
    held = steps < followed.flight.release_step[:, None]
    assert not (followed.flight.any_touch & held).any()
    lowest = context.plan.position[:, 2] - (pick[:, 2] - core.config.belt.height)
    np.testing.assert_allclose(lowest, -0.80, atol=1e-9)
    touchdown = core.cell.plant.fly(context, cycle).touchdown
    assert lies_in(touchdown, context.target, context.opening, np.array([core.config.bins.depth])).all()
    assert not touchdown.recontact.any()


def test_care_slows_what_carries_and_not_what_returns():
    free, careful = (core_of("pick_and_place", "waste_plain", count=24, grip=grip) for grip in ({}, {"safety": 2.0}))
    shared = careful.context.objects.mass == free.context.objects.mass  # others could not be held
    slower = careful.context.plan.time > free.context.plan.time + 1e-9
    slow = careful.context.throw_limits.acceleration < LimitRows.t3kr(careful.context.objects.percent).acceleration
    assert (slower == slow)[shared].all()
    assert (slow & shared).any()


def test_an_object_that_weighs_on_the_cup_is_let_go_where_it_stands():
    """Late by a tenth of a second or not: the hand stands still, so it falls where it is."""
    core = core_of("pick_and_place", "ideal", motion={"follow_through": {"window": 0.15}})
    with_objects(core, delay=np.full(COUNT, 0.10))
    assert core.step(np.zeros((COUNT, 2))).info["landing_error"].max() < 0.001


@pytest.mark.parametrize("bend", [0.0, 0.4, -0.3])
def test_a_meeting_is_the_first_time_that_nothing_is_late(bend):
    random = np.random.default_rng(0)
    start, slope = random.uniform(0.1, 1.0, 64), random.uniform(0.3, 1.0, 64)

    def late(time):
        return start - slope * time + bend * slope * time * np.maximum(1.0 - time, 0.0) / 2.0

    low, high = np.zeros(64), np.full(64, 6.0)
    time, good = first_not_late(late, low, high)
    assert good.all()
    assert (late(time) <= 0.0).all()
    assert (late(time) > -1e-4).all()
    at_once, good = first_not_late(lambda time: -1.0 - time, low, high)
    assert good.all()
    np.testing.assert_array_equal(at_once, low)
    assert not first_not_late(lambda time: 1.0 + time, low, high)[1].any()
