"""A shift of a line, decision by decision: nothing is lost or taken twice, robots act in turn, the books are right."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pnt_gym.cells.conveyor.movers.tracking import stop_motion
from pnt_gym.cells.line.outcome import shift_figures
from pnt_gym.cells.line.rows import Fate
from pnt_gym.planning.motion.limits import LimitRows
from tests.tools.line import Ledger, begun, decided, with_table

DOWN = [{"robot": "second", "start": 2.0, "end": 6.0}, {"robot": "first", "start": 7.0, "end": 7.5}]
LEVELS = {
    "single": {"base": "single", "duration": 12.0},
    "speed": {"base": "speed", "duration": 12.0, "arrivals": {"rate": 1.5}},
    "line": {"base": "line3", "duration": 8.0},
    "burst": {"base": "skills3_burst", "duration": 10.0, "camera": 0.4, "down": DOWN},
    "flight": {"base": "skills3_burst", "duration": 6.0, "throws": "flight"},
    "full": {"base": "skills3", "duration": 5.0, "throws": "full"},
}


def level_of(name, tables):
    level = LEVELS[name]
    return level if "throws" in level else with_table(level, tables)


def shift(cell, random, invalid=0.0):
    """Every decision of a shift, with the state before and after it."""
    while not cell.over.all():
        before = cell.state
        taken = cell.take(decided(cell, random, invalid))
        yield before, taken, cell.state


def counted(cell, row):
    """How many objects have come into the camera's sight, and where they are now, each counted by itself."""
    config, state = cell.config, cell.state
    clock = min(float(state.clock[row]), config.duration)
    low, high = config.reach
    x = cell.stream.x[row] + config.cell.belt.speed * clock
    fate = state.accounts["fate"][row]
    rides = fate == Fate.RIDES
    places = {
        "on the belt": int((rides & (x >= low) & (x <= high)).sum()),
        "past its end": int((rides & (x > high)).sum()),
        **{one.name: int((fate == one).sum()) for one in Fate if one is not Fate.RIDES},
    }
    came = (x >= low) | ~rides
    return int(came.sum()), places


@pytest.mark.parametrize("name", LEVELS)
@settings(max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 10**6), invalid=st.sampled_from([0.0, 0.2]))
def test_every_object_is_somewhere_and_none_is_taken_twice(name, seed, invalid, tables):
    cell, random, ledger = begun(level_of(name, tables), 1, seed), np.random.default_rng(seed), Ledger()
    tries = 0
    for _, taken, _ in shift(cell, random, invalid):
        ledger.enter(taken, 0, cell.config.duration)
        ledger.agrees(cell, 0)
        came, places = counted(cell, 0)
        assert came == sum(places.values())
        tries += int(taken.valid[0])
    # What is decided beyond the end of the belt that was drawn would be lost unseen.
    assert cell.stream.x[0, -1] + cell.config.cell.belt.speed * cell.config.duration < cell.config.reach[0]
    assert tries == sum(ledger.tries.values()) > 0


@pytest.mark.parametrize("name", LEVELS)
def test_robots_act_in_the_order_in_which_they_become_free(name, tables):
    cell, random = begun(level_of(name, tables), 3, 5), np.random.default_rng(5)
    many = 0
    for before, taken, after in shift(cell, random, 0.1):
        going = ~(before.clock >= cell.config.duration)
        assert (after.clock >= before.clock).all()
        assert (taken.start[going] == before.clock[going]).all()
        rows = np.arange(3)
        # Whoever has just decided is free when it has done so, and nobody else became free before this decision.
        assert (before.arms["free"][rows, before.robot] == before.clock)[going].all()
        assert (before.clock == before.arms["free"].min(axis=1))[going].all()
        assert (taken.robot == before.robot).all()
        on = ~(after.clock >= cell.config.duration)
        assert (after.arms["free"][rows, after.robot] == after.clock)[on].all()
        assert after.choices["real"][on].any(axis=1).all()
        assert not after.choices["real"][~on].any()
        many += int(going.sum())
    assert many > 10


def where(cell, state):
    """Where the objects of all choices are when each is to be lifted, from the base of the robot (N, CHOICES) [m]."""
    choices, config = state.choices, cell.config
    rows = np.arange(len(state.clock))[:, None]
    then = state.clock[:, None] + choices["lift"]
    x = cell.stream.x[rows, choices["index"]] + config.cell.belt.speed * then
    return x - config.robot_x()[state.robot][:, None]


