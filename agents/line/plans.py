"""Plans of a line, and what each brings: recovery, causes, energy and money, from simulated work shifts."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.config import MADE_TABLES, LineConfig
from pnt_gym.cells.line.sections import Down, Robot
from pnt_gym.errors import ConfigError
from pnt_gym.names import unknown_name

from ..dispatchers import registry
from ..dispatchers.decisions import make_release
from ..dispatchers.registry import ENV, line_core
from ..ground import metrics
from ..ground.cli import UsageError
from ..ground.environments import make_vector, stream_seed
from ..ground.metrics import Interval
from ..ground.tables import throws_bar
from ..judging import losses
from ..judging.losses import FATES, Counted, Fates
from ..judging.shifts import Shifts, run_shifts
from .counting import with_chances
from .flown import fly
from .thrown import with_table

A_PLAN: Final = ", a plan"
"""End of the name of a plan's line."""


@dataclass(frozen=True)
class Sweep:
    """Values that plans combine; None stands for the value of the level."""

    robots: tuple[int, ...] = (1, 2, 3, 4)
    speeds: tuple[float, ...] | None = None
    percents: tuple[float, ...] | None = None
    skills: tuple[Literal["level", "all"], ...] = ("level",)
    minutes: float = 2.0
    burst: float | None = None
    down: str | None = None


def make_plans(level: LineConfig, sweep: Sweep) -> Iterator[tuple[dict[str, Any], LineConfig]]:
    """Numbers and level of every plan.

    Raises:
        UsageError: no plan has the robot of `--down`, or the values of a plan describe no line.
    """
    speeds = sweep.speeds or (level.cell.belt.speed,)
    percents = sweep.percents or (None,)
    down = standstill(level, sweep)
    for count, speed, limit, skills in itertools.product(sweep.robots, speeds, percents, sweep.skills):
        changes = level.model_dump(mode="json", exclude_unset=True)
        changes |= {"name": f"{level.name.removesuffix(A_PLAN)}{A_PLAN}", "duration": 60.0 * sweep.minutes}
        overrides = {} if skills == "level" else {"skills": []}
        changes["robots"] = [{**robot.model_dump(mode="json"), **overrides} for robot in line_up(level, count)]
        cell = changes["cell"]
        cell["belt"] = {**cell.get("belt", {}), "speed": speed}
        if limit is not None:
            cell["limits"] = {"percent": [limit]}
        if sweep.burst is not None:
            changes["arrivals"] = {**changes.get("arrivals", {}), "regularity": sweep.burst}
        given = {"robots": count, "speeds": speed, "percents": limit, "minutes": sweep.minutes, "burst": sweep.burst}
        try:
            config = LineConfig.load({"base": "nominal", **changes})
        except ConfigError as error:
            words = " ".join(f"--{name} {value:g}" for name, value in given.items() if value is not None)
            raise UsageError(f"plan {words}: {str(error).removeprefix('config: ')}") from None
        numbers = {"robots": count, "belt_speed": speed, "percent": max(config.cell.limits.percent), "skills": skills}
        yield numbers, with_standstill(config, down)


def line_up(level: LineConfig, count: int) -> list[Robot]:
    """The first `count` robots of the level; further robots copy its last robot, at the distance of its first two."""
    robots = list(level.robots[:count])
    low, high = level.cell.belt.pick_x
    step = robots[1].x - robots[0].x if len(robots) > 1 else 2.0 * (high - low)
    for index in range(len(robots), count):
        last = robots[-1]
        robots.append(last.model_copy(update={"name": f"{level.robots[-1].name}_{index + 1}", "x": last.x + step}))
    return robots


