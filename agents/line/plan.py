"""Find how many robots and which belt speed a line needs: `python -m agents.line plan --level my_line.yaml`."""

from __future__ import annotations

import itertools
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import tyro

from pnt_gym.cells.line.chances import MADE, made_table, shipped_table
from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig, Robot

from ..dispatchers.registry import ENV, NAMES, line_controller, line_core
from ..ground.cli import UsageError, at_least, option
from ..ground.drawings import COLOURS, dress, subplots, svg
from ..ground.environments import make_vector, stream_seed
from ..ground.metrics import mean_interval
from ..ground.outputs import check_drawing, check_writable, deliver_json, deliver_text
from ..ground.starters import show_assumed
from ..ground.tables import Grid, console, percent, throws_bar
from ..ground.versions import versions
from ..judging.work_shifts.data import run_shifts
from .calibrate import calibrate


@dataclass(frozen=True)
class Arguments:
    """Sweep robots, belt speeds and speed limits over one stream of objects, and report plans that reach a recovery."""

    level: Annotated[str, tyro.conf.arg(metavar="NAME|FILE.yaml")] = "skills3"
    """A shipped level's name or a YAML file; all plans have its stream, items, bins and values."""
    recovery: float = 0.95
    """Recovery to reach: share of all objects that are sorted."""
    robots: tuple[int, ...] = (1, 2, 3, 4)
    """Numbers of robots to try; further robots than the level has are copies of its last robot, at equal distances."""
    speeds: Annotated[tuple[float, ...] | None, option("that of the level", "M/S ...")] = None
    """Belt speeds to try [m/s]; the number of objects per minute stays the same."""
    percents: Annotated[tuple[float, ...] | None, option("those of the level", "PERCENT ...")] = None
    """Limits of the robots to try [% of V, A and J]."""
    skills: tuple[Literal["level", "all"], ...] = ("level",)
    """Skills to try: the skills of the level, or for every robot all items that its bins accept."""
    minutes: float = 2.0
    """Length of a shift [min]."""
    shifts: int = 16
    """Work shifts for each plan."""
    burst: Annotated[float | None, option("the level's own", "SHAPE")] = None
    """Shape of the gamma distribution of the gaps between objects: 1 is a Poisson process, less means bursts."""
    down: Annotated[str | None, option("no robot", "ROBOT:MINUTES")] = None
    """Robot that stands still from the middle of the shift on, and the minutes for which the robot stands."""
    controller: str = "price"
    """The controller: one of fifo, spt, value_rate, atc, price, pair, beam, price_beam, joint_beam, guided_beam."""
    throws: int = 1000
    """Throws in the full physics to count for a table of chances that does not exist yet."""
    seed: int = 0
    """Seed of the objects."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write all plans to this file."""
    picture: Annotated[Path | None, option("none", "FILE.svg")] = None
    """Draw recovery over belt speed."""
    tables: Path = MADE
    """Folder of the tables of chances that do not ship; other commands look for tables in the default folder."""
    threads: int = 2
    """Threads of the simulation."""


def main(arguments: Arguments) -> None:
    """Evaluate every plan, and report the smallest one that reaches the recovery."""
    at_least(vars(arguments), shifts=1, seed=0, throws=100, threads=1)
    _check(arguments)
    check_writable(arguments.json, arguments.picture)
    check_drawing(picture=arguments.picture)
    level = LineConfig.load(arguments.level, throws="table")
    show_assumed(level)
    plans = list(make_plans(level, arguments))
    rows: list[dict[str, Any]] = []
    for number, (numbers, config) in enumerate(plans, 1):
        text = ", ".join(f"{name} {value}" for name, value in numbers.items())
        console().print(f"plan {number} of {len(plans)}: {text}")
        rows.append({**numbers, **evaluate_plan(with_table(config, arguments), arguments)})
    console().print(plans_table(arguments, rows).terminal())
    console().print(answer(arguments, rows))
    if arguments.json is not None:
        head = {"level": level.name, "controller": arguments.controller, "seed": arguments.seed}
        deliver_json(arguments.json, {**head, "versions": versions(), "plans": rows})
    if arguments.picture is not None:
        deliver_text(arguments.picture, picture(arguments, rows))


