"""Rows of a benchmark are carried out again: equal, different and where, or of another version."""

import copy
import json
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.progress import Progress

from agents.ground import tables
from agents.ground.tables import throws_bar
from agents.ground.work import LimitedWorker, UnfinishedError
from agents.results import columns
from agents.results.content import read_form
from pnt_gym.constants import WORLD
from tests.tools.benchmark import FILE, carried_out, forge, toy_plan, verify, write
from tests.tools.commands import answered, output_of, refused

RIDGE = {"label": "ridge", "controller": "ridge", "throws": [16, 32]}
PLAN = toy_plan({"label": "analytic", "controller": "analytic"}, RIDGE, levels=["waste", "unseen"], seeds=[0, 1])
ROWS = 10
"""Two levels of one planner, and of ridge with two seeds and two numbers of throws."""

pytestmark = pytest.mark.usefixtures("worker_here")


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return carried_out(PLAN, tmp_path_factory.mktemp("work"))


@pytest.fixture
def data(result: dict[str, Any], desk: Path) -> dict[str, Any]:
    return copy.deepcopy(result)


def change_head(data: dict[str, Any], **changes: Any) -> None:
    """Write a result, and change keys of its head."""
    write(FILE, data)
    FILE.write_text(json.dumps({**json.loads(FILE.read_text()), **changes}))


def test_every_row_of_an_honest_file_is_equal(data: dict[str, Any]) -> None:
    code, verdicts = verify(data, "--rows", "99")
    assert code == 0
    assert len(verdicts) == len(data["results"]) == ROWS
    assert {row["verdict"] for row in verdicts} == {"equal"}


def test_rows_are_counted_on_a_bar(data: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Progress] = []

    @contextmanager
    def watched() -> Generator[Progress, None, None]:
        with throws_bar() as bar:
            seen.append(bar)
            yield bar

    monkeypatch.setattr(tables, "throws_bar", watched)
    assert verify(data, "--rows", "3")[0] == 0
    assert [(task.description, task.completed, task.total) for task in seen[0].tasks] == [
        ("rows thrown again, 300 s each at most", 3, 3)
    ]


def test_a_sample_is_drawn_by_its_seed(data: dict[str, Any]) -> None:
    drawn = [verify(data, "--rows", "2", "--seed", seed)[1] for seed in ("0", "0", "1")]
    assert len(drawn[0]) == 2
    assert drawn[0] == drawn[1] != drawn[2]


def test_one_changed_outcome_is_found_with_its_place(data: dict[str, Any]) -> None:
    columns = data["results"][3]["columns"]
    outcomes = columns["outcome"]
    flipped = "m" if outcomes[17] == "s" else "s"
    columns["outcome"] = outcomes[:17] + flipped + outcomes[18:]
    forge(data)
    code, verdicts = verify(data, "--rows", str(ROWS))
    assert code == 1
    assert [n for n, row in enumerate(verdicts) if row["verdict"] == "different"] == [3]
    expected = {"column": "outcome", "at": 17, "file": flipped, "here": outcomes[17], "count": 1}
    assert verdicts[3]["difference"] == expected


@pytest.mark.parametrize(
    ("changes", "options", "words"),
    [
        ({"plan": {"name": "x"}}, (), "plan in 'file.json' has 3 problems:\n- key 'train_level' is missing"),
        ({"results": 3}, (), "'file.json': results is 3: input should be a valid list"),
        ({}, ("--rows", "0"), "--rows is 0; it must be at least 1"),
        ({}, ("--longest", "-1"), "--longest is -1; it must be above 0 s"),
        ({}, ("--longest", "nan"), "--longest is nan; it must be above 0 s"),
        (
            {"plan": {**PLAN, "env": "theirs:Toy-v0"}},
            (),
            "'file.json' names 'theirs:Toy-v0': importing the module runs",
        ),
    ],
)
def test_wrong_files_are_one_sentence(
    data: dict[str, Any], changes: dict[str, Any], options: tuple[str, ...], words: str
) -> None:
    change_head(data, **changes)
    assert words in refused("agents.benchmark.verify", FILE, *options)


@pytest.mark.parametrize("content", ["[]", '{"results": []}'])
def test_a_file_of_anything_else_is_one_sentence(tmp_path: Path, content: str) -> None:
    file = tmp_path / "file.json"
    file.write_text(content)
    words = "has no plan: only files of `pnt-gym benchmark` and `pnt-gym submit` are verified"
    assert words in refused("agents.benchmark.verify", str(file))