def standstill(level: LineConfig, sweep: Sweep) -> dict[str, Any] | None:
    """The standstill of `--down`; None without one.

    The robot is given by its name, or counted from 1 upstream, unless a robot has the number as its name.

    Raises:
        UsageError: the option has another form, or no plan has the robot.
    """
    if sweep.down is None:
        return None
    name, _, text = sweep.down.rpartition(":")
    names = [robot.name for robot in line_up(level, max(sweep.robots))]
    try:
        minutes = float(text)
    except ValueError:
        minutes = -1.0
    if not name or not 0.0 < minutes < float("inf"):
        raise UsageError(f"--down is {sweep.down!r}; it must be ROBOT:MINUTES with minutes above 0, as {names[0]}:0.5")
    start = 30.0 * sweep.minutes
    down = Down(robot=name, start=start, end=start + 60.0 * minutes)
    place = down.place(names)
    if place is None:
        numbers = f", or a number from 1 to {len(names)}"
        raise UsageError(f"--down: {unknown_name('robot', name, names, numbers)}")
    return down.model_dump() | {"robot": names[place]}


def with_standstill(config: LineConfig, down: dict[str, Any] | None) -> LineConfig:
    """The line with a standstill, if the line has the robot."""
    has_robot = down is not None and down["robot"] in [robot.name for robot in config.robots]
    return LineConfig.load(config, down=[down]) if has_robot else config


@dataclass(frozen=True)
class Conditions:
    """How plans are judged."""

    controller: str = "price"
    shifts: int = 16
    seed: int = 0
    throws: int = 1000
    """Throws to count for a table that does not exist yet."""
    fidelity: Literal["flight", "full"] = "full"
    """Whether tables are counted in simulated flights, in memory, or in the full physics."""
    tables: Path = MADE_TABLES
    """Folder of such tables."""
    check: int = 4
    """Shifts that a chosen plan works in the full physics as well."""
    mend: bool = True
    """Whether changes are tried that could mend the chosen plan."""
    sensitivity: bool = False
    """Whether each assumed number is tried at both ends of its range, on the chosen plan."""
    threads: int = 2
    quiet: bool = False
    """Whether shifts show no progress."""


@dataclass(frozen=True)
class Planned:
    """A judged plan."""

    config: LineConfig
    """The line with its table of chances."""
    counted: Counted | None
    """What became of the throws behind the table."""
    row: dict[str, Any]
    """Figures by the names of the JSON contract."""
    recovery: Floats
    """Recovery of each shift (S,)."""

    def shares(self, item: int) -> dict[str, float]:
        """Shares of the fates of an item's objects."""
        return self.row["fates_by_item"][self.config.cell.items[item]]

    def thrown_badly(self, item: int) -> float:
        """Share of the thrown objects of an item that do not end in their bin; 0 where none was thrown."""
        shares = self.shares(item)
        bad = shares["misplaced"] + shares["missed"] + shares["lost"]
        return bad / (bad + shares["sorted"]) if bad > 0.0 else 0.0

    @property
    def numbers(self) -> dict[str, Any]:
        """What tells this plan from others of the same level."""
        return {name: self.row[name] for name in ("robots", "belt_speed", "percent", "skills")}


def judge(
    numbers: dict[str, Any],
    config: LineConfig,
    conditions: Conditions,
    release: str | None = None,
    recount: bool = False,
) -> Planned:
    """Work the shifts of a plan, with throws by the table of a release.

    Args:
        numbers: what tells the plan from others.
        config: the line.
        conditions: how plans are judged.
        release: what corrects the throws; None for nothing.
        recount: whether the table counts throws as the plan's own controller chooses them, and not random ones.
    """
    if conditions.fidelity == "flight":
        flown = fly(config, conditions.throws, conditions.seed, conditions.threads, release)
        line = with_chances(config, flown.digest, flown.chances)
        return assess({**numbers, "chances_by": "random"}, line, flown.counted, conditions)
    chooser = conditions.controller if recount else None
    line, counted = with_table(
        config, release, conditions.tables, conditions.throws, conditions.seed, conditions.threads, chooser
    )
    return assess({**numbers, "chances_by": chooser or "random"}, line, counted, conditions)


