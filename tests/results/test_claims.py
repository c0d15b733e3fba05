"""Guards of committed numbers: what the pages say of drift, of lines, of the order of picks, and of neighbours."""

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import yaml

from agents.dispatchers.settings import PLANNERS
from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT
from agents.report.answers import interval
from agents.report.line import CLASS_BLIND, best, by_seed, learners, value
from agents.report.tables import rows_of
from agents.results.content import read_form
from pnt_gym.arrays import Floats
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.config import LineConfig


@cache
def read(name: str) -> Any:
    """Figures of a file of results, without the columns of a benchmark's rows."""
    return read_json(ROOT / "results" / f"{name}.json")


@cache
def details(name: str) -> Any:
    """A benchmark's file with the throws or shifts of its rows."""
    return read_form(ROOT / "results" / f"{name}.json").data


# Drift: results/drift.md and docs/drift.md.

ADAPT = {(row["controller"], row["level"]): row for row in read("benchmark_adapt")["table"]}
CAMERAS = {
    (row["camera"], row["controller"]): 1000.0 * row["error_m"]["value"]
    for row in read("adaptation")["rows"]
    if row["part"] == "camera"
}
KINDS = {(row["kind"], row["controller"]): row for row in read("adaptation")["rows"] if row["part"] == "newcomers"}
ADAPTING = ("ema", "kalman", "in_context")
FROM_WORST = ("static", "recursive_ridge", "ema", "in_context", "oracle_drift")
OTHER_DRIFTS = ("steps", "day_far", "steps_far", "drift_mix_far")
"""Drifts on which nothing learned."""


def error(name: str, level: str) -> float:
    """Mean landing error [mm]."""
    return 1000.0 * ADAPT[name, level]["landing_error_mean_m"]


ORDERS = [
    *((level, FROM_WORST) for level in ("day", "drift_mix")),
    *((level, ("static", "recursive_ridge", "ema", "kalman", "oracle_drift")) for level in OTHER_DRIFTS),
    *((level, ("static", "recurrent_ppo", "kalman")) for level in ("steps", "day_far")),
    *((level, ("ema", "kalman")) for level in ("day", "drift_mix")),
]
"""Controllers from the largest error on a level to the smallest."""


@pytest.mark.parametrize(("level", "names"), ORDERS)
def test_errors_under_drift_have_the_order_of_the_pages(level: str, names: tuple[str, ...]) -> None:
    assert all(error(one, level) > error(other, level) for one, other in pairwise(names))


MOST = {
    "day": {"static": 17.5, "ema": 13.0, "kalman": 12.0, "in_context": 12.5},
    "drift_mix": {"static": 21.0, "kalman": 14.5, "in_context": 14.5},
    "waste": {name: error("static", "waste") + 1.0 for name in ADAPTING},
    **{level: {"in_context": error("kalman", level) + 0.5} for level in OTHER_DRIFTS},
}
"""Largest errors [mm] by level; without drift adapting costs less than a millimetre."""


@pytest.mark.parametrize("level", MOST)
def test_errors_under_drift_stay_below_their_bounds(level: str) -> None:
    assert {name for name, most in MOST[level].items() if error(name, level) > most} == set()


@pytest.mark.parametrize(("level", "shifts"), [("day", 32), ("drift_mix", 256)])
def test_five_seeds_and_enough_shifts_stand_behind_each_error(level: str, shifts: int) -> None:
    for name in (*FROM_WORST, "kalman"):
        assert (ADAPT[name, level]["seeds"], ADAPT[name, level]["shifts"]) == ([0, 1, 2, 3, 4], shifts)
    if level == "drift_mix":
        for name in ("kalman", "in_context"):
            row = ADAPT[name, level]
            assert 0.0 < row["landing_error_high_m"] - row["landing_error_low_m"] < 2 * 0.00025, name


