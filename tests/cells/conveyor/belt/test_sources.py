"""Which object the hand takes next: each rule against trying all objects one by one; whatever it says, none is lost."""

from itertools import product

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.belt.belt_picks import SHORTEST_QUEUE, BeltPicks
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.planning.motion.limits import LimitRows
from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core, vary

RULES = ("first", "soonest", "atc")
ROWS, THROWS = 6, 25
PATIENCE = 2.0


def belt(level="dense", **changes):
    """Picks at belts whose planner counts the objects it draws."""
    planner = PickPlanner(vary(level, patience=PATIENCE, **changes))
    drawn, draw = np.zeros(ROWS, dtype=int), planner.draw

    def counting(generators, rows, count):
        if len(generators) == ROWS:
            np.add.at(drawn, rows, count)
        return draw(generators, rows, count)

    planner.draw = counting
    return planner, BeltPicks(planner, [np.random.default_rng([9, row]) for row in range(ROWS)]), drawn


def thrown(planner, context):
    return planner.mover.throw(context.pick, context.plan, context.throw_limits, context.ceiling)


def choices(planner, source, row, motion, limits):
    """Every object of one belt that can be picked and thrown: (time until free, slack, mass), each tried alone."""
    belt, found = planner.config.belt, []
    for place in range(source.stream.length):
        objects, x = take(source.stream.queue, np.s_[row : row + 1, place]), source.stream.queue_x[row : row + 1, place]
        at = planner.pick_point(objects, x + belt.speed * motion.stop_time)
        meeting = planner.mover.reach(motion, at, limits)
        if not meeting.feasible[0]:
            continue
        context, good = planner.plan(objects, meeting.position)
        if good[0]:
            busy = meeting.time[0] + planner.config.motion.dwell + thrown(planner, context).stop_time[0]
            slack = (belt.pick_x[1] - meeting.position[0, 0]) / belt.speed - planner.config.motion.dwell
            found.append((busy, slack, objects.mass[0]))
    return found


@pytest.mark.parametrize("rule", RULES)
def test_the_rule_takes_what_trying_all_of_them_says(rule):
    planner, source, _ = belt(dispatch=rule)
    context, others = source.first(np.arange(ROWS)), 0
    for _ in range(8):
        motion = thrown(planner, context)
        all_of_them = [
            choices(planner, source, row, take(motion, [row]), take(LimitRows.t3kr(context.objects.percent), [row]))
            for row in range(ROWS)
        ]
        context = source.following(motion, LimitRows.t3kr(context.objects.percent)).context
        for row, found in enumerate(all_of_them):
            busy, slack, mass = np.array(found).T
            wanted = {
                "first": 0,
                "soonest": busy.argmin(),
                "atc": (np.exp(-slack / PATIENCE) / busy).argmax(),
            }[rule]
            assert context.objects.mass[row] == mass[wanted]
            others += wanted > 0
    assert (others > 0) == (rule != "first")


BELTS = [*product(("dense", "waste_plain"), ("edge", "centre"), RULES)]


@pytest.mark.parametrize(
    ("level", "gap", "rule"), with_nightly(BELTS, [case for case in BELTS if case != ("dense", "centre", "first")])
)
def test_every_object_drawn_is_thrown_or_let_go_or_still_on_the_belt(level, gap, rule):
    planner, source, drawn = belt(level, dispatch=rule, belt={"gap": gap})
    context, passed, seen = source.first(np.arange(ROWS)), np.zeros(ROWS, dtype=int), []
    for throws in range(1, THROWS + 1):
        passed += source.passed
        seen.append(context.objects.mass)
        np.testing.assert_array_equal(drawn, throws + passed + source.stream.length)
        left = source.stream.queue_x - planner.config.belt.pick_x[1]
        assert (left <= 0.0).all() or rule == "first"  # who has left the window is no longer in the queue
        context = source.following(thrown(planner, context), LimitRows.t3kr(context.objects.percent)).context
    assert all(len(set(masses)) == THROWS for masses in np.array(seen).T)  # and none is thrown twice
    assert passed.sum() > 0 or level == "waste_plain"


def test_an_object_that_is_not_taken_is_taken_later():
    """By any rule but `first` the hand comes back to objects that lie downstream of one it took."""
    planner, source, _ = belt(dispatch="soonest")
    context, back = source.first(np.arange(ROWS)), 0
    for _ in range(THROWS):
        skipped = [set(source.stream.queue.mass[row][x > context.pick[row, 0]])
                   for row, x in enumerate(source.stream.queue_x)]  # fmt: skip
        context = source.following(thrown(planner, context), LimitRows.t3kr(context.objects.percent)).context
        back += sum(mass in skipped[row] for row, mass in enumerate(context.objects.mass))
    assert back > 5


def test_what_is_seen_reaches_to_the_camera_where_the_best_is_taken():
    """Of a dense belt about all that lies between the camera and the end of the window is compared, not more."""
    _, source, _ = belt()
    source.first(np.arange(ROWS))
    belt_, last = source.stream._belt, source.stream.queue_x[:, -1]
    assert source.stream.length > SHORTEST_QUEUE
    assert (belt_.pick_x[0] - last).mean() == pytest.approx(belt_.pick_x[1] - belt_.camera_x, rel=0.15)
    assert belt(dispatch="first")[1].stream.length == SHORTEST_QUEUE


def test_the_info_tells_who_passed():
    """What is let go before the first throw counts with that throw; without a belt nothing passes."""
    core = make_core(vary("dense", dispatch="first", picks_per_shift=1000), ROWS, picks="belt")
    source, total = core.cell.source, np.zeros(ROWS, dtype=int)
    for _ in range(4):
        expected = source.passed.copy()
        info = core.step(np.zeros((ROWS, 2))).info
        np.testing.assert_array_equal(info["passed"], expected)
        total += info["passed"]
    assert total.sum() > 0
    assert (make_core("waste_plain", 3).step(np.zeros((3, 2))).info["passed"] == 0).all()


def test_an_episode_that_begins_anew_has_its_own_count():
    planner, source, _ = belt(dispatch="first")
    context = source.first(np.arange(ROWS))
    for _ in range(3):
        context = source.following(thrown(planner, context), LimitRows.t3kr(context.objects.percent)).context
    before = source.passed.copy()
    assert before.sum() > 0
    fresh = BeltPicks(PickPlanner(planner.config), [np.random.default_rng([1, row]) for row in range(ROWS)])
    source._generators[2] = np.random.default_rng([1, 2])
    source.first(np.array([2]))
    fresh.first(np.arange(ROWS))
    assert source.passed[2] == fresh.passed[2]
    np.testing.assert_array_equal(np.delete(source.passed, 2), np.delete(before, 2))
