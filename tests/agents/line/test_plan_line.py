"""What a line needs: plans, tables and the sentence at the end."""

import json

import numpy as np
import pytest

import pnt_gym
from agents.ground.cli import UsageError
from agents.judging.losses import FATES, Counted, Fates
from agents.judging.shifts import Shifts
from agents.line import reasons, verdict
from agents.line.plans import (
    Conditions,
    Planned,
    Sweep,
    line_up,
    make_plans,
    money_per_hour,
    standstill,
    table_spread,
    try_changes,
    with_standstill,
)
from agents.line.reasons import check_text, reason
from pnt_gym.cells.line.chances import shipped_table
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError
from tests.tools.commands import output_of, refused
from tests.tools.plant import plant, plant_text

LEVEL = LineConfig.load("skills3")


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
    row |= {"fates": fates, "fates_by_item": shares, "arrived": arrived, "utilisation": work, "value_per_min": 9.0}
    row |= {"energy_per_sorted_j": 40.0, "money_per_hour": None}
    return Planned(config, None, row, np.full(16, recovery))


WELL = (97, 0, 1, 0, 1, 1, 0)


def test_a_light_item_that_every_throw_misses_is_the_reason():
    plan = planned(0.75, WELL, WELL, (3, 0, 94, 0, 1, 2, 0))
    twin = planned(0.93, WELL, WELL, (94, 0, 3, 0, 1, 2, 0))
    assert plan.thrown_badly(2) == pytest.approx(94 / 97)
    assert plan.bound == pytest.approx(0.8 * 97 / 98 + 0.2 * 3 / 97)
    text = reason(plan, 0.95, "analytic", ("learned", twin), {})
    assert text == (
        "the reason: alu is thrown and misses (96.9 %), so more robots do not help: with every object picked these "
        "throws sort 79.8 %; release learned loses 3.1 % of alu, and the plan sorts 93.0 % instead of 75.0 % with "
        "analytic"
    )


def test_throws_are_named_only_as_far_as_they_matter():
    plan = planned(0.8, (60, 0, 0, 38, 1, 1, 0), WELL, (20, 0, 77, 0, 1, 2, 0))
    text = reason(plan, 0.95, "analytic", ("learned", plan), {})
    assert "alu is thrown and misses (79.4 %) and hdpe is thrown and is lost on the way (38.8 %), so more" in text
    good_enough = planned(0.9, (90, 0, 6, 0, 2, 2, 0), WELL, WELL)
    text = reason(good_enough, 0.91, "analytic", ("learned", good_enough), {})
    assert "hdpe is thrown and misses (6.2 %), so better throws help more than more robots:" in text


def test_objects_that_nobody_tries_are_the_reason():
    plan = planned(0.7, WELL, (50, 0, 1, 0, 2, 47, 0), WELL, work=(0.97, 0.96, 0.4))
    changes = {"one more robot": 0.8, "half as many objects": 0.93}
    assert reason(plan, 0.95, "analytic", ("learned", plan), changes) == (
        "the reason: 47.0 % of brick pass the end, not tried; taken by first, second, at work 97.0 %, 96.0 %; by the "
        "same table the plan would sort 80.0 % with one more robot, 93.0 % with half as many objects"
    )


def test_a_plan_is_tried_with_one_thing_changed(monkeypatch):
    lines = []

    def work(line, conditions):
        lines.append(line)
        return Shifts({"shift_recovery": np.full(2, 0.5 + 0.1 * len(lines))}, {}, 0, 0, 0.0)

    monkeypatch.setattr("agents.line.plans.work", work)
    changes = try_changes(planned(0.5, WELL, WELL, WELL), Conditions())
    assert changes == pytest.approx(
        {"one more robot": 0.6, "all skills for every robot": 0.7, "half as many objects": 0.8}
    )
    assert [len(line.robots) for line in lines] == [4, 3, 3]
    assert lines[1].can_take().all()
    assert [line.arrivals.rate for line in lines] == [2.5, 2.5, 1.25]


def test_cups_that_do_not_seal_are_the_reason():
    plan = planned(0.8, WELL, (60, 0, 1, 0, 30, 9, 0), WELL, work=(0.5, 0.6, 0.4))
    text = reason(plan, 0.95, "analytic", ("learned", plan), {})
    assert text.startswith("the reason: 30.0 % of brick pass the end after picks in which")


def test_the_chosen_plan_is_judged_by_its_own_throws_until_it_stays_the_chosen_one(monkeypatch):
    two, three, four = (planned(share, WELL, WELL, WELL, robots=n) for n, share in ((2, 0.97), (3, 0.96), (4, 0.8)))
    again = {2: planned(0.9, WELL, WELL, WELL, robots=2), 3: planned(0.95, WELL, WELL, WELL, robots=3)}
    monkeypatch.setattr(verdict, "judge_again", lambda plan, *_: again[plan.row["robots"]])
    plans = verdict.recount_chosen([two, three, four], 0.92, Conditions(), None)
    assert plans[0] is again[2]
    assert plans[1] is again[3]
    assert plans[2] is four


def test_the_table_names_causes_and_the_worst_item():
    plans = [planned(0.97, WELL, WELL, WELL, robots=4), planned(0.7, WELL, (50, 0, 1, 0, 2, 47, 0), WELL)]
    assert reasons.choose(plans, 0.9) == (plans[0], True)
    assert reasons.choose(plans, 0.99) == (plans[0], False)
    table = reasons.table("x", plans, 0.9)
    assert not {"skills", "belt", "limits", "money/h"} & set(table.header)
    assert table.headline == f"x, belt {plans[0].row['belt_speed']:.2f} m/s, limits {plans[0].row['percent']:g} %"
    second = dict(zip(table.header, table.rows[1], strict=True))
    assert (second["worst item"], second["missed"], second["not tried"]) == ("brick 50.0", "1.0", "14.8")
    assert [row[-1] for row in table.rows] == ["yes", "no"]


