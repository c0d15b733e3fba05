"""Throws of a line in the full physics, at random or as a controller chooses, and the table of their chances."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from pnt_gym.cells.conveyor.cup.hold import fail_chance
from pnt_gym.cells.line.cell import Decisions, LineCell
from pnt_gym.cells.line.chances import format_table, shipped_table
from pnt_gym.cells.line.config import MADE_TABLES, LineConfig
from pnt_gym.cells.line.throws import SimulatedThrows
from pnt_gym.reading import MOST_NUMBERS, bytes_of

from ..controllers import NAMES
from ..dispatchers import registry
from ..dispatchers.decisions import make_release, work_shifts
from ..dispatchers.registry import ENV, line_core
from ..ground import shipped
from ..ground.cli import UsageError
from ..ground.environments import make_vector, stream_seed
from ..ground.outputs import deliver_text
from ..ground.tables import throws_bar
from ..ground.versions import versions
from ..judging import losses
from ..judging.losses import ENTRY, Counted
from ..learning.runs import POLICY
from .counting import counting_line, tabulate

NUM_ENVS: Final = 32
FEW_ENVS: Final = 4
"""Lines side by side whose throws a controller chooses: few, so that not all throws are of the begin of a shift."""
MOST_EMPTY: Final = 200
"""Number of consecutive shifts without a throw that ends the calibration. If one shift in ten had throws, so many
shifts without any would come once in a billion times."""


def place(config: LineConfig, release: str | None, folder: Path = MADE_TABLES, controller: str | None = None) -> Path:
    """File of a line's table that a command makes.

    Args:
        config: the line.
        release: what corrects the throws; None for nothing.
        folder: folder of the tables.
        controller: what chooses the throws; None for random choices, which are the same for all lines of such cells.
    """
    place = config.made_table(folder)
    parts = [place.stem, *([] if release is None else [_name(release)])]
    if controller is not None:
        line = config.model_dump_json(exclude={"name", "chances", "throws"})
        parts += [controller, hashlib.sha256(line.encode()).hexdigest()[:8]]
    return place.with_stem("-".join(parts))


def _name(release: str) -> str:
    """Name of a release for files; a policy's file may change under its name, so its digest belongs to the name."""
    text = re.sub(r"[^A-Za-z0-9]+", "-", release).strip("-")[-60:]
    if release in NAMES:
        return text
    file = shipped.place(release) / POLICY
    return f"{text}-{hashlib.sha256(bytes_of(file, MOST_NUMBERS)).hexdigest()[:8]}" if file.is_file() else text


def with_table(
    config: LineConfig,
    release: str | None,
    folder: Path,
    throws: int,
    seed: int,
    threads: int,
    controller: str | None = None,
) -> tuple[LineConfig, Counted | None]:
    """The line with its table of chances for a release, and what became of the throws that were counted.

    A missing table is made in `folder`. A shipped table says nothing of failures and energy, so throws are counted
    there for these figures, while the shipped chances hold. With a controller, throws are counted once more as the
    controller chooses them by the first table.
    """
    file = place(config, release, folder)
    if not file.is_file():
        calibrate(config, file, throws, seed, threads=threads, release=release)
    with_chances = LineConfig.load(config, chances=str(file))
    ships = release is None and shipped_table(config).is_file()
    if controller is not None:
        file = place(config, release, folder, controller)
        if not file.is_file():
            line = config if ships else with_chances
            calibrate(line, file, throws, seed, threads=threads, release=release, controller=controller)
        with_chances = LineConfig.load(config, chances=str(file))
    counted = losses.read(with_chances)
    return (config if ships and controller is None else with_chances), counted


