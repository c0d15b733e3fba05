"""Rows of a benchmark are carried out again: equal, different and where, or of another version."""

import json
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from rich.progress import Progress

from agents.benchmark import run
from agents.benchmark.verify import first_difference
from agents.ground import bars
from agents.ground.bars import throws_bar
from agents.ground.files import json_text
from agents.jobs.parcel import torch_arithmetic
from tests.tools.benchmark import carried_out, toy_plan
from tests.tools.commands import answered, refused

RIDGE = {"label": "ridge", "controller": "ridge", "throws": [16, 32]}
PLAN = toy_plan({"label": "analytic", "controller": "analytic"}, RIDGE, levels=["waste", "unseen"], seeds=[0, 1])
ROWS = 10
"""Two levels of one planner, and of ridge with two seeds and two numbers of throws."""


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory) -> str:
    return json_text(carried_out(PLAN, tmp_path_factory.mktemp("work")))


@pytest.fixture(scope="module")
def stored_text(tmp_path_factory: pytest.TempPathFactory) -> str:
    """File with the policies of a training and of fits."""
    sac = {"label": "sac", "controller": "sac", "throws": [32, 64], "seeds": [0], "options": {"learning_starts": 16}}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "STORED_FROM", 0.0)
        return json_text(carried_out(toy_plan(RIDGE, sac, seeds=[0, 1]), tmp_path_factory.mktemp("work")))


@pytest.fixture
def stored(stored_text: str, desk: Path) -> dict[str, Any]:
    return json.loads(stored_text)


@pytest.fixture
def data(text: str, desk: Path) -> dict[str, Any]:
    return json.loads(text)


def verify(data: Any, *options: str) -> tuple[int, list[dict[str, Any]]]:
    """Exit code and verdicts of the command about a file with these data."""
    Path("file.json").write_text(json.dumps(data))
    code, _ = answered("agents.benchmark.verify", "file.json", "--json", "out.json", *options)
    return code, json.loads(Path("out.json").read_text())["verdicts"]


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

    monkeypatch.setattr(bars, "throws_bar", watched)
    assert verify(data, "--rows", "3")[0] == 0
    assert [(task.description, task.completed, task.total) for task in seen[0].tasks] == [("rows thrown again", 3, 3)]


def test_a_sample_is_drawn_by_its_seed(data: dict[str, Any]) -> None:
    drawn = [verify(data, "--rows", "2", "--seed", seed)[1] for seed in ("0", "0", "1")]
    assert len(drawn[0]) == 2
    assert drawn[0] == drawn[1] != drawn[2]


def test_one_changed_outcome_is_found_with_its_place(data: dict[str, Any]) -> None:
    columns = data["results"][3]["columns"]
    outcomes = columns["outcome"]
    flipped = "m" if outcomes[17] == "s" else "s"
    columns["outcome"] = outcomes[:17] + flipped + outcomes[18:]
    code, verdicts = verify(data, "--rows", str(ROWS))
    assert code == 1
    assert [n for n, row in enumerate(verdicts) if row["verdict"] == "different"] == [3]
    expected = {"column": "outcome", "at": 17, "file": flipped, "here": outcomes[17], "count": 1}
    assert verdicts[3]["difference"] == expected


def test_a_file_of_other_versions_is_told_apart_from_a_changed_one(data: dict[str, Any]) -> None:
    data["versions"]["numpy"] = "1.0"
    assert verify(data, "--rows", "1")[1][0]["verdict"] == "equal"
    for result in data["results"]:
        result["columns"]["cycle_s"][0] += 1.0
    code, (row,) = verify(data, "--rows", "1")
    assert (code, row["verdict"], row["difference"]["at"]) == (1, "made by another version", 0)


def test_differences_in_form_are_differences() -> None:
    assert first_difference({"a": 1, "b": [1, 2]}, {"a": 1, "b": [1, 2]}) is None
    shorter = {"column": "b", "at": None, "file": [1, 2], "here": [1], "count": 1}
    assert first_difference({"b": [1, 2]}, {"b": [1]}) == shorter
    assert first_difference({}, {"b": 1}) == {"column": "b", "at": None, "file": None, "here": 1, "count": 1}


