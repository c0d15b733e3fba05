"""A submission: what a user types, what the file holds, and what is refused."""

import json
from pathlib import Path
from typing import Any

import pytest

from agents.benchmark.submit import submission_name
from agents.ground.places import POLICY
from agents.report import submissions
from agents.report.submissions import HEADER
from agents.results import compare
from agents.results.content import read_form
from tests.tools.benchmark import write
from tests.tools.commands import answered, refused

MODULE = """
from agents.controllers.protocol import Controller
import numpy as np

class Mine(Controller):
    name = "mine"
    shift = 0.0
    def act(self, observation):
        return np.full((len(observation.kind), 2), self.shift, dtype=np.float32)

class Learns(Mine):
    def learn(self, outcome):
        self.shift -= 0.1 * np.nan_to_num(outcome.error[:, 0]).mean()
"""
PLAN = """
name: small
env: ToyThrow-v0
train_level: waste
levels: [waste, unseen]
picks: 24
num_envs: 8
entries: [{label: analytic, controller: analytic}]
"""

pytestmark = pytest.mark.usefixtures("worker_here")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a module of a user, in which the benchmark has few throws."""
    name = f"mine_{abs(hash(tmp_path))}"  # a module of its own for each test
    (tmp_path / f"{name}.py").write_text(MODULE)
    (tmp_path / "plan.yaml").write_text(PLAN)
    monkeypatch.setattr(compare, "BENCHMARKS", {"ToyThrow-v0": tmp_path / "plan.yaml"})
    monkeypatch.setattr("agents.benchmark.submit.MADE", tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path / f"{name}.py"


def submit(*words: str) -> None:
    code, complaint = answered("agents.benchmark.submit", *words, "--by", "Me", "--jobs", "1")
    assert code == 0, complaint


def test_a_module_is_measured_and_copied_and_verified(here: Path) -> None:
    name = here.stem
    submit(f"{name}:Mine", "--about", "Nothing new.", "--out", "handed")
    file = here.parent / "handed" / f"{name}.json"
    data = json.loads(file.read_text())
    assert (data["by"], data["about"]) == ("Me", "Nothing new.")
    assert data["command"] == f"pnt-gym submit {name}:Mine --by Me"
    rows = read_form(file).data["results"]
    assert [(row["level"], len(row["columns"]["item"])) for row in rows] == [("waste", 24), ("unseen", 24)]
    assert file.with_suffix(".py").read_text() == MODULE
    code, _ = answered("agents.benchmark.verify", str(file), "--trust", "--rows", "9")
    assert code == 0


def test_numbers_beside_a_module_go_along(here: Path) -> None:
    here.with_suffix(".npz").write_bytes(b"numbers")
    submit(f"{here.stem}:Mine", "--learned-from", "1000", "--out", "handed")
    file = here.parent / "handed" / here.name
    assert file.with_suffix(".npz").read_bytes() == b"numbers"
    assert json.loads(file.with_suffix(".json").read_text())["learned_from"] == 1000
    here.with_suffix(".npz").write_bytes(b"0" * 400_001)
    reason = refused("agents.benchmark.submit", f"{here.stem}:Mine", "--by", "Me", "--out", "handed")
    assert "400,001 bytes" in reason


CHOOSES = """
import numpy as np
from agents.controllers import Controller

class First(Controller):
    name = "first"

    def act(self, observation):
        return np.zeros(len(observation.features), dtype=np.int64)
