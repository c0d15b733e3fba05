"""Every command line of a long table is wrong: one sentence, exit code 2, nothing left behind."""

from __future__ import annotations

import io
import shlex
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from agents.evaluate import Arguments
from agents.ground.cli import UsageError, _parsed
from agents.ground.places import POLICY
from tests.agents.test_mistakes import PLAN, WRONG
from tests.tools.commands import refused
from tests.tools.toy_cell import register_toy
from tests.tools.wrong_lines import WRONG_LINES

register_toy()
LINES = [line.split(" | ") for line in WRONG_LINES.strip().splitlines()]
TEXTS = {
    "file": "text",
    "file.zip": "text",
    "text.yaml": "text",
    "typo.yaml": "binz: {}\n",
    "circle.yaml": "base: circle.yaml\n",
    "nominal.yaml": "mismatch: 9\n",
    "heavy.yaml": "suction: {tau: 1.0e+9}\n",
    "broken/x.json": "{",
    "plan.yaml": yaml.safe_dump(PLAN),
    "nobody.yaml": yaml.safe_dump({**PLAN, "entries": [{"label": "a", "controller": "nobody"}]}),
    "stacked.yaml": yaml.safe_dump({**PLAN, "entries": [{"label": "a", "controller": "analytic", "stack": 2}]}),
    "over.yaml": yaml.safe_dump({**PLAN, "entries": [{"label": "a", "controller": "sac", "stack": 8, "over": "mlp"}]}),
    "nowhere.yaml": yaml.safe_dump({**PLAN, "levels": ["nowhere"]}),
}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with files of every kind, which no wrong line changes."""
    here = tmp_path_factory.mktemp("place")
    (here / "folder" / "full" / "thing").mkdir(parents=True)
    (here / "broken").mkdir()
    (here / "datasets" / "one" / "two-v0" / "data").mkdir(parents=True)
    for name, text in TEXTS.items():
        (here / name).write_text(text)
    np.savez(here / "x.npz", centre=np.zeros(3))
    shutil.copytree(POLICY, here / "policy")
    for name in ("torn", "foreign", "written", "old"):
        shutil.copytree(POLICY, here / name)
    (here / "torn" / "policy.npz").write_bytes((POLICY / "policy.npz").read_bytes()[:9000])
    shutil.copy(here / "x.npz", here / "foreign" / "policy.npz")
    (here / "written" / "policy.npz").write_text("weights")
    (here / "old" / "policy.npz").unlink()
    return here


@pytest.mark.parametrize(("line", "said"), LINES, ids=[line for line, _ in LINES])
def test_a_wrong_line_is_refused(place: Path, monkeypatch: pytest.MonkeyPatch, line: str, said: str) -> None:
    monkeypatch.chdir(place)
    before = sorted(place.rglob("*"))
    command, *options = shlex.split(line)
    assert refused(f"agents.{command}", *options).startswith(f"error: {said}")
    assert sorted(place.rglob("*")) == before


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
@pytest.mark.parametrize("columns", ["40", "200"])
def test_a_box_of_any_width_and_colour_becomes_a_sentence(
    monkeypatch: pytest.MonkeyPatch, encoding: str, columns: str
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), encoding=encoding))
    with pytest.raises(UsageError) as caught:
        _parsed(Arguments, "this", ["--controller", "analytic", "--picsk", "4"])
    assert str(caught.value) == "Unrecognized options: --picsk, 4; perhaps you meant --picks N; see this --help"
    with pytest.raises(UsageError) as caught:
        _parsed(Arguments, "this", ["--controller", "analytic", "--seed", "x"])
    assert str(caught.value) == "Error parsing --seed: invalid literal for int() with base 10: 'x'; see this --help"


def test_there_are_many() -> None:
    assert len({line for line, _ in LINES}) + len(WRONG) >= 200