@pytest.mark.parametrize(
    ("changes", "options", "words"),
    [
        ({"plan": {"name": "x"}}, (), "plan in 'file.json': keys 'train_level', 'levels' and 'entries' are missing"),
        ({"results": 3}, (), "'file.json' was not written by this version"),
        ({}, ("--rows", "0"), "--rows is 0; it must be at least 1"),
        ({}, ("--longest", "-1"), "--longest is -1; no row of plan 'small' learned so quickly"),
        ({"plan": {**PLAN, "env": "theirs:Toy-v0"}}, (), "the file names 'theirs:Toy-v0': importing the module runs"),
    ],
)
def test_wrong_files_are_one_sentence(
    data: dict[str, Any], changes: dict[str, Any], options: tuple[str, ...], words: str
) -> None:
    Path("file.json").write_text(json.dumps({**data, **changes}))
    assert words in refused("agents.benchmark.verify", "file.json", *options)


@pytest.mark.parametrize("content", ["[]", '{"results": []}'])
def test_a_file_of_anything_else_is_one_sentence(tmp_path: Path, content: str) -> None:
    file = tmp_path / "file.json"
    file.write_text(content)
    words = "has no plan: only files of `pnt-gym benchmark` and `pnt-gym submit` are verified"
    assert words in refused("agents.benchmark.verify", str(file))


def test_a_row_of_no_entry_is_one_sentence(data: dict[str, Any]) -> None:
    data["results"][0]["seed"] = 7
    Path("file.json").write_text(json.dumps(data))
    assert "seed 7, level" in refused("agents.benchmark.verify", "file.json")


def test_rows_name_their_policy_level_and_code(data: dict[str, Any]) -> None:
    digests = [row["digests"] for row in data["results"]]
    assert len({digest["code"] for digest in digests}) == 1
    assert len({digest["level"] for digest in digests}) == 2
    policies = {(row["label"], row["throws"], row["seed"]): row["digests"]["policy"] for row in data["results"]}
    assert len(set(policies.values())) == len(policies), "one planner, and four fits that differ"


@pytest.mark.parametrize("name", ["policy", "level"])
def test_another_policy_or_level_than_the_row_says_is_different(data: dict[str, Any], name: str) -> None:
    data["results"][3]["digests"][name] = "0" * 32
    code, verdicts = verify(data, "--rows", "99")
    assert code == 1
    (row,) = [row for row in verdicts if row["verdict"] != "equal"]
    assert (row["verdict"], row["difference"]["column"]) == ("different", name)


def test_of_other_code_throws_alone_count(data: dict[str, Any]) -> None:
    for row in data["results"]:
        row["digests"] = {"policy": "0", "level": "0", "code": "0"}
    assert {row["verdict"] for row in verify(data, "--rows", "99")[1]} == {"equal"}
    data["results"][0]["columns"]["cycle_s"][0] += 1.0
    _, verdicts = verify(data, "--rows", "99")
    assert [row["verdict"] for row in verdicts].count("made by another version") == 1


def test_the_first_throws_alone_are_compared(data: dict[str, Any]) -> None:
    cycles = data["results"][0]["columns"]["cycle_s"]
    cycles[20] += 1.0
    assert {row["verdict"] for row in verify(data, "--rows", "99", "--throws", "16")[1]} == {"equal"}
    cycles[15] += 1.0
    _, verdicts = verify(data, "--rows", "99", "--throws", "16")
    (row,) = [row for row in verdicts if row["verdict"] != "equal"]
    assert (row["difference"]["column"], row["difference"]["at"]) == ("cycle_s", 15)


def test_rows_that_are_equal_get_digests(data: dict[str, Any]) -> None:
    whole = json.loads(json.dumps(data["results"]))
    for row in data["results"]:
        del row["digests"]
    data["results"][3]["columns"]["cycle_s"][5] += 0.1
    code, verdicts = verify(data, "--rows", "99", "--write")
    assert code == 1
    assert [row["verdict"] for row in verdicts].count("different") == 1
    written = json.loads(Path("file.json").read_text())
    whole[3] = data["results"][3]
    assert written == {**data, "results": whole}
    assert verify(written, "--rows", "99")[1] == verdicts, "the digests are those that are compared"


def test_digests_are_of_whole_rows_and_of_the_versions_of_the_file(data: dict[str, Any]) -> None:
    Path("file.json").write_text(json.dumps(data))
    said = refused("agents.benchmark.verify", "file.json", "--write", "--throws", "9")
    assert "--write goes without --throws: a row is equal if all of its throws are" in said
    Path("file.json").write_text(json.dumps({**data, "versions": {**data["versions"], "numpy": "1.0"}}))
    said = refused("agents.benchmark.verify", "file.json", "--write")
    assert "'file.json' is of other versions" in said


