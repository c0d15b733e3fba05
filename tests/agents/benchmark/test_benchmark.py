"""The benchmark: paired, resumable, keyed by what its numbers depend on; and the report made of it."""

import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from agents.benchmark.run import jobs, run_piece
from agents.ground.cli import UsageError
from agents.ground.cluster import Needs
from agents.ground.places import SHIPPED as ROOT
from agents.judging.throw_record import ThrowRecord
from agents.judging.throws import OUTCOMES, kept_rows
from agents.report import tables
from agents.report.__main__ import Arguments as ReportArguments
from agents.report.__main__ import main as report
from agents.report.blocks import fill, makers_from
from agents.report.tables import sorting_table
from agents.results import compare
from agents.results import plan as plans
from agents.results.compare import assemble
from agents.results.content import read_form
from agents.results.plan import Plan, needs, pieces, read_plan
from benchmarks.kill_trials.commands import LEARNER
from tests.tools.benchmark import carried_out, toy_plan, write
from tests.tools.nightly import with_nightly

PLAN = toy_plan(
    {"label": "analytic", "controller": "analytic"},
    {"label": "goal", "controller": "virtual_goal", "throws": [64], "options": {"gain": 0.8}},
    {"label": "ridge", "controller": "ridge", "throws": [64, 200]},
    {"label": "oracle", "controller": "oracle"},
    levels=["waste", "unseen"],
    picks=120,
    seeds=[0, 1],
    learned=[{"label": "ridge", "throws": 200}],
    references=[{"label": "analytic"}, {"label": "goal", "throws": 64}],
    floors={"waste": "ridge"},
)

BARE: dict[str, Any] = {"learned": [], "references": [], "floors": {}}
"""Of a plan that compares nothing."""


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return carried_out(PLAN, tmp_path_factory.mktemp("work"))


def test_every_line_of_the_plan_is_there(done: dict[str, Any]) -> None:
    lines = {(row["label"], row["throws"], row["level"]) for row in done["table"]}
    expected = {("analytic", 0), ("goal", 64), ("ridge", 64), ("ridge", 200), ("oracle", 0)}
    assert lines == {(*line, level) for line in expected for level in ("waste", "unseen")}
    seeds = {row["label"]: row["seeds"] for row in done["table"]}
    assert seeds == {"analytic": [0], "oracle": [0], "goal": [0, 1], "ridge": [0, 1]}


def test_intervals_hold_the_difference_and_the_learner_wins(done: dict[str, Any]) -> None:
    row = {(r["label"], r["throws"], r["level"]): r for r in done["table"]}
    for found in done["comparisons"]:
        mine = row["ridge", 200, found["level"]]
        other = row[found["reference"]["label"], found["reference"]["throws"], found["level"]]
        expected = mine["landing_error_mean_m"] - other["landing_error_mean_m"]
        assert found["landing_error_m"]["value"] == pytest.approx(expected, abs=1e-6)
        assert found["landing_error_m"]["high"] < 0
        assert found["sorted_per_min"]["value"] == pytest.approx(mine["sorted_per_min"] - other["sorted_per_min"])


def test_what_an_earlier_version_showed_besides_is_no_contradiction(done: dict[str, Any], tmp_path: Path) -> None:
    former = [{**found, "by_seed": [{"seed": 0}]} for found in done["comparisons"]]
    write(tmp_path / "former.json", {**done, "comparisons": former})
    assert compare.check(read_form(tmp_path / "former.json")).data["comparisons"] == former
    write(tmp_path / "more.json", {**done, "comparisons": [{**found, "by_chance": 1.0} for found in former]})
    with pytest.raises(UsageError, match=r"comparisons\.0\.by_chance is no figure of theirs"):
        compare.check(read_form(tmp_path / "more.json"))


def test_floor_multiples(done: dict[str, Any]) -> None:
    rows = {(r["label"], r["throws"]): r for r in done["table"] if r["level"] == "waste"}
    assert rows["ridge", 200]["times_floor"] == pytest.approx(1.0)
    assert rows["oracle", 0]["times_floor"] < 1.0 < rows["analytic", 0]["times_floor"]


def test_unpaired_results_are_refused(done: dict[str, Any]) -> None:
    results = json.loads(json.dumps(done["results"]))
    results[-1]["columns"]["item"][0] += 1
    with pytest.raises(UsageError, match="threw different objects"):
        assemble(Plan.model_validate(PLAN), results)


