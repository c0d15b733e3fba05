"""Reading of every form of file as commands do it."""

from __future__ import annotations

import contextlib
import gc
from contextlib import closing
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from agents.controllers.state import load_state
from agents.design import level_files
from agents.dispatchers import registry
from agents.dispatchers.settings import settings_in
from agents.fit import reading, writing
from agents.fit.fitted import fit_log
from agents.fit.parameters import priors
from agents.fit.report import report
from agents.fit.writing import page
from agents.grasping.features import NAMES
from agents.grasping.network import PlaceNetwork
from agents.ground import levels
from agents.ground.files import json_text
from agents.judging.loop import observed
from agents.judging.trials import open_trial
from agents.learning import trained
from agents.learning.hyperparameters import algorithm_arguments, hyperparameters, training_size
from agents.policies.actor import CHANNELS, Actor
from agents.policies.scorer import Scorer
from agents.report import __main__
from agents.train import Arguments
from agents.train import main as train
from benchmarks.fuzz_cases.basis import finite
from benchmarks.fuzz_cases.examples import CONFIGS, FREE, LINE, RULES, TOY, make_chances
from pnt_gym.cells.grasp.config import PIXELS
from pnt_gym.cells.line.chances import required_table
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.observation import ENTRIES
from pnt_gym.reading import bytes_of
from tests.tools.fitting import WASTE


def read_whole_log(path: Path) -> None:
    """Fit a log, and write all that a fit writes."""
    fitted = fit_log(reading.read(path, WASTE), WASTE, priors(WASTE, FREE))
    samples = fitted.posterior.samples(200)
    json_text(report(fitted, samples))
    writing.text(fitted, samples, "waste", path.with_name("fitted.yaml"), "fit")
    page(fitted, samples, "fit")


def read_level(path: Path) -> None:
    """Read a level of the family of its name, and the same for people."""
    CONFIGS[path.stem].load(path)
    levels.text(str(path))


def read_design(path: Path) -> None:
    """Read the line of a file as the design's page does when a browser sends the file."""
    level_files.line_of_file(bytes_of(path, level_files.LARGEST), path.name)


def read_chances(path: Path) -> None:
    """Read the table of chances of a line, and ask for chances."""
    config = LineConfig.load({"base": "single", "chances": str(path)})
    table = required_table(config)
    finite("chances", table.picked)
    finite("chances", table.landed)


def read_policy(path: Path) -> None:
    """Read a policy or a scorer, and let it act."""
    if path.name == "scorer.npz":
        finite("scores", Scorer.load(path)(np.full((3, ENTRIES), 0.5)))
        return
    actor = Actor.load(path)
    images = None if actor.eye is None else np.zeros((3, CHANNELS, PIXELS, PIXELS), np.uint8)
    finite("actions", actor(np.full((3, actor.sizes[0]), 0.5), images))


def read_learned(path: Path) -> None:
    """Load what a controller learned, and let it throw."""
    with closing(open_trial(TOY, None, 4, 1)) as trial:
        controller: Any = trial.controller(path.stem)
        load_state(controller, path)
        trial.run(controller, 4, 0)


def read_run(path: Path) -> None:
    """Throw with the policy of a run folder."""
    folder = _run_of(path)
    env_id, level, mode = trained.resolve(str(folder), None, None, None)
    with closing(open_trial(env_id, level, 4, 1, mode)) as trial:
        trial.run(trial.controller(str(folder)), 4, 0)


def resume_run(path: Path) -> None:
    """Go on with a training."""
    try:
        train(Arguments(resume=_run_of(path), steps=12, eval_picks=0, threads=1))
    finally:
        gc.collect()  # a replay buffer stands in a circle of references


def _run_of(path: Path) -> Path:
    return path.parents[2] if path.parent.parent.name == "checkpoints" else path.parent


def read_settings_of(path: Path) -> None:
    """Read hyperparameters, and check them for a training."""
    settings = hyperparameters(path.stem, "PnTRelease-v0", path)
    training_size(path.stem, "PnTRelease-v0", settings)
    algorithm_arguments(settings)


def read_rules(path: Path) -> None:
    """Make every rule with its settings, and let it choose."""
    env, features = _lines()
    with contextlib.chdir(path.parents[1]):
        settings_in(path)
        for name in RULES:
            registry.make(name, env.unwrapped.core).act(observed(features, np.zeros(2)))


@cache
def _lines() -> tuple[Any, Any]:
    """Two lines and their observations."""
    with TemporaryDirectory() as folder:
        make_chances(Path(folder))
        level = {**LINE, "chances": f"{folder}/table.json"}
        env = open_trial("PnTLine-v0", level, 2, 1).env
    return env, env.reset(seed=0)[0]


def read_network(path: Path) -> None:
    """Read a network that chooses places, and let it judge places."""
    finite("worths", PlaceNetwork.load(path).predict(np.zeros((2, len(NAMES)))))


def read_report(path: Path) -> None:
    """Tables and drawings of a result, alone in its folder."""
    __main__.read(path.parents[path.suffix == ".npz"])
