"""A benchmark computes the entries that are named, and keeps the other rows of its file."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import yaml

from agents.ground import work
from agents.ground.work import Completion, Job
from agents.results import content
from agents.results.content import read_form
from pnt_gym.constants import WORLD
from tests.tools.benchmark import forge, toy_plan, write
from tests.tools.commands import answered, refused

PLANNER = {"label": "analytic", "controller": "analytic"}
GOAL = {"label": "goal", "controller": "virtual_goal", "throws": [16], "options": {"gain": 0.8}}
SLOW = {**GOAL, "options": {"gain": 0.1}}
RIDGE = {"label": "ridge", "controller": "ridge", "throws": [16]}
PLAN = toy_plan(PLANNER, GOAL, seeds=[0])
COMMAND = ("agents.benchmark", "--config", "plan.yaml", "--jobs", "1", "--out", "out.json", "--work", "work")


@contextmanager
def in_this_process(jobs: Sequence[Job], folder: Path) -> Iterator[Iterator[tuple[Job, Completion]]]:
    """A pool without processes of its own, in which the toy environments exist."""
    yield ((job, work.run(job, folder)) for job in jobs)


def benchmark(plan: dict[str, Any], *options: str) -> dict[str, Any]:
    """The file that the command writes for a plan."""
    Path("plan.yaml").write_text(yaml.safe_dump(plan))
    code, text = answered(*COMMAND, *options)
    assert code == 0, text
    return read_form(Path("out.json")).data


def columns(data: dict[str, Any]) -> dict[str, Any]:
    return {row["label"]: row["columns"] for row in data["results"]}


def test_policies_that_no_row_names_any_more_go(tmp_path: Path) -> None:
    place, other = tmp_path / "out.json", tmp_path / "out" / "own.npz"
    row = {"label": "mlp", "columns": {}, "policy": "mlp-0.npz"}
    content.write(place, {}, [row, {**row, "policy": "mlp-1.npz"}], {"mlp-0.npz": b"a", "mlp-1.npz": b"b"})
    other.write_bytes(b"c")
    content.write(place, {}, [{**row, "policy": "mlp-1.npz"}], {})
    assert sorted(path.name for path in other.parent.iterdir()) == ["mlp-1.npz", "own.npz", "rows.npz"]


@pytest.fixture
def first(desk: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.setattr("agents.ground.cluster.pool", lambda *_: in_this_process)
    return benchmark(PLAN)


def test_the_named_entries_are_computed_and_the_other_rows_are_kept(first: dict[str, Any]) -> None:
    marked = next(row for row in first["results"] if row["label"] == "analytic")
    marked["learn_seconds"] = 7.0  # the mark of a row that nobody computes again
    forge(first)
    write(Path("out.json"), {**first, "seconds": 100.0})
    changed = {**PLAN, "entries": [PLANNER, SLOW, RIDGE]}
    second = benchmark(changed, "--only", "goal", "--only", "ridge")
    assert marked in second["results"]
    assert {row["label"] for row in second["table"]} == set(columns(second)) == {"analytic", "goal", "ridge"}
    whole = columns(benchmark(changed))
    assert columns(second) == whole
    assert columns(first)["goal"] != whole["goal"]
    assert second["seconds"] >= 100.0


@pytest.mark.parametrize(
    ("changes", "versions", "only", "words"),
    [
        ({}, {}, "nobody", "--only: unknown label 'nobody'; known are analytic, goal"),
        ({}, {"numpy": "1.0"}, "goal", "'out.json' is of numpy 1.0, here is "),
        ({}, {"world": "1"}, "goal", f"'out.json' is of world 1, here is {WORLD}; drop --only"),
        ({"picks": 32}, {}, "goal", "'out.json' is of a plan with other throws; drop --only"),
        ({"entries": [PLANNER, SLOW]}, {}, "analytic", "'out.json' has no rows of entry 'goal' as the plan has it"),
        ({"entries": [PLANNER, GOAL, RIDGE]}, {}, "goal", "'out.json' has no rows of entry 'ridge' as the plan has it"),
    ],
)
def test_rows_that_do_not_fit_are_refused(
    first: dict[str, Any], changes: dict[str, Any], versions: dict[str, str], only: str, words: str
) -> None:
    first["versions"] |= versions
    write(Path("out.json"), first)
    text = Path("out.json").read_text()
    Path("plan.yaml").write_text(yaml.safe_dump({**PLAN, **changes}))
    assert words in refused(*COMMAND, "--only", only)
    assert Path("out.json").read_text() == text