@pytest.mark.parametrize(("name", "first"), [("kalman", 0.0144), ("in_context", 0.0143)])
def test_the_first_shifts_of_drift_mix_are_hard_ones(name: str, first: float) -> None:
    rows = [row for row in details("benchmark_adapt")["results"] if (row["label"], row["level"]) == (name, "drift_mix")]
    columns = [np.array([row["columns"][c][: 32 * 50] for row in rows], dtype=float) for c in ("along_m", "across_m")]
    assert np.nanmean(np.hypot(*columns)) == pytest.approx(first, abs=0.0001)
    assert first > ADAPT[name, "drift_mix"]["landing_error_high_m"]


def test_what_the_pages_say_of_drift_in_shares() -> None:
    late = {
        name: ADAPT[name, "day"]["landing_error_second_half_m"] for name in ("kalman", "in_context", "oracle_drift")
    }
    assert max(late.values()) <= 0.0115
    assert late["kalman"] <= 1.05 * late["oracle_drift"]
    rates = [ADAPT[name, "day"]["success_rate"] for name in (*FROM_WORST, "kalman") if name != "recursive_ridge"]
    assert max(rates) - min(rates) < 0.03, "success does not see drift"
    static, learned, kalman = (error(name, "day") for name in ("static", "recurrent_ppo", "kalman"))
    assert 0.5 < (static - learned) / (static - kalman) < 0.6
    assert error("sac", "day") > 0.98 * static
    cost = {name: error(name, "day_far") - error(name, "day") for name in ("static", "kalman", "in_context")}
    assert cost.pop("static") > 7.0
    assert all(0.0 < more < 0.25 * (error("static", "day_far") - static) for more in cost.values())
    assert all(0.5 < error(name, "steps") - error(name, "day") < 1.5 for name in ADAPTING)


def test_a_worse_camera_over_the_bins_is_worth_less() -> None:
    for name in ADAPTING:
        assert CAMERAS["exact", name] < CAMERAS["10 mm", name] < CAMERAS["20 mm", name], name
    kalman = {camera: miss for (camera, name), miss in CAMERAS.items() if name == "kalman"}
    assert 1.0 < kalman["20 mm"] - kalman["5 mm"] < 1.6
    assert 0.3 < kalman["5 mm, 30 % unseen"] - kalman["5 mm"] < 0.7
    assert kalman["20 mm"] < min(CAMERAS["20 mm", name] for name in ("ema", "in_context"))
    assert kalman["blind"] == pytest.approx(CAMERAS["blind", "ema"], rel=1e-9)
    assert kalman["blind"] == pytest.approx(CAMERAS["blind", "static"], rel=0.03)


@pytest.mark.parametrize(("name", "throws"), [("ema", 5), ("kalman", 3), ("in_context", 3)])
def test_a_new_kind_is_understood_after_few_throws(name: str, throws: int) -> None:
    for kind in ("wet_paper", "sticky_pot"):
        static, learner = KINDS[kind, "static"], KINDS[kind, name]
        assert min(static["error_m"]) > 2.5 * static["floor_m"]
        assert learner["error_m"][3] < 1.25 * learner["floor_m"]
        assert learner["regret_m"] < 0.2 * static["regret_m"]
    assert max(KINDS[kind, name]["throws_to_floor"] for kind in ("pet_half_full", "wet_paper", "sticky_pot")) <= throws
    assert KINDS["wet_paper", name]["known_mean_m"] < KINDS["wet_paper", "static"]["known_mean_m"] + 0.0004


def test_the_level_on_the_page_of_drift_loads() -> None:
    text = (ROOT / "docs" / "drift.md").read_text(encoding="utf-8").split("```yaml\n")[1].split("```")[0]
    config = ConveyorConfig.load(yaml.safe_load(text))
    assert config.drift.moves
    assert (config.feedback.noise, config.picks_per_shift) == (0.010, 100)


# Planner, learners and oracle of single throws: README, docs/index.md and docs/reproducibility.md.

THROWS = [
    (name, level)
    for name in ("benchmark", "benchmark_precise", "benchmark_peers")
    for level in read(name)["plan"]["levels"]
]


