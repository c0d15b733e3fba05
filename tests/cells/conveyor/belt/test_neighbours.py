"""Objects on the belt that a carried object sweeps through: they are reported, and where they are solid, lost."""

import copy

import numpy as np
import pytest

from pnt_gym.arrays import concatenate_records, take
from pnt_gym.cells.base.items import BOX, CYLINDER, ELLIPSOID
from pnt_gym.cells.conveyor.belt.stream import (
    BESIDE_DEPTH,
    CHECK_AFTER_RELEASE,
    CHECK_INTERVAL,
    Carried,
    Neighbours,
    course,
    sweeps_through,
)
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.objects.records import half_extent
from pnt_gym.planning.motion.limits import MotionLimits
from pnt_gym.planning.motion.scurve import accelerate, coast
from tests.tools.nightly import with_nightly
from tests.tools.outlines import outlines, overlap
from tests.tools.throws import make_core, same_bits, vary

COUNT = 24


def core_of(count=COUNT, level="waste_plain", neighbours="solid", tracking=False, picks="belt", speed=0.8, **changes):
    belt = {"speed": speed, "neighbours": neighbours, "tracking": tracking}
    return make_core(vary(level, belt=belt, **{"fidelity": "flight", **changes}), count, picks=picks)


def some_objects(count, seed):
    """Objects of every shape and yaw."""
    objects = make_core("waste_plain", count, seed=seed).context.objects
    rng = np.random.default_rng(seed)
    return objects.replace(
        shape=rng.choice([ELLIPSOID, CYLINDER, BOX], count),
        size=rng.uniform(0.02, 0.2, (count, 3)),
        yaw=rng.uniform(-np.pi, np.pi, count),
    )


def sweeps(carried, start, way, neighbours, place):
    """Which of the objects (N, K) at places (N, K, 2) the carried objects (N,) sweep through, from starts (N, 2)."""
    others = Neighbours(neighbours.shape, neighbours.size, neighbours.yaw, place)
    return sweeps_through(Carried(carried.shape, carried.size, carried.yaw, start, way), others)


def test_outlines_overlap_where_drawn_ones_do():
    """To a millimetre, by which the corners of drawn ellipses lie inside of the true ones."""
    count = 300
    one, other = some_objects(count, 0), some_objects(count, 1000)
    apart = np.random.default_rng(0).uniform(-0.15, 0.15, (count, 2))
    still, pairs = np.zeros((count, 1, 3)), ((one, np.zeros((count, 2))), (other, apart))
    found = sweeps(one, np.zeros((count, 2)), still, take(other, np.s_[:, None]), apart[:, None])[:, 0]
    surely, maybe = (
        overlap(*(outlines(objects.replace(size=objects.size + wider), place) for objects, place in pairs))
        for wider in (-0.002, 0.002)
    )
    assert 0.2 < surely.mean() < 0.8
    assert found[surely].all()
    assert not found[~maybe].any()


def overlap_in_arrays(first, second, distance):
    """Whether outlines of pairs overlap, for distances (P, 2) between their middles, by separating axes."""
    turns = np.broadcast_to(np.arange(16) * np.pi / 16, (len(distance), 16))
    sides = np.stack([first.yaw, first.yaw + np.pi / 2, second.yaw, second.yaw + np.pi / 2], axis=1)
    heading = np.concatenate([sides, turns], axis=1)
    reach = sum(half_extent(take(objects, np.s_[:, None]), heading) for objects in (first, second))
    along = distance[:, :1] * np.cos(heading) + distance[:, 1:] * np.sin(heading)
    return (np.abs(along) < reach).all(axis=1)


def test_sweeps_are_those_of_every_moment_in_arrays():
    rng = np.random.default_rng(1)
    count, others, moments = 40, 7, 30
    carried, neighbours = some_objects(count, 5), take(some_objects(count * others, 7), np.arange(280).reshape(40, 7))
    start, place = rng.uniform(-0.1, 0.1, (count, 2)), rng.uniform(-0.5, 0.5, (count, others, 2))
    way = np.cumsum(rng.normal(scale=0.03, size=(count, moments, 3)), axis=1)
    meets = np.zeros((count, others), dtype=bool)
    for moment in range(moments):
        low = (way[:, None, moment, 2] < neighbours.size[..., 2]) & (way[:, None, moment, 2] > -BESIDE_DEPTH)
        for k in range(others):
            distance = place[:, k] - start - way[:, moment, :2]
            meets[:, k] |= low[:, k] & overlap_in_arrays(carried, take(neighbours, np.s_[:, k]), distance)
    assert 0.1 < meets.mean() < 0.9
    np.testing.assert_array_equal(sweeps(carried, start, way, neighbours, place), meets)


def straight_throw(count=3):
    """Throws from rest towards +y, rising."""
    limits = MotionLimits.t3kr(40.0)
    ahead = np.tile([0.0, 0.8, 0.6], (count, 1))
    segments = concatenate_records([accelerate(ahead, np.full(count, 0.2), limits), coast(np.full(count, 0.2))], axis=1)
    pick = np.random.default_rng(0).normal(size=(count, 3))
    resting = ThrowMotion.resting(pick)
    return resting.replace(segments=segments, release_time=segments.durations[:, :-1].sum(axis=1))


