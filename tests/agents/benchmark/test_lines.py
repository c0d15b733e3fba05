"""The benchmark of lines: whole shifts, the same for all, compared shift by shift."""

import json
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from agents.dispatchers import registry
from agents.dispatchers.registry import line_core
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector, stream_seed
from agents.ground.places import SHIPPED
from agents.judging.evaluation import evaluate
from agents.judging.shift_record import ShiftRecord
from agents.judging.shifts import LISTS, MEANS, run_shifts
from agents.learning.runs import RunFolder
from agents.policies.scorer import Scorer
from agents.report.__main__ import benchmark_chapter
from agents.results.plan import Plan, needs, pieces
from tests.tools.benchmark import carried_out, write
from tests.tools.commands import answered, output_of

SMALL = {"n_envs": 2, "n_steps": 4, "batch_size": 8, "policy_kwargs": {"net_arch": [8]}}
LONG = "configs/rl/residual_ppo_long.yml"
SCORER = "results/policies/PnTLine-v0/value/residual_ppo"
pytestmark = pytest.mark.usefixtures("worker_here")
PLAN: dict[str, Any] = {
    "name": "small",
    "env": "PnTLine-v0",
    "train_level": "each",
    "levels": ["one.yaml", "three.yaml"],
    "shifts": 5,
    "num_envs": 2,
    "seeds": [0, 1],
    "entries": [
        {"label": "fifo", "controller": "fifo"},
        {"label": "atc", "controller": "atc"},
        {"label": "patient", "controller": "atc", "options": {"patience": 8.0}},
        {"label": "beam", "controller": "beam", "shifts": 3, "options": {"width": 2}, "levels": ["one.yaml"]},
        {"label": "scorer", "controller": SCORER, "levels": ["one.yaml"]},
        {"label": "ppo", "controller": "residual_ppo", "throws": [8, 20], "options": SMALL, "levels": ["one.yaml"]},
        {"label": "found", "controller": "index", "throws": [1], "seeds": [1], "levels": ["one.yaml"]},
    ],
    "learned": [{"label": "ppo", "throws": 20}, {"label": "beam"}],
    "references": [{"label": "fifo"}],
}


def write_levels(folder: Path) -> None:
    for name, base in (("one", "value"), ("three", "skills3")):
        (folder / f"{name}.yaml").write_text(yaml.safe_dump({"base": base, "name": name, "duration": 8.0}))


@pytest.fixture
def levels(desk: Path) -> Path:
    write_levels(desk)
    return desk


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("line")
    write_levels(place)
    return place