def calibrate(
    config: LineConfig,
    place: Path,
    throws: int,
    seed: int,
    num_envs: int = NUM_ENVS,
    threads: int = 2,
    release: str | None = None,
    controller: str | None = None,
) -> str:
    """Make the table of a line and write it to a file; a summary in one sentence.

    Throws are those of the counting line, at random, or those that a controller chooses on the line itself by the
    chances that the line has before.
    """
    if controller is None:
        line = counting_line(config, config.finest)
        batches = list(random_throws(line, throws, seed, num_envs, threads, release))
    else:
        batches = list(chosen_throws(config.simulated(), controller, throws, seed, threads, release))
    columns = {name: np.concatenate([part[name] for part in batches]) for name in batches[0]}
    head = {"digest": config.digest(), "throws": len(columns["kind"]), "seed": seed, "versions": versions()}
    head |= {} if release is None else {"release": release}
    head |= {} if controller is None else {"controller": controller}
    chances, counted = tabulate(config, columns)
    text = format_table(chances, **head, items=list(config.cell.items), **{ENTRY: counted.as_json()})
    deliver_text(place, text)
    success, sealed = columns["hits"].sum() / columns["picked"].sum(), np.sort(chances.picked)
    return (
        f"{len(columns['kind'])} throws: {success:.1%} of the held objects ended in their bins, and the cup seals on "
        f"{sealed[0]:.0%} to {sealed[-1]:.0%} of the picks of an item; the table is in {place}"
    )


def random_throws(
    config: LineConfig,
    throws: float,
    seed: int,
    num_envs: int,
    threads: int,
    release: str | None = None,
    quiet: bool = False,
) -> Iterator[dict[str, Any]]:
    """Columns of throws of robots that choose at random, batch by batch; `quiet` shows no progress, for any number.

    Raises:
        UsageError: no robot throws in `MOST_EMPTY` consecutive shifts.
    """
    first = stream_seed("practice", seed)
    cell, generator = LineCell(config, num_envs, threads), np.random.default_rng(first)
    if release is not None and isinstance(cell.throws, SimulatedThrows):
        cell.throws.release = make_release(release, config)
    cell.reset(np.arange(num_envs), [np.random.default_rng(first + row) for row in range(num_envs)])
    with throws_bar(quiet=quiet) as bar:
        task = bar.add_task("throws", total=throws)
        count = empty = 0
        while count < throws:
            real = cell.state.choices["real"]
            attempts = cell.take(np.where(real, generator.random(real.shape), -1.0).argmax(axis=1))
            yield _columns(attempts, config)
            throws_now, over = int(attempts.valid.sum()), np.flatnonzero(cell.over)
            count += throws_now
            bar.advance(task, throws_now)
            empty = empty + over.size if throws_now == 0 else 0
            if empty >= MOST_EMPTY:
                raise UsageError(_text(config, empty))
            if over.size > 0:
                cell.reset(over, [cell.generators[row] for row in over])


def chosen_throws(
    config: LineConfig, controller: str, throws: int, seed: int, threads: int, release: str | None = None
) -> Iterator[dict[str, Any]]:
    """Columns of the throws that a controller chooses in whole shifts, batch by batch.

    Raises:
        UsageError: no robot throws in `MOST_EMPTY` consecutive shifts.
    """
    with closing(make_vector(ENV, config, FEW_ENVS, threads)) as env, throws_bar() as bar:
        core, task = line_core(env), bar.add_task("throws", total=throws)
        if release is not None:
            core.use(make_release(release, config))
        act, count, empty = registry.make(controller, core).act, 0, 0
        for step in work_shifts(act, env, stream_seed("practice", seed), throws + MOST_EMPTY):
            assert core.last is not None
            yield _columns(core.last, config)
            throws_now = int(core.last.valid.sum())
            count, empty = count + throws_now, empty + int(step.over.sum()) if throws_now == 0 else 0
            bar.advance(task, throws_now)
            if count >= throws:
                return
            if empty >= MOST_EMPTY:
                raise UsageError(_text(config, empty))


def _text(config: LineConfig, shifts: int) -> str:
    return (
        f"level {config.name!r}: no robot threw an object in {shifts} shifts of {config.duration:g} s; arrivals.rate "
        f"is {config.arrivals.rate:g} objects a second, or {config.arrivals.rate * config.duration:.3g} objects a shift"
    )


def _columns(attempts: Decisions, config: LineConfig) -> dict[str, Any]:
    """Columns of the table's counts, for the valid attempts of one batch."""
    objects, outcomes = attempts.context.objects, attempts.results
    columns = {
        "kind": objects.kind,
        "percent": objects.percent,
        "distance": attempts.context.distance,
        "hits": outcomes["is_success"],
        "picked": outcomes["picked"],
        "fails": fail_chance(attempts.context, config.cell),
        **{name: outcomes[name] for name in ("lost", "ended_in", "energy", "miss")},
    }
    return {name: values[attempts.valid] for name, values in columns.items()}
