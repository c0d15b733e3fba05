"""What robots can choose is what the conveyor's planner says of each case by itself: the same times, the same cases."""

import numpy as np
import pytest

from benchmarks.line_exactness import compare_shift
from pnt_gym.arrays import take
from pnt_gym.cells.line.config import LineConfig
from tests.tools.line import THREE_BINS, begun, chances, decided, with_table
from tests.tools.nightly import with_nightly

LEVELS = {
    "single": {"base": "single"},
    "speed": {"base": "speed", "arrivals": {"rate": 2.0}},
    "skills3": {"base": "skills3"},
    "plain": {"base": "single", "cell": {"belt": {"tracking": False}, "motion": {"reserve": 0.0}}},
    "three bins": {"base": "single", "robots": [{"name": "first", "x": 0.0, "bins": THREE_BINS}]},
}


@pytest.mark.parametrize("name", LEVELS)
def test_every_case_is_the_planners_own_and_none_is_missing(name, tables):
    """A sample of `python benchmarks/line_exactness.py`."""
    found = compare_shift(with_table(LEVELS[name], tables), cases=250, seed=1)
    assert found.cases >= 250
    assert found.unlike == 0
    assert found.feasible > 20
    assert found.worst < 1e-9
    assert found.hidden > 0 or name != "speed"  # more than can be shown at once


@pytest.mark.parametrize("name", ["speed", "skills3", "plain", "three bins"])
def test_what_is_done_is_planned_as_it_was_when_it_was_chosen(name, tables):
    """Though it is planned again, beside other throws."""
    level = with_table({**LEVELS[name], "duration": 12.0}, tables)
    cell, random = begun(level, 5, 7), np.random.default_rng(7)
    seen = 0
    while not cell.over.all():
        choice, state = decided(cell, random), cell.state
        one = take(state.choices, (np.arange(5), choice))
        context = cell.take(choice).context
        for row in np.flatnonzero(one["real"]):
            planner, own = cell.chooser.planner_of(int(state.robot[row])), take(context, np.array([row]))
            motion = planner.mover.throw(own.pick, own.plan, own.throw_limits, own.ceiling)
            assert planner.mover.is_feasible(own.pick, own.plan, own.throw_limits).all()
            np.testing.assert_allclose(motion.stop_time, one["throwing"][row], rtol=1e-12)
            np.testing.assert_allclose(motion.stop[0], one["stop"][row], atol=1e-12)
            np.testing.assert_array_equal(own.pick[0], one["pick"][row])
            np.testing.assert_array_equal((own.target - own.pick)[0, :2], one["away"][row])
            assert (own.bin, own.objects.percent) == (one["bin"][row], one["percent"][row])
            assert own.objects.measured.kind == cell.stream.objects.measured.kind[row, one["index"][row]]
            seen += 1
    assert seen > 20


def test_an_object_of_a_class_that_a_robot_does_not_take_is_no_choice_of_its(tables):
    cell, random = begun(with_table({"base": "skills3", "duration": 20.0}, tables), 2), np.random.default_rng(0)
    allowed, met = ({0, 1, 2, 3}, {0, 1}, {0}), [set(), set(), set()]
    while not cell.over.any():
        state = cell.state
        for row in range(2):
            robot, real = int(state.robot[row]), state.choices["real"][row]
            kinds = {int(k) for k in cell.stream.objects.measured.kind[row, state.choices["index"][row][real]]}
            assert kinds <= allowed[robot]
            met[robot] |= kinds
        cell.take(decided(cell, random))
    assert tuple(met) == allowed


@pytest.mark.parametrize("name", with_nightly(("single", "speed", "skills3"), ["skills3"]))
def test_the_best_come_first_and_each_is_what_is_known_of_it(name, tables):
    level = with_table({**LEVELS[name], "duration": 20.0, "value": {"spread": 1.0}}, tables)
    cell, random, config = begun(level, 2, 5), np.random.default_rng(5), LineConfig.load(level)
    table, speed = chances(config), config.cell.belt.speed
    seen = 0
    while not cell.over.any():
        state, stream = cell.state, cell.stream
        for row in range(2):
            choices, real = take(state.choices, row), state.choices["real"][row]
            assert (np.diff(real.astype(int)) <= 0).all()  # the first places are the real ones
            score = choices["value"] * choices["chance"] - config.price_of_time * (
                choices["lift"] + choices["throwing"]
            )
            assert (np.diff(score[real]) <= 1e-12).all()
            robot, base = int(state.robot[row]), config.robot_x()
            x = stream.x[row] + speed * state.clock[row]
            free = (state.accounts["since"][row] <= state.clock[row]) & (x >= config.reach[0]) & (x <= config.reach[1])
            for k in np.flatnonzero(real):
                one, index = take(choices, k), int(choices["index"][k])
                kind = stream.objects.measured.kind[row, index]
                assert free[index]
                assert one["value"] == stream.riders["worth"][row, index]
                setting = np.flatnonzero(table.percent == one["percent"])[0]
                into = config.cell_of(robot).bins.fixed[one["bin"]]
                away = np.hypot(into.x - one["pick"][0], into.y - one["pick"][1])
                of = int((away > table.edges).sum())
                assert one["chance"] == pytest.approx(table.picked[kind] * table.landed[kind, setting, of])
                able = config.can_take()
                then = x + speed * (one["lift"] + one["throwing"])
                near = np.abs(then - base[robot] - one["stop"][0]) <= 0.25
                own = free & able[robot, stream.objects.measured.kind[row]]
                assert one["crowd"] == (near & own).sum() - int((near & own)[index])
                heirs = [r for r in range(robot + 1, len(base)) if able[r, kind]]
                assert one["heirs"] == len(heirs)
                window = base[heirs[0]] + config.cell.belt.pick_x[0] if heirs else x[index]
                assert one["reaches"] == pytest.approx(max(window - x[index], 0.0) / speed)
                heir = free & able[heirs[0], stream.objects.measured.kind[row]] if heirs else free & False
                between = heir & (x >= x[index]) & (x <= window)
                assert one["queue"] == between.sum()  # itself, too
                seen += 1
        cell.take(decided(cell, random))
    assert seen > 100