@pytest.fixture(scope="module")
def done(work: Path) -> dict[str, Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(work)
        return carried_out(PLAN, work)


def rows_by(done: dict[str, Any]) -> dict[Any, Any]:
    return {(row["label"], row["throws"], row["level"]): row for row in done["table"]}


def test_every_line_of_the_plan_is_there(done: dict[str, Any]) -> None:
    both = {(label, 0, level) for label in ("fifo", "atc", "patient") for level in PLAN["levels"]}
    alone = {("beam", 0), ("scorer", 0), ("ppo", 8), ("ppo", 20), ("found", 1)}
    assert set(rows_by(done)) == both | {(*line, "one.yaml") for line in alone}
    assert all(row["train_level"] == row["level"] for row in done["table"])
    assert rows_by(done)["ppo", 20, "one.yaml"]["seeds"] == [0, 1]
    assert {row["label"]: row["shifts"] for row in done["table"] if row["shifts"] != 5} == {"beam": 3}


@pytest.mark.parametrize(("label", "level"), [("atc", "one.yaml"), ("atc", "three.yaml"), ("scorer", "one.yaml")])
def test_figures_are_those_of_an_evaluation(done: dict[str, Any], work: Path, label: str, level: str) -> None:
    controller = "atc" if label == "atc" else str(SHIPPED / SCORER)
    told = evaluate(controller, "PnTLine-v0", 5, level=str(work / level), num_envs=2)
    row = rows_by(done)[label, 0, level]
    for name in (*MEANS, *LISTS, "pick_rate", "success_rate"):
        np.testing.assert_allclose(np.array(row[name], float), np.array(told[name], float), atol=1e-4)
    assert row["by_shift"]["value_per_min"] == pytest.approx(told["by_shift"]["value_per_min"], abs=1e-4)
    assert (row["items"], row["robots"]) == (told["items"], told["robots"])


def test_shifts_are_worked_again_by_a_stored_policy(work: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(work)
    file = carried_out({**PLAN, "learned": [], "entries": [PLAN["entries"][0], PLAN["entries"][5]]}, work)
    write(Path("file.json"), file)
    assert answered("agents.benchmark.verify", "file.json", "--rows", "99", "--json", "out.json")[0] == 0
    verdicts = json.loads(Path("out.json").read_text())["verdicts"]
    assert [row["verdict"] for row in verdicts] == ["equal"] * len(file["results"])
    assert [row["label"] for row in verdicts if row["stored"]] == ["ppo"] * 4


def test_settings_of_an_entry_are_its_own(done: dict[str, Any]) -> None:
    plain, patient = (rows_by(done)[label, 0, "one.yaml"]["by_shift"] for label in ("atc", "patient"))
    assert plain["value_per_min"] != patient["value_per_min"]


def test_what_is_trained_is_what_the_command_trains(done: dict[str, Any], work: Path) -> None:
    (work / "own.yml").write_text(yaml.safe_dump({"PnTLine-v0": {**_shipped(), **SMALL}}))
    what = "--env PnTLine-v0 --level one.yaml --algo residual_ppo --config own.yml --seed 1 --out run"
    output_of(f"train {what} --steps 20 --num-envs 2 --checkpoint-every 8 --eval-picks 0", work)
    (folder,) = work.glob("ppo-one-8-20-seed1-*-run")
    theirs, ours = (np.load(RunFolder(place).checkpoints[1] / "policy.npz") for place in (work / "run", folder))
    assert RunFolder(folder).checkpoints[1].name == "00000008"
    for name in theirs.files:
        np.testing.assert_array_equal(theirs[name], ours[name])


def test_what_is_searched_is_what_the_command_finds(done: dict[str, Any], work: Path) -> None:
    """The least search is a generation, whose index is judged on the same shifts."""
    output_of("line tune --level one.yaml --what index --generations 1 --seed 1 --out rules.yaml", work)
    settings = yaml.safe_load((work / "rules.yaml").read_text())["one"]["index"]
    with closing(make_vector("PnTLine-v0", str(work / "one.yaml"), 2, 1)) as env:
        index = registry.make("index", line_core(env), **settings)
        found = run_shifts(index, env, PLAN["shifts"], stream_seed("evaluate", 0))
    row = rows_by(done)["found", 1, "one.yaml"]
    assert row["seeds"] == [1]
    assert row["by_shift"]["value_per_min"] == pytest.approx(found.value, abs=1e-4)
    assert row["learn_seconds"] > 0.0


def _shipped() -> dict[str, Any]:
    text = (SHIPPED / "configs" / "rl" / "residual_ppo.yml").read_text()
    return {k: v for k, v in yaml.safe_load(text)["PnTLine-v0"].items() if k not in ("n_timesteps", "n_envs")}


def test_pairs_are_shifts_that_both_have_worked(done: dict[str, Any]) -> None:
    value = {label: np.array(row["by_shift"]["value_per_min"]) for (label, throws, level), row in rows_by(done).items()
             if level == "one.yaml" and throws in (0, 20)}  # fmt: skip
    found = {c["learned"]["label"]: c for c in done["comparisons"] if c["level"] == "one.yaml"}
    beam, ppo = found["beam"]["value_per_min"], found["ppo"]["value_per_min"]
    assert beam["value"] == pytest.approx((value["beam"] - value["fifo"][:3]).mean())
    assert ppo["value"] == pytest.approx((value["ppo"] - value["fifo"]).mean())
    assert ppo["low"] <= ppo["value"] <= ppo["high"]
    assert {c["level"] for c in done["comparisons"]} == {"one.yaml"}


def result(seed: int, **figures: list[Any]) -> dict[str, Any]:
    shifts = len(figures["value_per_min"])
    usual = {**dict.fromkeys(MEANS, [1.0] * shifts), **dict.fromkeys(LISTS, [[1.0]] * shifts)}
    counts = {"items": ["tray"], "robots": ["first"], "picks": 10, "picked": 8, "success": 6, "invalid": 1}
    columns = {**usual, **counts, "ms_per_decision": 0.5 + seed, **figures}
    return {"label": "x", "seed": seed, "learn_seconds": 2.0 * seed, "columns": columns}


def test_a_summary_by_hand() -> None:
    results = [
        result(0, value_per_min=[10.0, 30.0], recovery=[0.5, None], utilisation=[[1.0], [0.5]]),
        result(1, value_per_min=[20.0, 60.0], recovery=[0.1, 0.3], utilisation=[[0.25], [0.25]]),
    ]
    found = ShiftRecord.summarise(results, 16)
    assert (found["value_per_min"], found["value_per_min_by_seed"]) == (30.0, [20.0, 40.0])
    assert found["by_shift"]["value_per_min"] == [15.0, 45.0]
    assert found["recovery"] == pytest.approx(0.3)
    assert found["utilisation"] == [0.5]
    assert (found["pick_rate"], found["success_rate"], found["invalid_actions"]) == (0.8, 0.6, 2)
    assert (found["ms_per_decision"], found["learn_seconds"], found["shifts"]) == (1.0, 1.0, 2)
    # The interval is over the two shifts, whichever seed they are of.
    assert (found["value_per_min_low"], found["value_per_min_high"]) == (15.0, 45.0)


def test_what_is_known_is_not_measured_again(levels: Path) -> None:
    entries = [PLAN["entries"][0], {**PLAN["entries"][5], "throws": [8], "seeds": [0]}]
    plan = {**PLAN, "entries": entries, "learned": [], "references": []}
    Path("plan.yaml").write_text(yaml.safe_dump(plan))
    line = "benchmark --config plan.yaml --jobs 1 --out out.json --work kept"
    first = output_of(line, levels)
    assert "over fifo" in first
    found = Path("out.json").read_bytes()
    assert "done:" in first
    assert "done:" not in output_of(line, levels)
    assert Path("out.json").read_bytes() == found
    Path("plan.yaml").write_text(yaml.safe_dump({**plan, "entries": [*entries, PLAN["entries"][1]]}))
    added = {row.split()[1] for row in output_of(line, levels).splitlines() if row.startswith("done:")}
    assert added == {"atc-one-0-seed0", "atc-three-0-seed0"}


@pytest.mark.usefixtures("levels")
def test_keys_change_with_what_figures_depend_on(monkeypatch: pytest.MonkeyPatch) -> None:
    Scorer.linear().save(Path("own.npz"))
    scorer = {"label": "scorer", "controller": "own.npz", "levels": ["one.yaml"]}
    guided = {**scorer, "label": "guided", "controller": "guided_beam", "options": {"guide": "own.npz"}}
    entries = [*PLAN["entries"][:4], scorer, guided, *PLAN["entries"][5:]]

    def keys(**changes: Any) -> dict[str, str]:
        return {piece.name: piece.key for piece in pieces(Plan.model_validate({**PLAN, "entries": entries, **changes}))}

    def changed(what: Callable[[pytest.MonkeyPatch], None]) -> set[str]:
        with monkeypatch.context() as patch:
            what(patch)
            found = keys()
        return {name.partition("-")[0] for name, key in found.items() if key != before[name]}

    before = keys()
    assert before == keys()
    # Whoever has fewer shifts than the plan depends on those alone.
    assert set(before.values()) & set(keys(shifts=6, learned=[]).values()) == {before["beam-one-0-seed0"]}
    tuned = {"atc": {"patience": 3.0}, "beam": {}}
    told = "agents.judging.shift_trial.tuned_settings"
    assert changed(lambda p: p.setattr(told, lambda level, name, robots=1: tuned.get(name, {}))) == {
        "atc", "patient", "ppo", "found", "guided",
    }  # fmt: skip
    everybody = {"fifo", "atc", "patient", "beam", "scorer", "guided", "ppo", "found"}
    assert changed(lambda p: p.setattr("agents.judging.shift_trial.format_table", lambda chances: "other")) == everybody
    Path("own.npz").write_bytes(Path("own.npz").read_bytes() + b" ")
    assert changed(lambda p: None) == {"scorer", "guided"}
    before, entries[6] = keys(), {**entries[6], "config": LONG}
    assert changed(lambda p: None) == {"ppo"}


FIFO = {"label": "fifo", "controller": "fifo"}
PPO = {"label": "ppo", "controller": "residual_ppo", "throws": [8]}
GUIDED = {"label": "guided", "controller": "guided_beam"}


@pytest.mark.usefixtures("levels")
@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"picks": 100}, "picks goes with throws; 'PnTLine-v0' is judged by work shifts"),
        ({"floors": {"one.yaml": "fifo"}}, "floors goes with throws"),
        ({"shifts": 4, "entries": [{**FIFO, "shifts": 5}]}, "entry 'fifo' has shifts 5; the plan has 4"),
        ({"entries": [{"label": "r", "controller": "ridge", "throws": [9]}]}, "unknown controller of a line 'ridge'"),
        ({"entries": [{"label": "o", "controller": "my:Own"}]}, "entry 'o': module 'my' cannot be imported"),
        ({"entries": [{"label": "s", "controller": "none.npz"}]}, "none.npz"),
        (
            {"entries": [{**FIFO, "options": {"patience": 2}}]},
            "'fifo': unknown setting 'patience'; there is none",
        ),
        ({"entries": [{**GUIDED, "options": {"guide": "none.npz"}}]}, "scorer 'none.npz' does not exist"),
        ({"entries": [{**PPO, "config": "none.yml"}]}, "cannot read hyperparameters 'none.yml'"),
        ({"entries": [{**FIFO, "online": True}]}, "online goes with throws"),
        ({"env": "PnTRelease-v0", "levels": ["waste"], "train_level": "waste"}, "shifts goes with work shifts"),
    ],
)
def test_plans_that_fit_no_line_are_explained(change: dict[str, Any], said: str) -> None:
    plan = {**PLAN, "learned": [], "references": [], "entries": [FIFO], **change}
    with pytest.raises(UsageError, match=said) as refused:
        pieces(Plan.model_validate(plan))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("controller", ["atc", "maskable_ppo", "x/scorer.npz"])