def test_the_full_physics_is_said_to_agree_or_not():
    close = {"shifts": 4, "recovery": 0.66, "recovery_low": 0.64, "recovery_high": 0.68}
    close |= {"over_table": -0.01, "over_table_low": -0.03, "over_table_high": 0.01}
    assert check_text(close) == (
        "in the full physics 4 of these shifts sort 66.0 % (64.0..68.0), which agrees with the table"
    )
    far = {**close, "over_table": -0.03, "over_table_low": -0.04, "over_table_high": -0.02}
    assert check_text(far).endswith("(64.0..68.0), 3.0 points less than by the table")


def test_few_counted_throws_make_wide_intervals_by_hand():
    # Of 100 objects 50 picks are of the first item, of which 40 sealed and 20 ended in their bin; all 20 of the second
    # did. 25 sealed picks behind the table are 31.25 picks: 0.5^2 x 0.4 x 0.6 / 31.25 is the whole variance.
    counts = np.array([[[20.0, 5.0, 10.0, 5.0, 10.0, 30.0, 0.0], [20.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]])
    nothing = np.zeros(2, dtype=np.int64)
    counted = Counted(
        np.array([25, 9]), nothing, nothing, nothing, np.ones(1), np.ones((2, 1)), (np.zeros((0, 2)),) * 2
    )
    kind = np.repeat([0, 1], [50, 20])
    shifts = Shifts({}, {"true_kind": kind, "picked": np.arange(70) >= 10}, 0, 70, 0.0)
    assert table_spread(shifts, Fates(counts, True), counted) == pytest.approx(1.96 * 0.5 * (0.24 / 31.25) ** 0.5)


def test_money_is_proceeds_less_hours_and_energy():
    costs = {"robot_hour": 12.0, "joule": 1e-5, "per_tonne": {"alu": 1000.0, "hdpe": 300.0}}
    config = LineConfig.load({**plant(), "cost": costs, "duration": 120.0})
    figures = {"shift_sorted_by_item": np.array([[20, 9, 30], [30, 9, 20]])}
    decisions = {"energy": np.array([3000.0, np.nan, 5000.0])}
    shifts = Shifts({**figures, "shift_value_per_min": np.zeros(2)}, decisions, 0, 3, 0.0)
    # 25 hdpe of 60 g and 25 alu of 8 g in 1/30 h; three robots; 4000 J a shift.
    money = 30.0 * (25 * 60e-6 * 300.0 + 25 * 8e-6 * 1000.0) - 3 * 12.0 - 1e-5 * 30.0 * 4000.0
    assert money_per_hour(shifts, config, None) == pytest.approx(money)
    assert money_per_hour(shifts, LineConfig.load(plant()), None) is None
    with pytest.raises(ConfigError, match=r"cost\.per_tonne: unknown item 'tin'"):
        LineConfig.load({**plant(), "cost": {"per_tonne": {"tin": 1.0}}})


@pytest.fixture(scope="module")
def planned_plant(tmp_path_factory):
    """What the command says and writes on the plant, thrown fast, in a folder of its own."""
    folder = tmp_path_factory.mktemp("plant")
    (folder / "plant.yaml").write_text(plant_text())
    line = "line plan --level plant.yaml --robots 3 --percents 60 --shifts 3 --minutes 0.4 --throws 180 --check 2"
    return folder, output_of(f"{line} --json plans.json --picture plans.svg", folder)


def test_the_light_item_of_the_plant_is_the_reason(planned_plant):
    folder, said = planned_plant
    told, words = json.loads((folder / "plans.json").read_text()), " ".join(said.split())
    plan, twin = told["plans"][0], told["other_release"]
    assert plan["chances_by"] == twin["chances_by"] == "price"
    assert "no plan reaches a recovery of 95.0 %; the best plan, 3 robots at 60 %" in words
    assert "the reason: alu is thrown and misses (" in words and "so more robots do not help" in words
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
    said = output_of(f"{line} --json plans.json", working_folder)
    plans = json.loads((working_folder / "plans.json").read_text())["plans"]
    assert [plan["robots"] for plan in plans] == [1, 3]
    assert plans[1]["recovery"] > plans[0]["recovery"] > 0.0
    assert "the smallest plan with a recovery of 20.0 %:" in " ".join(said.split())
    assert not list(shipped_table(LEVEL).parent.glob("*waste-sac*"))


def test_plans_may_have_a_release_and_a_wrong_one_is_told_before_the_work(working_folder):
    assert "unknown shipped policy 'shipped:nobody'" in refused("agents.line plan", "--release", "shipped:nobody")
    line = "line plan --level skills3 --robots 3 --shifts 2 --minutes 0.1 --throws 100 --check 2 --release random"
    output_of(f"{line} --json plans.json", working_folder)
    told = json.loads((working_folder / "plans.json").read_text())
    assert (told["release"], told["other_release"]["release"]) == ("random", "analytic")


def test_from_python(working_folder, monkeypatch):
    monkeypatch.chdir(working_folder)
    found = pnt_gym.plan_line(
        "skills3", robots=(2,), shifts=2, minutes=0.1, throws=100, check=0, threads=1, tables="here"
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
