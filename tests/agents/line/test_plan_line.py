"""What a line needs: plans, tables and the sentence at the end."""

import json

import numpy as np
import pytest

import pnt_gym
from agents.ground.cli import UsageError
from agents.ground.metrics import Interval
from agents.judging.losses import FATES, Counted, Fates
from agents.judging.shifts import Shifts
from agents.line import reasons, verdict
from agents.line.changes import Gain, possible_changes
from agents.line.goal import Goal
from agents.line.plans import (
    Conditions,
    Planned,
    Sweep,
    line_up,
    make_plans,
    money_per_hour,
    standstill,
    table_spread,
    with_standstill,
)
from agents.line.reasons import check_text, main_losses, reason, worst_items
from pnt_gym.cells.line.chances import shipped_table
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError
from tests.tools.commands import output_of, refused
from tests.tools.plant import plant, plant_text

LEVEL = LineConfig.load("skills3")
TRIED = ("one more robot", "cups that always seal")
"""Changes of the plant that are tried."""


def test_more_robots_than_a_level_has_stand_on_as_its_last():
    robots = line_up(LEVEL, 4)
    assert [robot.x for robot in robots] == pytest.approx([0.0, 1.4, 2.8, 4.2])
    assert robots[3].skills == LEVEL.robots[2].skills
    assert len({robot.name for robot in robots}) == 4


def test_every_combination_is_a_plan_with_the_stream_of_the_level():
    plans = list(
        make_plans(LEVEL, Sweep(robots=(2, 3), speeds=(0.3, 0.4), percents=(30.0, 40.0), skills=("level", "all")))
    )
    assert len(plans) == 16
    for told, config in plans:
        assert len(config.robots) == told["robots"]
        assert config.cell.belt.speed == told["belt_speed"]
        assert config.cell.limits.percent == (told["percent"],)
        assert config.arrivals == LEVEL.arrivals
        assert config.can_take().all() == (told["skills"] == "all")


def test_a_robot_is_down_from_the_middle_of_the_shift_on():
    for robot in ("second", "2"):
        config = with_standstill(LEVEL, standstill(LEVEL, Sweep((3,), minutes=30.0, down=f"{robot}:10")))
        assert [(one.robot, one.start, one.end) for one in config.down] == [("second", 900.0, 1500.0)]
    assert with_standstill(LEVEL, standstill(LEVEL, Sweep((3,)))) is LEVEL


def test_plans_without_the_robot_that_stands_have_no_standstill() -> None:
    plans = [config for _, config in make_plans(LEVEL, Sweep((1, 4), down="4:1"))]
    assert [[one.robot for one in config.down] for config in plans] == [[], [plans[1].robots[3].name]]


@pytest.mark.parametrize(
    ("down", "said"),
    [
        (
            "secnd:10",
            "--down: unknown robot 'secnd'; did you mean 'second'? known are first, second, third, or",
        ),
        ("4:1", "--down: unknown robot '4'; known are first, second, third, or a number from 1 to 3"),
        ("0:1", "--down: unknown robot '0'"),
        ("second:0", "--down is 'second:0'; it must be ROBOT:MINUTES with minutes above 0"),
        ("second:nan", "--down is 'second:nan'"),
        (":1", "--down is ':1'"),
        ("second", "--down is 'second'"),
    ],
)
def test_a_robot_that_no_plan_has_cannot_stand_still(down: str, said: str) -> None:
    with pytest.raises(UsageError) as caught:
        next(make_plans(LEVEL, Sweep((1, 3), down=down)))
    assert str(caught.value).startswith(said)


def planned(recovery, *items, robots=3, work=(0.95, 0.5, 0.5), **numbers):
    """A plan of the plant, whose items have these percentages of each fate, in the order of `FATES`."""
    config, arrived = LineConfig.load(plant()), [50.0, 30.0, 20.0]
    shares = {
        name: dict(zip(FATES, np.array(fates) / 100.0, strict=True))
        for name, fates in zip(config.cell.items, items, strict=True)
    }
    fates = {fate: float(np.dot([of[fate] for of in shares.values()], arrived)) / 100.0 for fate in FATES}
    row = {"robots": robots, "belt_speed": 0.4, "percent": 60.0, "skills": "level", **numbers}
    row |= {"recovery": recovery, "recovery_low": recovery - 0.02, "recovery_high": recovery + 0.02}
    row |= {
        "fates": fates,
        "fates_by_item": shares,
        "arrived": arrived,
        "utilisation": work,
        "value_per_min": 9.0,
        "sorted_per_min": 50.0 * recovery,
    }
    row |= {"sorted_per_min_low": 50.0 * recovery - 1.0}
    row |= {"energy_per_sorted_j": 40.0, "money_per_hour": None}
    return Planned(config, None, row, np.full(16, recovery))