def _check(arguments: Arguments) -> None:
    if not 0.0 < arguments.recovery < 1.0:
        raise UsageError(f"--recovery is {arguments.recovery:g}; it must lie between 0 and 1")
    if not (arguments.robots and all(1 <= count <= MOST_ROBOTS for count in arguments.robots)):
        raise UsageError(f"--robots is {arguments.robots}; a line has 1 to {MOST_ROBOTS} robots")
    if arguments.controller not in NAMES:
        raise UsageError(f"--controller is {arguments.controller!r}; it must be one of {', '.join(NAMES)}")


def make_plans(level: LineConfig, arguments: Arguments) -> Any:
    """Numbers and level of every plan."""
    speeds = arguments.speeds or (level.cell.belt.speed,)
    percents = arguments.percents or (None,)
    for count, speed, limit, skills in itertools.product(arguments.robots, speeds, percents, arguments.skills):
        changes = level.model_dump(mode="json", exclude_unset=True)
        changes |= {"name": f"{level.name}, a plan", "duration": 60.0 * arguments.minutes}
        overrides = {} if skills == "level" else {"skills": []}
        changes["robots"] = [{**robot.model_dump(mode="json"), **overrides} for robot in line_up(level, count)]
        cell = changes["cell"]
        cell["belt"] = {**cell.get("belt", {}), "speed": speed}
        if limit is not None:
            cell["limits"] = {"percent": [limit]}
        if arguments.burst is not None:
            changes["arrivals"] = {**changes.get("arrivals", {}), "regularity": arguments.burst}
        config = LineConfig.load({"base": "nominal", **changes})
        numbers = {"robots": count, "belt_speed": speed, "percent": max(config.cell.limits.percent), "skills": skills}
        yield numbers, down(config, arguments)


def line_up(level: LineConfig, count: int) -> list[Robot]:
    """The first `count` robots of the level; further robots copy its last robot, at the distance of its first two."""
    robots = list(level.robots[:count])
    low, high = level.cell.belt.pick_x
    step = robots[1].x - robots[0].x if len(robots) > 1 else 2.0 * (high - low)
    for index in range(len(robots), count):
        last = robots[-1]
        robots.append(last.model_copy(update={"name": f"{level.robots[-1].name}_{index + 1}", "x": last.x + step}))
    return robots


def down(config: LineConfig, arguments: Arguments) -> LineConfig:
    """The line with a standstill of the robot of `--down`, if the line has this robot."""
    if arguments.down is None:
        return config
    name, _, minutes = arguments.down.partition(":")
    try:
        start, still = 30.0 * arguments.minutes, 60.0 * float(minutes)
    except ValueError:
        raise UsageError(f"--down is {arguments.down!r}; it must be ROBOT:MINUTES") from None
    if name not in [robot.name for robot in config.robots]:
        return config
    return LineConfig.load(config, down=[{"robot": name, "start": start, "end": start + still}])


def with_table(config: LineConfig, arguments: Arguments) -> LineConfig:
    """The line with its table of chances; a missing table is made."""
    if shipped_table(config).is_file():
        return config
    place = made_table(config, arguments.tables)
    if not place.is_file():
        calibrate(config, place, arguments.throws, arguments.seed, threads=arguments.threads)
    return LineConfig.load(config, chances=str(place))