def test_ways_are_those_of_the_hand_and_then_of_a_falling_object_against_the_belt():
    motion, speed = straight_throw(), 0.5
    free_at = np.array([0.02, 0.06, 0.1])
    way = course(motion.path.table, motion.pick, free_at, speed)
    times = CHECK_INTERVAL * np.arange(way.shape[1])
    np.testing.assert_allclose(way[:, 0], 0.0)
    for row, free in enumerate(free_at):
        counted = times <= free + CHECK_AFTER_RELEASE
        t, there = times[counted], way[row, counted]
        np.testing.assert_allclose(there[:, 0], -speed * t, atol=1e-12)
        held = t <= free
        # Along the line of the throw while it is held, at 1200 m/s3 at first.
        np.testing.assert_allclose(there[held, 1] * 0.75, there[held, 2], atol=1e-12)
        early = t <= min(free, 0.04)
        np.testing.assert_allclose(there[early, 1], 0.8 * 1200.0 * t[early] ** 3 / 6, atol=1e-12)
        flying = t > free + CHECK_INTERVAL
        if flying.sum() > 2:
            second = np.diff(there[flying], 2, axis=0) / CHECK_INTERVAL**2
            np.testing.assert_allclose(second, np.tile([0.0, 0.0, -9.81], (len(second), 1)), atol=1e-6)


def test_ways_are_those_of_arrays_to_the_last_bit():
    motion, speed, free_at = straight_throw(), 0.37, np.array([0.021, 0.063, 0.1])
    last = free_at[:, None] + CHECK_AFTER_RELEASE
    times = np.minimum(np.arange(0.0, last.max(), CHECK_INTERVAL), last)
    held = np.minimum(times, free_at[:, None])
    hand, since = motion.path.sample(held), times - held
    way = hand.position - motion.pick[:, None] + since[..., None] * hand.velocity
    way[..., 2] -= 0.5 * 9.81 * since**2
    way[..., 0] -= speed * times
    np.testing.assert_array_equal(course(motion.path.table, motion.pick, free_at, speed), way)


def test_a_lost_object_that_falls_back_meets_what_it_falls_on():
    """Held, it would have risen over its neighbour."""
    motion = straight_throw(1)
    one = some_objects(1, 3).replace(shape=np.array([BOX]), size=np.full((1, 3), 0.05), yaw=np.zeros(1))
    other = take(one, np.s_[:, None])
    lost, held = (course(motion.path.table, motion.pick, np.array([free]), 0.25) for free in (0.05, 0.15))
    down = int(np.argmax(lost[0, :, 2] < -0.005))
    assert down > 0
    for way, meets in ((lost, True), (held, False)):
        assert sweeps(one, np.zeros((1, 2)), way, other, lost[:, [down], :2])[0, 0] == meets


def identity(objects):
    """Objects by a value that no two share."""
    return set(np.asarray(objects.mass).ravel().tolist())


@pytest.mark.parametrize(("dispatch", "tracking"), [("first", True), ("soonest", False)])
def test_what_was_knocked_rides_on_and_is_never_picked(tracking, dispatch):
    core = core_of(tracking=tracking, dispatch=dispatch)
    knocked, told = set(), 0
    for _ in range(10):
        stream = core.cell.source.stream
        before = copy.deepcopy(stream)
        context = core.context
        motion, held = core.cell._motion(context, core.plan(np.zeros((COUNT, 2)))[0])
        met = core.cell.source.find_collisions(context, motion, held)
        info = core.step(np.zeros((COUNT, 2))).info
        np.testing.assert_array_equal(info["disturbed"], met.any(axis=1))
        told += info["disturbed"].sum()
        knocked |= set(before.objects.mass[met].tolist())
        assert not knocked & identity(core.context.objects)
        # What is still known to be knocked is what was.
        assert set(stream.objects.mass[stream.knocked].tolist()) <= knocked
    assert told > 0
    assert knocked


@pytest.mark.parametrize("tracking", with_nightly((False, True), [True]))
def test_solid_neighbours_are_rarely_touched(tracking):
    rates = {}
    for neighbours in ("ghosts", "solid"):
        core = core_of(40, neighbours=neighbours, tracking=tracking)
        rates[neighbours] = np.mean([core.step(np.zeros((40, 2))).info["disturbed"].mean() for _ in range(6)])
    assert rates["ghosts"] > 0.1
    assert rates["solid"] < 0.3 * rates["ghosts"]


def test_where_every_pick_touches_somebody_the_first_is_taken():
    """Nobody starves: picks go on, and are told to disturb."""
    belt = {"speed": 0.25, "neighbours": "solid", "spacing": [0.02, 0.021], "lane_y": [-0.33, -0.32]}
    core = make_core(vary("waste_plain", belt=belt, fidelity="flight"), 12, picks="belt")
    info = [core.step(np.zeros((12, 2))).info["disturbed"] for _ in range(4)]
    assert np.mean(info) > 0.5


def test_ghosts_are_told_of_and_change_nothing_else():
    """Until the first throw that touches somebody, or picks that would, both worlds are one."""
    ghosts, solid = core_of(neighbours="ghosts"), core_of(neighbours="solid")
    same = np.array([same_bits(ghosts.context.pick[k], solid.context.pick[k]) for k in range(COUNT)])
    assert same.any()
    one, other = (core.step(np.zeros((COUNT, 2))).info for core in (ghosts, solid))
    np.testing.assert_array_equal(one["disturbed"][same], other["disturbed"][same])
    np.testing.assert_array_equal(one["landing_error"][same], other["landing_error"][same])


def test_without_a_belt_nobody_is_there():
    core = core_of(picks="independent")
    assert not core.step(np.zeros((COUNT, 2))).info["disturbed"].any()
