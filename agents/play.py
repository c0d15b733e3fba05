"""Watch a controller throw: `python -m agents.play --controller analytic --video throws.mp4`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Final, Literal

import numpy as np
import tyro

from pnt_gym.cells.base.view import View, record_video

from .cli import UsageError, at_least, option, run
from .controllers import make_controller
from .environments import core_of, make_vector, stream_seed
from .evaluation import PRACTICE, practise, thrown
from .files import check_writable
from .tables import console
from .throws import Throws
from .trained import setting

RATE: Final = 60
"""Frames per second among which a picture is chosen."""


@dataclass(frozen=True)
class Arguments:
    """Film a controller's throws, at true rate or slower, or show them in a window.

    Blue dots are the planned flight, orange dots the flown one.
    """

    controller: Annotated[str, tyro.conf.arg(metavar="NAME|RUN_DIR|MODULE:CLASS|MODEL.zip")] = "analytic"
    """A controller's name, the folder of a training run, a class of your own, or with --trust a model of others."""
    trust: bool = False
    """Load a stable-baselines3 model or an RL-Zoo folder, which runs whatever code is in it. Run folders need no trust:
    they hold none."""
    env: Annotated[str | None, option("PnTConveyor-v0, or that of the run folder", "ID|MODULE:ID")] = None
    """Environment id; with MODULE:ID one that a module of yours registers."""
    level: Annotated[str | None, option("the environment's own, or that of the run folder", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    video: Annotated[Path | None, option("none", "FILE.mp4")] = None
    """Write a video here."""
    picture: Annotated[Path | None, option("none", "FILE.png")] = None
    """Write one picture of the first throw in flight here."""
    viewer: Annotated[Literal["native"] | None, option("none", "native")] = None
    """Show the throws in MuJoCo's window; needs a display."""
    picks: int = 5
    """Throws to show."""
    at: float = 0.4
    """Moment of the picture, after the throw's first motion [s]."""
    slow: int = 1
    """How many times slower than in truth the video runs."""
    seed: int = 0
    """Names the objects."""


def main(arguments: Arguments) -> None:
    """Throw, and film or show it."""
    at_least(vars(arguments), picks=1, seed=0, slow=1)
    if not 0.0 <= arguments.at < np.inf:
        raise UsageError(f"--at is {arguments.at} s; it must be finite and not negative")
    wanted = [w for w in (arguments.video, arguments.picture, arguments.viewer) if w is not None]
    if len(wanted) != 1:
        raise UsageError("give one of --video FILE.mp4, --picture FILE.png and --viewer native")
    check_writable(arguments.video, arguments.picture)
    env_id, level, mode = setting(arguments.controller, arguments.env, arguments.level, None)
    with closing(make_vector(env_id, level, num_envs=1, threads=1, action_mode=mode)) as env:
        controller = make_controller(arguments.controller, env, trust=arguments.trust)
        controller.reset(arguments.seed)
        practise(controller, env, PRACTICE, arguments.seed)
        seed = stream_seed("evaluate", arguments.seed)
        show(arguments, core_of(env).view(), thrown(controller, env, arguments.picks, seed))


def show(arguments: Arguments, view: View, throw: Iterator[Throws]) -> None:
    """Carry the throws out into a video, a picture or a window."""
    if arguments.video is not None:
        path = record_video(view, throw, arguments.video, slow=arguments.slow)
        console().print(f"video of {arguments.picks} throws in {path}")
        return
    with closing(view):
        if arguments.picture is not None:
            next(throw)
            save_picture(view, arguments.picture, arguments.at)
        else:
            for _ in throw:
                view.show()


def save_picture(view: View, path: Path, moment: float) -> None:
    """The last throw at a moment [s]; at its end if that is later."""
    from PIL import Image  # noqa: PLC0415 - only pictures need it

    Image.fromarray(view.at(moment, RATE)).save(path)
    console().print(f"picture of a throw in {path}")


if __name__ == "__main__":
    run(main, Arguments, "agents.play")