def test_controllers_of_lines_throw_nothing(controller: str) -> None:
    throws = [64] if controller == "maskable_ppo" else [0]
    entry = {"label": "a", "controller": controller, "throws": throws}
    plan = {"name": "x", "train_level": "waste", "levels": ["waste"], "entries": [entry]}
    with pytest.raises(
        UsageError, match=f"entry 'a': (unknown controller '{controller}'|.*{controller}.* does not learn from throws)"
    ):
        pieces(Plan.model_validate(plan))


@pytest.mark.usefixtures("levels")
def test_what_was_learned_on_this_machine_stays_here() -> None:
    alone = {**PLAN, "learned": [], "references": []}
    assert needs(Plan.model_validate({**alone, "entries": PLAN["entries"][5:]})).torch
    Path("own.yml").write_text("default: {}")
    own = {**PLAN["entries"][5], "config": "own.yml"}
    with pytest.raises(UsageError, match=r"entry 'ppo': config 'own.yml' is a file, which lies on this machine alone"):
        needs(Plan.model_validate({**alone, "entries": [own]}))
    assert needs(Plan.model_validate({**alone, "entries": [{**own, "config": LONG}]})).torch
    with pytest.raises(UsageError, match=r"entry 'scorer': controller .* lies on this machine alone"):
        needs(Plan.model_validate(alone))
    guided = {"label": "guided", "controller": "guided_beam", "options": {"guide": SCORER}, "levels": ["one.yaml"]}
    shipped = {"label": "shipped", "controller": "shipped:line/value", "levels": ["one.yaml"]}
    assert not needs(Plan.model_validate({**alone, "entries": [shipped]})).torch
    guided_by = {**shipped, "controller": "guided_beam", "options": {"guide": "shipped:line/value"}}
    assert not needs(Plan.model_validate({**alone, "entries": [guided_by]})).modules
    with pytest.raises(UsageError, match=r"entry 'guided': guide .* lies on this machine alone"):
        needs(Plan.model_validate({**alone, "entries": [guided]}))


