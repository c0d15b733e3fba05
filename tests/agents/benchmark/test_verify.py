"""Rows of a benchmark are carried out again: equal, different and where, or of another version."""

import json
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from tempfile import gettempdir
from typing import Any

import pytest
from rich.progress import Progress

from agents.benchmark import run
from agents.benchmark.verdicts import first_difference
from agents.ground import tables
from agents.ground.files import json_text
from agents.ground.parcel import torch_arithmetic
from agents.ground.tables import throws_bar
from agents.ground.work import LimitedWorker, UnfinishedError
from tests.tools.benchmark import carried_out, forge, toy_plan
from tests.tools.commands import answered, refused

RIDGE = {"label": "ridge", "controller": "ridge", "throws": [16, 32]}
PLAN = toy_plan({"label": "analytic", "controller": "analytic"}, RIDGE, levels=["waste", "unseen"], seeds=[0, 1])
ROWS = 10
"""Two levels of one planner, and of ridge with two seeds and two numbers of throws."""

pytestmark = pytest.mark.usefixtures("worker_here")


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


def test_a_file_of_other_versions_is_told_apart_from_a_changed_one(data: dict[str, Any]) -> None:
    data["versions"]["numpy"] = "1.0"
    assert verify(data, "--rows", "1")[1][0]["verdict"] == "equal"
    for result in data["results"]:
        result["columns"]["cycle_s"][0] += 1.0
    forge(data)
    code, (row,) = verify(data, "--rows", "1")
    assert (code, row["verdict"], row["difference"]["at"], row["other_code"]) == (1, "different", 0, True)


def test_differences_in_form_are_differences() -> None:
    assert first_difference({"a": 1, "b": [1, 2]}, {"a": 1, "b": [1, 2]}) is None
    shorter = {"column": "b", "at": None, "file": [1, 2], "here": [1], "count": 1}
    assert first_difference({"b": [1, 2]}, {"b": [1]}) == shorter
    assert first_difference({}, {"b": 1}) == {"column": "b", "at": None, "file": None, "here": 1, "count": 1}


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
    forge(data)
    _, verdicts = verify(data, "--rows", "99")
    assert [row["verdict"] for row in verdicts].count("different") == 1
    assert all(row["other_code"] for row in verdicts)


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


def test_rows_that_are_equal_get_digests(data: dict[str, Any]) -> None:
    whole = json.loads(json.dumps(data["results"]))
    for row in data["results"]:
        del row["digests"]
    data["results"][3]["columns"]["cycle_s"][5] += 0.1
    forge(data)
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


def test_rows_within_the_bounds_are_equal_for_those_who_accept_them(data: dict[str, Any]) -> None:
    for row in data["results"]:
        row["columns"]["error_m" if "error_m" in row["columns"] else "along_m"][0] += 5e-5
    forge(data)
    for options, expected in (((), 1), (("--near",), 0)):
        code, verdicts = verify(data, "--rows", "99", *options)
        assert code == expected
        assert {row["verdict"] for row in verdicts} == {"equal within the bounds"}
        assert all(row["difference"]["at"] == 0 for row in verdicts)
    data["results"][0]["columns"]["cycle_s"][0] += 1.0  # one throw of 24 is more than a hundredth
    forge(data)
    code, verdicts = verify(data, "--rows", "99", "--near")
    assert code == 1
    assert [row["verdict"] for row in verdicts].count("different") == 1


def test_a_file_has_no_say_in_how_it_is_checked(data: dict[str, Any]) -> None:
    """Whatever the file says of its making, a changed throw is different, and every row may be drawn."""
    for row in data["results"]:
        row["columns"]["cycle_s"][7] += 0.5
        row["learn_seconds"] = 1e8
        row["digests"] |= {"arithmetic": "of another processor", "torch": "of another processor", "code": "0"}
    data["versions"] = dict.fromkeys(data["versions"], "1.0")
    forge(data)
    code, verdicts = verify(data, "--rows", "99", "--near")
    assert code == 1
    assert [row["verdict"] for row in verdicts] == ["different"] * ROWS


def test_a_drawn_sample_is_another_one_each_time(data: dict[str, Any]) -> None:
    Path("file.json").write_text(json.dumps(data))
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
    data["results"][2]["columns"]["cycle_s"].pop()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_shown, "'file.json' shows what its throws do not give: table.0.sorted_per_min is"),
        (_renamed, "figures.sorted_per_min.label is 'sorted/s', and not 'sorted/min'"),
        (_invented, "table.1.stars is no figure of theirs"),
        (_dropped, "'file.json' lacks 1 of the rows of its plan; the first is label"),
        (_doubled, "stands there 2 times"),
        (_late, "cycle_s.3 is -1.0: input should be greater than 0"),
        (_torn, "cycle_s has 23 entries; the plan asks for 24"),
    ],
)
def test_a_file_that_says_other_than_its_throws_is_refused(data: dict[str, Any], change: Any, words: str) -> None:
    change(data)
    Path("file.json").write_text(json.dumps(data))
    for command in (("agents.benchmark.verify", "file.json"), ("agents.report", "--results", ".", "--readme", "x.md")):
        assert words in refused(*command)


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
    forge(stored)
    trained[0]["digests"]["torch"] = torch_arithmetic()
    verdicts = [row["verdict"] for row in verify(stored, "--rows", "99", "--longest", "1000")[1]]
    assert verdicts.count("equal within the bounds") == 1


def test_an_honest_stored_policy_is_thrown_whatever_torch_rounds(stored: dict[str, Any]) -> None:
    for row in stored["results"]:
        row["digests"]["torch"] = "of another processor"
    verdicts = verify(stored, "--rows", "99")[1]
    assert {(row["verdict"], row["elsewhere"]) for row in verdicts} == {("equal", False)}


def test_stored_policies_throw_without_learning(stored: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(stored["policies"]) == len(stored["results"]) == 6
    monkeypatch.setattr(run, "_learn", lambda *_: pytest.fail("a controller learned"))
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
    sentence = f"'file.json': row label {label}, throws"
    said = refused("agents.benchmark.verify", "file.json", "--rows", "99")
    assert sentence in said
    assert "the stored policy has not the digest of its row" in said


@pytest.mark.parametrize(
    ("policy", "words"), [("x", "is no text in base64"), ("AAAA", "the stored policy cannot be used: it ")]
)
def test_a_damaged_policy_is_named_by_its_file_and_row(stored: dict[str, Any], policy: str, words: str) -> None:
    damaged = dict.fromkeys(stored["policies"], policy)
    Path("file.json").write_text(json.dumps({**stored, "policies": damaged}))
    said = refused("agents.benchmark.verify", "file.json", "--rows", "99")
    assert said.startswith("error: 'file.json': row label ")
    assert words in said
    assert gettempdir() not in said
