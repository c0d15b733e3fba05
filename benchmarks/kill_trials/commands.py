"""The commands that a kill must not harm, small: what they begin with and how they are given again."""

from __future__ import annotations

import json
import shutil
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from agents.ground.places import SHIPPED
from benchmarks.kill_trials.trials import Command, Line
from tests.tools.toy_cell import register_toy

register_toy()
LEARNER: dict[str, Any] = {
    "policy_kwargs": {"net_arch": [8]},
    "buffer_size": 100,
    "learning_starts": 4,
    "batch_size": 4,
    "gamma": 0.0,
}
TOY, REAL = "ToyThrow-v0", "PnTRelease-v0"


def train(env: str) -> Command:
    """A training of four legs' throws in two legs, with its table at the end."""
    return Command(f"train-{env}", _settings, partial(_train, env))


def _settings(folder: Path) -> None:
    (folder / "sac.yml").write_text(yaml.safe_dump({"default": LEARNER}))


def _train(env: str, folder: Path) -> Line:
    if (folder / "run").exists():
        return ["agents.train", "--resume", "run", "--eval-picks", "4"]
    start = ["--env", env, "--config", "sac.yml", "--out", "run", "--steps", "16", "--checkpoint-every", "8"]
    return ["agents.train", *start, "--num-envs", "4", "--eval-picks", "4"]


def benchmark(env: str, processes: int) -> Command:
    """A plan with a controller that learns nothing, one that practises, and a training in two steps."""
    return Command(f"benchmark-{env}-{processes}", partial(_plan, env), partial(_benchmark, processes))


def _plan(env: str, folder: Path) -> None:
    entries = [
        {"label": "analytic", "controller": "analytic"},
        {"label": "goal", "controller": "virtual_goal", "throws": [8]},
        {"label": "sac", "controller": "sac", "throws": [4, 8], "options": LEARNER},
    ]
    plan = {"name": "small", "env": env, "train_level": "waste", "levels": ["waste"], "seeds": [0]}
    options = {"picks": 8, "num_envs": 4, "entries": entries, "learned": [{"label": "sac", "throws": 8}]}
    (folder / "plan.yaml").write_text(yaml.safe_dump({**plan, **options, "references": [{"label": "analytic"}]}))


def _benchmark(processes: int, _: Path) -> Line:
    places = ["--config", "plan.yaml", "--work", "work", "--out", "out.json"]
    return ["agents.benchmark", *places, "--jobs", str(processes)]


def reproduce(*parts: str) -> Command:
    """Parts of a paper, with their figures and drawings."""
    return Command("reproduce", lambda _: None, lambda _: _reproduce(parts))


def _reproduce(parts: tuple[str, ...]) -> Line:
    places = ["--work", "work", "--json", "out.json", "--figures", "drawings", "--jobs", "1"]
    return ["agents.reproduce", "choe", *places, "--only", *parts]


def report(*results: Path) -> Command:
    """Tables, page and README of some results."""
    return Command("report", partial(_results, results), lambda _: ["agents.report", *REPORTED])


REPORTED = ("--results", "results", "--readme", "README.md")


def _results(files: tuple[Path, ...], folder: Path) -> None:
    (folder / "results").mkdir()
    for file in (*files, SHIPPED / "results" / "physics.json", SHIPPED / "results" / "perf_planner.json"):
        shutil.copy(file, folder / "results")
    (folder / "README.md").write_text("# Ours\n<!-- table:physics -->\n<!-- /table -->\nEnd.\n")


def small_reproduction(folder: Path) -> Path:
    """A record of a reproduction with a drawing that lies beside it."""
    record = {
        "command": "python -m agents.reproduce small", "versions": {}, "seconds": {}, "papers": ["small"],
        "titles": {"small": "Small 2026"}, "figures": {"small": ["small.svg"]}, "data": {"small": {}},
        "overview": {"small": {"grids": {}, "notes": {}}}, "grids": {"small": []}, "rows": [],
    }  # fmt: skip
    path = folder / "reproduction.json"
    path.write_text(json.dumps(record) + "\n")
    return path