WELL = (97, 0, 1, 0, 1, 1, 0)


def brings(what: str, points: float, low: float, high: float) -> Gain:
    """What a change brings, in points."""
    return Gain(what, "", 0.8, Interval(points / 100.0, low / 100.0, high / 100.0), None)


def test_a_light_item_that_every_throw_misses_is_the_reason():
    plan = planned(0.75, WELL, WELL, (3, 0, 94, 0, 1, 2, 0))
    assert plan.thrown_badly(2) == pytest.approx(94 / 97)
    gains = [brings("release learned", 18.0, 16.0, 20.0), brings("one more robot", 0.1, -0.5, 0.6)]
    assert reason(plan, gains) == (
        "the reason: 19.6 % of all objects are thrown and miss (94.0 % of alu); over the same shifts recovery rises by "
        "18.0 points (16.0..20.0) with release learned; no difference with one more robot"
    )


def test_of_many_items_with_small_shares_the_worst_one_is_named():
    names = ("can", "tray", "paper_ball", "yoghurt_cup", "pet_05")
    bins = {"random": None, "fixed": [{"name": "all", "x": 0.0, "y": 0.45, "size": [0.3, 0.3]}]}
    cell = {"items": names, "bins": bins}
    line = LineConfig.load({"name": "many", "throws": "flight", "cell": cell, "robots": [{"name": "first", "x": 0.0}]})
    fates = dict(zip(FATES, np.array([80, 0, 0, 0, 0, 20, 0]) / 100.0, strict=True))
    row = {"fates": fates, "fates_by_item": dict.fromkeys(names, fates), "arrived": [10, 10, 11, 10, 10]}
    plan = Planned(line, None, {**row, "utilisation": [1.0]}, np.full(2, 0.8))
    assert worst_items(plan, "passed") == [2]
    said = "20.0 % of all objects pass the end, not tried (20.0 % of paper_ball); taken by first, at work 100.0 %"
    assert reason(plan, []) == f"the reason: {said}"


def test_losses_are_named_as_far_as_they_matter_the_largest_first():
    plan = planned(0.8, (60, 0, 0, 38, 1, 1, 0), WELL, (20, 0, 77, 0, 1, 2, 0))
    assert [name for name, _ in main_losses(plan)] == ["lost", "missed"]
    assert "19.0 % of all objects are lost on the way (38.0 % of hdpe), and 15.7 % of all" in reason(plan, [])
    plan = planned(0.7, (50, 0, 0, 0, 0, 5, 45), WELL, (60, 0, 0, 0, 0, 0, 40))
    assert "30.5 % of all objects are out of reach: no robot can throw them" in reason(plan, [])
    assert reason(planned(1.0, *[(100, 0, 0, 0, 0, 0, 0)] * 3), []) == "no object was lost"


def test_objects_that_nobody_tries_name_the_robots_that_take_them():
    plan = planned(0.7, WELL, (50, 0, 1, 0, 2, 47, 0), WELL, work=(0.97, 0.96, 0.4))
    best = [brings("half as many objects", 23.0, 21.0, 25.0), brings("robots b", 3.0, 2.0, 4.0)]
    worse = [brings("robots a", 1.0, 0.5, 2.0), brings("a belt", -3.0, -4.0, -2.0)]
    assert reason(plan, best + worse).endswith(
        "pass the end, not tried (47.0 % of brick); taken by first, second, at work 97.0 %, 96.0 %; over the same "
        "shifts recovery rises by 23.0 points (21.0..25.0) with half as many objects, by 3.0 points (2.0..4.0) with "
        "robots b, by 1.0 points (0.5..2.0) with robots a"
    )
    assert reason(plan, worse[1:]).endswith("; no change that was tried brings more")


