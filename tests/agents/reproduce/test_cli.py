"""`python -m agents.reproduce` as a user meets it, and how finished parts are kept."""

import importlib
import importlib.util
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from agents.ground.cli import UsageError
from agents.ground.files import write_json
from agents.ground.places import CODE
from agents.ground.tables import Grid
from agents.ground.versions import module_files
from agents.reproduce import papers, record
from agents.reproduce.__main__ import Arguments, main
from agents.reproduce.finding import Findings, Overview, Row
from agents.reproduce.papers import OPTIMA, PAPERS, PART_NAMES, jobs, package
from agents.reproduce.record import assemble, headlines
from pnt_gym.errors import PntGymError
from tests.tools.commands import figures_of, output_of, run_python
from tests.tools.nightly import with_nightly

pytestmark = pytest.mark.usefixtures("worker_here")
ENTRIES = {"quantity", "published", "reproduced", "unit", "verdict", "tolerance", "note"}


def test_help_names_the_papers(tmp_path: Path) -> None:
    said = output_of("reproduce --help", tmp_path)
    for word in (*PAPERS, "--json FILE", "--figures FOLDER", "--jobs N", "--fresh"):
        assert word in said


def test_what_a_part_needs_at_its_end_is_checked_at_its_beginning(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    present = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "casadi" else present(name))
    for name in OPTIMA:
        paper, part = name.split("/")
        assert part in PART_NAMES[paper]
        with pytest.raises(ModuleNotFoundError, match="casadi"):
            main(Arguments(paper, only=((part,),), work=tmp_path / "work"))
    assert not list(tmp_path.iterdir())
    assert not {*OPTIMA} & {"choe/example", "choe/length"}


