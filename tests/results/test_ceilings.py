"""Guards of committed numbers: nobody passes an oracle of the same objects in what the oracle aims at."""

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
import pytest

from agents.controllers.named import CHEATS
from agents.ground import metrics
from agents.ground.places import SHIPPED as ROOT
from agents.judging.throw_record import ThrowRecord
from agents.report import contents

AIMS: Final = {"oracle": "landing_error_m", "oracle_drift": "landing_error_m", "oracle_grasp": "sorted_per_min"}
"""What controllers that are called oracles aim at; an oracle of releases hits its target, and weighs no time."""
PASSED: Final = {"sac after 10000 on boxes"}
"""Rows that sort more than an oracle of releases beyond the interval: a reward can weigh landings against time."""
RESULTS = ROOT / "results"
pytestmark = pytest.mark.usefixtures("results_as_they_stand")
SHOWN = sorted(path.stem for path in RESULTS.glob("benchmark*.json"))
"""Benchmarks with committed results."""


def pairs(data: Any) -> Iterator[tuple[str, dict[str, Any], dict[str, Any]]]:
    """Rows that cheat in no way, each with an oracle on the same level, and what the row is."""
    for oracle in data["table"]:
        for row in data["table"]:
            if oracle["controller"] in AIMS and row["level"] == oracle["level"] and row["controller"] not in CHEATS:
                yield f"{row['label']} after {row['throws']} on {row['level']}", row, oracle


def difference(data: Any, figure: str, row: dict[str, Any], oracle: dict[str, Any]) -> metrics.Interval:
    """A figure of a row less that of the oracle, over the same objects."""
    keys = ("label", "throws", "level")
    sides = [[one for one in data["results"] if all(one[k] == of[k] for k in keys)] for of in (row, oracle)]
    columns = [ThrowRecord.paired_columns(side, sides, data["plan"]["num_envs"])[figure] for side in sides]
    means = [np.mean(column, axis=0) for side in columns for column in side]
    return metrics.rate_difference(*means) if len(means) > 2 else metrics.difference(*means)


def above(name: str, figure: str | None = None) -> set[str]:
    """Rows of a benchmark that pass an oracle beyond the interval, in a figure or in what the oracle aims at."""
    data, found = contents.read(RESULTS / f"{name}.json"), set[str]()
    for what, row, oracle in pairs(data):
        aim = figure or AIMS[oracle["controller"]]
        interval = difference(data, aim, row, oracle)
        if interval.high < 0.0 if aim == "landing_error_m" else interval.low > 0.0:
            found.add(what)
    return found


@pytest.mark.parametrize("name", SHOWN)
def test_no_row_of_a_benchmark_passes_an_oracle_in_what_it_aims_at(name: str) -> None:
    assert not above(name)


def test_benchmarks_of_releases_and_of_drifting_cells_have_oracles() -> None:
    held = {name for name in SHOWN if any(pairs(contents.read(RESULTS / f"{name}.json")))}
    assert {"benchmark", "benchmark_adapt", "benchmark_grasp", "benchmark_precise"} <= held


def test_hardly_a_row_sorts_more_than_an_oracle() -> None:
    assert {row for name in SHOWN for row in above(name, "sorted_per_min")} <= PASSED


def test_the_oracle_of_grasps_is_above_all_others_and_leaves_them_room() -> None:
    rows = [row for row in contents.read(RESULTS / "grasp_ceiling.json")["rows"] if row["part"] == "thrown"]
    others = [row for row in rows if row["who"] != "oracle_grasp"]
    assert {row["level"] for row in others} == {"seen", "unseen"}
    assert all(row["gain"]["high"] < 0.0 for row in others)
    assert all(row["gain"]["high"] < -3.0 for row in others if row["who"] not in CHEATS)


def test_no_order_of_a_line_is_above_its_bound_and_foresight_is_near_it() -> None:
    data = contents.read(RESULTS / "ceilings.json")
    rows = data["rows"]
    many = [row for row in rows if row["part"] == "closest"]
    assert {row["level"] for row in many} == {row["level"] for row in rows}
    assert data["throws"] >= 100
    assert all(row["closest"] <= 1.0 for row in many)
    levels = {row["level"] for row in rows}
    assert len(levels) == 6
    for row in (row for row in rows if row["part"] == "orders"):
        own, drawn = np.array(row["shifts"])[:, 0], np.array(row["drawn"])[:, 0]
        assert (own <= drawn).all()
        if row["controller"] == "clairvoyant":
            assert own.sum() > 0.92 * drawn.sum()
        else:
            assert own.sum() < np.array(row["expected"])[:, 0].sum()


def test_a_memory_of_a_shift_pays_and_the_oracle_is_above_all() -> None:
    rows = {row["who"]: row for row in contents.read(RESULTS / "grasp_shift.json")["rows"]}
    plain, learner, rule = (rows[name] for name in ("shift_values, no memory", "shift_values", "remembering"))
    holds = rows["oracle_grasp of holds"]
    remember = {"shift_values", "shift_values, recurrent", "remembering"}
    without = set(rows) - remember - {"oracle_grasp", "oracle_grasp of holds"}
    assert max(rows[name]["late"]["value"] for name in without) == plain["late"]["value"]
    assert learner["late"]["value"] < holds["late"]["value"] < rows["oracle_grasp"]["late"]["value"]
    assert learner["share_of_holds"]["low"] > max(0.5, 1.5 * rule["share_of_holds"]["value"])
    assert all(row["less"]["high"] < -10.0 for name, row in rows.items() if not name.startswith("oracle_grasp"))
    assert learner["gain"]["low"] > 5.0
    assert rule["gain"]["low"] > 1.0
