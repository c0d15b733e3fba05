"""Make a line's table of success chances in the full physics: `python -m agents.line calibrate --level skills3`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from pnt_gym.cells.line.config import LineConfig

from ..ground import levels
from ..ground.cli import at_least, option
from ..ground.outputs import check_writable
from ..ground.tables import console
from . import thrown
from .thrown import NUM_ENVS, calibrate


@dataclass(frozen=True)
class Arguments:
    """Throw the objects of a line at random, and count the successes by item, speed setting and distance."""

    level: Annotated[str, tyro.conf.arg(metavar="NAME|FILE.yaml")] = "single"
    """A shipped level's name or a YAML file."""
    throws: int = 5000
    """Throws to count."""
    seed: int = 0
    """Seed of the objects."""
    out: Annotated[Path | None, option("runs/chances/, where other commands find the table", "FILE.json")] = None
    """File of the table; a level names a file in another place as `chances`."""
    release: Annotated[str | None, option("analytic", "NAME|shipped:NAME|RUN_DIR")] = None
    """Controller that corrects the throws: a controller or a policy of PnTRelease-v0."""
    num_envs: int = NUM_ENVS
    """Lines simulated side by side; the objects depend on the seed and on this number."""
    threads: int = 2
    """Threads of the simulation; results do not depend on this number."""


def main(arguments: Arguments) -> None:
    """Simulate the throws, count successes, write the table."""
    at_least(vars(arguments), throws=100, seed=0, num_envs=1, threads=1)
    config = LineConfig.load(arguments.level, chances=None).simulated()
    place = thrown.place(config, arguments.release) if arguments.out is None else arguments.out
    check_writable(place)
    numbers = arguments.throws, arguments.seed, arguments.num_envs, arguments.threads
    levels.show(config)
    console().print(calibrate(config, place, *numbers, release=arguments.release))
