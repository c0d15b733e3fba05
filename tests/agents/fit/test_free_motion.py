"""Logs of throws by any motion, of which the releases alone are known."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

import pnt_gym
from agents.fit import reading
from agents.fit.fitted import fit_log
from agents.fit.log import ThrowLog
from agents.fit.model import ThrowModel
from agents.fit.parameters import priors
from agents.ground.cli import UsageError
from pnt_gym.cells.conveyor.config import ConveyorConfig
from tests.tools.commands import call_here, output_of, refused
from tests.tools.fitting import QUIET, WASTE, level, throw

RIGID = {"cup": {"stiffness": None}}
SLOW = {"limits": {"percent": [25.0, 33.0]}}
"""A robot of other speeds than those of the level waste."""


def freed(log: ThrowLog) -> ThrowLog:
    return replace(log, percent=np.full(len(log), np.nan))


@cache
def slow_log() -> ThrowLog:
    """A log of a robot of other speeds, whose vacuum decays slowly."""
    return throw(level(**RIGID, **SLOW, suction={"tau": 0.014}), 60)[0]


def test_where_nothing_is_hidden_releases_alone_give_the_simulated_landings() -> None:
    """The planner's hands keep their velocity until the objects are free, as is assumed of every motion."""
    config = level(**QUIET, **RIGID)
    log, record = throw(config, 24)
    rows = log.has_landing & ~record.throws.info["recontact"]
    predicted = ThrowModel(freed(log), config, 2).landings(config)
    assert rows.sum() > 10
    np.testing.assert_allclose(predicted[rows], log.landing[rows], atol=1e-3)


def test_a_log_of_another_motion_is_fitted_from_its_releases() -> None:
    log, parameters = slow_log(), priors(WASTE, ["tau", "camera_x", "camera_y"])
    other = replace(log, percent=np.full(len(log), WASTE.limits.percent[0]))
    with pytest.raises(UsageError, match="or give --free-motion for a robot that moves otherwise"):
        ThrowModel(other, WASTE)
    fitted = fit_log(freed(log), WASTE, parameters)
    low, high = np.quantile(fitted.posterior.samples()[:, 0], (0.025, 0.975))
    true = parameters[0].score(0.014)
    assert low - 0.1 < true < high + 0.1
    assert fitted.posterior.density.model.config.cup.stiffness is None
    assert fitted.level.cup.stiffness == WASTE.cup.stiffness


def test_nothing_is_said_of_grips_and_lips() -> None:
    assert "stiffness" not in [parameter.name for parameter in priors(WASTE, free_motion=True)]
    with pytest.raises(UsageError, match="no parameter is free"):
        priors(WASTE, ["stiffness"], free_motion=True)
    log = freed(slow_log())
    assert ThrowModel(log, WASTE, 2).outcomes(WASTE).holds.all()
    with pytest.raises(UsageError, match="throw 1 never comes down to the rims of the bins"):
        ThrowModel(replace(log, release=log.release - [0.0, 0.0, 3.0]), WASTE)
    ThrowModel(log, level(planner="ellipse"), 2)


def test_the_command_reads_any_motion_and_refuses_what_lacks_its_columns(tmp_path: Path) -> None:
    text = slow_log().text(WASTE.items)
    (tmp_path / "log.csv").write_text(text)
    line = "fit log.csv --level waste --free tau --free-motion --out f.yaml"
    assert "decay of the vacuum" in output_of(line, tmp_path)
    written = (tmp_path / "f.yaml").read_text()
    assert "--free-motion" in written
    assert yaml.safe_load(written)["suction"]["tau"] == pytest.approx(0.014, abs=0.002)
    assert ConveyorConfig.load(tmp_path / "f.yaml").cup.stiffness == WASTE.cup.stiffness
    found = pnt_gym.fit(tmp_path / "log.csv", free=["tau"], free_motion=True)
    assert found["parameters"]["tau"]["value"] == pytest.approx(14.0, abs=2.0)
    (tmp_path / "f.yaml").unlink()
    (tmp_path / "log.csv").write_text(text.replace("release_vz", "vertical"))
    done = call_here("agents.fit", *line.split()[1:], folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert "lacks the columns 'release_vz'" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "f.yaml").exists()
    for option in ("--design 3", "--twins 1"):
        refused("agents.fit", str(tmp_path / "log.csv"), "--level", "waste", "--free-motion", *option.split())
    refused("agents.fit", "--level", "waste", "--twins", "1", "--free-motion")


def test_a_speed_setting_is_not_needed(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(freed(slow_log()).text(WASTE.items))
    with pytest.raises(UsageError, match="percent is empty"):
        reading.read(path, WASTE)
    assert reading.read(path, WASTE, free_motion=True).has_free_motion