def throws_row(name: str, level: str, label: str, throws: int) -> Any:
    """The row of a controller in the table of a benchmark."""
    keys = (label, throws, level)
    return next(row for row in read(name)["table"] if (row["label"], row["throws"], row["level"]) == keys)


def test_thirty_throws_beat_the_planner_of_a_throw() -> None:
    planner, ridge = (throws_row("benchmark", "waste", *who) for who in (("analytic", 0), ("ridge", 30)))
    ahead = interval(details("benchmark"), "waste", ridge, planner)
    assert ahead is not None
    assert ahead.low > 5.0


@pytest.mark.parametrize(("name", "level"), THROWS)
def test_every_learner_lands_farther_from_the_target_than_the_oracle(name: str, level: str) -> None:
    rows = [row for row in read(name)["table"] if row["level"] == level]
    oracles = [row["landing_error_mean_m"] for row in rows if row["label"] == "oracle"]
    assert all(row["landing_error_mean_m"] > min(oracles) for row in rows if row["label"] != "oracle" and oracles)


@pytest.mark.parametrize(
    ("name", "level", "clear"), [("benchmark", "waste", False), ("benchmark_peers", "boxes", True)]
)
def test_the_oracle_bounds_no_pace(name: str, level: str, clear: bool) -> None:
    sac, oracle = throws_row(name, level, "sac", 10_000), throws_row(name, level, "oracle", 0)
    ahead = interval(details(name), level, sac, oracle)
    assert ahead is not None
    assert (ahead.low > 0.0, ahead.excludes_zero) == (clear, clear)


BOUNDS = ("truly best", "be won", "best possible", "task allows", "truly optimal")
"""Words that call a controller a bound; learners stand above oracles in the tables."""


@pytest.mark.parametrize(
    "pattern", ["README.md", "docs/*.md", "docs/environments/*.md", "results/*.md", "results/tables/*.md"]
)
def test_no_page_calls_an_oracle_a_bound(pattern: str) -> None:
    pages = [*ROOT.glob(pattern)]
    assert pages
    told = {page.name: [words for words in BOUNDS if words in page.read_text(encoding="utf-8")] for page in pages}
    told.pop("changelog.md", None)
    assert not {name: words for name, words in told.items() if words}


# Lines: results/order.md and docs/line.md.

ALONE = tuple(name for name in PLANNERS if name != "guided_beam")
"""Planners that nothing guides."""
LEVELS = sorted({*LineConfig.level_names()} - {"nominal"})


def row(level: str, names: str | tuple[str, ...] | None) -> Any:
    """The row of a label after all it learned, or of the best of some controllers; None stands for all."""
    if isinstance(names, str):
        return [row for row in rows_of(read("benchmark_line"), [level]) if row["label"] == names][-1]
    return best(rows_of(read("benchmark_line"), [level]), names)


def seeds(level: str, name: str) -> list[Floats]:
    """Value of each shift, by seed of the learning."""
    return by_seed(details("benchmark_line"), row(level, name))


def gain(one: Floats, other: Floats, errors: float = 0.0) -> float:
    """Share by which one earns more than another on shared shifts, less some standard errors."""
    shared = min(len(one), len(other))
    share = (one[:shared] - other[:shared]) / other[:shared].mean()
    return float(share.mean() - errors * share.std() / np.sqrt(shared))


GAINS = [
    ("single", None, "fifo", 0.12),
    ("value", None, "fifo", 0.50),
    ("value", None, CLASS_BLIND, 0.06),
    ("skills3", None, CLASS_BLIND, 0.15),
    ("skills3_burst", None, CLASS_BLIND, 0.10),
    ("skills3", ALONE, CLASS_BLIND, 0.135),
    ("skills3_burst", ALONE, CLASS_BLIND, 0.10),
    *((level, "price", CLASS_BLIND, 0.05) for level in ("skills3", "skills3_burst")),
    *((level, "price", "beam", 0.02) for level in ("skills3", "skills3_burst")),
    *((level, "index", PLANNERS, -0.02) for level in LEVELS),
]
"""Level, controller, reference, and the least gain that the pages state."""


