"""Watch a controller throw: `python -m agents.play --controller analytic --video throws.mp4`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
import tyro

from agents.cli import UsageError, at_least, option, run
from agents.controllers import make_controller
from agents.environments import make_vector, stream_seed
from agents.evaluation import PRACTICE, Throws, practise, thrown
from agents.files import check_writable
from agents.tables import console
from pnt_gym.render import View, record_video

RATE: Final = 60
"""Frames per second among which a picture is chosen."""


@dataclass(frozen=True)
class Arguments:
    """Film a controller's throws, at true rate or slower, or show them in a window.

    Blue dots are the planned flight, orange dots the flown one.
    """

    controller: Annotated[str, tyro.conf.arg(metavar="NAME|RUN_DIR")] = "analytic"
    """A controller's name or the folder of a training run."""
    env: str = "PnTConveyor-v0"
    """Environment id."""
    level: str = "nominal"
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
    at_least("picks", arguments.picks, 1)
    at_least("seed", arguments.seed, 0)
    at_least("slow", arguments.slow, 1)
    if not 0.0 <= arguments.at < np.inf:
        raise UsageError(f"--at is {arguments.at} s; it must be finite and not negative")
    wanted = [w for w in (arguments.video, arguments.picture, arguments.viewer) if w is not None]
    if len(wanted) != 1:
        raise UsageError("give one of --video FILE.mp4, --picture FILE.png and --viewer native")
    for path in (arguments.video, arguments.picture):
        if path is not None:
            check_writable(path)
    env = make_vector(arguments.env, arguments.level, num_envs=1, threads=1)
    try:
        controller = make_controller(arguments.controller, env)
        controller.reset(arguments.seed)
        practise(controller, env, PRACTICE, arguments.seed)
        seed = stream_seed("evaluate", arguments.seed)
        show(arguments, env, thrown(controller, env, arguments.picks, seed))
    finally:
        env.close()


def show(arguments: Arguments, env: Any, throw: Iterator[Throws]) -> None:
    """Carry the throws out into a video, a picture or a window."""
    view = env.unwrapped.core.view()
    if arguments.video is not None:
        path = record_video(view, throw, arguments.video, slow=arguments.slow)
        console().print(f"video of {arguments.picks} throws in {path}")
        return
    try:
        if arguments.picture is not None:
            next(throw)
            save_picture(view, arguments.picture, arguments.at)
        else:
            for _ in throw:
                view.show()
    finally:
        view.close()


def save_picture(view: View, path: Path, moment: float) -> None:
    """The last throw at a moment [s]; at its end if that is later."""
    from PIL import Image  # noqa: PLC0415 - only pictures need it

    frames = view.last_throw(RATE)
    Image.fromarray(frames[min(len(frames) - 1, round(RATE * moment))]).save(path)
    console().print(f"picture of a throw in {path}")


if __name__ == "__main__":
    run(main, Arguments, "agents.play")