"""


def test_a_chooser_of_a_line_works_the_shifts_of_the_lines_benchmark(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here.write_text(CHOOSES)
    plan = here.parent / "line.yaml"
    plan.write_text(
        "{name: few, env: PnTLine-v0, train_level: each, levels: [single], shifts: 2, num_envs: 2, "
        "entries: [{label: fifo, controller: fifo}]}"
    )
    monkeypatch.setattr(compare, "BENCHMARKS", {"PnTLine-v0": plan})
    submit(f"{here.stem}:First", "--env", "PnTLine-v0", "--out", "handed")
    file = here.parent / "handed" / f"{here.stem}.json"
    (row,) = read_form(file).data["table"]
    assert row["level"] == "single" and row["value_per_min"] > 10.0
    code, _ = answered("agents.benchmark.verify", str(file), "--trust", "--rows", "1")
    assert code == 0


def test_one_that_learns_learns_several_times(here: Path) -> None:
    submit(f"{here.stem}:Learns", "--throws", "16", "--seeds", "2", "--out", ".")
    rows = json.loads(here.with_suffix(".json").read_text())["results"]
    assert [(row["seed"], row["throws"]) for row in rows if row["level"] == "waste"] == [(0, 16), (1, 16)]


def test_the_policy_of_a_run_is_copied(here: Path) -> None:
    submit(str(POLICY), "--name", "trained", "--out", "handed")
    folder = here.parent / "handed" / "trained"
    assert (folder / "policy.npz").read_bytes() == (POLICY / "policy.npz").read_bytes()
    assert not (folder / "model.zip").exists()
    (entry,) = json.loads((here.parent / "handed" / "trained.json").read_text())["plan"]["entries"]
    assert entry["controller"] == "handed/trained"
    code, _ = answered("agents.benchmark.verify", "handed/trained.json", "--rows", "1", "--throws", "8")
    assert code == 0


def test_what_cannot_be_handed_in_is_refused(here: Path) -> None:
    for words, reason in (
        ((f"{here.stem}:Mine", "--name", "other"), "a submission has the name of its module"),
        (("json.tool:Mine",), "is not one file in the working folder"),
        (("nothing",), "unknown controller 'nothing'"),
        (("ridge",), "a controller that learns needs numbers above 0"),
        (("analytic", "--throws", "-1"), "--throws"),
        (("ridge", "--throws", "9", "--learned-from", "9"), "--learned-from is of a policy that has learned"),
        (("analytic", "--env", "ToyThrw-v0"), "did you mean 'ToyThrow-v0'"),
    ):
        assert reason in refused("agents.benchmark.submit", *words, "--by", "Me", "--out", "handed")
    assert "--by is empty" in refused("agents.benchmark.submit", "analytic", "--by", " ", "--out", "handed")


def _changed(name: str, value: Any) -> Any:
    def change(data: dict[str, Any]) -> None:
        data["plan"][name] = value

    return change


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (_changed("picks", 8), "has picks 8; the benchmark has 24"),
        (_changed("seed", 5), "has seed 5; the benchmark has 0"),
        (_changed("env", "PnTAdapt-v0"), "unknown environment 'PnTAdapt-v0'"),
        (lambda data: data.pop("by"), "has no 'by'"),
        (lambda data: data["results"][0].update(label="else"), "must have the label"),
    ],
)
def test_a_file_of_other_throws_or_form_is_refused(here: Path, change: Any, reason: str) -> None:
    submit("analytic", "--out", ".")
    file = here.parent / "analytic.json"
    data = json.loads(file.read_text())
    change(data)
    file.write_text(json.dumps(data))
    assert reason in refused("agents.benchmark.verify", str(file))


def test_submissions_stand_beside_the_benchmarks_rows_with_paired_differences(here: Path) -> None:
    results = here.parent / "results"
    submit(f"{here.stem}:Mine", "--out", "results/submissions")
    submit("analytic", "--out", ".")
    data = read_form(here.parent / "analytic.json").data
    write(results / "benchmark.json", data)
    rows = [dict(zip(HEADER, row, strict=True)) for row in submissions.grid(results).rows]
    assert [(row["level"], row["controller"], row["by"]) for row in rows] == [
        ("waste", "analytic", "the project"),
        ("waste", here.stem, "Me"),
        ("unseen", "analytic", "the project"),
        ("unseen", here.stem, "Me"),
    ]
    assert [row["landing, less the planner's"] for row in rows] == ["-", "0.0 (0.0..0.0) mm"] * 2
    data["results"][0]["columns"]["item"][0] += 1
    write(results / "benchmark.json", data)
    changed = dict(zip(HEADER, submissions.grid(results).rows[1], strict=True))
    assert changed["landing, less the planner's"] == "-"


def test_without_submissions_there_is_no_table(tmp_path: Path) -> None:
    assert submissions.grid(tmp_path).rows == []


def test_the_usual_name() -> None:
    assert submission_name("mine:Mine") == "mine"
    assert submission_name("runs/sac-7") == "sac-7"
    assert submission_name("shipped:waste-sac") == "waste-sac"
    assert submission_name("ridge") == "ridge"