@pytest.mark.parametrize(("level", "names", "reference", "least"), GAINS)
def test_gains_on_a_line_are_those_of_the_pages(level: str, names: Any, reference: Any, least: float) -> None:
    assert gain(value(row(level, names)), value(row(level, reference))) > least


AHEAD = [
    *((level, "guided_beam", ALONE) for level in ("skills3", "skills3_burst")),
    *((level, ALONE, "price") for level in ("skills3", "skills3_burst")),
    *(("skills3_burst", "residual_ppo", reference) for reference in ("price", "beam")),
    *(("skills3_burst", name, ALONE) for name in ("index", "index_searched")),
]
"""Level, controller, and a reference that every seed of the controller beats by more than two standard errors."""


@pytest.mark.parametrize(("level", "names", "reference"), AHEAD)
def test_every_seed_is_clearly_ahead(level: str, names: Any, reference: Any) -> None:
    learned = {"residual_ppo", "index_searched"}
    found = seeds(level, names) if names in learned else [value(row(level, names))]
    assert len(found) == (5 if names in learned else 1)
    assert all(gain(one, value(row(level, reference)), 2.0) > 0.0 for one in found)


@pytest.mark.parametrize("level", LEVELS)
def test_what_the_pages_say_of_every_line(level: str) -> None:
    rows = rows_of(read("benchmark_line"), [level])
    wanted = {"random", "fifo", "spt", "value_rate", "atc", "beam", "index", "residual_ppo", "maskable_ppo"}
    assert wanted <= {one["label"] for one in rows}
    assert {(one["invalid_actions"], one["shifts"]) for one in rows} == {(0, 100)}
    assert row(level, PLANNERS)["label"] == "guided_beam"
    plain, residual = seeds(level, "maskable_ppo"), seeds(level, "residual_ppo")
    assert min(one.mean() for one in residual) > max(one.mean() for one in plain)
    behind = gain(value(row(level, "maskable_ppo")), value(row(level, CLASS_BLIND))) < 0.0
    assert behind == (level == "speed"), "where there is little to gain"
    if level != "skills3_burst":
        longest = seeds(level, "residual_ppo_long") if level == "skills3" else residual
        assert len(residual) == 5
        assert all(gain(one, value(row(level, ALONE))) > -0.02 for one in residual)
        assert all(gain(one, value(row(level, PLANNERS))) > -0.02 for one in longest)


@pytest.mark.parametrize("level", LEVELS)
def test_guided_beam_is_hard_to_beat(level: str) -> None:
    """No seed of what was learned or searched beats it on any of the six levels, and all are clearly behind."""
    planner = value(row(level, "guided_beam"))
    assert len(LEVELS) == 6
    for learner in learners(rows_of(read("benchmark_line"), [level])):
        assert gain(value(learner), planner, -2.0) < 0.0, learner["label"]
        assert all(gain(one, planner) < 0.0 for one in by_seed(details("benchmark_line"), learner)), learner["label"]


@pytest.mark.parametrize("level", ["skills3", "skills3_burst"])
def test_longer_returns_bring_more_where_a_robot_leaves_to_others(level: str) -> None:
    assert row(level, ALONE)["label"] == "price_beam"
    short, long = (seeds(level, name) for name in ("residual_ppo", "residual_ppo_long"))
    assert len(long) == 5
    assert min(one.mean() for one in long) > max(one.mean() for one in short)


def test_what_the_pages_say_of_single_lines() -> None:
    for name in ("price_beam", "index"):
        first, second, third = row("skills3", name)["utilisation"]
        assert 0.965 < second < first < 0.995
        assert 0.7 < third < 0.8
    learned, atc, beam = (row("value", name) for name in ("residual_ppo", "atc", "beam"))
    assert learned["throws"] == 500_000
    assert all(
        gain(one, value(atc)) > 0.6 * gain(value(beam), value(atc))
        for one in by_seed(details("benchmark_line"), learned)
    )
    assert sorted(read("benchmark_line")["plan"]["levels"]) == LEVELS


