"""Files of results say what their rows give, whoever reads them."""

import json
from pathlib import Path
from typing import Any

import pytest

from agents.ground.cli import UsageError
from agents.ground.places import SHIPPED as ROOT
from agents.report import contents

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


@pytest.mark.nightly
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_committed_files_show_what_their_throws_give(file: Path) -> None:
    assert contents.read(file)["table"]