def test_a_package_without_the_papers_says_where_they_are(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(papers, "SHIPPED", tmp_path)
    with pytest.raises(UsageError, match=r"hassan is reproduced in a checkout of pnt_gym, and .* has no folder papers"):
        main(Arguments("hassan", work=tmp_path / "work"))
    assert not list(tmp_path.iterdir())


def test_the_former_place_of_a_paper_names_the_new_one() -> None:
    with pytest.raises(ImportError, match=r"agents.reproduce.hassan is papers.hassan now"):
        importlib.import_module("agents.reproduce.hassan.nlp")


@pytest.mark.parametrize(
    ("only", "parts"),
    [
        ("--only example --only length", {"example", "length"}),
        ("--only length example", {"example", "length"}),
        ("--only example --only length joints", {"example", "length", "joints"}),
    ],
)
def test_parts_may_be_named_at_once_or_one_by_one(tmp_path: Path, only: str, parts: set[str]) -> None:
    for name in ("example", "length", "joints"):
        (job,) = (job for job in jobs("choe") if job.name == f"choe/{name}")
        write_json(tmp_path / "work" / job.file, {"seconds": 1.0, "rows": [], "data": {}, "figures": {}, "grids": []})
    data = figures_of(f"reproduce choe {only} --work work", tmp_path)
    assert set(data["seconds"]) == {f"choe/{part}" for part in parts}


def test_figures_are_written_where_asked(tmp_path: Path) -> None:
    line = "reproduce choe --only example speed --work work --jobs 1 --json out.json --figures drawings"
    said = output_of(line, tmp_path)
    assert "misprint" in said
    assert "2 parts, " in said
    assert "of processor time in all" in said
    assert len(list((tmp_path / "work" / "choe").iterdir())) == 2
    data: dict[str, Any] = json.loads((tmp_path / "out.json").read_text())
    assert all(set(row) >= ENTRIES for row in data["rows"])
    assert {row["paper"] for row in data["rows"]} == {"choe"} == set(data["papers"])
    assert data["command"] == "python -m agents.reproduce choe"
    assert set(data["seconds"]) == {"choe/example", "choe/speed"}
    assert data["versions"]["pnt_gym"]
    drawings = {path.name for path in (tmp_path / "drawings").iterdir()}
    assert drawings == set(data["figures"]["choe"])
    assert "choe_ellipse.svg" in drawings


def test_finished_parts_are_not_done_again_unless_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In this process, which sees one state of the code."""

    def run(**more: Any) -> list[str]:
        main(Arguments("choe", only=(("length",),), work=tmp_path, jobs=1, **more))
        return [line.split(" (")[0] for line in capsys.readouterr().out.splitlines() if line.startswith("done: ")]

    assert run() == ["done: choe/length"]
    (kept,) = (tmp_path / "choe").iterdir()
    before = kept.stat().st_mtime_ns
    assert run() == []
    assert kept.stat().st_mtime_ns == before
    assert run(fresh=True) == ["done: choe/length"]
    assert kept.stat().st_mtime_ns > before
    assert [path.name for path in tmp_path.iterdir()] == ["choe"]


class Small:
    """A paper with the one part given."""

    SHORT = "Small 2026"

    def __init__(self, part: Callable[[], Findings]) -> None:
        self.PARTS = {"small": part}

    @staticmethod
    def overview(rows: Any) -> Overview:
        grid = Grid("All", ["figure"], [[name] for name in rows])
        return Overview({"all": grid}, {"all": "A note."}, {"all.svg": "<svg>2</svg>"})


def with_part(monkeypatch: pytest.MonkeyPatch, part: Callable[[], Findings]) -> None:
    for module in (papers, record):
        monkeypatch.setattr(module, "package", lambda _: Small(part))


def test_a_record_holds_what_parts_and_overview_gave(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    rows = (
        Row.compared("hassan/a", 1.0, 1.1, "m", within=0.2, more=[1, 2]),
        Row.compared("hassan/b", 1.0, 1.3, "m", within=0.2),
        Row.ours("c", None, "m", note="why"),
        Row.ours("d", 2.0, "m", beside=3.0),
    )
    grid = Grid("Of a part", ["figure"], [["x"]])
    with_part(monkeypatch, lambda: Findings(rows, {"x": 1}, {"a.svg": "<svg>1</svg>"}, (grid,)))
    (job,) = jobs("hassan")
    found = {job.name: json.loads(json.dumps(job.run(tmp_path)))}
    assert found[job.name]["seconds"] < 10.0
    made, drawings = assemble("command", found)
    assert made["rows"] == [{**row.as_json(), "paper": "hassan"} for row in rows]
    assert made["rows"][0]["more"] == [1, 2]
    assert [row["verdict"] for row in made["rows"]] == ["reproduced", "differs", "ours", "ours"]
    assert [row["tolerance"] for row in made["rows"]] == [0.2, 0.2, None, None]
    assert (made["titles"], made["data"]) == ({"hassan": "Small 2026"}, {"hassan": {"x": 1}})
    assert made["grids"] == {"hassan": [{"headline": "Of a part", "header": ["figure"], "rows": [["x"]], "note": ""}]}
    assert made["overview"]["hassan"]["grids"]["all"]["note"] == made["overview"]["hassan"]["notes"]["all"] == "A note."
    assert drawings == {"a.svg": "<svg>1</svg>", "all.svg": "<svg>2</svg>"}
    assert made["figures"] == {"hassan": ["a.svg", "all.svg"]}
    assert json.loads(json.dumps(made)) == made
    assert [shown.headline for shown in headlines(made)] == [
        "All", "Small 2026: what does not agree", "Of a part", "Small 2026: verdicts",
    ]  # fmt: skip
    assert [line[0] for line in headlines(made)[1].rows] == ["b"]
    assert headlines(made)[3].rows == [["differs", "1"], ["reproduced", "1"], ["ours, not compared", "2"]]


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

    with_part(monkeypatch, fail)
    with pytest.raises(PntGymError, match=said):
        papers.run("hassan", "small", tmp_path)
    assert not list(tmp_path.iterdir())


def test_kept_parts_belong_to_the_code_that_made_them(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def write(name: str, text: str) -> None:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)

    def key() -> str:
        (found,) = {job.key for job in jobs("hassan")}
        return found

    for name in ("agents/__init__.py", "agents/reproduce/__init__.py", "agents/reproduce/finding.py"):
        write(name, "1")
    write("papers/__init__.py", "1")
    write("papers/hassan/__init__.py", "from agents.reproduce import finding")
    monkeypatch.setattr(papers, "CODE", tmp_path)
    first = key()
    for name in ("papers/choe/a.py", "agents/reproduce/record.py", "pnt_gym/cells/conveyor/view.py",
                 "configs/cells/gripper/a.yaml"):  # fmt: skip
        write(name, "2")
        assert key() == first, name
    seen = {first}
    for name in ("agents/reproduce/finding.py", "pnt_gym/planning/x/a.py", "configs/cells/conveyor/a.yaml"):
        write(name, "3")
        assert key() not in seen, name
        seen.add(key())


def test_a_paper_is_kept_under_what_it_plans_with() -> None:
    files = {path.relative_to(CODE).as_posix() for path in module_files("papers.choe", CODE)}
    assert {"papers/choe/planning/timing.py", "agents/reproduce/finding.py"} <= files
    assert not [name for name in files if name.startswith("papers/hassan")]


@pytest.mark.parametrize("paper", with_nightly(PAPERS, ["choe"]))
def test_a_paper_needs_no_code_of_another(paper: str) -> None:
    """What a part is kept under leaves the other papers' code out."""
    done = run_python("-c", f"import sys, papers.{paper}; print(*sys.modules)", timeout=60, check=True)
    others = tuple(f"papers.{name}" for name in PAPERS if name != paper)
    assert f"papers.{paper}" in done.stdout.split()
    assert not [name for name in done.stdout.split() if name.startswith(others)]


@pytest.mark.parametrize("paper", PAPERS)
def test_every_paper_has_a_job_for_each_part_a_title_and_an_overview_even_of_nothing(paper: str) -> None:
    found = jobs(paper)
    assert len({job.file for job in found}) == len(found) >= 1
    assert {job.name.split("/")[0] for job in found} == {paper}
    assert package(paper).SHORT
    assert all(not grid.rows for grid in package(paper).overview({}).grids.values())