def test_unmeasured_throws_are_left_out_of_errors() -> None:
    columns = {"along_m": [0.03, None], "across_m": [0.04, 0.0], "outcome": "sm", "cycle_s": [1.0, 1.0]}
    rows = kept_rows(columns)
    assert rows["error_m"] == pytest.approx([0.05, np.nan], nan_ok=True)
    assert rows["success"].tolist() == [True, False]


def judged(**more: Any) -> dict[str, Any]:
    """Six throws: sorted, in a bin of another kind, not picked, lost, beside its bin, and unmeasured."""
    columns = {
        "error_m": [0.01, 0.02, None, 0.4, 0.3, 0.2], "outcome": "sapdmr", "cycle_s": [1.0] * 6, "item": [0] * 6,
        "clipped": 0, "recontact": 0, **more,
    }  # fmt: skip
    return {"label": "x", "seed": 0, "learn_seconds": 0.0, "columns": columns}


def test_what_a_sorter_is_judged_by() -> None:
    counts = {"passed": 4, "ended": 4, "belong": 2, "dropped": 1, "energy_j": 240.0}
    found = ThrowRecord.summarise([judged(**counts), judged(**counts)], 16)
    assert (found["success_rate"], found["share_sorted"]) == (pytest.approx(2 / 6), pytest.approx(1 / 6))
    assert found["sorted_per_min"] == pytest.approx(10.0)
    assert found["recovery"] == pytest.approx(1 / 10)
    assert found["purity"] == pytest.approx(1 / 2)
    assert (found["pick_rate"], found["drop_rate"]) == (pytest.approx(5 / 6), pytest.approx(1 / 5))
    assert found["energy_per_pick_j"] == pytest.approx(40.0)
    assert np.isfinite([found["landing_error_low_m"], found["landing_error_high_m"]]).all()
    assert sum(found[f"share_{name}"] for name in OUTCOMES) == pytest.approx(1.0)


def test_cells_that_practise_side_by_side_change_what_is_learned_and_not_the_held_out_throws(tmp_path: Path) -> None:
    goal = {"controller": "virtual_goal", "throws": [64], "options": {"gain": 0.8}}
    entries = [{"label": "few", **goal, "practice_envs": 2}, {"label": "usual", **goal}, {"label": "eight", **goal}]
    entries[2]["practice_envs"] = PLAN["num_envs"]
    plan = Plan.model_validate({**PLAN, **BARE, "entries": entries, "seeds": [0], "levels": ["waste"]})
    results = {row["label"]: row["columns"] for piece in pieces(plan) for row in run_piece(piece, tmp_path).results}
    assert results["usual"] == results["eight"] != results["few"]
    assert results["usual"]["item"] == results["few"]["item"]


def test_results_of_before_are_reported_without_what_they_do_not_tell(done: dict[str, Any]) -> None:
    found = ThrowRecord.summarise([judged()], 16)
    assert not {"recovery", "purity", "pick_rate", "drop_rate", "energy_per_pick_j"} & found.keys()
    old = [{k: v for k, v in row.items() if k not in ("share_astray", "share_unpicked")} for row in done["table"]]
    before = {**done, "table": [{k: v for k, v in row.items() if k != "share_dropped"} for row in old]}
    headlines = [grid.headline for grid in tables.grids(before)]
    assert "What failed, level waste" in headlines
    assert not any("judged by" in headline for headline in headlines)
    assert tables.failures(before, "waste") == tables.failures(done, "waste")


def test_the_table_of_a_sorter_has_what_its_level_tells(done: dict[str, Any]) -> None:
    told = {"purity": 0.98, "pick_rate": 0.9, "drop_rate": 0.01, "energy_per_pick_j": 40.0, "share_unpicked": 0.1}
    table = [row | (told if row["label"] == "ridge" else {}) for row in done["table"]]
    grid = sorting_table({**done, "table": table}, "waste")
    assert list(grid.header[2:]) == ["purity", "picks that sealed", "lost on the way", "energy per pick"]
    assert [row[2:] for row in grid.rows] == [["98.0 %", "90.0 %", "1.0 %", "40.0 J"]] * 2
    assert "not picked" in tables.failures({**done, "table": table}, "waste").header


def test_keys_change_with_what_numbers_depend_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def keys(**changes: Any) -> set[str]:
        return {piece.key for piece in pieces(Plan.model_validate({**PLAN, **changes}))}

    assert keys() == keys()
    for change in ({"picks": 121}, {"seed": 1}, {"num_envs": 4}):
        assert not keys() & keys(**change)
    assert len(keys() & keys(train_level="unseen")) == 0
    assert keys(picks_on={"unseen": PLAN["picks"]}) == keys()
    assert not keys() & keys(picks_on={"unseen": 2 * PLAN["picks"]})
    before = keys()
    monkeypatch.setattr(plans, "results_code", lambda: "other code")
    assert not before & keys()