def test_tables_stand_in_for_throws_and_a_learned_release_keeps_its_worth() -> None:
    rows = read("line")["rows"]
    tables = [one for one in rows if one["part"] != "release"]
    assert len(tables) == 21
    for one in tables:
        full, by_table = (one[throws]["value_per_min"]["value"] for throws in ("full", "table"))
        assert full == pytest.approx(by_table, rel=0.04), (one["level"], one["controller"])
    worth = {(r["release"], r["order"]): r["value_per_min"]["value"] for r in rows if r["part"] == "release"}
    for order in ("fifo", "atc", "residual_ppo"):
        assert 1.1 < worth["learned", order] / worth["analytic", order] < 1.25
    for release in ("analytic", "learned"):
        assert worth[release, "residual_ppo"] / worth[release, "fifo"] > 1.6


# The order of picks, neighbours and the virtual goal: docs/levels.md, results/order.md and results/learning.md.


def test_no_patience_gains_more_than_the_default() -> None:
    """By more than the tuning tells apart: 0.2 % of picks a minute, on average of the levels."""
    default = ConveyorConfig.model_fields["patience"].default
    gains: dict[float, list[float]] = {}
    for one in read("dispatch")["rows"]:
        if one["part"] == "tuning":
            gains.setdefault(one["patience"], []).append(one["gain"])
    mean = {patience: sum(levels) / len(levels) for patience, levels in gains.items()}
    assert [len(levels) for levels in gains.values()] == [4] * 6
    assert max(mean.values()) - mean[default] < 0.002
    assert mean[default] - min(mean.values()) > 0.01


def test_on_a_dense_belt_the_shipped_rule_picks_a_tenth_more_than_the_first() -> None:
    dense = {
        one["rule"]: one for one in read("dispatch")["rows"] if (one["part"], one["level"]) == ("dispatch", "dense")
    }
    config = ConveyorConfig.load("dense")
    assert config.patience == ConveyorConfig.model_fields["patience"].default
    assert dense[config.dispatch]["picks_per_min_gain"]["value"] >= 0.10
    assert dense[config.dispatch]["sorted_per_min_gain"]["low"] > 0.0
    assert 1.5 < dense["first"]["passed_per_pick"]["value"] < 3.0


@pytest.mark.parametrize("gap", ["centre", "edge"])
def test_a_hand_that_rides_slips_little_and_picks_that_touch_no_neighbour_are_found(gap: str) -> None:
    study = {(r["gap"], r["speed"], r["hand"], r["neighbours"]): r for r in read("neighbours")["rows"]}
    for speed in (0.25, 0.8):
        for neighbours in ("ghosts", "solid"):
            standing, riding = (study[gap, speed, hand, neighbours] for hand in ("stands", "rides"))
            assert standing["slip_mean_m"] == pytest.approx(0.1 * speed, rel=0.01)
            assert riding["slip_p95_m"] < 1e-3
            assert riding["disturbed"]["value"] <= standing["disturbed"]["value"]
    for hand in ("stands", "rides"):
        ghosts, solid = (study[gap, 0.8, hand, neighbours] for neighbours in ("ghosts", "solid"))
        assert solid["disturbed"]["value"] < 0.3 * ghosts["disturbed"]["value"]
        assert solid["picks_per_min_interval"]["value"] > 0.95 * ghosts["picks_per_min_interval"]["value"]


def test_gains_of_the_virtual_goal_are_those_of_the_page() -> None:
    errors = {one["label"]: one["landing_error_mean_m"] for one in read("benchmark_goal")["table"]}
    for label in ("K_0.5", "planned_anew_K_0.5"):
        assert 0.0 < errors[f"{label}_in_64_cells"] - errors[label] < 0.003
    gains = [miss for label, miss in errors.items() if label.removeprefix("K_").replace(".", "").isdigit()]
    assert len(gains) == 5
    assert errors["K_chosen"] < min(gains) + 0.0005
    for gain_label in ("0.1", "0.5"):
        assert abs(errors[f"planned_anew_K_{gain_label}"] - errors[f"K_{gain_label}"]) < 0.001
