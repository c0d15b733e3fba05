"""Studies are plans: those that ship can be read, a small one runs and goes on after an end, wrong ones are told."""

import json
import runpy
from pathlib import Path
from typing import Any

import pytest

from agents.ground.cli import run
from agents.report.study_plan import STUDIES, StudyPlan, merged, read_study
from benchmarks import study

SCRIPTS = sorted((Path(__file__).resolve().parents[1] / "benchmarks").rglob("*.py"))
ROOT = Path(__file__).resolve().parents[1]
RESULTS, DOCS = ROOT / "results", ROOT / "docs"
SMALL = """
study: small
about: what a test takes
throws: 4
levels: {soft: {base: waste_plain, fidelity: flight, cup: {stiffness: 1.0}}}
parts:
  throws:
    measure: throws.figures
    settings: {level: {fidelity: flight}, cells: 2, figures: [success, picks_per_min, success_by_item]}
    axes: {level: [waste_plain, soft], level.mismatch: [0.0, 1.0]}
"""


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_loads_and_says_what_it_is_for(path):
    assert runpy.run_path(str(path), run_name="loaded")["__doc__"]


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.yaml")), ids=lambda path: path.stem)
def test_plans_that_ship_have_cases_that_differ_and_measurements_that_are_there(path):
    plan = read_study(path)
    assert plan.study == path.stem
    cases = [case for name in plan.parts for case in plan.cases(name)]
    assert len({json.dumps(case.labels) for case in cases}) == len(cases)
    assert len({json.dumps([case.labels["part"], case.settings], sort_keys=True) for case in cases}) == len(cases)
    assert all(callable(study.measurement(part)) for part in plan.parts.values())


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.yaml")), ids=lambda path: path.stem)
def test_committed_rows_are_those_of_the_plan(path):
    file = RESULTS / path.name.replace(".yaml", ".json")
    if not file.exists():
        blocks = [table.block for table in read_study(path).tables if table.block]
        pages = [page.read_text(encoding="utf-8") for folder in (RESULTS, DOCS) for page in folder.rglob("*.md")]
        assert not [block for block in blocks for page in pages if f"<!-- table:{block} -->" in page]
        return
    plan, rows = read_study(path), json.loads(file.read_text(encoding="utf-8"))["rows"]
    cases = [case for name in plan.parts for case in plan.cases(name)]
    assert all(study.is_held(case, rows) for case in cases)
    assert all(any(study.is_held(case, [row]) for case in cases) for row in rows)


def test_axes_set_what_their_path_names_and_keep_the_settings_beside_it():
    plan = StudyPlan.model_validate(
        {
            "study": "s",
            "about": "x",
            "throws": 10,
            "levels": {"a": {"base": "waste", "cup": {"peel": True}}},
            "parts": {
                "p": {
                    "measure": "throws.figures",
                    "share": 0.25,
                    "settings": {"cells": 3, "level": {"timestep": 0.001}},
                    "axes": {"level": ["a", "dense"], "level.cup.stiffness": [1.0], "way": {"x": {"cells": 4}}},
                }
            },
        }
    )
    first, second = plan.cases("p")
    assert first.labels == {"part": "p", "level": "a", "stiffness": 1.0, "way": "x"}
    level = {"timestep": 0.001, "base": "waste", "cup": {"peel": True, "stiffness": 1.0}}
    assert first.settings == {"cells": 4, "level": level}
    assert second.settings["level"] == {"timestep": 0.001, "base": "dense", "cup": {"stiffness": 1.0}}
    assert plan.parts["p"].count(plan.throws) == 2
    assert merged({"a": {"b": 1, "c": 2}}, {"a": {"c": 3}, "d": 4}) == {"a": {"b": 1, "c": 3}, "d": 4}


def measure(*words: str | Path) -> None:
    run(study.main, study.Arguments, "study", list(map(str, words)))


def refusal(capsys: pytest.CaptureFixture[str], *words: str | Path) -> str:
    """The one sentence with which a study is refused."""
    with pytest.raises(SystemExit) as end:
        measure(*words)
    error = capsys.readouterr().err
    assert end.value.code == 2
    assert error.startswith("error: ")
    assert len(error.splitlines()) == 1
    return error


@pytest.fixture
def small(tmp_path: Path) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    return path


def rows_of(path: Path) -> list[dict[str, Any]]:
    return json.loads(path.read_text())["rows"]


def test_a_study_that_was_killed_goes_on_with_the_rows_that_it_has(small, tmp_path, monkeypatch, capsys):
    whole, cut = tmp_path / "whole.json", tmp_path / "cut.json"
    measure(small, "--json", whole)
    assert [(row["level"], row["mismatch"]) for row in rows_of(whole)] == [
        ("waste_plain", 0.0), ("waste_plain", 1.0), ("soft", 0.0), ("soft", 1.0)
    ]  # fmt: skip
    assert all(0.0 <= row["success"] <= 1.0 < row["picks_per_min"] for row in rows_of(whole))

    write, written = study.write_json, []

    def dying(path: Path, data: Any) -> None:
        write(path, data)
        written.append(len(data["rows"]))
        if len(written) == 2:
            raise SystemExit(9)

    monkeypatch.setattr(study, "write_json", dying)
    with pytest.raises(SystemExit):
        measure(small, "--json", cut)
    assert rows_of(cut) == rows_of(whole)[:2]
    measure(small, "--json", cut)
    assert written == [1, 2, 3, 4]
    assert json.loads(cut.read_text()) == json.loads(whole.read_text())
    capsys.readouterr()
    measure(small, "--json", cut)
    assert capsys.readouterr().out == ""