def test_keys_change_with_what_ships_where_that_is_known_beforehand(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entries = [
        {"label": "given", "controller": "kalman"},
        {"label": "over", "controller": "recurrent_ppo", "throws": [100], "over": "static"},
        {"label": "practised", "controller": "static", "throws": [100]},
        {"label": "alone", "controller": "recurrent_ppo", "throws": [100]},
    ]
    shift = {"name": "adapt", "env": "PnTAdapt-v0", "train_level": "day", "levels": ["day"], "picks": 800, "seeds": [0]}

    def keys() -> dict[str, str]:
        return {piece.entry.label: piece.key for piece in pieces(Plan.model_validate({**shift, "entries": entries}))}

    before = keys()
    (tmp_path / "static.npz").write_bytes(b"other knowledge")
    monkeypatch.setattr("agents.judging.throw_trial.ADAPTIVE", tmp_path)
    after = keys()
    assert {name for name in before if before[name] != after[name]} == {"given", "over"}


def test_a_level_of_the_users_is_done_as_it_was_when_planned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("base.yaml").write_text(yaml.safe_dump({"base": "waste", "mismatch": 0.5}))
    Path("mild.yaml").write_text(yaml.safe_dump({"base": "base.yaml", "picks_per_shift": 3}))
    few = {"levels": ["mild.yaml", "unseen"], "train_level": "mild.yaml", "picks": 16}
    first, second = pieces(Plan.model_validate({**PLAN, **few, **BARE, "entries": PLAN["entries"][1:2]}))
    assert str(tmp_path).encode() not in pickle.dumps(first)
    before = run_piece(first, tmp_path)
    Path("base.yaml").unlink()
    Path("mild.yaml").unlink()
    after = run_piece(pickle.loads(pickle.dumps(first)), tmp_path)
    assert [r["columns"] for r in after.results] == [r["columns"] for r in before.results]
    assert [r["level"] for r in after.results] == ["mild.yaml", "unseen"]
    assert second.configs["mild.yaml"].mismatch == 0.5
    assert [*second.configs] == ["mild.yaml"]


def test_what_lies_on_this_machine_alone_is_refused(here: Path) -> None:
    Path("weights").write_text("1")
    own = {"label": "own", "controller": "theirs:Better", "options": {"gain": 0.5}}
    plan = {**PLAN, **BARE, "env": "lob:Lob-v0", "levels": ["home"], "train_level": "home", "entries": [own]}
    assert needs(Plan.model_validate(plan)) == Needs(("lob", "theirs"), torch=False)
    assert needs(Plan.model_validate(PLAN)) == Needs((), torch=False)
    fitted = {**plan, "entries": [own, {"label": "mlp", "controller": "mlp", "throws": [16]}]}
    assert needs(Plan.model_validate(fitted)).torch
    with pytest.raises(UsageError, match="entry 'own': gain 'weights' is a file, which lies on this machine alone"):
        needs(Plan.model_validate({**plan, "entries": [own | {"options": {"gain": "weights"}}]}))
    with pytest.raises(UsageError, match="level 'weights' is a file, which 'lob:Lob-v0' would have to read"):
        needs(Plan.model_validate({**plan, "levels": ["weights"]}))


def test_a_level_may_take_more_throws_than_the_others(tmp_path: Path) -> None:
    alone = {**PLAN, **BARE, "entries": PLAN["entries"][:1], "picks": 16}
    (few,) = pieces(Plan.model_validate(alone))
    (more,) = pieces(Plan.model_validate({**alone, "picks_on": {"unseen": 48}}))
    assert more.cost == few.cost + 32
    before, after = (run_piece(piece, tmp_path).results for piece in (few, more))
    assert [len(r["columns"]["outcome"]) for r in after] == [16, 48]
    assert after[0]["columns"] == before[0]["columns"]
    assert after[1]["columns"]["along_m"][:16] == before[1]["columns"]["along_m"]


def test_training_is_one_piece_for_all_its_throw_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    more = {"policy": "MlpPolicy", "learning_starts": 16, "batch_size": 16, "buffer_size": 500, "gradient_steps": -1}
    monkeypatch.setattr("agents.results.entries.hyperparameters", lambda *_: LEARNER | more)
    sac = {"label": "sac", "controller": "sac", "throws": [32, 64], "seeds": [0]}
    small = {**PLAN, **BARE, "entries": [sac], "levels": ["waste"], "picks": 16}
    (piece,) = pieces(Plan.model_validate(small))
    first = run_piece(piece, tmp_path).results
    assert [r["throws"] for r in first] == [32, 64]
    assert first[0]["columns"] != first[1]["columns"]
    # A piece that was cut off after its training goes on from the run it left.
    again = run_piece(piece, tmp_path).results
    assert [r["columns"] for r in again] == [r["columns"] for r in first]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"nme": "x"}, "unknown key 'nme'"),
        ({"entries": [{"label": "a", "controller": "ridge"}]}, r"has throws \(0,\)"),
        (
            {"entries": [{"label": "../up", "controller": "analytic"}]},
            r"entries.0.label is '\.\./up': files are called so",
        ),
        ({"learned": [{"label": "ridge", "throws": 7}]}, "unknown result 'ridge after 7'"),
        ({"floors": {"waste": "nobody"}}, "floors.waste: unknown label 'nobody'"),
        ({"levels": ["waste", "waste"]}, "levels: 'waste' is given 2 times; give it once"),
        ({"seeds": [3, 3, 3]}, "seeds: 3 is given 3 times; give it once"),
        (
            {"entries": [{"label": "a", "controller": "ridge", "throws": [8, 8]}]},
            "entry 'a': throws: 8 is given 2 times; give it once",
        ),
        ({"picks_on": {"tight": 500}}, "picks_on: unknown level 'tight'; known are "),
        (
            {"entries": [{"label": "a", "controller": "sac", "throws": [64], "practice_envs": 4}]},
            "entry 'a': `also`, `online` and `practice_envs` cannot be used with sac, td3",
        ),
    ],
)
def test_bad_plans_are_explained(tmp_path: Path, change: dict[str, Any], said: str) -> None:
    (tmp_path / "plan.yaml").write_text(yaml.safe_dump({**PLAN, **change}))
    with pytest.raises(UsageError, match=said) as refused:
        read_plan(tmp_path / "plan.yaml")
    assert "\n" not in str(refused.value)


