"""Answers to questions from results that other plans made under the names of shipped results."""

from __future__ import annotations

import pytest

from agents.ground import files
from agents.report import contents, headline
from agents.report.answers import difference, interval
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
    assert contents.read(path) is contents.read(path) == [1]
    path.write_text("[1, 2]")
    assert contents.read(path) == [1, 2]
    assert calls == ["x.json", "x.json"]
    with pytest.raises(files.UsageError, match="cannot read"):
        contents.read(tmp_path / "none.json")


def answer(name, tmp_path, **sources):
    """The answer to a question from contents of its files."""
    return next(question for question in QUESTIONS if question.name == name).answer_from(sources, tmp_path)


def line_of(**values):
    """A benchmark of a line with the same value in each of three shifts, by controller."""
    rows = [
        {"label": name, "controller": name, "level": "mine", "throws": 0, "shifts": 3, "value_per_min": worth}
        | {"by_shift": {"value_per_min": [worth, worth, worth]}}
        for name, worth in values.items()
    ]
    return {"plan": {"levels": ["mine"]}, "table": rows, "comparisons": []}


@pytest.mark.parametrize(
    ("learned", "said"),
    [
        (
            99.0,
            "Nothing learned or searched beats the planner `beam` on any of the 1 levels; nearest is `index` on `mine`",
        ),
        (
            101.0,
            "What was learned or searched beats the planner `beam` on `mine`, by most `index` on `mine`, with +1.0 %",
        ),
    ],
)
def test_the_order_says_whether_a_learner_beats_the_planners(tmp_path, learned, said):
    assert said in answer("order", tmp_path, benchmark_line=line_of(fifo=50.0, atc=80.0, beam=100.0, index=learned))


def benchmark_of(*controllers, items=0):
    """A benchmark of 40 throws of 1 s each: label, throws learned from and share that is sorted of each controller."""
    table, results = [], []
    for k, (label, throws, share) in enumerate(controllers):
        row = {"label": label, "throws": throws, "level": "mine"}
        outcome = "s" * round(40 * share) + "m" * (40 - round(40 * share))
        columns = {"item": [k * items] * 40, "outcome": outcome, "cycle_s": [1.0] * 40, "error_m": [0.1] * 40}
        table.append({**row, "controller": label, "sorted_per_min": 60.0 * share})
        results.append({**row, "seed": 0, "columns": columns})
    plan = {"levels": ["mine"], "num_envs": 1}
    return {"plan": plan, "table": table, "comparisons": [], "results": results}


CONTROLLERS = (("analytic", 0, 0.5), ("ridge", 30, 0.8), ("sac", 100, 0.95), ("oracle", 0, 0.95))


def test_the_answer_says_who_beats_the_planner_first_and_what_cannot_be_told_from_the_oracle(tmp_path):
    said = answer("learning", tmp_path, benchmark=benchmark_of(*CONTROLLERS))
    assert "`ridge` (ridge regression) after 30 throws already adds +18.0, 95 % interval +" in said
    assert "`sac` less the oracle is +0.0, 95 % interval +0.0 to +0.0, not distinguishable." in said
    weak = [(label, throws, 0.5) for label, throws, _ in CONTROLLERS]
    assert "No learner is sure to beat the planner." in answer("learning", tmp_path, benchmark=benchmark_of(*weak))


def test_the_planner_that_fits_the_cell_is_told_of_where_it_was_measured(tmp_path):
    without = answer("learning", tmp_path, benchmark=benchmark_of(*CONTROLLERS))
    logs = (("fitted_planner", 10, 0.6), ("fitted_planner", 40, 0.9))
    said = answer("learning", tmp_path, benchmark=benchmark_of(*CONTROLLERS, *logs))
    own = " The same planner, fitted to a log of 40 throws, reaches 54.0: +24.0, 95 % interval +15.0 to +33.0."
    assert said.replace(own, "") == without


def test_the_short_table_has_the_rows_that_were_measured():
    def row(label, throws):
        figures = {"landing_error_mean_m": 0.01, "success_rate": 0.8, "sorted_per_min": 50.0}
        return {"label": label, "throws": throws, "level": "mine", **figures}

    learned = [("ridge", 40), ("ridge", 1000), ("fitted_planner", 40), ("fitted_planner", 1000)]
    plan = {"levels": ["mine"], "picks": 9, "env": "PnTRelease-v0", "seeds": [0]}
    grid = headline.table({"plan": plan, "table": [row("analytic", 0), *(row(*one) for one in learned)]})
    assert [line[1] for line in grid.rows] == ["-", "40", "40", "1,000"]
    grid = headline.table({"plan": plan, "table": [row("analytic", 0), row("ridge", 1000)]})
    assert [line[:2] for line in grid.rows] == [["analytic planner", "-"], ["ridge regression", "1,000"]]


def test_throws_of_other_objects_have_no_interval():
    data = benchmark_of(*CONTROLLERS, items=1)
    planner, ridge, *_ = data["table"]
    assert interval(data, "mine", ridge, planner) is None
    assert difference(data, "mine", ridge, planner) == "+18.0"


def test_what_an_oracle_of_grasps_gains_is_the_whole_of_which_the_best_of_the_others_has_a_share(tmp_path):
    shares = {
        "centre": 0.4,
        "flattest": 0.5,
        "local_mlp": 0.6,
        "fitted_q": 0.7,
        "true_surface": 0.75,
        "oracle_grasp": 0.8,
    }
    data = benchmark_of(*((label, 0, share) for label, share in shares.items()))
    text = answer("grasp", tmp_path, benchmark_grasp=data)
    assert (
        "beforehand, and sorts 48.0; of what it gains on the middle, `fitted_q`, the best of all others, gains 75 %"
        in text
    )
    less = benchmark_of(*((label, 0, share) for label, share in shares.items() if label != "oracle_grasp"))
    assert answer("grasp", tmp_path, benchmark_grasp=less) is None