@pytest.mark.parametrize("name", LEVELS)
def test_a_lift_is_where_the_object_then_is_in_the_window_and_in_time(name, tables):
    cell, random, config = begun(level_of(name, tables), 2, 3), np.random.default_rng(3), None
    found = 0
    for _, taken, state in shift(cell, random):
        config, real = cell.config, state.choices["real"]
        x, lift = where(cell, state)[real], state.choices["lift"][real]
        np.testing.assert_allclose(state.choices["pick"][..., 0][real], x, rtol=0, atol=1e-9)
        low, high = config.cell.lift_x
        assert ((x > low - 1e-9) & (x < high + 1e-9)).all()
        assert (lift > config.cell.motion.dwell).all()
        assert (lift <= config.horizon + config.cell.motion.dwell).all()
        assert (state.choices["wait"][real] >= 0.0).all()
        assert (state.choices["wait"][real] < lift).all()
        assert (state.choices["throwing"][real] > 0.0).all()
        # `leave`: then the object is at the end of the window.
        end = x + config.cell.belt.speed * (state.choices["leave"][real] - lift)
        np.testing.assert_allclose(end, config.cell.belt.pick_x[1], rtol=0, atol=1e-9)
        found += int(real.sum())
        ends = taken.valid & taken.results["picked"]
        assert (taken.end[ends] > taken.start[ends]).all()
    assert found > 50


@pytest.mark.parametrize("name", LEVELS)
def test_what_one_robot_has_chosen_is_never_offered_to_another(name, tables):
    cell, random = begun(level_of(name, tables), 2, 8), np.random.default_rng(8)
    reserved = [dict[int, float](), dict[int, float]()]
    offered = 0
    for before, taken, state in shift(cell, random):
        for row in np.flatnonzero(taken.valid):
            lift = before.clock[row] + before.choices["lift"][row][before.choices["index"][row] == taken.index[row]]
            until = np.inf if taken.results["picked"][row] else float(lift.min())
            reserved[row][int(taken.index[row])] = until
        for row in range(2):
            for index in state.choices["index"][row][state.choices["real"][row]]:
                assert reserved[row].get(int(index), 0.0) <= state.clock[row]
                offered += 1
    assert offered > 50


def test_what_a_cup_did_not_lift_is_offered_again_here_and_downstream(tables):
    level = with_table({"base": "line3", "duration": 12.0}, tables, picked=(0.0, 0.0, 0.0, 0.0))
    cell, random = begun(level, 2), np.random.default_rng(0)
    by = [dict[int, list[int]](), dict[int, list[int]]()]
    for before, taken, state in shift(cell, random):
        assert not taken.results["picked"].any()
        for row in np.flatnonzero(taken.valid):
            index, robot = int(taken.index[row]), int(taken.robot[row])
            by[row].setdefault(index, []).append(robot)
            one = before.choices["index"][row] == index
            limits = LimitRows.t3kr(before.choices["percent"][row][one])
            rode = stop_motion(before.choices["pick"][row][one], limits, cell.config.cell.belt.speed)
            # It costs the way there, the dwell, and what it takes to stand still.
            spent = before.choices["lift"][row][one] + rode.stop_time
            assert np.abs(taken.end[row] - taken.start[row] - spent).min() < 1e-12
            hand = state.arms["hand"][row, robot]
            assert np.abs(rode.stop - hand).max(axis=1).min() < 1e-12
    assert (cell.state.accounts["fate"] == Fate.RIDES).all()
    robots = [found for row in by for found in row.values()]
    assert any(len(found) != len(set(found)) for found in robots)
    assert any(len(set(found)) > 1 for found in robots)
    assert all(found == sorted(found) for found in robots)  # a belt does not run back


@pytest.mark.parametrize("count", [1, 4])
def test_a_robot_that_is_down_does_nothing_then(count, tables):
    cell, random = begun(level_of("burst", tables), count, 2), np.random.default_rng(2)
    windows = [(0, 7.0, 7.5), (1, 2.0, 6.0)]
    acted = {0: 0, 1: 0, 2: 0}
    for before, taken, _ in shift(cell, random):
        going = before.clock < cell.config.duration
        for robot, start, end in windows:
            begins = taken.start[going & (taken.robot == robot)]
            assert not ((begins >= start) & (begins < end)).any()
        during = going & (taken.start >= 2.0) & (taken.start < 6.0)
        for robot in taken.robot[during]:
            acted[int(robot)] += 1
    assert acted[0] > 0
    assert acted[1] == 0
    assert acted[2] > 0


