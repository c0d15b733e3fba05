"""Sound files of every form that a command reads, made by the suite itself, and small."""

from __future__ import annotations

import shutil
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from agents.controllers.state import save_state
from agents.dataset import collection
from agents.dataset.episodes import Episode
from agents.design.level_files import text_of_line
from agents.dispatchers.settings import MADE
from agents.dispatchers.settings import settings as settings_of_rule
from agents.ground.files import json_text
from agents.ground.places import GRASPING
from agents.ground.places import SHIPPED as ROOT
from agents.judging.trials import open_trial
from agents.learning.hyperparameters import hyperparameters
from agents.policies.actor import CHANNELS, Actor, Eye
from agents.policies.networks import Convolution, Dense, Lstm
from agents.policies.scorer import INPUTS, Scorer
from benchmarks.fuzz_cases.levels import whole_level
from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.line.chances import format_table, required_table
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.reading import json_of, yaml_text
from tests.tools.benchmark import carried_out, toy_plan, write
from tests.tools.commands import call_here
from tests.tools.fitting import WASTE, throw
from tests.tools.toy_cell import register_toy

register_toy()
RULES: Final = ("atc", "price", "index", "beam", "price_beam", "guided_beam")


CHECKPOINT: Final = "checkpoints/00000008"


LEARNERS: Final = ("ridge", "virtual_goal", "mlp")


LINE: Final = {"base": "single", "name": "mine"}


CONFIGS: Final[dict[str, type[LevelConfig]]] = {
    "waste": ConveyorConfig, "day": ConveyorConfig, "skills3": LineConfig, "grasp": GraspConfig, "belt": GripperConfig,
    "nominal": OneJointConfig,
}  # fmt: skip

"""Families of the levels that are changed, by the name of such a level."""


FREE: Final = ("valve",)

"""Parameters of a quick fit."""


TOY: Final = "ToyThrow-v0"


SMALL: Final = {"policy_kwargs": {"net_arch": [8]}, "learning_starts": 4, "gamma": 0.9}

"""Hyperparameters of a small training, none of which asks for memory by its value."""


def make_log(folder: Path) -> None:
    """A log of thirteen landings."""
    log, _ = throw(WASTE, 16)
    (folder / "log.csv").write_text(log.text(WASTE.items))


def make_levels(folder: Path) -> None:
    """A level of each family with all its values, and one that differs from another in few of them."""
    for name, config in CONFIGS.items():
        (folder / f"{name}.yaml").write_text(yaml_text(whole_level(config, name)))


def make_design(folder: Path) -> None:
    """A line as the design page saves it."""
    (folder / "line.yaml").write_text(text_of_line(LineConfig.load("skills3_burst")))


def make_plan(folder: Path) -> None:
    """A plan with all keys, of a cell on paper."""
    (folder / "plan.yaml").write_text(
        yaml_text(
            {
                "name": "plan", "env": TOY, "train_level": "each", "picks": 32, "picks_on": {"other": 16}, "seed": 3,
                "levels": {"waste": None, "other": {"base": "waste", "mismatch": 0.5}}, "seeds": [0, 1], "num_envs": 4,
                "entries": [
                    {"label": "analytic", "controller": "analytic"},
                    {"label": "ridge", "controller": "ridge", "throws": [8, 16], "seeds": [1], "options": {}},
                    {"label": "sac", "controller": "sac", "throws": [8], "config": "configs/rl/sac.yml",
                     "levels": ["waste"], "stack": 1, "over": "analytic", "fidelity": "full",
                     "action_mode": "release_point"},
                ],
                "learned": [{"label": "ridge", "throws": 8}], "references": [{"label": "analytic", "throws": 0}],
                "floors": {"waste": "analytic"},
            }
        )
    )  # fmt: skip


def make_chances(folder: Path) -> None:
    """The table of chances of a line."""
    config = LineConfig.load("single")
    (folder / "table.json").write_text(format_table(required_table(config), digest=config.digest()))
    (folder / "line.yaml").write_text(yaml_text({**LINE, "chances": "table.json"}))


def _array(*shape: int) -> Any:
    return np.random.default_rng(0).standard_normal(shape).astype(np.float32)


def make_policies(folder: Path) -> None:
    """A policy of vectors, one with a memory, one that sees pictures, and a scorer."""
    layers = Dense(_array(4, 5), _array(4)), Dense(_array(2, 4), _array(2))
    ends: Any = np.full(2, -1.0, np.float32), np.full(2, 1.0, np.float32)
    Actor(layers, "Tanh", "squashed", np.inf, *ends).save(folder / "policy.npz")
    Actor(layers, "ReLU", "scores", 3.0, *ends, lstm=Lstm(_array(20, 3), _array(20, 5), _array(20))).save(
        folder / "memory.npz"
    )
    convolutions = tuple(
        Convolution(_array(2, maps, side, side), _array(2)) for maps, side in ((CHANNELS, 8), (2, 4), (2, 3))
    )
    eye = Eye(convolutions, Dense(_array(1, 8), _array(1)))
    Actor(layers, "SiLU", "clipped", np.inf, *ends, eye=eye).save(folder / "seeing.npz")
    Scorer((Dense(_array(3, INPUTS), _array(3)), Dense(_array(1, 3), _array(1))), 1.5).save(folder / "scorer.npz")