def test_of_each_kind_of_change_the_best_one_is_named():
    plan, low = planned(0.7, WELL, WELL, WELL), Interval(0.01, 0.005, 0.02)
    gains = [Gain("robots", name, 0.8, low, None) for name in ("wide", "narrow")]
    assert reason(plan, gains).endswith("recovery rises by 1.0 points (0.5..2.0) with robots wide")


def test_changes_of_a_line_differ_from_it_in_one_thing():
    line = LineConfig.load(plant())
    changes = {change.what: change for change in possible_changes(line, "hdpe")}
    assert len(changes["one more robot"].config.robots) == 4
    assert changes["all skills for every robot"].config.can_take().all()
    assert changes["half as many objects"].config.arrivals.rate == line.arrivals.rate / 2.0
    assert changes["a belt at"].config.cell.belt.speed == pytest.approx(0.75 * line.cell.belt.speed)
    swapped = [(bin_.x, bin_.y) for bin_ in changes["a swap of bins"].config.cell.bins.fixed]
    assert sorted(swapped) == [(bin_.x, bin_.y) for bin_ in line.cell.bins.fixed] != swapped
    assert changes["robots"].config.cell.robot.name not in {sheet.name for sheet in line.sheets()}
    assert {change.config.value == line.value for change in changes.values()} == {True}
    own = LineConfig.load("skills3")
    assert [change.to for change in possible_changes(own, "tray") if change.what == "a swap of bins"]


def test_the_chosen_plan_is_judged_by_its_own_throws_until_it_stays_the_chosen_one(monkeypatch):
    two, three, four = (planned(share, WELL, WELL, WELL, robots=n) for n, share in ((2, 0.97), (3, 0.96), (4, 0.8)))
    again = {2: planned(0.9, WELL, WELL, WELL, robots=2), 3: planned(0.95, WELL, WELL, WELL, robots=3)}
    monkeypatch.setattr(verdict, "judge_again", lambda plan, *_: again[plan.row["robots"]])
    plans = verdict.recount_chosen([two, three, four], Goal.of(0.92), Conditions(), None)
    assert plans[0] is again[2]
    assert plans[1] is again[3]
    assert plans[2] is four


def test_the_table_names_causes_and_the_worst_item():
    plans = [planned(0.97, WELL, WELL, WELL, robots=4), planned(0.7, WELL, (50, 0, 1, 0, 2, 47, 0), WELL)]
    assert reasons.choose(plans, Goal.of(0.9)) == (plans[0], True)
    assert reasons.choose(plans, Goal.of(0.99)) == (plans[0], False)
    table = reasons.table("x", plans, Goal.of(0.9))
    assert not {"skills", "belt", "limits", "money/h"} & set(table.header)
    assert table.headline == f"x, belt {plans[0].row['belt_speed']:.2f} m/s, limits {plans[0].row['percent']:g} %"
    second = dict(zip(table.header, table.rows[1], strict=True))
    assert (second["worst item"], second["missed"], second["not tried"]) == ("brick 50.0", "1.0", "14.8")
    assert [row[-1] for row in table.rows] == ["yes", "no"]


def test_the_cheapest_plan_that_reaches_a_pace_is_chosen():
    plans = [planned(share, WELL, WELL, WELL, robots=n) for n, share in ((2, 0.7), (3, 0.9), (4, 0.95))]
    goal = Goal.of(want="40/min")
    assert reasons.choose(plans, goal) == (plans[1], True)
    assert reasons.answer(plans[1], True, goal).startswith("the smallest plan with 40.0 sorted a minute: 3 robots")
    for plan, money in zip(plans, (1.0, 2.0, 3.0), strict=True):
        plan.row["money_per_hour"] = money
    assert reasons.choose(plans, goal) == (plans[2], True)
    assert reasons.answer(plans[2], True, goal).startswith("the cheapest plan with 40.0 sorted")
    assert reasons.answer(plans[2], False, Goal.of(want="60 / min")).endswith("reaches 47.5 sorted a minute")
    assert Goal.of(want="99 %") == Goal("recovery", 0.99)


