"""`python -m agents.reproduce` as a user meets it, and how finished parts are kept."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from commands import call, environment

from agents.reproduce import papers
from agents.reproduce.__main__ import Arguments, main
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.papers import PAPERS, Job, jobs, run_job
from pnt_gym.errors import PntGymError

ENTRIES = {"quantity", "published", "reproduced", "unit", "verdict", "note"}


def test_help_names_the_papers(tmp_path: Path) -> None:
    done = call("agents.reproduce", "--help", folder=tmp_path)
    assert done.returncode == 0
    for word in (*PAPERS, "--json FILE", "--figures FOLDER", "--jobs N", "--fresh"):
        assert word in done.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nobody",), "unknown paper 'nobody'; known are hassan, choe"),
        (("hassan", "--jobs", "0"), "--jobs is 0; it must be at least 1"),
        (("hassan", "--json", "."), "cannot write '.': it is a folder"),
        (("hassan", "--json", "a_file/out.json"), "cannot write"),
        (("hassan", "--figures", "a_file"), "cannot write"),
        (("hassan", "--only", "table9"), "unknown part 'table9'; known are table1"),
    ],
)
def test_mistakes_are_explained_before_anything_is_done(tmp_path: Path, arguments: tuple[str, ...], said: str) -> None:
    (tmp_path / "a_file").write_text("")
    done = call("agents.reproduce", *arguments, "--work", "work", folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1
    assert said in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["a_file"]


def test_figures_are_written_where_asked(tmp_path: Path) -> None:
    arguments = ("hassan", "--only", "inconsistencies", "figures", "--work", "work")
    done = call("agents.reproduce", *arguments, "--json", "out.json", "--figures", "drawings", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert "misprint" in done.stdout
    assert len(list((tmp_path / "work" / "hassan").iterdir())) == 2
    data: dict[str, Any] = json.loads((tmp_path / "out.json").read_text())
    assert all(set(row) >= ENTRIES for row in data["rows"])
    assert {row["paper"] for row in data["rows"]} == {"hassan"} == set(data["papers"])
    assert data["command"] == "python -m agents.reproduce hassan"
    assert set(data["seconds"]) == {"hassan/inconsistencies", "hassan/figures"}
    assert data["versions"]["pnt_gym"]
    drawings = {path.name for path in (tmp_path / "drawings").iterdir()}
    assert drawings == set(data["figures"]["hassan"])
    assert "hassan_scurve.svg" in drawings


def test_finished_parts_are_not_done_again_unless_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In this process, which sees one state of the code."""

    def run(**more: Any) -> list[str]:
        main(Arguments("hassan", only=("inconsistencies",), work=tmp_path, jobs=1, **more))
        return [line.split(" (")[0] for line in capsys.readouterr().out.splitlines() if line.startswith("done: ")]

    assert run() == ["done: hassan, inconsistencies"]
    (kept,) = (tmp_path / "hassan").iterdir()
    before = kept.stat().st_mtime_ns
    assert run() == []
    assert kept.stat().st_mtime_ns == before
    assert run(fresh=True) == ["done: hassan, inconsistencies"]
    assert kept.stat().st_mtime_ns > before
    assert [path.name for path in tmp_path.iterdir()] == ["hassan"]


def with_part(monkeypatch: pytest.MonkeyPatch, part: Part) -> Job:
    monkeypatch.setattr(papers, "parts", lambda _: (part,))
    return Job("hassan", part.name, "key")


def test_a_part_is_kept_with_its_drawings(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    row = Row("a/b", 1.0, None, "m", "infeasible", "why", {"more": [1, 2]})
    job = with_part(monkeypatch, Part("small", lambda: Findings((row,), {"x": 1}, {"a.svg": "<svg/>"})))
    run_job(job, tmp_path)
    record = json.loads((tmp_path / job.file).read_text())
    assert record["rows"] == [{**row.as_json(), "paper": "hassan"}]
    assert record["rows"][0]["more"] == [1, 2]
    assert (record["data"], record["figures"]) == ({"x": 1}, {"a.svg": "<svg/>"})


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (PntGymError("casadi is\nmissing"), "hassan, part small: casadi is missing"),
        (ModuleNotFoundError("no", name="matplotlib"), "hassan, part small: matplotlib is not installed"),
    ],
)
def test_a_part_that_cannot_be_done_says_which(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, error: Exception, said: str
) -> None:
    def fail() -> Findings:
        raise error

    with pytest.raises(PntGymError, match=said):
        run_job(with_part(monkeypatch, Part("small", fail)), tmp_path)
    assert not list(tmp_path.iterdir())


def test_kept_parts_belong_to_the_code_that_made_them(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("agents/reproduce/hassan_a.py", "agents/reproduce/choe.py", "pnt_gym/planning/a.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("1")
    monkeypatch.setattr(papers, "ROOT", tmp_path)

    def key() -> str:
        papers._key.cache_clear()
        return papers._key("hassan")

    first = key()
    (tmp_path / "agents/reproduce/choe.py").write_text("2")
    assert key() == first
    seen = {first}
    for name in ("agents/reproduce/hassan_a.py", "pnt_gym/planning/a.py", "agents/reproduce/simulation.py"):
        (tmp_path / name).write_text("3")
        assert key() not in seen
        seen.add(key())
    papers._key.cache_clear()


@pytest.mark.parametrize("paper", PAPERS)
def test_a_paper_needs_no_code_of_another(paper: str) -> None:
    """What a part is kept under leaves the other papers' code out."""
    code = f"import sys, {PAPERS[paper]}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment(), capture_output=True, text=True, timeout=60, check=True
    )
    others = tuple(module for name, module in PAPERS.items() if name != paper)
    assert PAPERS[paper] in done.stdout.split()
    assert not [name for name in done.stdout.split() if name.startswith(others)]


@pytest.mark.parametrize("paper", PAPERS)
def test_every_part_has_a_job_of_its_own(paper: str) -> None:
    found = jobs(paper)
    assert len({job.file for job in found}) == len(found) >= 1
    assert {job.paper for job in found} == {paper}
