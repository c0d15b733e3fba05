"""The runner of benchmarks measures a study: it goes on after an end, keeps rows, and tells wrong plans."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from agents.ground import work
from agents.ground.work import Completion, Job
from pnt_gym.constants import WORLD
from tests.tools.commands import answered, refused

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
COMMAND = ("agents.benchmark", "--config", "plan.yaml", "--jobs", "1", "--out", "out.json", "--work", "work")
OTHER = "  other: {measure: throws.figures, settings: {level: {fidelity: flight}, cells: 2, figures: [placed]}}\n"


JOBS: list[str] = []
"""Names of the jobs that the command has done."""


@pytest.fixture
def desk_with_a_plan(desk: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a small plan, whose jobs this process does."""

    @contextmanager
    def in_this_process(jobs: Sequence[Job], folder: Path) -> Iterator[Iterator[tuple[Job, Completion]]]:
        JOBS.extend(job.name for job in jobs)
        yield ((job, work.run(job, folder)) for job in jobs)

    monkeypatch.setattr("agents.ground.cluster.pool", lambda *_: in_this_process)
    (desk / "plan.yaml").write_text(SMALL)
    return desk


def measure(*options: str) -> tuple[dict[str, Any], int]:
    """The file of the study, and the number of cases that were measured for it."""
    JOBS.clear()
    code, text = answered(*COMMAND, *options)
    assert code == 0, text
    return json.loads(Path("out.json").read_text()), len(JOBS)


@pytest.mark.usefixtures("desk_with_a_plan")
def test_a_study_that_was_killed_goes_on_with_the_cases_that_it_has(monkeypatch: pytest.MonkeyPatch) -> None:
    whole, count = measure()
    rows = whole["rows"]
    assert [(row["level"], row["mismatch"]) for row in rows] == [
        ("waste_plain", 0.0), ("waste_plain", 1.0), ("soft", 0.0), ("soft", 1.0)
    ]  # fmt: skip
    assert all(0.0 <= row["success"] <= 1.0 < row["picks_per_min"] for row in rows)
    assert (whole["study"], whole["throws"], whole["seed"], count) == ("small", 4, 0, 4)
    for file in list(Path("work").glob("*.json"))[:2]:
        file.unlink()
    assert measure() == (whole, 2)
    assert measure() == (whole, 0)
    monkeypatch.setattr("agents.benchmark.study.code_digest", lambda patterns: "changed")
    assert measure() == (whole, 4), "other code measures every case anew"


@pytest.mark.usefixtures("desk_with_a_plan")
def test_a_named_part_is_measured_and_the_rows_of_the_others_are_kept() -> None:
    Path("plan.yaml").write_text(SMALL + OTHER)
    whole, _ = measure()
    changed = SMALL.replace("[0.0, 1.0]", "[0.0, 0.5, 1.0]") + OTHER
    Path("plan.yaml").write_text(changed)
    marked = {**whole, "rows": [*whole["rows"][:-1], {**whole["rows"][-1], "mark": 1}]}
    Path("out.json").write_text(json.dumps(marked))
    said = "'out.json' lacks 2 of the 7 cases of its study, the first of which is part throws, level waste_plain"
    assert said in refused(*COMMAND)
    data, count = measure("--only", "throws")
    assert [row.get("mismatch") for row in data["rows"]] == [0.0, 0.5, 1.0, 0.0, 0.5, 1.0, None]
    assert (data["rows"][-1]["mark"], count) == (1, 2)
    Path("plan.yaml").write_text(changed.replace("throws: 4", "throws: 2"))
    assert "is of another study, version, world, seed or number of throws" in refused(*COMMAND, "--only", "throws")
    assert measure()[0]["throws"] == 2


