"""Judge one controller on held-out throws: `python -m agents.evaluate --controller analytic`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from agents import runs
from agents.cli import UsageError, at_least, option, run
from agents.controllers import Learner, load_state, make_controller, save_state
from agents.controllers.protocol import Controller
from agents.environments import make_vector
from agents.evaluation import NUM_ENVS, PRACTICE, Env, Throws, evaluate, practise, summary, throw_records
from agents.files import check_writable, write_json
from agents.tables import console, summary_table, throws_bar
from agents.versions import versions


@dataclass(frozen=True)
class Arguments:
    """Throw held-out objects with one controller and say what it is worth in picks per minute."""

    controller: Annotated[str, tyro.conf.arg(metavar="NAME|RUN_DIR")]
    """A controller (analytic, analytic_height, mean_lead, mean_shift, virtual_goal, newton_goal, ridge, mlp, oracle,
    random) or the folder of a training run."""
    env: Annotated[str | None, option("PnTConveyor-v0, or that of the run folder", "ID")] = None
    """Environment id."""
    level: Annotated[str | None, option("nominal, or that of the run folder", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    picks: int = 200
    """Throws to count."""
    seed: int = 0
    """Names the objects; training and practice never see them, whatever their seed."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write all figures and every throw to this file."""
    num_envs: int = NUM_ENVS
    """Cells simulated side by side; part of what a seed means."""
    threads: int = 2
    """Threads that simulate; results do not depend on it."""
    practice: Annotated[int | None, option("120, or 0 with --load", "N")] = None
    """Throws before the evaluation for a controller that learns; others throw none."""
    online: bool = False
    """Go on learning during the evaluation."""
    action_mode: Annotated[str | None, option("the environment's own, or that of the run folder", "MODE")] = None
    """What an action means: one of the environment's action modes, e.g. release_point, release_xyz, virtual_goal."""
    load: Annotated[Path | None, option("nothing learned", "FILE.npz")] = None
    """Start from what a learning controller saved to this .npz file."""
    save: Annotated[Path | None, option("none", "FILE.npz")] = None
    """Save what a learning controller learned to this .npz file."""


def main(arguments: Arguments) -> None:
    """Evaluate, print the table, write the JSON."""
    check(arguments)
    env_id, level, mode = setting(arguments)
    env = make_vector(env_id, level, arguments.num_envs, arguments.threads, mode)
    try:
        controller = make_controller(arguments.controller, env)
        throws, practised = throw(controller, env, arguments)
        core = env.unwrapped.core
    finally:
        env.close()
    figures = summary(throws)
    title = f"{controller.name} on {env_id}, level {core.config.name}, {len(throws)} throws, seed {arguments.seed}"
    title += f", after {practised} practice throws" if practised else ""
    console().print(summary_table(title, figures))
    if arguments.json is not None:
        head = {
            "env": env_id,
            "controller": arguments.controller,
            "level": core.config.name,
            "seed": arguments.seed,
        }
        tail = {
            "dwell_s": core.dwell,
            "practice": practised,
            "online": arguments.online,
            "num_envs": arguments.num_envs,
            "action_mode": core.action_mode,
            "versions": versions(),
            "throws": throw_records(throws, core.item_names, core.correction),
        }
        write_json(arguments.json, {**head, **figures, **tail})
        console().print(f"every throw is in {arguments.json}")


def check(arguments: Arguments) -> None:
    """Find mistakes before anything is simulated.

    Raises:
        UsageError: a number out of its range, or a file that cannot be written.
    """
    for name, least in (("picks", 1), ("seed", 0), ("num-envs", 1), ("threads", 1)):
        at_least(name, getattr(arguments, name.replace("-", "_")), least)
    at_least("practice", arguments.practice or 0, 0)
    for path in (arguments.json, arguments.save):
        if path is not None:
            check_writable(path)


def setting(arguments: Arguments) -> tuple[str, Any, str | None]:
    """Environment id, level and action mode: as asked for, else the run folder's, else the defaults.

    A mode of None is the environment's own.
    """
    known: dict[str, Any] = {"env": "PnTConveyor-v0", "level": "nominal", "action_mode": None}
    folder = Path(arguments.controller)
    if folder.is_dir():
        known.update(runs.read_arguments(folder), level=str(folder / "env.yaml"))
    asked = {"env": arguments.env, "level": arguments.level, "action_mode": arguments.action_mode}
    known.update({name: value for name, value in asked.items() if value is not None})
    return known["env"], known["level"], known["action_mode"]


def throw(controller: Controller, env: Env, arguments: Arguments) -> tuple[Throws, int]:
    """Practise if the controller can, then evaluate; returns the throws and how many were practice.

    Raises:
        UsageError: something is to be loaded or saved that this controller does not have.
    """
    controller.reset(arguments.seed)
    practice = prepare(controller, arguments)
    with throws_bar(console()) as bar:
        if practice:
            task = bar.add_task("practice", total=practice)
            practise(controller, env, practice, arguments.seed, progress=lambda n: bar.advance(task, n))
        counted = bar.add_task("evaluation", total=arguments.picks)
        throws = evaluate(
            controller,
            env,
            arguments.picks,
            arguments.seed,
            online=arguments.online,
            progress=lambda n: bar.advance(counted, n),
        )
    if isinstance(controller, Learner) and arguments.save is not None:
        save_state(controller, arguments.save)
    return throws, practice


def prepare(controller: Controller, arguments: Arguments) -> int:
    """Load what a learning controller knows; returns the throws it is to practise."""
    if isinstance(controller, Learner):
        if arguments.load is None:
            return PRACTICE if arguments.practice is None else arguments.practice
        load_state(controller, arguments.load)
        return arguments.practice or 0
    for name in ("load", "save"):
        if getattr(arguments, name) is not None:
            raise UsageError(f"--{name}: controller {controller.name!r} learns nothing that could be kept")
    return 0


if __name__ == "__main__":
    run(main, Arguments, "agents.evaluate")
