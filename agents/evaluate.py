"""Judge one controller on held-out throws: `python -m agents.evaluate --controller analytic`."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from pnt_gym.cells.base.view import record_video
from pnt_gym.cells.line.config import LineConfig

from .controllers import Learner, load_state, make_controller, save_state
from .controllers.protocol import Controller
from .dispatchers.registry import line_controller, line_of, opened, the_line
from .dispatchers.release import releaser
from .ground.cli import UsageError, at_least, option, run
from .ground.environments import Env, make_vector, stream_seed
from .ground.outputs import VIDEOS, check_ending, check_writable, deliver, deliver_json, deliver_text
from .ground.tables import console, shifts_table, summary_table, throws_bar
from .judging.evaluation import NUM_ENVS, evaluate, usual_picks, usual_practice
from .judging.work_shifts import SHIFTS
from .judging.work_shifts import judged as shifts_judged
from .learning.trained import setting
from .pictures.film import SECONDS, decisions
from .pictures.gantt import gantt

OF_LINES = ("shifts", "release", "throws", "picture", "video")
OF_THROWS = ("picks", "practice", "online", "load", "save")
"""Options that only one kind of environment has a use for."""


@dataclass(frozen=True)
class Arguments:
    """Throw held-out objects with one controller and say what it is worth in picks per minute."""

    controller: Annotated[str, tyro.conf.arg(metavar="NAME|RUN_DIR|MODULE:CLASS|MODEL.zip")]
    """A controller (analytic, analytic_height, mean_lead, mean_shift, virtual_goal, newton_goal, ridge, mlp, oracle,
    random; of a line fifo, spt, value_rate, atc, price, pair, beam, price_beam, joint_beam, guided_beam, index, random,
    or a scorer's FILE.npz), the folder of a training run, a class of your own, or with --trust a stable-baselines3
    model or the folder of an RL-Zoo training."""
    trust: bool = False
    """Load a stable-baselines3 model or an RL-Zoo folder, which runs whatever code is in it. Run folders need no trust:
    they hold none."""
    env: Annotated[str | None, option("PnTConveyor-v0, or that of the run folder", "ID|MODULE:ID")] = None
    """Environment id; with MODULE:ID one that a module of yours registers."""
    level: Annotated[str | None, option("the environment's own, or that of the run folder", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    picks: Annotated[int | None, option("200; whole shifts on PnTAdapt-v0", "N")] = None
    """Throws to count."""
    shifts: Annotated[int | None, option(f"{SHIFTS}", "N")] = None
    """Shifts to count, of a line."""
    release: Annotated[str | None, option("analytic", "NAME|RUN_DIR")] = None
    """Who corrects the throws of a line that are simulated: a controller or a run folder of PnTRelease-v0."""
    throws: Annotated[Literal["table", "flight", "full"] | None, option("the level's own", "table|flight|full")] = None
    """What becomes of the throws of a line."""
    picture: Annotated[Path | None, option("none", "FILE.svg")] = None
    """Draw who took what in the first minute of a line's first shift."""
    video: Annotated[Path | None, option("none", "FILE.mp4")] = None
    """Film the first 12 s of a line's first shift; with --throws full the throws are those that are judged."""
    seed: int = 0
    """Names the objects; training and practice never see them, whatever their seed."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write all figures and every throw to this file."""
    num_envs: int = NUM_ENVS
    """Cells simulated side by side; part of what a seed means."""
    threads: int = 2
    """Threads that simulate; results do not depend on it."""
    practice: Annotated[int | None, option("120, or 0 with --load and for one that ships knowing", "N")] = None
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
    at_least(vars(arguments), picks=1, shifts=1, seed=0, num_envs=1, threads=1, practice=0)
    check_writable(arguments.json, arguments.save, arguments.picture, arguments.video)
    check_ending("video", arguments.video, VIDEOS)
    env_id, level, mode = setting(arguments.controller, arguments.env, arguments.level, arguments.action_mode)
    with closing(opened(env_id, level, arguments.num_envs, arguments.threads, mode, arguments.throws)) as env:
        if line_of(env) is not None:
            judge_line(env, env_id, arguments)
            return
        check_settings(arguments, OF_LINES, "goes with a line, such as PnTLine-v0")
        controller = make_controller(arguments.controller, env, trust=arguments.trust)
        controller.reset(arguments.seed)
        practice = prepare(controller, arguments)
        found = judge(controller, env, arguments, practice)
    if isinstance(controller, Learner) and arguments.save is not None:
        save_state(controller, arguments.save)
    title = f"{controller.name} on {env_id}, level {found['level']}, {found['picks']} throws, seed {arguments.seed}"
    title += f", after {found['practice']} practice throws" if found["practice"] else ""
    console().print(summary_table(title, found))
    if arguments.json is not None:
        deliver_json(arguments.json, found | {"env": env_id, "controller": arguments.controller})
        console().print(f"every throw is in {arguments.json}")


def judge_line(env: Env, env_id: str, arguments: Arguments) -> None:
    """Work shifts of a line, print the table, write the JSON."""
    check_settings(arguments, OF_THROWS, "goes with throws, and not with a line")
    controller = worker(env, arguments)
    shifts = SHIFTS if arguments.shifts is None else arguments.shifts
    with throws_bar() as bar:
        task = bar.add_task("shifts", total=shifts)
        found = shifts_judged(controller, env, shifts, arguments.seed, lambda count: bar.advance(task, count))
    if arguments.picture is not None:
        deliver_text(arguments.picture, gantt(found))
    console().print(shifts_table(f"{controller.name} on {env_id}, level {found['level']}, {shifts} shifts", found))
    if arguments.video is not None:
        film(env_id, the_line(env).config, arguments, arguments.video)
    if arguments.json is not None:
        told = {"env": env_id, "controller": arguments.controller, "release": arguments.release or "analytic"}
        deliver_json(arguments.json, told | found)
        console().print(f"every decision is in {arguments.json}")


def worker(env: Env, arguments: Arguments) -> Controller:
    """Who decides on a line, whose throws are corrected as asked for."""
    core = the_line(env)
    if arguments.release is not None:
        core.use(releaser(arguments.release, core))
    controller = line_controller(arguments.controller, core)
    controller.reset(arguments.seed)
    return controller


def film(env_id: str, level: LineConfig, arguments: Arguments, file: Path) -> None:
    """Work the begin of the first shift once more, on one line, and film it."""
    with closing(make_vector(env_id, level, 1, 1)) as env:
        shown = decisions(worker(env, arguments), env, stream_seed("evaluate", arguments.seed), SECONDS)
        deliver(file, lambda path: record_video(the_line(env).view(), shown, path))
    console().print(f"a film of its first shift is in {file}")


def check_settings(arguments: Arguments, names: Sequence[str], said: str) -> None:
    """Make sure that options that mean nothing here were not given.

    Raises:
        UsageError: one was.
    """
    for name in names:
        if getattr(arguments, name) not in (None, False):
            raise UsageError(f"--{name.replace('_', '-')} {said}")


def judge(controller: Controller, env: Env, arguments: Arguments, practice: int) -> dict[str, Any]:
    """Practise and evaluate with a bar for each."""
    picks = usual_picks(env) if arguments.picks is None else arguments.picks
    seed, online = arguments.seed, arguments.online
    with throws_bar() as bar:
        totals = {"practice": practice, "evaluation": picks}
        tasks = {name: bar.add_task(name, total=total) for name, total in totals.items() if total}

        def show(name: str, throws: int) -> None:
            bar.advance(tasks[name], throws)

        return evaluate(controller, env, picks, seed, practice=practice, online=online, progress=show)


def prepare(controller: Controller, arguments: Arguments) -> int:
    """Load what a learning controller knows; returns the throws it is to practise."""
    if isinstance(controller, Learner):
        if arguments.load is None:
            return usual_practice(controller) if arguments.practice is None else arguments.practice
        load_state(controller, arguments.load)
        return arguments.practice or 0
    for name in ("load", "save"):
        if getattr(arguments, name) is not None:
            raise UsageError(f"--{name}: controller {controller.name!r} learns nothing that could be kept")
    return 0


if __name__ == "__main__":
    run(main, Arguments, "agents.evaluate")
