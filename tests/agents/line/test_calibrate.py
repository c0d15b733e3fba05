"""`agents.calibrate` throws, counts, and writes a table that a level can go by."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from agents.ground.cli import UsageError
from agents.line import thrown
from agents.line.counting import counting_line
from agents.line.thrown import calibrate, chosen_throws, random_throws
from pnt_gym.cells.line.chances import Chances, shipped_table
from pnt_gym.cells.line.config import LineConfig
from tests.tools.commands import answered, output_of, refused
from tests.tools.plant import plant

LEVEL = {"name": "mine", "base": "single", "cell": {"limits": {"percent": [30, 45]}}}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a level, and its table by the command line."""
    folder = tmp_path_factory.mktemp("line")
    (folder / "mine.yaml").write_text(yaml.safe_dump(LEVEL))
    return folder, output_of("line calibrate --level mine.yaml --throws 120 --num-envs 8 --out table.json", folder)


def test_a_table_is_written_and_said_to_be(made):
    folder, said = made
    told = json.loads((folder / "table.json").read_text())
    words = " ".join(said.split())
    low, high = min(told["picked"]), max(told["picked"])
    assert words.startswith(f"{told['throws']} throws: ") and "of the held objects ended in their bins" in words
    assert words.endswith(
        f"the cup seals on {low:.0%} to {high:.0%} of the picks of an item; the table is in table.json"
    )
    assert 120 <= told["throws"] < 128
    assert told["digest"] == LineConfig.load(LEVEL).digest()
    assert told["items"] == ["tray", "can", "paper_ball", "yoghurt_cup"]
    assert told["percent"] == [30.0, 45.0]
    assert (told["seed"], np.shape(told["landed"])) == (0, (4, 2, 4))
    assert {"mujoco", "numpy", "pnt_gym"} <= set(told["versions"])
    assert sorted(path.name for path in folder.iterdir()) == ["mine.yaml", "table.json"]


def test_the_table_is_what_the_throws_of_the_seed_say(made):
    folder, _ = made
    config = LineConfig.load(LEVEL)
    told = list(random_throws(counting_line(config, "full"), throws=120, seed=0, num_envs=8, threads=1))
    columns = {name: np.concatenate([part[name] for part in told]) for name in told[0]}
    counts = {name: columns[name] for name in ("kind", "percent", "distance", "hits")}
    again = Chances.of(1.0 - sums(columns["fails"], counts["kind"]), **counts)
    written = json.loads((folder / "table.json").read_text())
    for name in ("percent", "edges", "picked", "landed"):
        np.testing.assert_allclose(written[name], getattr(again, name), atol=5.1e-6)
    assert columns["picked"].all()


def sums(values, kind):
    """Mean value of each of the four items."""
    return np.array([values[kind == item].mean() for item in range(4)])


def test_flights_and_the_full_physics_throw_the_same_objects(made):
    config = LineConfig.load(LEVEL)
    full, flown = (next(random_throws(counting_line(config, throws), 100, 0, 8, 1)) for throws in ("full", "flight"))
    for name in ("kind", "percent", "distance", "fails"):
        np.testing.assert_array_equal(full[name], flown[name])
    assert np.nanmedian(np.linalg.norm(full["miss"] - flown["miss"], axis=1)) < 0.003


def test_without_a_place_a_table_is_found_by_other_commands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(LEVEL))
    level = ("--level", "mine.yaml")
    evaluation = ("--env", "PnTLine-v0", "--controller", "atc", *level, "--shifts", "1", "--num-envs", "1")
    assert "has no table of throws; make it with `pnt-gym line calibrate" in refused("agents.evaluate", *evaluation)
    assert answered("agents.line calibrate", *level, "--throws", "100", "--num-envs", "8", "--threads", "1")[0] == 0
    config = LineConfig.load("mine.yaml")
    place = tmp_path / "runs" / "chances" / f"{config.digest()}.json"
    assert place.is_file()
    assert config.files() == (Path("runs") / "chances" / place.name,)
    assert not shipped_table(config).is_file()
    assert answered("agents.evaluate", *evaluation) == (0, "")


def test_a_line_on_which_nothing_comes_has_a_table_but_a_controller_throws_nothing_there(tmp_path):
    empty = LineConfig.load({"name": "empty", "base": "single", "arrivals": {"rate": 1e-9}, "duration": 5})
    tables = [tmp_path / f"{name}.json" for name in ("random", "price")]
    calibrate(empty, tables[0], 32, 0, 8)
    said = r"level 'empty': no robot threw an object in \d+ shifts of 5 s; arrivals.rate is 1e-09 objects a second"
    with pytest.raises(UsageError, match=said):
        calibrate(empty, tables[1], 32, 0, controller="price")
    assert [table.is_file() for table in tables] == [True, False]


def test_throws_that_a_controller_chooses_are_counted():
    config = LineConfig.load({**plant(), "throws": "flight", "value": {"of": {"alu": 50.0}}, "duration": 20.0})
    parts = [list(chosen_throws(config, "value_rate", 60, 0, 1)), list(random_throws(config, 60, 0, 4, 1))]
    chosen, drawn = (np.concatenate([part["kind"] for part in throws]) for throws in parts)
    assert 60 <= len(chosen) < 72
    assert (chosen == 2).mean() > 1.5 * (drawn == 2).mean() > 0.0


def test_a_table_of_a_controller_belongs_to_its_line():
    line = LineConfig.load(plant())
    faster = LineConfig.load(line, arrivals={"rate": 2.0})
    places = {
        thrown.place(config, None, controller=name).name for config in (line, faster) for name in ("price", "atc")
    }
    assert len(places) == 4
    assert thrown.place(line, None) == thrown.place(faster, None)
