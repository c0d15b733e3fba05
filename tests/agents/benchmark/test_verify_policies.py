"""Rows of a benchmark whose controllers have learned are carried out again by their stored policies."""

import base64
import copy
import json
from pathlib import Path
from tempfile import gettempdir
from typing import Any

import pytest

from agents.benchmark import run
from agents.results.content import read_form
from tests.tools.benchmark import FILE, carried_out, toy_plan, verified, verify, write
from tests.tools.commands import refused

pytestmark = pytest.mark.usefixtures("worker_here")


@pytest.fixture(scope="module")
def stored_result(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Result with the policies of a training and of fits."""
    ridge = {"label": "ridge", "controller": "ridge", "throws": [16, 32]}
    sac = {"label": "sac", "controller": "sac", "throws": [32, 64], "seeds": [0], "options": {"learning_starts": 16}}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "STORED_FROM", 0.0)
        return carried_out(toy_plan(ridge, sac, seeds=[0, 1]), tmp_path_factory.mktemp("work"))


@pytest.fixture
def stored(stored_result: dict[str, Any], desk: Path) -> dict[str, Any]:
    return copy.deepcopy(stored_result)


def test_stored_policies_throw_without_learning(stored: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(stored["policies"]) == len(stored["results"]) == 6
    monkeypatch.setattr(run, "_learn", lambda *_: pytest.fail("a controller learned"))
    code, verdicts = verify(stored, "--rows", "99")
    assert code == 0
    assert [row["verdict"] for row in verdicts] == ["equal"] * 6
    assert all(row["stored"] for row in verdicts)


@pytest.mark.parametrize("label", ["ridge", "sac"])
def test_a_policy_of_another_row_throws_otherwise(stored: dict[str, Any], label: str) -> None:
    first, second, *_ = (row for row in stored["results"] if row["label"] == label)
    first["policy"] = second["policy"]
    code, verdicts = verify(stored, "--rows", "99")
    assert code == 1
    (found,) = (row for row in verdicts if row["verdict"] != "equal")
    assert (found["verdict"], found["label"], found["throws"]) == ("different", label, first["throws"])


def test_controllers_of_stored_policies_learn_again_when_asked(stored: dict[str, Any]) -> None:
    for row in stored["results"]:
        row["policy"] = stored["results"][0]["policy"]
    code, verdicts = verify(stored, "--rows", "99", "--learn")
    assert code == 0
    assert {row["verdict"] for row in verdicts} == {"equal"}
    assert not any(row["stored"] for row in verdicts)


def test_a_row_without_a_policy_learns_again(stored: dict[str, Any]) -> None:
    del stored["results"][0]["policy"]
    assert [row["stored"] for row in verify(stored, "--rows", "99")[1]] == [False, *[True] * 5]


@pytest.mark.parametrize(
    ("policy", "words"), [(b"x", "the stored policy cannot be used: it "), (None, "cannot read 'file/")]
)
def test_a_policy_that_cannot_be_read_is_named_with_its_file(
    stored: dict[str, Any], policy: bytes | None, words: str
) -> None:
    write(FILE, stored)
    for place in Path("file").glob("*seed*.npz"):
        place.write_bytes(policy) if policy else place.unlink()
    said = refused("agents.benchmark.verify", FILE, "--rows", "99")
    assert words in said
    assert gettempdir() not in said


@pytest.mark.parametrize("name", ["../file.npz", ".npz", "a/b.npz", ""])
def test_a_policy_lies_in_the_folder_of_its_file(stored: dict[str, Any], name: str) -> None:
    stored["results"][0]["policy"] = name
    write(FILE, stored)
    assert "'file.json': results.0.policy is" in refused("agents.benchmark.verify", FILE)


def test_a_result_is_as_it_was_when_it_is_read(stored: dict[str, Any]) -> None:
    without = [{name: value for name, value in row.items() if name != "policy"} for row in stored["results"]]
    for result in (stored, {**stored, "results": without, "policies": {}}):
        write(FILE, result)
        found = read_form(FILE)
        assert found.data["results"] == result["results"]
        for row in found.data["results"]:
            assert found.policy(row) == result["policies"].get(row.get("policy"))


def test_a_file_of_an_earlier_version_is_read(stored: dict[str, Any]) -> None:
    """Earlier versions kept throws, digests and policies in the head."""
    files = {row.pop("policy"): row for row in stored["results"]}
    texts = {name: base64.b64encode(policy).decode() for name, policy in stored.pop("policies").items()}
    for name, row in files.items():
        row["digests"] = {"policy": name, "code": "0"}
    shared = {"second": next(iter(texts)), **texts}
    FILE.write_text(json.dumps({**stored, "policies": shared}))
    code, verdicts = verified("--rows", "99")
    assert code == 0
    assert [(row["verdict"], row["stored"]) for row in verdicts] == [("equal", True)] * 6
    FILE.write_text(json.dumps({**stored, "policies": dict.fromkeys(texts, "x")}))
    assert "the policy is no text in base64" in refused("agents.benchmark.verify", FILE)
