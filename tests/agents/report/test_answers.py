"""Answers to questions from results that other plans made under the names of shipped results."""

from __future__ import annotations

import pytest

from agents.ground import files
from agents.report import contents
from agents.report.contents import read_results
from agents.report.questions import QUESTIONS

BENCHMARK = {
    "plan": {"levels": ["waste"]},
    "table": [{"label": "mine", "controller": "mine", "level": "waste", "throws": 10, "value": 1.0}],
    "comparisons": [],
}
STUDY = {"study": "mine", "throws": 10, "rows": [{"part": "mine", "level": "waste", "value": 1.0}]}
ASKED = [question for question in QUESTIONS if question.name not in ("speed", "papers")]


@pytest.mark.parametrize("data", [BENCHMARK, STUDY], ids=["a benchmark", "a study"])
@pytest.mark.parametrize("question", ASKED, ids=lambda question: question.name)
def test_a_plan_of_a_users_own_under_a_shipped_name_answers_nothing(tmp_path, question, data):
    assert question.answer_from(dict.fromkeys(question.sources, data), tmp_path) is None


def test_a_drifting_benchmark_without_a_controller_that_adapts_answers_nothing(tmp_path):
    rows = [
        {"label": name, "controller": name, "level": "day", "throws": 10, "landing_error_mean_m": 0.01}
        for name in ("static", "oracle_drift")
    ]
    data = {"plan": {"levels": ["day"]}, "table": rows, "comparisons": []}
    (drift,) = (question for question in QUESTIONS if question.name == "drift")
    assert drift.answer_from({"benchmark_adapt": data}, tmp_path) is None


def test_a_file_is_parsed_once_until_it_changes(tmp_path, monkeypatch):
    calls: list[str] = []

    def parse(path, *arguments):
        calls.append(path.name)
        return files.read_json(path, *arguments)

    monkeypatch.setattr(contents, "read_json", parse)
    path = tmp_path / "x.json"
    path.write_text("[1]")
    assert read_results(path) is read_results(path) == [1]
    path.write_text("[1, 2]")
    assert read_results(path) == [1, 2]
    assert calls == ["x.json", "x.json"]
    with pytest.raises(files.UsageError, match="cannot read"):
        read_results(tmp_path / "none.json")