def test_a_row_of_no_entry_is_one_sentence(data: dict[str, Any]) -> None:
    data["results"][0]["seed"] = 7
    write(FILE, data)
    assert "seed 7, level" in refused("agents.benchmark.verify", "file.json")


def test_the_first_throws_alone_are_compared(data: dict[str, Any]) -> None:
    cycles = data["results"][0]["columns"]["cycle_s"]
    cycles[20] += 1.0
    forge(data)
    assert {row["verdict"] for row in verify(data, "--rows", "99", "--throws", "16")[1]} == {"equal"}
    cycles[15] += 1.0
    forge(data)
    _, verdicts = verify(data, "--rows", "99", "--throws", "16")
    (row,) = [row for row in verdicts if row["verdict"] != "equal"]
    assert (row["difference"]["column"], row["difference"]["at"]) == ("cycle_s", 15)


def test_a_drawn_sample_is_another_one_each_time(data: dict[str, Any]) -> None:
    write(FILE, data)
    seeds = set()
    for _ in range(3):
        answered("agents.benchmark.verify", "file.json", "--rows", "1", "--throws", "2", "--json", "out.json")
        seeds.add(json.loads(Path("out.json").read_text())["seed"])
    assert len(seeds) == 3


def test_rows_that_take_too_long_are_counted_as_left_out(
    data: dict[str, Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def late(worker: LimitedWorker, *_: Any) -> None:
        raise UnfinishedError(f"not done after {worker.seconds:g} s")

    monkeypatch.setattr(LimitedWorker, "call", late)
    code, verdicts = verify(data, "--rows", "2", "--longest", "7")
    assert code == 3
    assert [(row["verdict"], row["why"]) for row in verdicts] == [("left out", "not done after 7 s")] * 2


def _shown(data: dict[str, Any]) -> None:
    data["table"][0]["sorted_per_min"] += 1.0


def _renamed(data: dict[str, Any]) -> None:
    data["figures"]["sorted_per_min"]["label"] = "sorted/s"


def _invented(data: dict[str, Any]) -> None:
    data["table"][1]["stars"] = 5


def _dropped(data: dict[str, Any]) -> None:
    del data["results"][0]


def _doubled(data: dict[str, Any]) -> None:
    data["results"][1] = data["results"][0]


def _late(data: dict[str, Any]) -> None:
    data["results"][2]["columns"]["cycle_s"][3] = -1.0


def _torn(data: dict[str, Any]) -> None:
    columns = data["results"][2]["columns"]
    columns |= {name: values[:-1] for name, values in columns.items() if isinstance(values, list | str)}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_shown, "'file.json' shows what its throws do not give: table.0.sorted_per_min is"),
        (_renamed, "figures.sorted_per_min.label is 'sorted/s', and not 'sorted/min'"),
        (_invented, "table.1.stars is no figure of theirs"),
        (_dropped, "'file.json' lacks 1 of the rows of its plan; the first is label"),
        (_doubled, "stands there 2 times"),
        (_late, "cycle_s.3 is -1.0: input should be greater than 0"),
        (_torn, "has 23 entries; the plan asks for 24"),
    ],
)
def test_a_file_that_says_other_than_its_throws_is_refused(data: dict[str, Any], change: Any, words: str) -> None:
    change(data)
    write(FILE, data)
    for command in (("agents.benchmark.verify", "file.json"), ("agents.report", "--results", ".", "--readme", "x.md")):
        assert words in refused(*command)


def test_a_file_of_other_versions_is_equal_if_its_throws_are(data: dict[str, Any]) -> None:
    data["versions"] |= {"numpy": "1.0", "abacus": "2.0"}
    assert verify(data, "--rows", "1")[1][0]["verdict"] == "equal"
    said = output_of("benchmark.verify file.json --rows 1", Path())
    assert "the file was made with numpy 1.0; here is" in said
    assert "the file was made with abacus 2.0; here is none" in said


def test_a_file_that_names_no_world_is_of_the_first(data: dict[str, Any]) -> None:
    assert data["versions"].pop("world") == str(WORLD)
    verify(data, "--rows", "1")
    said = output_of("benchmark.verify file.json --rows 1", Path())
    assert f"the file was made with world 1; here is {WORLD}" in said


