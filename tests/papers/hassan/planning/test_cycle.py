"""Whole cycles: the sum of moves, the clock, limits, release states, rows without a plan."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from papers.hassan.planning.blend import begin_times, blend, throw_move
from papers.hassan.planning.cycle import CycleRules, CycleTask, horizontal_throw, min_time_throw, pick_and_place
from pnt_gym.planning import (
    EllipticWorkspace,
    InfeasibleThrow,
    MotionLimits,
    Reason,
    Segments,
    landing_point,
    min_time_scurve,
    rest_to_rest,
)

PICKS = np.array([(-0.2, -0.25, -0.85), (-0.2, -0.35, -0.85), (-0.3, -0.35, -0.85)])
NEXT = np.roll(PICKS, -1, axis=0)
INSIDE, OUTSIDE = np.tile((0.3, 0.4, -0.85), (3, 1)), np.tile((0.45, 0.65, -0.85), (3, 1))
WORKSPACE = EllipticWorkspace()
BUILDERS = (pick_and_place, horizontal_throw, min_time_throw)

coordinates = st.floats(-1.0, 1.0).map(lambda x: round(x, 4))
points = st.tuples(coordinates, coordinates, coordinates)
overlaps = st.sampled_from(["none", "jerk", "ramp"])


def planned(builder, *args):
    return builder(CycleTask.of(*args))


def moves_between(corners, limits):
    return [rest_to_rest(b - a, limits) for a, b in pairwise(corners)]


@settings(deadline=None, max_examples=60)
@given(corners=st.lists(points, min_size=2, max_size=6), percent=st.floats(5.0, 100.0), overlap=overlaps)
def test_a_blend_is_the_sum_of_its_moves(corners, percent, overlap):
    limits = MotionLimits.t3kr(percent)
    corners = [np.array([corner]) for corner in corners]
    moves = moves_between(corners, limits)
    begins = begin_times(moves, overlap)
    path = blend(corners[0], moves, begins)
    np.testing.assert_allclose(path.end, corners[-1], rtol=0, atol=1e-10)
    times = np.linspace(0.0, path.duration[0], 301)
    # The oracle reads every move off the folded S-curve and knows nothing of jerks and borders.
    position, velocity, acceleration = (np.zeros((301, 3)) + x for x in (corners[0][0], 0.0, 0.0))
    for (a, b), begin in zip(pairwise(corners), begins[0], strict=True):
        way = float(np.linalg.norm(b - a))
        direction = (b - a)[0] / way if way > 0.0 else np.zeros(3)
        s, v, c = min_time_scurve(way, limits).sample(times - begin)
        position += s[:, None] * direction
        velocity += v[:, None] * direction
        acceleration += c[:, None] * direction
    found = path.sample(times)
    np.testing.assert_allclose(found.position[0], position, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.velocity[0], velocity, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.acceleration[0], acceleration, rtol=0, atol=1e-6)


@settings(deadline=None, max_examples=60)
@given(corners=st.lists(points, min_size=3, max_size=5), percent=st.floats(5.0, 100.0))
def test_what_each_overlap_costs(corners, percent):
    limits = MotionLimits.t3kr(percent)
    corners = [np.array([corner]) for corner in corners]
    moves = moves_between(corners, limits)
    paths = {rule: blend(corners[0], moves, begin_times(moves, rule)) for rule in ("none", "jerk", "ramp")}
    peaks = {rule: path.peak_ratios(limits) for rule, path in paths.items()}
    assert paths["ramp"].duration <= paths["jerk"].duration + 1e-12
    assert paths["jerk"].duration <= paths["none"].duration + 1e-12
    for rule, greatest in (("none", (1.0, 1.0)), ("jerk", (1.0, 2.0)), ("ramp", (2.0, 2.0))):
        assert peaks[rule].velocity[0] <= 1.0 + 1e-9
        assert peaks[rule].acceleration[0] <= greatest[0] + 1e-9
        assert peaks[rule].jerk[0] <= greatest[1] + 1e-9


def test_moves_do_not_reach_across_a_stop():
    limits = MotionLimits.t3kr(40)
    moves = [rest_to_rest(np.array([[0.3, 0.0, 0.0]]), limits) for _ in range(3)]
    each = moves[0].durations.sum()
    ramp = moves[0].durations[0, :3].sum()
    np.testing.assert_allclose(begin_times(moves, "ramp", stops=(1,))[0], [0.0, each - ramp, 2.0 * each - ramp])


def test_blending_refuses_what_is_no_move():
    move = rest_to_rest(np.ones((1, 3)), MotionLimits.t3kr(40))
    with pytest.raises(ValueError, match="at least one move"):
        begin_times([], "ramp")
    with pytest.raises(ValueError, match="7 segments"):
        begin_times([Segments(np.ones((1, 3)), np.ones((1, 3, 3)))], "ramp")
    with pytest.raises(ValueError, match="unknown overlap 'half'; known are none, jerk, ramp"):
        begin_times([move], "half")


def test_a_throw_brakes_at_once():
    limits = MotionLimits.t3kr(40)
    move = throw_move(np.array([[1.0, 0.0, 0.0]]), np.array([0.3]), limits)
    path = blend(np.zeros((1, 3)), [move], np.zeros((1, 1)))
    curve = min_time_scurve(0.6, limits)
    ramp = curve.velocity / curve.acceleration + curve.acceleration / curve.jerk
    assert path.duration[0] == pytest.approx(0.3 / curve.velocity + 1.5 * ramp, rel=1e-12)
    assert path.end[0, 0] == pytest.approx(0.3 + 0.5 * curve.velocity * ramp, rel=1e-12)


@pytest.mark.parametrize("builder", BUILDERS)
@pytest.mark.parametrize("overlap", ["none", "jerk", "ramp"])
def test_a_cycle_runs_from_pick_to_pick_and_hits(builder, overlap):
    rules = CycleRules(overlap=overlap)
    cycle = planned(builder, PICKS, INSIDE, NEXT, MotionLimits.t3kr(30), rules, WORKSPACE)
    assert cycle.feasible.all()
    assert cycle.require() is cycle
    np.testing.assert_allclose(cycle.path.start, PICKS, rtol=0, atol=0)
    np.testing.assert_allclose(cycle.path.end, NEXT, rtol=0, atol=1e-12)
    for quantity in cycle.path.knots[1:]:
        np.testing.assert_allclose(quantity[:, (0, -1)], 0.0, rtol=0, atol=1e-9)
    # The release state of the blended path is that of the plan: no other move disturbs it.
    motion = cycle.path.sample(cycle.release_time[:, None])
    np.testing.assert_allclose(motion.position[:, 0], cycle.release_position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.velocity[:, 0], cycle.release_velocity, rtol=0, atol=1e-10)
    landing = landing_point(motion.position[:, 0], motion.velocity[:, 0], INSIDE[0, 2] - 1e-12)
    miss = np.abs(landing - INSIDE)[:, :2].max(axis=1)
    np.testing.assert_allclose(miss, 0.0 if builder is pick_and_place else rules.tolerance, rtol=0, atol=1e-9)


def test_phases_are_named_and_end_in_order():
    limits = MotionLimits.t3kr(30)
    expected = {
        pick_and_place: ("lift", "carry", "place", "leave", "return", "approach"),
        horizontal_throw: ("lift", "throw", "brake", "return", "approach"),
        min_time_throw: ("throw", "brake", "return", "approach"),
    }
    for builder, names in expected.items():
        cycle = planned(builder, PICKS, INSIDE, NEXT, limits)
        assert cycle.phases == names
        assert (np.diff(cycle.phase_ends, axis=1) > 0.0).all()
        np.testing.assert_allclose(cycle.phase_ends[:, -1], cycle.duration, rtol=1e-12)
        last = names.index("place" if builder is pick_and_place else "throw")
        np.testing.assert_allclose(cycle.phase_ends[:, last], cycle.release_time, rtol=1e-12)


def test_samples_follow_the_path_and_the_grip_opens_at_the_release():
    cycle = planned(min_time_throw, PICKS, INSIDE, NEXT, MotionLimits.t3kr(30))
    run = cycle.sample()
    assert run.time.shape == run.grip.shape == run.position.shape[:2]
    np.testing.assert_allclose(np.diff(run.time, axis=1), 1.0 / 2500.0)
    assert (run.time[:, -1] >= cycle.duration.max()).all()
    np.testing.assert_array_equal(run.grip, run.time < cycle.release_time[:, None])
    np.testing.assert_allclose(run.position[:, -1], NEXT, rtol=0, atol=1e-12)
    # Within a piece the jerk is the slope of the acceleration; a border falls into few of the steps.
    slope = np.diff(run.acceleration, axis=1) * 2500.0
    same = (run.jerk[:, 1:] == run.jerk[:, :-1]).all(axis=2)
    assert same.mean() > 0.9
    np.testing.assert_allclose(slope[same], run.jerk[:, :-1][same], rtol=0, atol=1e-3)
    few = cycle.sample([0.0, 0.1])
    assert few.position.shape == (3, 2, 3)
    with pytest.raises(ValueError, match="rate must be positive"):
        cycle.sample(rate=0.0)


def test_rows_do_not_know_of_each_other():
    percent = np.array([15.0, 30.0, 40.0])
    for builder in BUILDERS:
        together = planned(builder, PICKS, INSIDE, NEXT, MotionLimits.t3kr(percent))
        for k in range(3):
            alone = planned(builder, PICKS[k : k + 1], INSIDE[:1], NEXT[k : k + 1], MotionLimits.t3kr(percent[k]))
            assert alone.duration[0] == together.duration[k]
            assert alone.release_time[0] == together.release_time[k]
            np.testing.assert_array_equal(alone.path.sample([0.3]).position[0], together.path.sample([0.3]).position[k])


def test_a_row_without_a_plan_is_marked_and_leaves_the_others_alone():
    targets = INSIDE.copy()
    targets[1] = PICKS[1] + np.array([0.0, 0.0, 0.05])
    for builder in (horizontal_throw, min_time_throw):
        cycle = planned(builder, PICKS, targets, NEXT, MotionLimits.t3kr(30), CycleRules(), WORKSPACE)
        whole = planned(builder, PICKS, INSIDE, NEXT, MotionLimits.t3kr(30), CycleRules(), WORKSPACE)
        assert cycle.feasible.tolist() == [True, False, True]
        assert cycle.reason[1] == Reason.NO_REACH
        for values in (cycle.duration, cycle.release_time, cycle.release_position, cycle.phase_ends):
            assert np.isnan(values[1]).all()
        assert all(np.isnan(ratio[1]) for ratio in cycle.peak_ratios(MotionLimits.t3kr(30)))
        np.testing.assert_array_equal(cycle.duration[[0, 2]], whole.duration[[0, 2]])
        np.testing.assert_array_equal(cycle.path.sample([0.2]).position[1, 0], PICKS[1])
        assert not cycle.sample([0.0]).grip[1, 0]
        with pytest.raises(InfeasibleThrow, match="row 1"):
            cycle.require()


@pytest.mark.parametrize(
    ("builder", "percent", "rules", "reason"),
    [
        # The target can be thrown to but not reached.
        (pick_and_place, 40, CycleRules(), Reason.WORKSPACE),
        # From a lower lift the object is carried further, and the hand cannot stop inside.
        (horizontal_throw, 35, CycleRules(lift=0.06), Reason.WORKSPACE),
        (horizontal_throw, 5, CycleRules(), Reason.WORKSPACE),
        (horizontal_throw, 40, CycleRules(lift=0.12), Reason.CEILING),
        (horizontal_throw, 40, CycleRules(lift=0.0), Reason.ELEVATION),
        (min_time_throw, 40, CycleRules(rise=0.0), Reason.CEILING),
        (min_time_throw, 5, CycleRules(), Reason.WORKSPACE),
    ],
)
def test_impossible_cells_say_why(builder, percent, rules, reason):
    cycle = planned(builder, PICKS, OUTSIDE, NEXT, MotionLimits.t3kr(percent), rules, WORKSPACE)
    assert not cycle.feasible.any()
    assert (cycle.reason == reason).all()
    assert np.isnan(cycle.duration).all()
    with pytest.raises(InfeasibleThrow) as caught:
        cycle.require()
    assert caught.value.reason == reason


def test_no_rows_give_no_cycles():
    none = np.zeros((0, 3))
    for builder in BUILDERS:
        cycle = planned(builder, none, none, none, MotionLimits.t3kr(40))
        assert len(cycle) == 0
        assert cycle.sample().position.shape == (0, 1, 3)


@pytest.mark.parametrize("builder", BUILDERS)
def test_points_outside_and_shapes_are_refused(builder):
    limits, away = MotionLimits.t3kr(40), PICKS + np.array([0.0, 0.7, 0.0])
    with pytest.raises(ValueError, match=r"next pick .* lies outside the workspace"):
        planned(
            builder, PICKS, INSIDE, np.where(np.arange(3)[:, None] == 1, PICKS - 0.6, NEXT), limits, None, WORKSPACE
        )
    with pytest.raises(ValueError, match=r"^pick .* lies outside the workspace"):
        planned(builder, PICKS - np.array([0.4, 0.0, 0.0]), INSIDE, NEXT, limits, None, WORKSPACE)
    with pytest.raises(ValueError, match="one row each"):
        planned(builder, PICKS, INSIDE[:2], NEXT, limits)
    with pytest.raises(ValueError, match="one row each"):
        planned(builder, PICKS, INSIDE, NEXT[:2], limits)
    with pytest.raises(ValueError, match="finite"):
        planned(builder, PICKS, np.full((3, 3), np.nan), away, limits)
    with pytest.raises(ValueError, match="2 throws but 3"):
        planned(builder, PICKS, INSIDE, NEXT, MotionLimits.t3kr(np.array([30.0, 40.0])))


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"lift": -0.1}, "lift must be finite and not negative"),
        ({"approach": np.nan}, "approach must be finite"),
        ({"tolerance": -1e-9}, "tolerance must be finite"),
        ({"rise": np.inf}, "rise must be finite, or None"),
        ({"overlap": "full"}, "unknown overlap 'full'; known are none, jerk, ramp"),
    ],
)
def test_bad_rules_are_refused(change, word):
    with pytest.raises(ValueError, match=word):
        CycleRules(**change)