@pytest.mark.parametrize("want", ["95", "0%", "100%", "-3/min", "0/min", "fast", "90/h", "nan%"])
def test_what_is_wanted_is_a_recovery_or_a_pace(want):
    with pytest.raises(UsageError, match=r"--want is .*; it must be a recovery below 100 % or a pace"):
        Goal.of(want=want)
    with pytest.raises(UsageError, match=r"leave one of them out"):
        Goal.of(0.9, "95%")


def test_the_full_physics_is_said_to_agree_or_not():
    close = {"shifts": 4, "recovery": 0.66, "recovery_low": 0.64, "recovery_high": 0.68}
    close |= {"over_table": -0.01, "over_table_low": -0.03, "over_table_high": 0.01}
    assert check_text(close) == (
        "in the full physics 4 of these shifts sort 66.0 % (64.0..68.0), which agrees with the table"
    )
    far = {**close, "over_table": -0.03, "over_table_low": -0.04, "over_table_high": -0.02}
    assert check_text(far).endswith("(64.0..68.0), 3.0 points less than by the table")


def test_few_counted_throws_make_wide_intervals_by_hand():
    # Of 100 objects 40 of the first item were held, of which 20 ended in their bin; all 20 of the second did. With 25
    # throws of the first item behind the table, 0.4^2 x 0.5 x 0.5 / 25 is the whole variance.
    counts = np.array([[[20.0, 5.0, 10.0, 5.0, 10.0, 30.0, 0.0], [20.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]])
    nothing = np.zeros(2, dtype=np.int64)
    counted = Counted(
        np.array([25, 9]), nothing, nothing, nothing, np.ones(1), np.ones((2, 1)), (np.zeros((0, 2)),) * 2
    )
    kind = np.repeat([0, 1], [50, 20])
    shifts = Shifts({}, {"true_kind": kind, "picked": np.arange(70) >= 10}, 0, 70, 0.0)
    assert table_spread(shifts, Fates(counts, True), counted) == pytest.approx(1.96 * 0.4 * 0.5 / 25**0.5)


def test_money_is_proceeds_less_hours_and_energy():
    costs = {"robot_hour": 12.0, "joule": 1e-5, "per_tonne": {"alu": 1000.0, "hdpe": 300.0}}
    config = LineConfig.load({**plant(), "cost": costs, "duration": 120.0})
    figures = {"shift_sorted_by_item": np.array([[20, 9, 30], [30, 9, 20]])}
    decisions = {"energy": np.array([3000.0, np.nan, 5000.0]), "shift": np.array([0, 0, 1])}
    shifts = Shifts({**figures, "shift_value_per_min": np.zeros(2)}, decisions, 0, 3, 0.0)
    # hdpe of 60 g and alu of 8 g in 1/30 h; three robots.
    first = 30.0 * (20 * 60e-6 * 300.0 + 30 * 8e-6 * 1000.0) - 3 * 12.0 - 1e-5 * 30.0 * 3000.0
    second = 30.0 * (30 * 60e-6 * 300.0 + 20 * 8e-6 * 1000.0) - 3 * 12.0 - 1e-5 * 30.0 * 5000.0
    assert money_per_hour(shifts, config, None) == pytest.approx([first, second])
    assert money_per_hour(shifts, LineConfig.load(plant()), None) is None
    with pytest.raises(ConfigError, match=r"cost\.per_tonne: unknown item 'tin'"):
        LineConfig.load({**plant(), "cost": {"per_tonne": {"tin": 1.0}}})


@pytest.fixture(scope="module")
def planned_plant(tmp_path_factory):
    """What the command says and writes on the plant, thrown fast, in a folder of its own."""
    folder = tmp_path_factory.mktemp("plant")
    (folder / "plant.yaml").write_text(plant_text())
    line = "line plan --level plant.yaml --robots 3 --percents 60 --shifts 3 --minutes 0.4 --throws 100 --check 2"
    with pytest.MonkeyPatch.context() as patch:  # two of the fifteen changes
        patch.setattr(verdict, "possible_changes", lambda *of: [c for c in possible_changes(*of) if c.what in TRIED])
        return folder, output_of(f"{line} --json plans.json --picture plans.svg", folder)


def test_the_light_item_of_the_plant_is_the_reason(planned_plant):
    folder, said = planned_plant
    told, words = json.loads((folder / "plans.json").read_text()), " ".join(said.split())
    plan, twin = told["plans"][0], told["other_release"]
    assert plan["chances_by"] == twin["chances_by"] == "price"
    assert "no plan reaches a recovery of 95.0 %; the best plan, 3 robots at 60 %" in words
    assert "of all objects are thrown and miss (" in words and "% of alu" in words
    assert told["gains"]["release shipped:waste-sac"][0] > 0.0
    alu = plan["fates_by_item"]["alu"]
    assert max(alu, key=alu.__getitem__) == "missed"
    assert twin["release"] == "shipped:waste-sac"
    assert twin["fates_by_item"]["alu"]["sorted"] > plan["fates_by_item"]["alu"]["sorted"]
    assert plan["recovery_low"] <= plan["recovery"] <= plan["recovery_high"]
    checked = told["checked"]
    assert (checked["shifts"], len(told["sentences"])) == (2, 3)
    assert 0.4 < checked["recovery"] < 0.9
    assert checked["recovery_low"] < checked["recovery"] < checked["recovery_high"]
    assert "in the full physics 2 of these shifts sort" in words
    assert sum(plan["fates"].values()) == pytest.approx(1.0)
    assert 50.0 < plan["energy_per_sorted_j"] < 200.0
    assert (folder / "plans.svg").read_text().startswith("<?xml")


def test_tables_of_plans_are_kept_in_the_working_folder(planned_plant):
    folder, _ = planned_plant
    parts = [path.stem.split("-")[1:] for path in (folder / "runs" / "chances").iterdir()]
    names = sorted(" ".join(part for part in name if len(part) != 8 and part != "shipped") for name in parts)
    assert names == ["", "price", "waste sac", "waste sac price"]


@pytest.fixture(scope="module")
def working_folder(tmp_path_factory):
    """A working folder of several commands, in which tables of throws are counted once."""
    return tmp_path_factory.mktemp("skills3")


def test_it_says_which_plan_is_enough(working_folder):
    line = "line plan --level skills3 --robots 1 3 --shifts 2 --minutes 0.2 --recovery 0.2 --throws 100 --check 0"
    said = output_of(f"{line} --no-mend --fidelity flight --json plans.json", working_folder)
    plans = json.loads((working_folder / "plans.json").read_text())["plans"]
    assert [plan["robots"] for plan in plans] == [1, 3]
    assert plans[1]["recovery"] > plans[0]["recovery"] > 0.0
    assert "the smallest plan with a recovery of 20.0 %:" in " ".join(said.split())
    assert not list(shipped_table(LEVEL).parent.glob("*waste-sac*"))


def test_plans_may_have_a_release_and_a_wrong_one_is_told_before_the_work(working_folder):
    assert "unknown shipped policy 'shipped:nobody'" in refused("agents.line plan", "--release", "shipped:nobody")
    line = "line plan --level skills3 --robots 3 --shifts 2 --minutes 0.1 --throws 100 --check 2 --release random"
    output_of(f"{line} --no-mend --fidelity flight --json plans.json", working_folder)
    told = json.loads((working_folder / "plans.json").read_text())
    assert (told["release"], told["other_release"]["release"]) == ("random", "analytic")


def test_from_python(working_folder, monkeypatch):
    monkeypatch.chdir(working_folder)
    found = pnt_gym.plan_line(
        "single", robots=(2,), shifts=2, minutes=0.1, throws=100, check=0, threads=1, tables="here", mend=False
    )
    assert list((working_folder / "here").iterdir())
    assert [plan["robots"] for plan in found["plans"]] == [2]
    assert (len(found["sentences"]), found["checked"]) == (2, None)
    for options, said in (
        ({"robot": 2}, "unknown argument 'robot'; did you mean 'robots'"),
        ({"recovery": 2.0}, "recovery is 2"),
        ({"check": 1}, "check is 1"),
        ({"tables": 5}, "tables is 5"),
        ({"robots": 2}, "robots is 2: input should be a valid list"),
        ({"release": 5}, "unknown controller '5'"),
    ):
        with pytest.raises(UsageError, match=said):
            pnt_gym.plan_line("skills3", **options)
