"""Evaluate one controller on held-out throws: `python -m agents.evaluate --controller analytic`."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from .ground.cli import NUM_ENVS, at_least, option, read_settings, run
from .ground.outputs import VIDEOS, check_drawing, check_ending, check_writable, deliver_json, deliver_text
from .ground.tables import console

CONTROLLERS = (
    "A controller's name (analytic, virtual_goal, ridge, mlp, oracle, on a line price, with pictures flattest, ...; "
    "`pnt-gym controllers` lists all), a policy that ships (shipped:waste-sac for the cell of `waste`, shipped:cells "
    "for a cell that nobody measured, shipped:line/skills3, ...), the folder of a training run, a class of your own, "
    "on a line a scorer's FILE.npz, or with --trust a stable-baselines3 model or the folder of an RL-Zoo training."
)


@dataclass(frozen=True)
class Arguments:
    """Throw held-out objects with one controller and report its picks per minute, success and landing error."""

    controller: Annotated[
        str, tyro.conf.arg(metavar="NAME|shipped:NAME|RUN_DIR|MODULE:CLASS|MODEL.zip", help=CONTROLLERS)
    ]
    trust: bool = False
    """Load a stable-baselines3 model or an RL-Zoo folder, whose code then runs; run folders hold no code."""
    env: Annotated[str | None, option("PnTConveyor-v0, or that of the run folder", "ID|MODULE:ID")] = None
    """Environment id; MODULE:ID imports a module of yours first, which registers the id."""
    trial: Annotated[str | None, option("the one that the levels name", "MODULE:CLASS")] = None
    """Judge by another trial: a subclass of `Trial` in a module of yours, whose code then runs."""
    level: Annotated[str | None, option("the environment's own, or that of the run folder", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    picks: Annotated[int | None, option("200; whole shifts on PnTAdapt-v0", "N")] = None
    """Throws to count."""
    shifts: Annotated[int | None, option("32", "N")] = None
    """Work shifts of a line to count."""
    release: Annotated[str | None, option("analytic", "NAME|shipped:NAME|RUN_DIR")] = None
    """Controller that corrects the simulated throws of a line: a controller or a policy of PnTRelease-v0."""
    throws: Annotated[Literal["table", "flight", "full"] | None, option("the level's own", "table|flight|full")] = None
    """How throws of a line are computed: by its table of chances, with flights simulated, or in the full physics."""
    picture: Annotated[Path | None, option("none", "FILE.svg")] = None
    """Draw which robot took which object in the first minute of a line's first shift."""
    video: Annotated[Path | None, option("none", "FILE.mp4")] = None
    """Film the first 12 s of a line's first shift; with --throws full the film shows the evaluated throws."""
    seed: int = 0
    """Seed of the objects; training and practice never see these objects, whatever their seed."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write all figures and every throw to this file."""
    log: Annotated[Path | None, option("none", "FILE.csv")] = None
    """Write a log of the conveyor's throws, as a real cell would measure them, for `pnt-gym fit`."""
    num_envs: int = NUM_ENVS
    """Cells simulated side by side; the objects depend on the seed and on this number."""
    threads: int = 2
    """Threads of the simulation; results do not depend on this number."""
    practice: Annotated[
        int | None, option("120, or 0 with --load and for a controller that ships pre-trained", "N")
    ] = None
    """Practice throws before the evaluation of a controller with a method `learn`; refused for others."""
    online: bool = False
    """Let the controller go on learning during the evaluation."""
    action_mode: Annotated[str | None, option("the environment's own, or that of the run folder", "MODE")] = None
    """Meaning of an action: one of the environment's action modes, e.g. release_point, release_xyz, virtual_goal."""
    settings: Annotated[
        tuple[str, ...], tyro.conf.UseAppendAction, option("none", "NAME=VALUE"), tyro.conf.arg(name="option")
    ] = ()
    """Setting of a controller given by name, e.g. gain=0.1 of virtual_goal; may be given more than once."""
    load: Annotated[Path | None, option("nothing learned", "FILE.npz")] = None
    """Start from the state that a learning controller saved to this .npz file."""
    save: Annotated[Path | None, option("none", "FILE.npz")] = None
    """Save the learned state of the controller to this .npz file."""


def main(arguments: Arguments) -> None:
    """Evaluate the controller, print the table, and write the files asked for."""
    from .ground import levels
    from .judging import trials
    from .judging.evaluation import Learning, judge
    from .judging.trials import open_trial
    from .learning import trained
    from .pictures.stage import film

    at_least(vars(arguments), picks=1, shifts=1, seed=0, num_envs=1, threads=1, practice=0)
    check_writable(arguments.json, arguments.save, arguments.picture, arguments.video, arguments.log)
    check_ending("video", arguments.video, VIDEOS)
    check_drawing(picture=arguments.picture, film=arguments.video)
    env_id, level, mode = trained.resolve(arguments.controller, arguments.env, arguments.level, arguments.action_mode)
    cells = env_id, level, arguments.num_envs, arguments.threads, mode
    with closing(open_trial(*cells, arguments.throws, arguments.trial)) as trial:
        trials.check(trial, vars(arguments), env_id)
        trial.correct_throws(arguments.release)
        settings = read_settings(arguments.settings)
        controller = trials.controller(trial, arguments.controller, settings, trust=arguments.trust)
        controller.reset(arguments.seed)
        count = getattr(arguments, trial.option, None) or trial.count()
        learning = Learning(arguments.practice, arguments.online, arguments.load, arguments.save)
        record, practice, conditions = judge(trial, controller, count, arguments.seed, learning, arguments.log)
        config = trial.core.config
    report = {"level": config.name, "seed": arguments.seed, "practice": practice, **record.report()}
    report |= levels.values(config)
    console().print(record.table(f"{controller.name} on {env_id}, {conditions}", report))
    levels.show(config)
    if note := getattr(controller, "note", ""):
        console().print(note)
    if arguments.picture is not None and (drawing := record.picture()) is not None:
        deliver_text(arguments.picture, drawing)
    if arguments.video is not None:
        stage_args = arguments.controller, env_id, config, arguments.seed
        film(arguments.video, *stage_args, trust=arguments.trust, release=arguments.release)
        console().print(f"a film of the first {trial.step}s is in {arguments.video}")
    if arguments.json is not None:
        deliver_json(arguments.json, {"env": env_id, "controller": arguments.controller, **report})
        console().print(f"every {trial.step} is in {arguments.json}")


if __name__ == "__main__":
    run(main, Arguments, "agents.evaluate")