def test_rows_of_another_processor_may_differ_within_bounds(data: dict[str, Any]) -> None:
    for row in data["results"]:
        row["digests"]["arithmetic"] = "of another processor"
        row["columns"]["error_m" if "error_m" in row["columns"] else "along_m"][0] += 5e-5
    code, verdicts = verify(data, "--rows", "99")
    assert code == 0
    assert {row["verdict"] for row in verdicts} == {"equal within the bounds"}
    assert all(row["difference"]["at"] == 0 for row in verdicts)
    data["results"][0]["columns"]["cycle_s"][0] += 1.0  # one throw of 24 is more than a hundredth
    code, verdicts = verify(data, "--rows", "99")
    assert code == 1
    assert [row["verdict"] for row in verdicts].count("different") == 1


def test_rounding_of_torch_counts_where_torch_fits_a_network_anew(stored: dict[str, Any]) -> None:
    trained = [row for row in stored["results"] if row["controller"] == "sac"]
    assert ["torch" in row["digests"] for row in stored["results"]] == [row in trained for row in stored["results"]]
    for row in trained:
        row["digests"]["torch"] = "of another processor"
        row["digests"]["policy"] = "of another rounding"
    stored["policies"] = {}
    verdicts = verify(stored, "--rows", "99", "--longest", "1000")[1]
    assert {row["verdict"] for row in verdicts} == {"equal"}  # no throw differs, and the policy need not be the same
    assert [row["elsewhere"] for row in verdicts] == [row["label"] == "sac" for row in verdicts]
    trained[0]["columns"]["cycle_s"][0] += 5e-4
    trained[0]["digests"]["torch"] = torch_arithmetic()
    verdicts = [row["verdict"] for row in verify(stored, "--rows", "99", "--longest", "1000")[1]]
    assert verdicts.count("different") == 1


def test_an_honest_stored_policy_is_thrown_whatever_torch_rounds(stored: dict[str, Any]) -> None:
    for row in stored["results"]:
        row["digests"]["torch"] = "of another processor"
    verdicts = verify(stored, "--rows", "99")[1]
    assert {(row["verdict"], row["elsewhere"]) for row in verdicts} == {("equal", False)}


def test_stored_policies_throw_without_learning(stored: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(stored["policies"]) == len(stored["results"]) == 6
    monkeypatch.setattr(run, "_learn", lambda *_: pytest.fail("a controller learned"))
    for row in stored["results"]:
        row["learn_seconds"] = 1e4
    code, verdicts = verify(stored, "--rows", "99")
    assert code == 0
    assert [row["verdict"] for row in verdicts] == ["equal"] * 6
    assert all(row["stored"] for row in verdicts)


def test_controllers_of_stored_policies_learn_again_when_asked(stored: dict[str, Any]) -> None:
    other = {row["digests"]["policy"]: next(iter(stored["policies"].values())) for row in stored["results"]}
    code, verdicts = verify({**stored, "policies": other}, "--rows", "99", "--learn")
    assert code == 0
    assert {row["verdict"] for row in verdicts} == {"equal"}
    assert not any(row["stored"] for row in verdicts)


def test_a_row_without_its_policy_learns_again(stored: dict[str, Any]) -> None:
    del stored["policies"][stored["results"][0]["digests"]["policy"]]
    assert [row["stored"] for row in verify(stored, "--rows", "99")[1]] == [False, *[True] * 5]


@pytest.mark.parametrize("label", ["ridge", "sac"])
def test_a_stored_policy_of_another_row_is_refused(stored: dict[str, Any], label: str) -> None:
    first, second, *_ = (row["digests"]["policy"] for row in stored["results"] if row["label"] == label)
    stored["policies"][first] = stored["policies"][second]
    Path("file.json").write_text(json.dumps(stored))
    sentence = f"the stored policy of '{label}', seed 0, has not the digest of its row"
    assert sentence in refused("agents.benchmark.verify", "file.json", "--rows", "99")


@pytest.mark.parametrize(("policy", "words"), [("x", "another form"), ("AAAA", "holds no")])
def test_a_damaged_policy_is_one_sentence(stored: dict[str, Any], policy: str, words: str) -> None:
    damaged = dict.fromkeys(stored["policies"], policy)
    Path("file.json").write_text(json.dumps({**stored, "policies": damaged}))
    assert words in refused("agents.benchmark.verify", "file.json", "--rows", "99")