def make_states(folder: Path) -> None:
    """What controllers learned from a few throws."""
    with closing(open_trial(TOY, None, 8, 1)) as trial:
        for name in LEARNERS:
            controller: Any = trial.controller(name)
            trial.practise(controller, 32, 0)
            save_state(controller, folder / f"{name}.npz")


def make_run(folder: Path) -> None:
    """The run folder of a training of eight throws."""
    (folder / "sac.yml").write_text(yaml_text({"default": SMALL}))
    words = ("--steps", "8", "--num-envs", "4", "--eval-picks", "0", "--config", "sac.yml", "--checkpoint-every", "4")
    done = call_here("agents.train", "--env", TOY, *words, "--threads", "1", "--out", "run", folder=folder)
    assert done.returncode == 0, done.stderr
    run = folder / "run"
    for part in list(run.iterdir()):
        shutil.move(part, folder / part.name)


def make_benchmark(folder: Path) -> None:
    """Results of a planner and a learner, and of two rules of a line."""
    throws = toy_plan(
        {"label": "analytic", "controller": "analytic"},
        {"label": "ridge", "controller": "ridge", "throws": [8]},
        env="PnTRelease-v0", picks=8, num_envs=4, seeds=[0, 1],
        learned=[{"label": "ridge", "throws": 8}], references=[{"label": "analytic"}],
    )  # fmt: skip
    shifts = {
        "name": "line", "env": "PnTLine-v0", "train_level": "single", "levels": ["single"], "shifts": 2, "num_envs": 2,
        "entries": [{"label": name, "controller": name} for name in ("fifo", "price")],
        "learned": [{"label": "price"}], "references": [{"label": "fifo"}],
    }  # fmt: skip
    for name, plan in (("throws", throws), ("shifts", shifts)):
        (folder / name).mkdir()
        write(folder / name / "results.json", carried_out(plan, folder / "work"))


def make_study_plan(folder: Path) -> None:
    """The plan of a study that ships."""
    shutil.copyfile(ROOT / "configs" / "studies" / "cup.yaml", folder / "plan.yaml")


def make_study(folder: Path) -> None:
    """Results of a study that ships."""
    shutil.copyfile(ROOT / "results" / "cup.json", folder / "results.json")


def make_reproduction(folder: Path) -> None:
    """Results about one paper, with some of its rows."""
    record = json_of(ROOT / "results" / "reproduction.json", 2**24)
    rows = [row for row in record["rows"] if row["paper"] == "choe"][:20]
    of_paper = {name: {"choe": record[name]["choe"]} for name in ("titles", "figures", "data", "overview", "grids")}
    content = {**record, **of_paper, "papers": ["choe"], "rows": rows, "seconds": {"choe/example": 1.0}}
    (folder / "results.json").write_text(json_text(content))


def make_settings(folder: Path) -> None:
    """Hyperparameters of two algorithms."""
    for algo in ("sac", "ppo"):
        settings = {**hyperparameters(algo, "PnTRelease-v0"), "learning_rate": "lin_0.001"}
        (folder / f"{algo}.yml").write_text(yaml_text({"PnTRelease-v0": settings, "default": {}}))


def make_rules(folder: Path) -> None:
    """Settings of rules of a line in the working folder, and a level for a command."""
    make_chances(folder)
    (folder / MADE).parent.mkdir()
    content = {"mine": {"rate": 1.173, **{name: settings_of_rule("single", name) for name in RULES}}}
    (folder / MADE).write_text(yaml_text(content))


def make_zoo(folder: Path) -> None:
    """A folder as RL-Zoo writes it."""
    inner = folder / "MyEnv-v0"
    inner.mkdir()
    (inner / "args.yml").write_text(yaml_text({"env": "MyEnv-v0", "env_kwargs": {"level": "waste"}}))
    (inner / "config.yml").write_text(yaml_text({"policy": "MlpPolicy", "frame_stack": 1}))
    (folder / "MyEnv-v0.zip").write_bytes(b"")


def make_networks(folder: Path) -> None:
    """A network that chooses places, as it ships."""
    shutil.copyfile(GRASPING / "local_mlp.npz", folder / "local_mlp.npz")


def make_chunk(folder: Path) -> None:
    """A chunk of a dataset: two episodes of two and three throws."""
    whole = [
        Episode(
            seed, _array(count + 1, 4), _array(count, 2), np.arange(float(count)), True, {"kind": _array(count + 1)},
            {"mass": np.arange(float(count))}, {"value": 1.5},
        )
        for seed, count in ((1, 2), (5, 3))
    ]  # fmt: skip
    (folder / "chunk.npz").write_bytes(collection.pack(whole))
