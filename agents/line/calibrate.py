"""Make a line's table of success chances in the full physics: `python -m agents.line calibrate --level skills3`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from pnt_gym.cells.line.cell import Decisions, LineCell
from pnt_gym.cells.line.chances import Chances, digest, format_table, made_table
from pnt_gym.cells.line.config import LineConfig

from ..ground.cli import UsageError, at_least, option
from ..ground.environments import stream_seed
from ..ground.outputs import check_writable, deliver_text
from ..ground.starters import show_assumed
from ..ground.tables import console, throws_bar
from ..ground.versions import versions

NUM_ENVS = 32
MOST_EMPTY = 200
"""Number of consecutive shifts without a throw that ends the calibration. If one shift in ten had throws, so many
shifts without any would come once in a billion times."""


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
    num_envs: int = NUM_ENVS
    """Lines simulated side by side; the objects depend on the seed and on this number."""
    threads: int = 2
    """Threads of the simulation; results do not depend on this number."""


def main(arguments: Arguments) -> None:
    """Simulate the throws, count successes, write the table."""
    at_least(vars(arguments), throws=100, seed=0, num_envs=1, threads=1)
    config = LineConfig.load(arguments.level, throws="full", chances=None)
    place = made_table(config) if arguments.out is None else arguments.out
    check_writable(place)
    numbers = arguments.throws, arguments.seed, arguments.num_envs, arguments.threads
    show_assumed(config)
    console().print(calibrate(config, place, *numbers))


def calibrate(
    config: LineConfig, place: Path, throws: int, seed: int, num_envs: int = NUM_ENVS, threads: int = 2
) -> str:
    """Make the table of a line and write it to a file; a summary in one sentence."""
    batches = list(random_throws(LineConfig.load(config, throws="full", chances=None), throws, seed, num_envs, threads))
    columns = {name: np.concatenate([part[name] for part in batches]) for name in batches[0]}
    head = {"digest": digest(config), "throws": len(columns["kind"]), "seed": seed, "versions": versions()}
    deliver_text(
        place, format_table(Chances.from_throws(config.cell, **columns), **head, items=list(config.cell.items))
    )
    success_share = columns["hits"].sum() / columns["picked"].sum()
    return (
        f"{len(columns['kind'])} throws: {columns['picked'].mean():.1%} of the picks succeeded, and "
        f"{success_share:.1%} of the picked objects ended in their bins; the table is in {place}"
    )


def random_throws(config: LineConfig, throws: int, seed: int, num_envs: int, threads: int) -> Iterator[dict[str, Any]]:
    """Columns of the throws of robots that choose at random, batch by batch.

    Raises:
        UsageError: no robot throws in `MOST_EMPTY` consecutive shifts.
    """
    first = stream_seed("practice", seed)
    cell, generator = LineCell(config, num_envs, threads), np.random.default_rng(first)
    cell.reset(np.arange(num_envs), [np.random.default_rng(first + row) for row in range(num_envs)])
    with throws_bar() as bar:
        task = bar.add_task("throws", total=throws)
        count = empty = 0
        while count < throws:
            real = cell.state.choices.real
            attempts = cell.take(np.where(real, generator.random(real.shape), -1.0).argmax(axis=1))
            yield _table_columns(attempts)
            throws_now, over = int(attempts.valid.sum()), np.flatnonzero(cell.over)
            count += throws_now
            bar.advance(task, throws_now)
            empty = empty + over.size if throws_now == 0 else 0
            if empty >= MOST_EMPTY:
                raise UsageError(_no_throw_text(config, empty))
            if over.size > 0:
                cell.reset(over, [cell.generators[row] for row in over])


def _no_throw_text(config: LineConfig, shifts: int) -> str:
    return (
        f"level {config.name!r}: no robot threw an object in {shifts} shifts of {config.duration:g} s; arrivals.rate "
        f"is {config.arrivals.rate:g} objects a second, or {config.arrivals.rate * config.duration:.3g} objects a shift"
    )


def _table_columns(attempts: Decisions) -> dict[str, Any]:
    """Columns of the table's counts, for the valid attempts of one batch."""
    objects, outcomes = attempts.context.objects, attempts.results
    columns = {
        "kind": objects.kind,
        "percent": objects.percent,
        "distance": attempts.context.distance,
        "hits": outcomes.is_success,
        "picked": outcomes.picked,
    }
    return {name: values[attempts.valid] for name, values in columns.items()}