def test_the_report_has_tables_and_figures(done: dict[str, Any]) -> None:
    chapter = benchmark_chapter("benchmark_line", done)
    headlines = [grid.headline for grid in chapter.parts]
    assert headlines[0] == "Every controller on the same held-out shifts"
    assert "What a line is judged by, level three.yaml" in headlines
    assert "Recovery by item, level one.yaml" in headlines
    assert set(chapter.figures) == {"benchmark_line_value.svg", "benchmark_line_learning_curves.svg"}
    first = {(row[0], row[1]): row for row in chapter.parts[0].rows}
    row = rows_by(done)["ppo", 20, "one.yaml"]
    half = (row["value_per_min_high"] - row["value_per_min_low"]) / 2.0
    assert first["ppo", "20"][2] == f"{row['value_per_min']:.1f} ± {half:.1f}"
    assert first["ppo", "20"][3:] == ["-"]
    assert "What the order is worth" in headlines
    learned = next(grid for grid in chapter.parts if grid.headline == "Learned, in several seeds")
    assert [row[1:3] for row in learned.rows] == [["`ppo (20)`", "2"], ["`found (1)`", "1"]]
    pairs = next(grid for grid in chapter.parts if grid.headline.startswith("Paired differences"))
    assert list(pairs.header[2:]) == ["value/min", "sorted/min", "recovery", "recovery of value"]
    assert "throws" not in " ".join((*chapter.parts[0].header, chapter.parts[0].note))
