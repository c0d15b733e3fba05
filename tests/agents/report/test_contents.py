"""Files of results say what their rows give, whoever reads them."""

import json
from pathlib import Path
from typing import Any, cast

import pytest

from agents.ground.cli import UsageError
from agents.ground.places import SHIPPED as ROOT
from agents.ground.versions import world_of
from agents.report import contents, page, submissions
from agents.report.__main__ import read
from agents.report.blocks import makers_from
from agents.results import compare
from agents.results.content import Content
from pnt_gym.constants import WORLD

TEXT = (ROOT / "results" / "reproduction.json").read_text(encoding="utf-8")
FILES = [*(ROOT / "results").glob("benchmark*.json"), *(ROOT / "results" / "submissions").glob("*.json")]


@pytest.fixture
def record() -> dict[str, Any]:
    return json.loads(TEXT)


@pytest.mark.parametrize("verdict", ["reproduced", "differs"])
def test_a_verdict_that_its_values_do_not_give_is_refused(record: dict[str, Any], tmp_path: Path, verdict: str) -> None:
    row = next(row for row in record["rows"] if row["verdict"] == verdict)
    row["verdict"] = "differs" if verdict == "reproduced" else "reproduced"
    (tmp_path / "r.json").write_text(json.dumps(record))
    with pytest.raises(UsageError, match=f"{row['quantity']} has the verdict '{row['verdict']}'"):
        contents.read(tmp_path / "r.json")


def test_another_value_without_another_verdict_is_refused(record: dict[str, Any], tmp_path: Path) -> None:
    row = next(row for row in record["rows"] if row["verdict"] == "reproduced" and row.get("holds") is None)
    row["reproduced"] = 1e3
    (tmp_path / "r.json").write_text(json.dumps(record))
    with pytest.raises(UsageError, match="has the verdict 'reproduced', which its values do not give"):
        contents.read(tmp_path / "r.json")


@pytest.mark.parametrize(("world", "said"), [(None, 1), ("1", 1), (str(WORLD), 0)])
def test_pages_of_an_older_world_say_so_once(
    record: dict[str, Any], tmp_path: Path, world: str | None, said: int
) -> None:
    record["versions"] = {**record["versions"], "world": world}
    if world is None:
        del record["versions"]["world"]
    (tmp_path / "reproduction.json").write_text(json.dumps(record))
    chapters = read(tmp_path)
    parts = page.sections(chapters, tmp_path)
    pages = [page.index(parts), *(page.tables(chapter, parts[0]) for chapter in chapters)]
    pages.append(makers_from(tmp_path)["question"]("papers"))
    line = f"Measured in world 1; `pnt_gym` simulates world {WORLD}, see CHANGELOG."
    assert [text.count(line) for text in pages] == [said] * len(pages)
    assert ("Measured in world 1;" in page.html(parts)) == bool(said)


def test_a_submission_of_another_world_is_not_compared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for file in ("benchmark.json", "submissions/mine.json"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text("{}")
    benchmark = {"plan": {"levels": [], "picks": 1, "env": "E"}, "table": [], "versions": {"world": "2"}}
    monkeypatch.setattr(contents, "read", lambda _: benchmark)
    monkeypatch.setattr(compare, "read", lambda path: Content(cast("Any", None), {**benchmark, "versions": {}}, path))
    with pytest.raises(
        UsageError, match="in world 1, and the benchmark in world 2; results of different worlds are not"
    ):
        submissions.grid(tmp_path)
    monkeypatch.setattr(compare, "read", lambda path: Content(cast("Any", None), benchmark, path))
    assert submissions.grid(tmp_path).rows == []


@pytest.mark.parametrize("world", ["two", "0", "1.0"])
def test_a_world_that_is_no_number_is_refused(world: str) -> None:
    with pytest.raises(UsageError, match="worlds are whole numbers from 1 on"):
        world_of({"versions": {"world": world}})


@pytest.mark.nightly
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_committed_files_show_what_their_throws_give(file: Path) -> None:
    assert contents.read(file)["table"]