def assess(numbers: dict[str, Any], line: LineConfig, counted: Counted | None, conditions: Conditions) -> Planned:
    """Work the shifts of a line that has a table of chances.

    Args:
        numbers: what tells the plan from others, and how the table was counted.
        line: the line with its table.
        counted: what became of the throws behind the table; None if nobody knows.
        conditions: how plans are judged.

    Raises:
        UsageError: no object came.
    """
    shifts = work(line, conditions)
    shares = shifts.figures["shift_recovery"].astype(np.float64)
    if not np.isfinite(shares).any():
        raise UsageError(
            f"no objects: none reached the end of level {line.name!r} in {conditions.shifts} shifts of "
            f"{line.duration:g} s; arrivals.rate is {line.arrivals.rate:g} objects a second"
        )
    fates = Fates.of(shifts, line, counted)
    # A shipped table is larger than the one whose throws say what became of them.
    spread = 0.0 if counted is None or line.chances is None else table_spread(shifts, fates, counted)
    recovery = widen(metrics.interval(shares[np.isfinite(shares)]), spread)
    by_item = zip(line.cell.items, np.nan_to_num(fates.shares_by_item()).tolist(), strict=True)
    figures = {
        "recovery": recovery.value,
        "recovery_counts": spread,
        "recovery_low": recovery.low,
        "recovery_high": recovery.high,
        **_pace(shifts, spread),
        **with_interval("value_per_min", shifts.value),
        **with_interval("purity", shifts.figures["shift_purity"]),
        "utilisation": shifts.figures["shift_utilisation"].mean(axis=0).tolist(),
        "fates": fates.shares(),
        "fates_by_item": {item: dict(zip(FATES, shares, strict=True)) for item, shares in by_item},
        "arrived": fates.arrived.tolist(),
        **losses.energy(shifts, counted),
        **_money(shifts, line, counted, spread / max(recovery.value, 1e-9)),
    }
    return Planned(line, counted, {**numbers, **figures}, shares)


def with_interval(name: str, values: Floats) -> dict[str, float | None]:
    """A figure's mean over shifts and its interval, by names; shifts without the figure do not count."""
    known = values[np.isfinite(values)]
    return _entries(name, metrics.interval(known) if known.size else None)  # without sorted objects there is no purity


def _entries(name: str, interval: Interval | None) -> dict[str, float | None]:
    """A figure and the ends of its interval by their names; None for each where there is no figure."""
    ends = (None, None, None) if interval is None else (interval.value, interval.low, interval.high)
    return dict(zip((name, f"{name}_low", f"{name}_high"), ends, strict=True))


def _pace(shifts: Shifts, spread: float) -> dict[str, float | None]:
    """Sorted objects a minute with their interval, which holds the spread of a recovery by the table's counts."""
    pace = metrics.interval(shifts.figures["shift_sorted_per_min"])
    shares = shifts.figures["shift_recovery"].astype(np.float64)
    return _entries("sorted_per_min", widen(pace, spread * pace.value / max(float(np.nanmean(shares)), 1e-9)))


def widen(interval: Interval, spread: float) -> Interval:
    """An interval that holds an independent spread as well, half of the 95 % interval of the counts behind a table."""
    below, above = (float(np.hypot(end - interval.value, spread)) for end in (interval.low, interval.high))
    return Interval(interval.value, interval.value - below, interval.value + above)


def work(line: LineConfig, conditions: Conditions) -> Shifts:
    """The shifts of a line with throws by its table."""
    bars = throws_bar(quiet=conditions.quiet)
    with closing(make_vector(ENV, line, conditions.shifts, conditions.threads)) as env, bars as bar:
        core = line_core(env)
        task = bar.add_task("shifts", total=conditions.shifts)
        controller = registry.make(conditions.controller, core)
        seed = stream_seed("evaluate", conditions.seed)
        env.reset(seed=seed)
        return run_shifts(controller, env, conditions.shifts, seed, lambda count: bar.advance(task, count))


