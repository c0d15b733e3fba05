"""Plans of a line: combinations of robots, skills, belt speeds and limits over one stream of objects."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.sections import Down, Robot
from pnt_gym.errors import ConfigError
from pnt_gym.names import unknown_name

from ..ground.cli import UsageError


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
        changes |= {"name": f"{level.name}, a plan", "duration": 60.0 * sweep.minutes}
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