def evaluate_plan(config: LineConfig, arguments: Arguments) -> dict[str, Any]:
    """Recovery, value per minute and utilisation of a plan, from simulated shifts."""
    with closing(make_vector(ENV, config, arguments.shifts, arguments.threads)) as env, throws_bar() as bar:
        core = line_core(env)
        task = bar.add_task("shifts", total=arguments.shifts)
        controller = line_controller(arguments.controller, core)
        seed = stream_seed("evaluate", arguments.seed)
        shifts = run_shifts(controller, env, arguments.shifts, seed, lambda count: bar.advance(task, count))
    recovery, value = mean_interval(shifts.figures["shift_recovery"]), mean_interval(shifts.value)
    return {
        "recovery": recovery.value,
        "recovery_low": recovery.low,
        "recovery_high": recovery.high,
        "value_per_min": value.value,
        "value_per_min_low": value.low,
        "value_per_min_high": value.high,
        "utilisation": shifts.figures["shift_utilisation"].mean(axis=0).tolist(),
    }


def plans_table(arguments: Arguments, rows: list[dict[str, Any]]) -> Grid:
    """Table of all plans."""
    header = ("robots", "skills", "belt", "limits", "recovery (95 % interval)", "value/min", "at work", "enough")
    lines = [
        [
            str(row["robots"]),
            row["skills"],
            f"{row['belt_speed']:.2f} m/s",
            f"{row['percent']:g} %",
            f"{percent(row['recovery'])} ({100 * row['recovery_low']:.1f}..{100 * row['recovery_high']:.1f})",
            f"{row['value_per_min']:.1f}",
            ", ".join(percent(share) for share in row["utilisation"]),
            "yes" if row["recovery_low"] >= arguments.recovery else "no",
        ]
        for row in rows
    ]
    title = (
        f"level {arguments.level}, {arguments.shifts} shifts of {arguments.minutes:g} min each, {arguments.controller}"
    )
    return Grid(title, header, lines)


def answer(arguments: Arguments, rows: list[dict[str, Any]]) -> str:
    """The smallest plan that reaches the recovery, in one sentence."""
    enough = [row for row in rows if row["recovery_low"] >= arguments.recovery]
    if not enough:
        best = max(rows, key=lambda row: row["recovery"])
        return (
            f"no plan reaches a recovery of {percent(arguments.recovery)}; the best plan, {_plan_text(best)}, reaches "
            f"{percent(best['recovery'])}"
        )
    least = min(enough, key=lambda row: (row["robots"], row["percent"], row["belt_speed"]))
    return f"the smallest plan with a recovery of {percent(arguments.recovery)}: {_plan_text(least)}"


def _plan_text(row: dict[str, Any]) -> str:
    robots = "1 robot" if row["robots"] == 1 else f"{row['robots']} robots"
    return f"{robots} at {row['percent']:g} % and a belt at {row['belt_speed']:g} m/s"


def _kind(row: dict[str, Any]) -> tuple[float, float, str]:
    """Belt speed, limits and skills of a plan; plans with equal ones are points of one curve in the picture."""
    return row["belt_speed"], row["percent"], row["skills"]


def picture(arguments: Arguments, rows: list[dict[str, Any]]) -> str:
    """Picture of recovery over the number of robots with intervals, a curve for each belt speed and limit, as SVG."""
    figure, (axes,) = subplots(1, 1, (6.4, 4.0))
    kinds = sorted({_kind(row) for row in rows})
    for kind, colour in zip(kinds, itertools.cycle(COLOURS), strict=False):
        kind_rows = sorted((row for row in rows if _kind(row) == kind), key=lambda row: row["robots"])
        low, middle, high = (np.array([row[f"recovery{end}"] for row in kind_rows]) for end in ("_low", "", "_high"))
        label = f"{kind[0]:g} m/s, {kind[1]:g} %, skills {kind[2]}"
        off = np.stack([middle - low, high - middle])
        axes.errorbar(
            [row["robots"] for row in kind_rows], middle, off, marker="o", capsize=3, color=colour, label=label
        )
    axes.axhline(arguments.recovery, color="black", linewidth=0.8, linestyle="--")
    axes.set_xticks(sorted({row["robots"] for row in rows}))
    dress(axes, "robots", "recovery", f"level {arguments.level}", legend="lower right", ylim=(0.0, 1.0))
    return svg(figure)
