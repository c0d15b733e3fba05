"""Studies are plans: those that ship can be read, have measurements, and committed rows are those of their cases."""

import json
import runpy
from pathlib import Path

import pytest

from agents.benchmark.study import measurement
from agents.ground.versions import world_of
from agents.results import study
from agents.results.study import STUDIES, StudyPlan, merge
from pnt_gym.constants import WORLD

SCRIPTS = sorted((Path(__file__).resolve().parents[1] / "benchmarks").rglob("*.py"))
ROOT = Path(__file__).resolve().parents[1]
RESULTS, DOCS = ROOT / "results", ROOT / "docs"


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_loads_and_says_what_it_is_for(path):
    assert runpy.run_path(str(path), run_name="loaded")["__doc__"]


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.yaml")), ids=lambda path: path.stem)
def test_plans_that_ship_have_cases_that_differ_and_measurements_that_are_there(path):
    plan = study.read(path)
    assert plan.name == path.stem
    cases = plan.cases()
    assert len({json.dumps(case.labels) for case in cases}) == len(cases)
    assert len({json.dumps([case.labels["part"], case.settings], sort_keys=True) for case in cases}) == len(cases)
    assert all(callable(measurement(case.measure)) for case in cases)


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.yaml")), ids=lambda path: path.stem)
def test_committed_rows_are_those_of_the_plan(path):
    file = RESULTS / path.name.replace(".yaml", ".json")
    if not file.exists():
        blocks = [table.block for table in study.read(path).tables if table.block]
        pages = [page.read_text(encoding="utf-8") for folder in (RESULTS, DOCS) for page in folder.rglob("*.md")]
        assert not [block for block in blocks for page in pages if f"<!-- table:{block} -->" in page]
        return
    contents = json.loads(file.read_text(encoding="utf-8"))
    if world_of(contents) < WORLD:  # and pages say so
        return
    plan, rows = study.read(path), contents["rows"]
    assert all(case.rows_of(rows) for case in plan.cases())
    assert all(any(case.rows_of([row]) for case in plan.cases()) for row in rows)


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
    assert [case.amount for case in (first, second)] == [(2, 0), (2, 0)]
    assert merge({"a": {"b": 1, "c": 2}}, {"a": {"c": 3}, "d": 4}) == {"a": {"b": 1, "c": 3}, "d": 4}