def test_rows_within_the_bounds_are_equal_and_their_differences_are_shown(data: dict[str, Any]) -> None:
    for row in data["results"]:
        row["columns"]["error_m" if "error_m" in row["columns"] else "along_m"][0] += 5e-5
    forge(data)
    code, verdicts = verify(data, "--rows", "99")
    assert code == 0
    assert {row["verdict"] for row in verdicts} == {"equal"}
    assert all((row["difference"]["at"], row["difference"]["count"]) == (0, 1) for row in verdicts)
    data["results"][0]["columns"]["cycle_s"][0] += 1.0  # one throw of 24 is more than a hundredth
    forge(data)
    code, verdicts = verify(data, "--rows", "99")
    assert code == 1
    assert [row["verdict"] for row in verdicts].count("different") == 1


def test_a_file_has_no_say_in_how_it_is_checked(data: dict[str, Any]) -> None:
    """Whatever the file says of its making, a changed throw is different, and every row may be drawn."""
    for row in data["results"]:
        row["columns"]["cycle_s"][7] += 0.5
        row["learn_seconds"] = 1e8
    data["versions"] = dict.fromkeys(data["versions"], "1.0")
    forge(data)
    code, verdicts = verify(data, "--rows", "99")
    assert code == 1
    assert [row["verdict"] for row in verdicts] == ["different"] * ROWS


def test_a_head_without_its_folder_is_one_sentence(data: dict[str, Any]) -> None:
    write(FILE, data)
    Path("file/rows.npz").unlink()
    assert "cannot read 'file/rows.npz': " in refused("agents.benchmark.verify", FILE)


TABLE = np.zeros(24, dtype=[("item", "i1"), ("outcome", "S1")])


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ([TABLE] * 9, "must hold one table for each of the 10 rows"),
        ([np.zeros(24)] * ROWS, "0 is no table"),
        ([np.zeros(5, dtype=[("item", "S0")])] * ROWS, "0 is no table"),
        ([np.zeros(24, dtype=[("item", "S9")])] * ROWS, "column 'item' holds neither letters nor numbers"),
        ([np.zeros(24, dtype=[("item", "i1", (2, 2))])] * ROWS, "column 'item' holds neither letters nor numbers"),
        ([TABLE] * ROWS, "key 'cycle_s' is missing"),
    ],
)
def test_tables_of_another_form_are_refused(data: dict[str, Any], tables: list[Any], words: str) -> None:
    write(FILE, data)
    with Path("file/rows.npz").open("wb") as file:
        np.savez(file, **{str(number): table for number, table in enumerate(tables)})
    assert words in refused("agents.benchmark.verify", FILE)


def test_tables_of_an_earlier_version_are_read(data: dict[str, Any]) -> None:
    """Each row had a table of its own, with a field for each column."""
    write(FILE, data)
    kept = dict(np.load("file/rows.npz"))
    members: dict[int, int] = {}
    former: dict[str, Any] = {}
    for row, group in enumerate(kept.pop("groups").tolist()):
        place = members[group] = members.get(group, -1) + 1
        columns = {key.split(" ", 1)[1]: stack[place] for key, stack in kept.items() if key.startswith(f"{group} ")}
        former[str(row)] = np.rec.fromarrays([*columns.values()], names=[*columns])
    np.savez("file/rows.npz", **former)
    assert read_form(FILE).data["results"] == data["results"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"groups": np.zeros(9, np.uint16)}, "must name the group of each of the 10 rows"),
        ({"groups": np.zeros(ROWS)}, "must name the group of each of the 10 rows"),
        ({"0 item": np.zeros((9, 24), np.int8)}, "'0 item' does not hold 10 rows"),
        ({"0 item": np.zeros(ROWS, np.int8)}, "'0 item' does not hold 10 rows"),
        ({"0": np.zeros((ROWS, 24), np.int8)}, "'0' does not hold 10 rows"),
        ({"7 item": np.zeros((ROWS, 24), np.int8)}, "'7 item' does not hold 0 rows"),
        ({"x item": np.zeros((ROWS, 24), np.int8)}, "which does not belong there"),
    ],
)
def test_columns_of_other_rows_are_refused(data: dict[str, Any], changes: dict[str, Any], words: str) -> None:
    write(FILE, data)
    kept = dict(np.load("file/rows.npz"))
    np.savez("file/rows.npz", **{**kept, **changes})
    assert words in refused("agents.benchmark.verify", FILE)


def test_more_values_than_memory_holds_are_refused(data: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "MOST_VALUES", 1000)
    write(FILE, data)
    assert "'file/rows.npz' holds more than 1,000 values" in refused("agents.benchmark.verify", FILE)
