"""Watch a controller throw: `python -m agents.play --controller analytic --video throws.mp4`."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import tyro

from pnt_gym.cells.line.config import LineConfig

from .ground.cli import UsageError, at_least, check_effects, check_libraries, option, run
from .ground.environments import config_of
from .ground.outputs import PICTURES, VIDEOS, check_drawing, check_ending, check_writable
from .ground.tables import console
from .learning import trained
from .pictures import studio
from .pictures.door import LOOPBACK
from .pictures.stage import Stage

VIEWER = (
    "Show the throws live, with their figures, until the viewer is closed. Level and controller can be changed in the "
    "viewer. native opens a window; web serves a page for browsers of this machine, also without a display. A line is "
    "shown by web alone, with the extra `design`."
)
ADDRESS = (
    "Address of this machine at which --viewer web serves its page, such as 0.0.0.0 for all of them. Everyone who "
    "reaches this address and the page's port sees and steers the viewer: there is no password and no encryption."
)


@dataclass(frozen=True)
class Arguments:
    """Film a controller's throws, in real time or slower, or show the throws in a window.

    Blue dots are the planned flight, orange dots the simulated flight, green is the target. Where a camera sees the
    objects, its colours, its depths and the controller's map of places stand at the right, with red rings around the
    chosen place, and white rings around a place that failed before.
    """

    controller: Annotated[str, tyro.conf.arg(metavar="NAME|shipped:NAME|RUN_DIR|MODULE:CLASS|MODEL.zip")] = "analytic"
    """A controller's name, a shipped policy, a run folder, a class of your own, or with --trust another's model."""
    trust: bool = False
    """Load a stable-baselines3 model or an RL-Zoo folder, whose code then runs; run folders hold no code."""
    env: Annotated[str | None, option("PnTConveyor-v0, or that of the run folder", "ID|MODULE:ID")] = None
    """Environment id; MODULE:ID imports a module of yours first, which registers the id."""
    level: Annotated[str | None, option("the environment's own, or that of the run folder", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    video: Annotated[Path | None, option("none", "FILE.mp4")] = None
    """Write a video to this file."""
    picture: Annotated[Path | None, option("none", "FILE.png")] = None
    """Write one picture of the first throw in flight to this file."""
    log: Annotated[Path | None, option("none", "FILE.csv")] = None
    """Write a log of the filmed throws, as a real cell would measure them, for `pnt-gym fit`."""
    viewer: Annotated[Literal["native", "web"] | None, option("none", "native|web", VIEWER)] = None
    address: Annotated[str | None, option(f"{LOOPBACK}, which only this machine reaches", "IP", ADDRESS)] = None
    throws: Annotated[Literal["table", "flight", "full"] | None, option("the level's own", "table|flight|full")] = None
    """How throws of a line are computed: by its table of chances, with flights simulated, or in the full physics."""
    picks: Annotated[int | None, option("5; on a line those of 12 s", "N")] = None
    """Throws of a video, or decisions of a line."""
    at: float = 0.4
    """Moment of the picture [s], from the first motion of the throw or from the beginning of a line's shift."""
    slow: int = 1
    """Factor by which the video is slower than real time."""
    seed: int = 0
    """Seed of the objects."""


def main(arguments: Arguments) -> None:
    """Film, draw or show the controller's throws."""
    at_least(vars(arguments), picks=1, seed=0, slow=1)
    if not 0.0 <= arguments.at < np.inf:
        raise UsageError(f"--at is {arguments.at} s; it must be finite and not negative")
    outputs = [w for w in (arguments.video, arguments.picture, arguments.viewer) if w is not None]
    if len(outputs) != 1:
        raise UsageError("give one of --video FILE.mp4, --picture FILE.png and --viewer native|web")
    check_writable(arguments.video, arguments.picture, arguments.log)
    check_ending("video", arguments.video, VIDEOS)
    check_ending("picture", arguments.picture, PICTURES)
    check_effects(arguments, {"picks": "video", "slow": "video", "log": "video", "at": "picture"})
    if arguments.address is not None and arguments.viewer != "web":
        raise UsageError("--address goes with --viewer web, and has no effect here")
    check_drawing(film=arguments.video)
    if arguments.picture is not None:
        check_libraries("PIL")
    if arguments.viewer is not None:
        _show(arguments)
        return
    with closing(open_stage(arguments, arguments.controller, arguments.level)) as stage:
        if arguments.video is not None:
            stage.film(arguments.video, arguments.picks, arguments.slow, arguments.log)
            for output, file in (("log", arguments.log), ("video", arguments.video)):
                if file is not None:
                    console().print(f"{output} in {file}")
        elif arguments.picture is not None:
            stage.draw(arguments.picture, arguments.at)
            console().print(f"picture of a throw in {arguments.picture}")


def _show(arguments: Arguments) -> None:
    """Show the controller at work until the viewer is closed."""
    env, level, _ = trained.resolve(arguments.controller, arguments.env, arguments.level, None)
    if isinstance(config_of(env, level), LineConfig):
        _watch_line(arguments)
        return
    address = (arguments.address or LOOPBACK) if arguments.viewer == "web" else None
    studio.show(address, arguments.controller, arguments.env, arguments.level, partial(open_stage, arguments))


def _watch_line(arguments: Arguments) -> None:
    """Show a line at work in a browser.

    Raises:
        UsageError: a window is asked for.
    """
    if arguments.viewer == "native":
        raise UsageError("--viewer native shows a single robot; --viewer web shows a line")
    check_libraries("viser")
    from .design import watch  # noqa: PLC0415 - needs the extra `design`

    stage = partial(open_stage, arguments, arguments.controller, arguments.level)
    watch.show(arguments.address or LOOPBACK, arguments.controller, stage)


def open_stage(arguments: Arguments, controller: str, level: str | None) -> Stage:
    """The stage for a controller and a level, either of which a viewer may have changed."""
    return Stage(controller, arguments.env, level, arguments.seed, trust=arguments.trust, throws=arguments.throws)


if __name__ == "__main__":
    run(main, Arguments, "agents.play")