PLANS = (
    *("benchmark", "benchmark_quick", "benchmark_goal", "benchmark_grasp"),
    *("benchmark_adapt", "benchmark_line_quick", "benchmark_line"),
)


@pytest.mark.parametrize("name", with_nightly(PLANS, PLANS[:-1]))
def test_shipped_plans_hold_together(name: str) -> None:
    plan = read_plan(ROOT / "configs" / f"{name}.yaml")
    made = pieces(plan)
    assert plan.name == name
    assert len({job.file for job in jobs(made)}) == len(jobs(made)) == len(made)
    assert len({(piece.name, piece.key) for piece in made}) == len({piece.name for piece in made}) == len(made)


def test_report_writes_tables_figures_and_page(done: dict[str, Any], tmp_path: Path) -> None:
    write(tmp_path / "benchmark.json", done)
    (tmp_path / "other.json").write_text("[1, 2]")
    (tmp_path / "README.top").write_text("# x\n<!-- table:benchmark -->\nold\n<!-- /table -->\nend\n")
    report(ReportArguments(results=tmp_path, readme=tmp_path / "README.top"))
    index = (tmp_path / "README.md").read_text()
    text = (tmp_path / "tables" / "benchmark.md").read_text()
    assert "(tables/benchmark.md)" in index
    assert "| ridge | 200 |" in text
    page = (tmp_path / "report.html").read_text()
    images = {path.name: path.read_bytes() for path in (tmp_path / "figures").iterdir()}
    figures = {name for name in images if not name.startswith("small_")}  # the small ones stand on the index alone
    # Images, in which nothing runs.
    assert page.count("<img") == page.count('src="figures/') == page.count("src=") == len(figures)
    assert page.index("<ol>") < page.index("<h2") < page.index("landing_error.svg")
    assert "http-equiv" not in page
    names = ("sorted_per_min", "losses", "landing_error", "learning_curves", "landing_clouds")
    assert figures == {f"{name}.svg" for name in names}
    report(ReportArguments(results=tmp_path, readme=tmp_path / "README.top"))
    assert images == {path.name: path.read_bytes() for path in (tmp_path / "figures").iterdir()}
    top = (tmp_path / "README.top").read_text()
    assert tables.table(done).markdown() in top
    assert top.startswith("# x\n<!-- table:benchmark -->")
    assert top.endswith("<!-- /table -->\nend\n")
    assert "\nold\n" not in top
    assert fill(top, makers_from(tmp_path)) == top
