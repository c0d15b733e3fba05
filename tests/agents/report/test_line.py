"""Tables and the figure of a benchmark of lines, and of what throwing makes of an order."""

from typing import Any

import numpy as np
import pytest

from agents.judging.shift_record import ShiftRecord
from agents.report import line
from agents.report.line import best, gains_figure, gains_table, seeds_table, value
from agents.report.tables import rows_of

SHIFTS = 6
LISTS = {name: [[0.5]] for name in ("utilisation", "picks_by_robot", "recovery_by_item", "passed_by_item")}
SHARES = ("sorted_per_min", "recovery", "value_recovery", "purity", "passed_value_per_min", "passed_tried")


def result(label: str, mean: float, controller: str = "", throws: int = 0, seed: int = 0, shifts: int = SHIFTS) -> Any:
    """What a benchmark keeps of somebody who brings in so much a minute, one more in each shift than in the last."""
    gained = mean + np.linspace(-1.0, 1.0, SHIFTS)[:shifts]
    more = {**dict.fromkeys(SHARES, [0.5] * shifts), **{name: one * shifts for name, one in LISTS.items()}}
    counts = {"items": ["tray"], "robots": ["first"], "picks": 10, "picked": 9, "success": 8, "invalid": 0}
    columns = {"value_per_min": gained.tolist(), **more, **counts, "ms_per_decision": 1.0}
    head = {"label": label, "controller": controller or label, "throws": throws, "seed": seed, "level": "single"}
    return {**head, "learn_seconds": 0.0, "columns": columns}


RULES = [
    result("random", 30.0), result("fifo", 60.0), result("spt", 70.0), result("atc", 72.0), result("value_rate", 71.0),
    result("beam", 76.0, shifts=3), result("scorer", 74.0, "some/scorer.npz"),
]  # fmt: skip
LEARNED = [
    result("ppo", mean, "residual_ppo", throws, seed)
    for throws, means in {10: (61.0, 62.0, 63.0), 90: (75.0, 73.0, 77.0)}.items()
    for seed, mean in enumerate(means)
]


def data_of(results: list[Any]) -> dict[str, Any]:
    table: list[dict[str, Any]] = []
    for label, throws in dict.fromkeys((one["label"], one["throws"]) for one in results):
        same = [one for one in results if (one["label"], one["throws"]) == (label, throws)]
        head = {name: same[0][name] for name in ("label", "controller", "throws", "level")}
        table.append({**head, **ShiftRecord.summarise(same, 16)})
    plan = {"levels": ["single"], "shifts": SHIFTS, "env": "PnTLine-v0", "seeds": [0, 1, 2], "train_level": "each"}
    return {"plan": plan, "table": table, "results": results, "comparisons": [], "versions": {"python": "3"}}


DATA = data_of([*RULES, *LEARNED])


def test_the_best_is_told_by_the_shifts_that_all_have_worked() -> None:
    rows = rows_of(DATA, ["single"])
    found = best(rows, ("atc", "beam"))
    assert found is not None
    assert found["label"] == "beam"
    # All of its shifts are good ones, but on those three alone the other one is better.
    early = data_of([result("beam", 72.5, shifts=3), result("atc", 73.0)])["table"]
    assert best(early)["label"] == "atc"
    assert best(rows, ("nobody",)) is None


def test_gains_are_those_of_the_means_on_shared_shifts() -> None:
    (row,) = gains_table(DATA).rows
    assert row[0] == "`single`"
    assert row[1].startswith("`atc` +20.0 %")
    beam, fifo = (value(one)[:3].mean() for one in (rows_of(DATA, ["single"])[5], rows_of(DATA, ["single"])[1]))
    assert row[2].startswith(f"`beam` {100 * (beam / fifo - 1):+.1f} %")
    assert row[4].startswith("`ppo (90)`")


def test_a_level_on_which_nobody_has_learned_says_so() -> None:
    (row,) = gains_table(data_of(RULES[:-1])).rows
    assert row[4] == "-"
    assert seeds_table(data_of(RULES)).rows == []


def test_a_plan_without_the_first_rule_has_no_such_table() -> None:
    headlines = [grid.headline for grid in line.grids(data_of([RULES[0], *LEARNED]))]
    assert "What the order is worth" not in headlines
    assert headlines[0] == "Every controller on the same held-out shifts"


def test_of_several_seeds_the_worst_is_compared_after_all_it_learned() -> None:
    (row,) = seeds_table(DATA).rows
    assert row[:4] == ["`single`", "`ppo (90)`", "3", "75.0 (73.0..77.0)"]
    assert row[4].startswith(f"`atc` {100 * (73.0 / 72.0 - 1):+.1f} %")
    assert row[5] == "-"
    worst, beam = (np.array(one["columns"]["value_per_min"])[:3].mean() for one in (LEARNED[4], RULES[5]))
    against = f"{100 * (worst / beam - 1):+.1f} %"
    assert row[6].startswith(against)
    assert row[7].startswith(f"`beam` {against}")


def test_who_has_worked_fewer_shifts_is_named_under_the_table() -> None:
    assert "6 held-out shifts (beam 3) per seed" in line.grids(DATA)[0].note


def test_the_figure_has_a_mark_for_everybody_but_the_first_and_the_one_by_chance() -> None:
    (panel,) = gains_figure(DATA).axes
    names = [label.get_text() for label in panel.get_yticklabels()]
    assert names == ["spt", "atc", "value_rate", "beam", "scorer", "ppo (10)", "ppo (90)"]
    marks = [line.get_xdata()[0] for line in panel.lines if line.get_marker() == "o"]
    assert marks[:2] == [pytest.approx(100 * (70.0 / 60.0 - 1)), pytest.approx(20.0)]
    assert panel.get_xlabel() == "over fifo [%]"