@pytest.mark.usefixtures("desk_with_a_plan")
def test_cases_of_which_the_file_has_no_row_are_measured_alone() -> None:
    whole, _ = measure()
    Path("plan.yaml").write_text(SMALL.replace("[0.0, 1.0]", "[0.0, 0.5, 1.0]") + OTHER)
    marked = {**whole, "rows": [{**row, "mark": 1} for row in whole["rows"]]}
    Path("out.json").write_text(json.dumps(marked))
    assert "give --missing to measure these alone" in refused(*COMMAND)
    assert "lacks 1 of the 7 cases" in refused(*COMMAND, "--missing", "--only", "throws")
    data, count = measure("--missing")
    assert [row.get("mark") for row in data["rows"]] == [1, None, 1, 1, None, 1, None]
    assert [row.get("mismatch") for row in data["rows"]] == [0.0, 0.5, 1.0, 0.0, 0.5, 1.0, None]
    assert count == 3
    assert measure("--missing") == (data, 0)
    Path("out.json").unlink()
    assert measure("--missing")[1] == 0, "all pieces are there"
    Path("out.json").write_text(json.dumps({**data, "seed": 1}))
    assert "drop --missing" in refused(*COMMAND, "--missing")


@pytest.mark.usefixtures("desk_with_a_plan")
def test_rows_of_another_world_are_not_kept() -> None:
    whole, _ = measure()
    assert whole["world"] == WORLD
    text = json.dumps({name: value for name, value in whole.items() if name != "world"})
    Path("out.json").write_text(text)
    assert "is of another study, version, world, seed or number of throws" in refused(*COMMAND, "--only", "throws")
    assert Path("out.json").read_text() == text


@pytest.mark.usefixtures("desk_with_a_plan")
def test_a_file_that_an_earlier_version_has_not_finished_is_refused_in_one_sentence() -> None:
    """Earlier versions wrote the file case by case, each row with a digest."""
    whole, _ = measure()
    rows = [{**row, "digest": "0123456789abcdef"} for row in whole["rows"]]
    text = json.dumps({**whole, "rows": rows[:2]})
    Path("out.json").write_text(text)
    assert "'out.json' lacks 2 of the 4 cases of its study" in refused(*COMMAND)
    assert Path("out.json").read_text() == text
    Path("out.json").write_text(json.dumps({**whole, "rows": rows}))
    assert measure() == (whole, 0), "a whole file may be written anew"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("throws: 4", "throws: 0", "throws is 0: input should be greater than or equal to 1"),
        ("throws: 4", "throws: 4\nthings: 1", "unknown key 'things'"),
        ("throws.figures", "nowhere.figures", "measure: unknown module of benchmarks/studies 'nowhere'; known are"),
        ("throws.figures", "throws.nothing", "measure is 'throws.nothing'; throws has no function nothing"),
        ("throws.figures", "throws", "measure"),
        ("[0.0, 1.0]", "[1.0, 1.0]", "axes.level.mismatch: values [1.0, 1.0] must differ from one another"),
        ("[0.0, 1.0]", "[[0.0], [1.0]]", "axes.level.mismatch: a list of values or a mapping of values to settings"),
        ("[0.0, 1.0]", "[]", "axes.level.mismatch: a list of values or a mapping of values to settings is needed"),
        ("[waste_plain, soft]", "[moon]", "moon"),
        ("[success,", "[luck,", "unknown figure 'luck'"),
    ],
)
def test_a_wrong_plan_is_told_in_one_sentence(desk_with_a_plan: Path, old: str, new: str, said: str) -> None:
    (desk_with_a_plan / "plan.yaml").write_text(SMALL.replace(old, new))
    assert said in refused(*COMMAND)


@pytest.mark.usefixtures("desk_with_a_plan")
def test_a_figure_that_is_no_number_is_told_with_its_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.benchmark.study.measurement", lambda _: lambda *_: {"mean": float("nan")})
    assert "part throws, level waste_plain, mismatch 0.0: a figure is not a number" in refused(*COMMAND)


@pytest.mark.usefixtures("desk_with_a_plan")
def test_an_unknown_part_is_told_with_those_that_the_study_has() -> None:
    assert "--only: unknown part 'trows'; did you mean 'throws'?" in refused(*COMMAND, "--only", "trows")
