"""Train a residual agent: `python -m agents.train --env PnTConveyor-v0`."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from .controllers import make_controller
from .controllers.between import PLANNER, as_seen
from .controllers.own import run_policy
from .dispatchers.registry import line_of
from .ground.cli import UsageError, at_least, option, run
from .ground.environments import Env, core_of, find_environment, make_vector
from .ground.files import held, write_json
from .ground.places import module_name
from .ground.streams import destination
from .ground.tables import comparison_table, console
from .judging.evaluation import NUM_ENVS, PRACTICE, held_out, practise
from .judging.throws import summary
from .judging.work_shifts import SHIFTS
from .learning import runs
from .learning.hyperparameters import hyperparameters, size
from .learning.runs import ALGORITHMS, CHOOSING, Algorithm
from .learning.trained import own_environment
from .lessons import training as lines
from .lessons.course import in_flight, learn

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

    from .learning.vec_env import SameStepVecEnv

LEVELS: Mapping[str, str] = dict.fromkeys(("PnTConveyor-v0", "PnTRelease-v0"), "waste")
"""What is trained on unless it is said: where learning shows in success, not only in the landing."""
PICKS = 320
"""Throws of each controller in the table at the end."""
TABLE_SEED = 0
TABLE = "evaluation.json"
"""The table at the end of a run, in its folder."""


@dataclass(frozen=True)
class Arguments:
    """Train an agent to correct the analytic planner's throws, or to choose what comes next on a line; compare."""

    env: Annotated[str | None, option("PnTConveyor-v0", "ID|MODULE:ID")] = None
    """Environment id; with MODULE:ID one that a module of yours registers."""
    level: Annotated[str | None, option("waste at the conveyor, elsewhere nominal", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    fidelity: Annotated[Literal["full", "flight"] | None, option("the level's own", "full|flight")] = None
    """What is simulated to learn from: flight is several times as fast, and is judged in the level's own fidelity."""
    full_last: Annotated[int | None, option("0", "N")] = None
    """With --fidelity flight: the last N throws are simulated in full."""
    algo: Annotated[Algorithm | None, option("sac; residual_ppo on a line", "|".join((*ALGORITHMS, *CHOOSING)))] = None
    """Learning algorithm; the last two choose, on a line."""
    steps: Annotated[int | None, option("n_timesteps of --config, or as the resumed run was asked for", "N")] = None
    """Throws in all, counting those before a resume; rounded up to whole batches. On a line decisions."""
    seed: Annotated[int | None, option("0", "S")] = None
    """Of the networks, the exploration and the objects thrown."""
    out: Annotated[Path | None, option("runs/ENV-LEVEL-ALGO-seedS-TIME", "DIR")] = None
    """Run folder."""
    resume: Annotated[Path | None, option("a new run", "DIR")] = None
    """Continue this run folder; everything but --steps and --threads is taken from it."""
    num_envs: Annotated[int | None, option("n_envs of --config", "N")] = None
    """Cells simulated side by side."""
    threads: int = 2
    """Threads that simulate; results do not depend on it."""
    action_mode: Annotated[str | None, option("the environment's own", "MODE")] = None
    """What an action means: one of the environment's action modes, e.g. release_point, release_xyz, virtual_goal."""
    checkpoint_every: Annotated[int | None, option("2000; 125000 on a line", "N")] = None
    """Throws between checkpoints, from which the run can be continued."""
    config: Annotated[Path | None, option("configs/rl/ALGO.yml", "FILE.yml")] = None
    """Hyperparameters in RL-Zoo syntax; also one that ships, such as configs/rl/residual_ppo_long.yml."""
    eval_picks: Annotated[int | None, option("320; 32 shifts on a line", "N")] = None
    """Held-out throws per controller in the table at the end, on a line shifts; 0 for no table."""
    stack: Annotated[int | None, option("1", "K")] = None
    """Observations that the policy sees at once, the last ones of the shift; more than 1 on PnTAdapt-v0."""
    over: Annotated[str | None, option("analytic", "CONTROLLER")] = None
    """The policy's action is added to that of this controller, which needs no practice, e.g. static or kalman: learning
    begins at its throws."""
    tensorboard: bool = False
    """Also log losses for TensorBoard, in the run folder."""


DEFAULTS: Mapping[str, Any] = {
    "env": "PnTConveyor-v0",
    "level": None,
    "fidelity": "full",
    "full_last": 0,
    "algo": "sac",
    "steps": None,
    "seed": 0,
    "num_envs": None,
    "action_mode": None,
    "checkpoint_every": 2_000,
    "stack": 1,
    "over": PLANNER,
}


def main(arguments: Arguments) -> None:
    """Train, and print the comparison."""
    asked, settings = settled(arguments)
    level = str(arguments.resume / "env.yaml") if arguments.resume is not None else asked["level"]
    cell = make_vector(asked["env"], level, asked["num_envs"], arguments.threads, asked["action_mode"])
    if arguments.resume is None:
        settings = lines.line_settings(asked, settings, cell)
    core, seen, quick = core_of(cell), as_seen(cell, asked), in_flight(cell, asked, arguments.threads)
    asked |= {"level": asked["level"] or core.config.name, "action_mode": core.action_mode}

    import torch  # noqa: PLC0415 - bad usage is answered without waiting for it

    from .learning.progress import Stop  # noqa: PLC0415
    from .learning.vec_env import SameStepVecEnv  # noqa: PLC0415

    torch.set_num_threads(1)  # small networks are slower on many threads
    even, price = asked["algo"] in runs.ON_POLICY, lines.more_price(settings, cell)
    with closing(SameStepVecEnv(seen, even=even, price=price)) as env:
        with Stop().listening() as stop, ExitStack() as ends:
            if arguments.resume is not None:
                ends.enter_context(held(arguments.resume))
            folder, model = start(arguments, asked, settings, env)
            if arguments.resume is None:
                ends.enter_context(held(folder))
                ends.enter_context(runs.nothing_left(folder))
            learn(model, env, folder, asked, stop, quick=quick, tensorboard=arguments.tensorboard)
        if stop.number is not None:
            say_how_to_resume(folder, asked["env"], model.num_timesteps)
            sys.exit(128 + stop.number)
        if arguments.eval_picks != 0:
            compare(folder, model.num_timesteps, cell, asked, arguments.eval_picks)


def settled(arguments: Arguments) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the run is to do, and its hyperparameters; they say how long and in how many cells unless it is asked for.

    Raises:
        UsageError: see `request`; or hyperparameters that are missing or damaged.
    """
    asked = request(arguments)
    file = arguments.config if arguments.resume is None else arguments.resume / "config.yml"
    settings = hyperparameters(asked["algo"], asked["env"], file)
    usual = size(asked["algo"], asked["env"], settings)
    return {**asked, **{name: value for name, value in usual.items() if asked[name] is None}}, settings


def request(arguments: Arguments) -> dict[str, Any]:
    """What the run is to do: from the command line and the defaults, or from the run that is resumed.

    Raises:
        UsageError: a number out of its range, or an option that a resumed run has already settled.
    """
    given = {name: getattr(arguments, name) for name in DEFAULTS if getattr(arguments, name) is not None}
    least = {"steps": 1, "num_envs": 1, "checkpoint_every": 1, "threads": 1, "stack": 1}
    at_least(vars(arguments), **least, seed=0, eval_picks=0, full_last=0)
    if arguments.resume is None:
        if arguments.out is not None:
            runs.check_new(arguments.out)
        env_id = given.get("env", DEFAULTS["env"])
        find_environment(env_id)
        asked = {**DEFAULTS, **lines.DEFAULTS.get(env_id.rpartition(":")[2], {}), **given}
        if asked["full_last"] and asked["fidelity"] != "flight":
            raise UsageError("--full-last goes with --fidelity flight")
        asked["level"] = asked["level"] or LEVELS.get(asked["env"])
        return asked
    recorded = runs.read_arguments(arguments.resume)
    if given.get("env") == recorded["env"]:
        recorded["env"] = given.pop("env")
    else:
        own_environment(arguments.resume, recorded["env"])
    settled = [*(given.keys() - {"steps"}), *(n for n in ("out", "config") if getattr(arguments, n) is not None)]
    if settled:
        name = settled[0].replace("_", "-")
        raise UsageError(f"--{name} cannot be changed with --resume: the run folder has settled it; leave it out")
    return {**recorded, **given}


def start(
    arguments: Arguments, asked: Mapping[str, Any], settings: Mapping[str, Any], env: SameStepVecEnv
) -> tuple[Path, BaseAlgorithm]:
    """A new run folder with its untrained model, or the resumed one as it was left."""
    from .learning.sb3 import build  # noqa: PLC0415

    if arguments.resume is not None:
        model = runs.restore(arguments.resume, env)
        if arguments.steps is not None and arguments.steps > model.num_timesteps:
            (arguments.resume / TABLE).unlink(missing_ok=True)  # of fewer throws
            runs.write_arguments(arguments.resume, asked)
        if model.num_timesteps >= asked["steps"] and (arguments.resume / TABLE).is_file():
            raise UsageError(
                f"run {str(arguments.resume)!r} has done {model.num_timesteps} throws of {asked['steps']}; "
                "give a larger --steps to go on"
            )
        return arguments.resume, model
    model = build(asked["algo"], env, settings, asked["seed"])
    config = core_of(env.env).config
    name = f"{runs.name_of(asked, config.name)}-{time.strftime('%Y%m%d-%H%M%S')}"
    folder = destination(Path("runs") / name if arguments.out is None else arguments.out)
    runs.create(folder, asked, settings, config, model)
    return folder, model


def say_how_to_resume(folder: Path, env_id: str, throws: int) -> None:
    """Tell the user where an interrupted run is."""
    more = f" --env {env_id}" if ":" in env_id else ""
    command = f"python -m {module_name('agents.train')} --resume {folder}{more}"
    print(f"stopped after {throws} throws; continue with: {command}", file=sys.stderr)


def compare(folder: Path, learned_from: int, cell: Env, asked: Mapping[str, Any], picks: int | None) -> None:
    """Analytic, virtual goal and learned on the same held-out seeds; also kept in the run folder."""
    if line_of(cell) is not None:
        shifts = SHIFTS if picks is None else picks
        with closing(make_vector(asked["env"], core_of(cell).config, NUM_ENVS, 1)) as env:
            write_json(folder / TABLE, lines.compare_shifts(folder, learned_from, env, shifts, TABLE_SEED))
        return
    picks = PICKS if picks is None else picks
    core, seed = core_of(cell), asked["seed"]
    # A virtual goal is for actions that shift what the throw is judged by.
    peers = {"analytic": 0} if core.correction is None else {"analytic": 0, "virtual_goal": PRACTICE}
    peers[asked["over"]] = 0
    learned = run_policy(runs.load_actor(folder), asked, cell, "the policy", f"learned ({asked['algo']})")
    entries = [(make_controller(name, cell), throws) for name, throws in peers.items()]
    rows: list[tuple[str, int, dict[str, Any]]] = []
    for controller, throws in [*entries, (learned, learned_from)]:
        controller.reset(seed)
        if controller is not learned:
            practise(controller, cell, throws, seed)
        rows.append((controller.name, throws, summary(held_out(controller, cell, picks, TABLE_SEED))))
    title = f"{picks} held-out throws each, level {core.config.name}; run folder {folder}"
    console().print(comparison_table(title, rows))
    write_json(folder / TABLE, [{"controller": n, "throws": t, **s} for n, t, s in rows])


if __name__ == "__main__":
    run(main, Arguments, "agents.train")