def simulate(plan: Planned, conditions: Conditions, count: int, release: str | None = None) -> Floats:
    """Recovery of a plan's first shifts in the full physics (S,)."""
    config, bars = plan.config.simulated(), throws_bar(quiet=conditions.quiet)
    with closing(make_vector(ENV, config, count, conditions.threads)) as env, bars as bar:
        core = line_core(env)
        if release is not None:
            core.use(make_release(release, config))
        task = bar.add_task("shifts in the full physics", total=count)
        controller, seed = registry.make(conditions.controller, core), stream_seed("evaluate", conditions.seed)
        shifts = run_shifts(controller, env, count, seed, lambda number: bar.advance(task, number))
    return shifts.figures["shift_recovery"].astype(np.float64)


def check(plan: Planned, conditions: Conditions, release: str | None = None) -> dict[str, Any] | None:
    """Recovery of a plan's first shifts in the full physics, and less that by the table; None for no shift to check.

    The interval of the difference holds the spread of the counts behind the table as well.
    """
    count = min(conditions.check, conditions.shifts)
    if count == 0:
        return None
    simulated = simulate(plan, conditions, count, release)
    recovery = metrics.interval(simulated[np.isfinite(simulated)])
    over = widen(metrics.difference(simulated, plan.recovery[:count]), plan.row["recovery_counts"])
    return {
        "shifts": count,
        "recovery": recovery.value,
        "recovery_low": recovery.low,
        "recovery_high": recovery.high,
        "over_table": over.value,
        "over_table_low": over.low,
        "over_table_high": over.high,
    }


def table_spread(shifts: Shifts, fates: Fates, counted: Counted) -> float:
    """Half of the 95 % interval of a recovery that comes from the counts of the table: sums of binomial variances.

    Only landings are counted: the chances to seal are known.
    """
    kind, items = shifts.decisions["true_kind"], len(counted.held)
    held = np.bincount(kind[shifts.decisions["picked"].astype(bool)], minlength=items).astype(np.float64)
    chance = np.minimum(fates.counts.sum(axis=0)[:, 0] / np.maximum(held, 1.0), 1.0)
    variance = (held / fates.counts.sum()) ** 2 * chance * (1.0 - chance) / np.maximum(counted.held, 1)
    return float(1.96 * np.sqrt(variance.sum()))


def _money(shifts: Shifts, line: LineConfig, counted: Counted | None, spread: float) -> dict[str, float | None]:
    """Money an hour with its interval, which holds a relative spread of what is sorted; None as `money_per_hour`."""
    money = money_per_hour(shifts, line, counted)
    spread *= float(_proceeds(shifts, line).mean())
    return _entries("money_per_hour", None if money is None else widen(metrics.interval(money), spread))


def money_per_hour(shifts: Shifts, config: LineConfig, counted: Counted | None) -> Floats | None:
    """Money an hour that a plan earns in each shift (S,): proceeds less the robots' hours and energy.

    None without costs, or without the energy that costs.
    """
    cost, hours = config.cost, config.duration / 3600.0
    if not cost.applies:
        return None
    energy = losses.decision_energy(shifts, counted)
    if energy is None and cost.joule > 0.0:
        return None
    joules = 0.0 if energy is None else losses.shift_energy(shifts, energy) / hours
    return _proceeds(shifts, config) - cost.robot_hour * len(config.robots) - cost.joule * joules


def _proceeds(shifts: Shifts, config: LineConfig) -> Floats:
    """Money an hour for what is sorted in each shift (S,)."""
    tonnes = [item.mass / 1000.0 for item in config.cell.item_list()]
    prices = [config.cost.per_tonne.get(name, 0.0) for name in config.cell.items]
    return shifts.figures["shift_sorted_by_item"] @ np.multiply(tonnes, prices) / (config.duration / 3600.0)
