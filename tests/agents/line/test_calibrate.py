"""`agents.calibrate` throws, counts, and writes a table that a level can go by."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from agents.line.calibrate import random_throws
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.chances import Chances, digest, read_table, table_path
from pnt_gym.cells.line.config import LineConfig
from tests.tools.commands import answer, call_here, refused

LEVEL = {"name": "mine", "base": "single", "cell": {"limits": {"percent": [30, 45]}}}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a level, and its table by the command line."""
    folder = tmp_path_factory.mktemp("line")
    (folder / "mine.yaml").write_text(yaml.safe_dump(LEVEL))
    given = ("--level", "mine.yaml", "--throws", "120", "--num-envs", "8", "--out", "table.json")
    return folder, call_here("agents.line calibrate", *given, folder=folder)


def test_a_table_is_written_and_said_to_be(made):
    folder, done = made
    told = answer(done, folder / "table.json")
    assert f"\n{told['throws']} throws: cups sealed on " in done.stdout  # below the bar
    assert "ended in its bin; the table is in table.json" in " ".join(done.stdout.split())
    assert 120 <= told["throws"] < 128
    assert told["digest"] == digest(LineConfig.load(LEVEL))
    assert told["items"] == ["tray", "can", "paper_ball", "yoghurt_cup"]
    assert told["percent"] == [30.0, 45.0]
    assert (told["seed"], np.shape(told["landed"])) == (0, (4, 2, 4))
    assert {"mujoco", "numpy", "pnt_gym"} <= set(told["versions"])
    assert sorted(path.name for path in folder.iterdir()) == ["mine.yaml", "table.json"]


def test_the_level_goes_by_the_table_that_it_names(made):
    folder, _ = made
    config = LineConfig.load({**LEVEL, "chances": str(folder / "table.json"), "duration": 10.0})
    found = read_table(config)
    told = json.loads((folder / "table.json").read_text())
    assert found is not None
    assert found.picked.tolist() == told["picked"]
    cell = LineCell(config, 2)
    cell.reset(np.arange(2), [np.random.default_rng(row) for row in range(2)])
    while not cell.over.all():
        assert cell.take(np.zeros(2, dtype=np.int64)).valid.any()


def test_the_table_is_what_the_throws_of_the_seed_say(made):
    folder, _ = made
    config = LineConfig.load(LEVEL, throws="full", chances=None)
    told = list(random_throws(config, throws=120, seed=0, num_envs=8, threads=1))
    columns = {name: np.concatenate([part[name] for part in told]) for name in told[0]}
    again = Chances.from_throws(config.cell, **columns)
    written = json.loads((folder / "table.json").read_text())
    for name in ("percent", "edges", "picked", "landed"):
        np.testing.assert_allclose(written[name], getattr(again, name), atol=5.1e-6)
    assert not (columns["hits"] & ~columns["picked"]).any()


def test_without_a_place_a_table_goes_beside_the_levels():
    config = LineConfig.load(LEVEL)
    place = table_path(config)
    assert place.parent == LineConfig.file_of("nominal").parent / "chances"
    assert place.name == f"{digest(config)}.json"
    assert not place.is_file()


WRONG = [
    (("--throws", "99"), "--throws is 99; it must be at least 100"),
    (("--throws", "x"), "Error parsing --throws"),
    (("--seed", "-1"), "--seed is -1; it must be at least 0"),
    (("--num-envs", "0"), "--num-envs is 0; it must be at least 1"),
    (("--num-envs", "100001"), "num_envs is 100001; it must be a whole number from 1 to 100000"),
    (("--threads", "0"), "--threads is 0; it must be at least 1"),
    (("--level", "nowhere"), "unknown level 'nowhere'; shipped levels are line3, nominal, single"),
    (("--level", "waste"), "unknown level 'waste'; shipped levels are line3"),
    (("--level", "skilled.yaml"), "level file 'skilled.yaml': skills of robot 'a': 'stone'"),
    (
        ("--level", "near.yaml"),
        "level file 'near.yaml': robots 'a' at x 0 m and 'b' at 0.5 m have windows",
    ),
    (("--level", "nobody.yaml"), "level file 'nobody.yaml': no robot takes item 'can'"),
    (("--level", "dense.yaml"), "level file 'dense.yaml': arrivals.rate is 19 objects a second"),
    (("--level", "solid.yaml"), "level file 'solid.yaml': cell.belt.neighbours is 'solid'"),
    (("--level", "far.yaml"), "level 'far': no robot can throw anything into its bins; move them closer"),
    (("--out", "folder"), "cannot write"),
    (("--out", "nowhere/deep/table.json", "--level", "text"), "unknown level 'text'"),
    (("--typo", "1"), "Unrecognized options: --typo"),
]
FAR = {"name": "far", "x": 0.0, "y": 3.5}
LEVELS = {
    "skilled": {"robots": [{"name": "a", "x": 0.0, "skills": ["stone"]}]},
    "near": {"robots": [{"name": "a", "x": 0.0}, {"name": "b", "x": 0.5}]},
    "nobody": {"robots": [{"name": "a", "x": 0.0, "skills": ["tray"]}]},
    "dense": {"arrivals": {"rate": 19.0}},
    "solid": {"cell": {"belt": {"neighbours": "solid"}}},
    "far": {"robots": [{"name": "a", "x": 0.0, "bins": [FAR]}]},
}


@pytest.mark.parametrize(("given", "said"), WRONG, ids=lambda value: str(value)[:60])
def test_a_wrong_line_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given, said):
    (tmp_path / "folder").mkdir()
    for name, changes in LEVELS.items():
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump({"name": name, **changes}))
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    out = () if "--out" in given else ("--out", "table.json")
    assert refused("agents.line calibrate", "--num-envs", "2", *given, *out).startswith(f"error: {said}")
    assert sorted(tmp_path.rglob("*")) == before


def test_a_line_on_which_nothing_comes_is_said_to_have_no_throws(tmp_path):
    empty = {"name": "empty", "base": "single", "arrivals": {"rate": 1e-9}, "duration": 5}
    level = tmp_path / "empty.yaml"
    level.write_text(yaml.safe_dump(empty))
    said = "level 'empty': nobody threw anything in 224 shifts of 5 s; arrivals.rate is 1e-09 objects a second"
    assert said in refused("agents.line calibrate", "--level", level, "--out", tmp_path / "table.json")
