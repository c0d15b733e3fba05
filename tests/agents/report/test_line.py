"""Tables of the line's study."""

import numpy as np

from agents.report.line import best, gains_table, learned_table, line_chapter, line_table, release_table, thrown_table


def found(mean, shifts=6):
    values = mean + np.linspace(-1.0, 1.0, shifts)
    return {"value_per_min": values.tolist(), "pick_rate": 0.85, "success": 0.98}


TABLE = {
    "random": found(30.0),
    "fifo": found(60.0),
    "spt": found(70.0),
    "atc": found(72.0),
    "pair": found(71.0),
    "beam": found(76.0, shifts=3),
    "residual_ppo": found(75.0),
}
DATA = {
    "shifts": 6,
    "thrown_shifts": 3,
    "seed": 0,
    "versions": {"python": "3.11"},
    "line": {"single": TABLE},
    "full": {"single": {"fifo": found(59.0, shifts=3)}},
    "release": {"analytic, fifo": found(50.0), "learned, residual_ppo": found(55.0)},
}


def test_the_best_is_told_by_the_shifts_that_all_have_worked():
    assert best(TABLE, ("beam", "residual_ppo")) == "beam"
    assert best({"one": found(10.0), "other": {"value_per_min": [11.0]}}, ("one", "other")) == "other"


def test_everybody_has_a_row_with_mean_and_interval():
    rows = line_table(DATA).rows
    assert [row[0] for row in rows] == [f"`{name}`" for name in TABLE]
    assert rows[1][1].startswith("60.0 (")


def test_gains_are_those_of_the_means_on_shared_shifts():
    (row,) = gains_table(DATA).rows
    assert row[1].startswith("`atc` +20.0 %")
    first_three = np.array(TABLE["fifo"]["value_per_min"])[:3].mean()
    assert row[2].startswith(f"`beam` {100 * (76.0 / first_three - 1):+.1f} %")
    assert row[4].startswith("`residual_ppo`")


def test_a_level_on_which_nobody_has_learned_says_so():
    table = {name: one for name, one in TABLE.items() if name != "residual_ppo"}
    (row,) = gains_table({**DATA, "line": {"single": table}}).rows
    assert row[4] == "-"


def test_of_several_seeds_the_worst_is_compared():
    seeds = {"0": found(75.0), "1": found(73.0), "2": found(77.0)}
    (row,) = learned_table({**DATA, "learned": {"single": {"residual_ppo": seeds}}}).rows
    assert row[:4] == ["`single`", "`residual_ppo`", "3", "75.0 (73.0..77.0)"]
    assert row[4].startswith(f"`atc` {100 * (73.0 / 72.0 - 1):+.1f} %")
    assert row[5] == "-"
    first_three = np.array(TABLE["beam"]["value_per_min"])
    worst = np.array(found(73.0)["value_per_min"])[:3]
    assert row[6].startswith(f"`beam` {100 * (worst.mean() / first_three.mean() - 1):+.1f} %")


def test_throws_stand_beside_the_same_shifts_by_table():
    (row,) = thrown_table(DATA).rows
    by_table = np.array(TABLE["fifo"]["value_per_min"])[:3].mean()
    assert row[2].startswith("59.0")
    assert row[3].startswith(f"{by_table:.1f}")


def test_releases_and_orders_are_compared_with_the_plainest():
    first, last = release_table(DATA).rows
    assert first[2].startswith("+0.0 %")
    assert last[2].startswith("+10.0 %")


def test_the_chapter_has_all_tables_and_a_figure():
    chapter = line_chapter("line", DATA)
    assert len(chapter.parts) == 4
    assert chapter.figures["line.svg"].startswith("<?xml")