def test_robots_that_are_down_all_the_time_cost_and_bring_nothing(tables):
    cell = begun(with_table({**LEVELS["single"], "down": [{"robot": "first", "start": 0.0, "end": 99.0}]}, tables))
    assert cell.over.all()
    taken = cell.take(np.zeros(1, dtype=np.int64))
    assert not taken.valid.any()
    assert (taken.elapsed, taken.value) == (0.0, 0.0)


def test_lines_whose_robots_wait_and_stand_still_do_so_each_by_itself(tables):
    """Rows in which nobody can decide yet are looked at again, in no particular order of what kept them."""
    down = [{"robot": "first", "start": 2.5 * k, "end": 2.5 * k + 0.3 + 0.1 * k} for k in range(1, 7)]
    level = with_table({"base": "single", "duration": 20.0, "arrivals": {"rate": 0.3}, "down": down}, tables)
    together = begun(level, 6, 30)
    alone = [begun(level, 1, 30 + row) for row in range(6)]
    for _ in range(12):
        for row, one in enumerate(alone):
            assert together.state.clock[row] == one.state.clock[0]
            assert (together.state.choices["real"][row] == one.state.choices["real"][0]).all()
        for cell in (together, *alone):
            cell.take(np.zeros(cell.count, dtype=np.int64))


@pytest.mark.parametrize("name", ["single", "speed", "burst", "flight"])
def test_the_figures_of_a_shift_are_those_of_its_steps(name, tables):
    rows = 2
    cell, random = begun(level_of(name, tables), rows, 11), np.random.default_rng(11)
    ledgers, busy, picks = [Ledger() for _ in range(rows)], np.zeros((rows, len(cell.config.robots))), 0
    for before, taken, _ in shift(cell, random):
        going = before.clock < cell.config.duration
        for row in np.flatnonzero(going):
            ledgers[row].enter(taken, row, cell.config.duration)
            if taken.valid[row]:
                busy[row, taken.robot[row]] += taken.end[row] - taken.start[row] - taken.attempt.chosen["wait"][row]
    figures = shift_figures(cell.config, cell.chooser.tables, cell.state, cell.stream, np.arange(rows))
    config, kinds = cell.config, cell.stream.objects.kind
    end = config.reach[1] - config.cell.belt.speed * config.duration
    for row, ledger in enumerate(ledgers):
        one = {name: values[row] for name, values in figures.items()}
        fates = {index: fate for index, (fate, _, _) in ledger.taken.items() if fate is not Fate.HELD}
        gone = [i for i in np.flatnonzero(cell.stream.x[row] > end) if i not in ledger.taken]
        ours = [i for i, fate in fates.items() if fate is Fate.SORTED]
        binned = [i for i, fate in fates.items() if fate in (Fate.SORTED, Fate.MISPLACED)]
        worth, minutes = cell.stream.riders["worth"][row], config.duration / 60.0
        came = [*fates, *gone]
        assert one["shift_value_per_min"] == pytest.approx(ledger.value / minutes)
        assert one["shift_sorted_per_min"] == pytest.approx(len(ours) / minutes)
        assert one["shift_attempts"] == sum(ledger.tries.values())
        assert one["shift_objects"] == len(came)
        assert one["shift_sorted"] == len(ours)
        assert one["shift_misplaced"] == len(binned) - len(ours)
        assert one["shift_on_floor"] == sum(fate is Fate.FLOOR for fate in fates.values())
        assert one["shift_passed"] == len(gone)
        assert one["shift_recovery"] == pytest.approx(len(ours) / len(came))
        assert one["shift_value_recovery"] == pytest.approx(worth[ours].sum() / worth[came].sum())
        assert one["shift_purity"] == pytest.approx(len(ours) / len(binned), nan_ok=True)
        for item in range(4):
            of_it = [i for i in came if kinds[row, i] == item]
            share = sum(i in ours for i in of_it) / len(of_it) if of_it else np.nan
            assert one["shift_recovery_by_item"][item] == pytest.approx(share, nan_ok=True)
            assert one["shift_passed_by_item"][item] == sum(kinds[row, i] == item for i in gone)
        assert one["shift_passed_value_per_min"] == pytest.approx(worth[gone].sum() / minutes)
        tried = sum(i in ledger.tries for i in gone) / len(gone) if gone else np.nan
        assert one["shift_passed_tried"] == pytest.approx(tried, nan_ok=True)
        by = [robot for index, (_, robot, _) in ledger.taken.items() if index in fates]
        assert one["shift_picks_by_robot"].tolist() == np.bincount(by, minlength=len(config.robots)).tolist()
        np.testing.assert_allclose(one["shift_utilisation"], np.minimum(busy[row] / config.duration, 1.0))
        picks += len(came)
    assert picks > 20
