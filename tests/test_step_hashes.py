"""Fingerprints of what environments give, against those of another code state."""

import pytest

from benchmarks.step_hashes import compare

BEFORE = {"a/ideal/x": {"reward": "1", "ended": "2"}, "b/ideal/x": {"reward": "3"}}


def test_what_differs_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    made = {"a/ideal/x": {"reward": "9", "ended": "2", "info/new": "4"}, "b/ideal/x": {"reward": "3"}}
    assert compare(made, BEFORE) == 1
    assert capsys.readouterr().out == "a/ideal/x: info/new, reward\n"


def test_cases_that_an_older_file_lacks_are_told_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert compare({**BEFORE, "c/day/x": {"reward": "5"}, "c/day/y": {}}, BEFORE) == 0
    assert capsys.readouterr().out.splitlines() == [
        "2 cases: all fingerprints are equal",
        "2 cases are not in the older file: c/day/x, c/day/y",
    ]