def test_processes_share_a_study_and_one_takes_over_all_rows_in_order(small, tmp_path, capsys):
    whole, parts = tmp_path / "whole.json", [tmp_path / f"{number}.json" for number in (1, 2, 3)]
    measure(small, "--json", whole)
    for number, part in enumerate(parts, 1):
        measure(small, "--json", part, "--share", f"{number}/3")
    assert sorted(len(rows_of(part)) for part in parts) == [1, 1, 2]
    capsys.readouterr()
    together = tmp_path / "together.json"
    measure(small, "--json", together, "--join", *reversed(parts))
    assert capsys.readouterr().out == "", "nothing is measured again"
    assert json.loads(together.read_text()) == json.loads(whole.read_text())
    measure(small, "--json", parts[0], "--throws", 2)
    assert "is of another study, or of other amounts" in refusal(capsys, small, "--join", parts[0])


@pytest.mark.parametrize("share", ["0/2", "3/2", "1", "a/2", "1/0"])
def test_a_wrong_share_is_refused(small, capsys, share):
    assert f"--share is '{share}'; it must be K/N" in refusal(capsys, small, "--share", share)


def test_rows_of_another_seed_or_of_other_code_are_not_gone_on_with(small, tmp_path, monkeypatch):
    file = tmp_path / "s.json"
    measure(small, "--json", file, "--throws", 2)
    first = json.loads(file.read_text())
    measure(small, "--json", file, "--throws", 2, "--seed", 1)
    second = json.loads(file.read_text())
    assert (first["throws"], first["seed"], second["seed"]) == (2, 0, 1)
    assert len(second["rows"]) == 4
    assert second["rows"] != first["rows"]
    monkeypatch.setattr(study, "code_digest", lambda patterns: "changed")
    measure(small, "--json", file, "--throws", 2, "--seed", 1)
    third = json.loads(file.read_text())
    assert not digests(third) & digests(second)
    assert without_digests(third) == without_digests(second)


def digests(data: dict[str, Any]) -> set[str]:
    return {row["digest"] for row in data["rows"]}


def without_digests(data: dict[str, Any]) -> list[dict[str, Any]]:
    return [{name: value for name, value in row.items() if name != "digest"} for row in data["rows"]]


def test_a_new_case_leaves_the_rows_of_the_others(small, tmp_path, capsys):
    file = tmp_path / "s.json"
    measure(small, "--json", file)
    first = rows_of(file)
    capsys.readouterr()
    small.write_text(SMALL.replace("[0.0, 1.0]", "[0.0, 0.5, 1.0]"))
    measure(small, "--json", file)
    assert [row["mismatch"] for row in rows_of(file)] == [0.0, 0.5, 1.0] * 2
    assert [row for row in rows_of(file) if row["mismatch"] != 0.5] == first
    assert capsys.readouterr().out.count("mismatch 0.5") == 2
    assert len(capsys.readouterr().out) == 0


def test_rows_of_other_code_can_be_joined_and_say_so(small, tmp_path, monkeypatch, capsys):
    old, new = tmp_path / "old.json", tmp_path / "new.json"
    measure(small, "--json", old, "--share", "1/2")
    monkeypatch.setattr(study, "code_digest", lambda patterns: "changed")
    measure(small, "--json", new, "--share", "2/2", "--join", old)
    assert len(rows_of(new)) == 4
    before = digests(json.loads(old.read_text()))
    assert [row["digest"] in before for row in rows_of(new)] == [True, False, True, False]
    capsys.readouterr()
    measure(small, "--json", new)
    assert capsys.readouterr().out.count("\n") == 2, "without --join rows of other code are measured again"
    assert not digests(json.loads(new.read_text())) & before


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("throws: 4", "throws: 0", "throws is 0: input should be greater than or equal to 1"),
        ("throws: 4", "throws: 4\nthings: 1", "unknown key 'things'"),
        ("throws.figures", "nowhere.figures", "measure: unknown module of benchmarks/studies 'nowhere'; known are"),
        ("throws.figures", "throws.nothing", "measure is 'throws.nothing'; throws has no function nothing"),
        ("throws.figures", "throws", "measure"),
        ("[0.0, 1.0]", "[1.0, 1.0]", "axes.level.mismatch: values [1.0, 1.0] must differ from one another"),
        ("[0.0, 1.0]", "[]", "axes.level.mismatch: a list of values or a mapping of values to settings is needed"),
        ("[waste_plain, soft]", "[moon]", "moon"),
        ("[success,", "[luck,", "unknown figure 'luck'"),
    ],
)
def test_a_wrong_plan_is_told_in_one_sentence(small, capsys, old, new, said):
    small.write_text(SMALL.replace(old, new))
    assert said in refusal(capsys, small)


def test_a_figure_that_is_no_number_is_told_with_its_case(small, capsys, monkeypatch):
    monkeypatch.setattr(study, "measurement", lambda part: lambda settings, amount: {"mean": float("nan")})
    said = "part throws, level waste_plain, mismatch 0.0: a figure is not a number"
    assert refusal(capsys, small).startswith(f"error: {said}")


def test_an_unknown_study_is_told_with_those_that_ship(capsys):
    assert "unknown study 'gripp'; did you mean 'grip'? known are grip" in refusal(capsys, "gripp")
