"""Changes of a line, by which an engineer designs: each takes a line and returns another, which is checked whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from pnt_gym.cells.conveyor.robot import RobotSheet, read_sheet
from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig
from pnt_gym.errors import ConfigError

from ..line.changes import cell_differences, section_differences
from ..line.plans import line_up

Change = Callable[[LineConfig], LineConfig]
"""A change of a line; raises ConfigError where the other line is impossible."""
DIGITS: Final = 3
"""Decimals of places: millimetres."""


def _cell(line: LineConfig, section: str, **values: Any) -> LineConfig:
    """The line with other values in a section of its cell."""
    return LineConfig.load(line, **section_differences(line, section, **values))


def _robots(line: LineConfig) -> list[dict[str, Any]]:
    """The robots as values of a level."""
    return [robot.model_dump(mode="json", exclude_unset=True) for robot in line.robots]


def _robot(line: LineConfig, index: int, **values: Any) -> LineConfig:
    """The line with other values of one robot."""
    robots = _robots(line)
    if not 0 <= index < len(robots):
        raise ConfigError(f"there is no robot {index + 1}; the line has {len(robots)}")
    robots[index] |= values
    return LineConfig.load(line, robots=robots)


def move_robot(line: LineConfig, robot: int, x: float) -> LineConfig:
    """The line with one robot at another place along the belt [m]."""
    return _robot(line, robot, x=round(x, DIGITS))


def choose_sheet(line: LineConfig, robot: int, name: str) -> LineConfig:
    """The line with one robot by another shipped data sheet."""
    sheet = RobotSheet.model_validate(read_sheet(name))
    # The robot of the cell needs no mention.
    return _robot(line, robot, robot=None if sheet == line.cell.robot else sheet.model_dump(mode="json"))


def set_robots(line: LineConfig, count: int) -> LineConfig:
    """The line with another number of robots; new robots are copies of the last robot, downstream."""
    if not 1 <= count <= MOST_ROBOTS:
        raise ConfigError(f"the number of robots is {count}; a line has 1 to {MOST_ROBOTS} robots")
    robots = [robot.model_dump(mode="json", exclude_unset=True) for robot in line_up(line, count)]
    names = [robot["name"] for robot in robots]
    down = [down.model_dump(mode="json") for down in line.down if down.place(names) is not None]
    return LineConfig.load(line, robots=robots, down=down)


def fixed_bins(line: LineConfig, robot: int) -> list[dict[str, Any]]:
    """The bins into which a robot throws, as values of a level."""
    bins = line.robots[robot].bins or line.cell.bins.fixed
    return [bin_.model_dump(mode="json") for bin_ in bins]


def with_bins(line: LineConfig, robot: int, bins: list[dict[str, Any]]) -> LineConfig:
    """The line with other bins of a robot; robots without bins of their own share those of the cell."""
    if line.robots[robot].bins:
        return _robot(line, robot, bins=bins)
    return _cell(line, "bins", fixed=bins)


def move_bin(line: LineConfig, robot: int, number: int, x: float, y: float) -> LineConfig:
    """The line with the middle of a bin's opening at another place, from the robot's base [m]."""
    bins = fixed_bins(line, robot)
    bins[number] |= {"x": round(x, DIGITS), "y": round(y, DIGITS)}
    return with_bins(line, robot, bins)


def bin_owners(line: LineConfig) -> list[int]:
    """Robots whose bins differ: each robot with bins of its own, and the first of those that share the cell's."""
    sharing = [index for index, robot in enumerate(line.robots) if not robot.bins]
    return sorted([*sharing[:1], *(index for index, robot in enumerate(line.robots) if robot.bins)])


def set_belt_speed(line: LineConfig, speed: float) -> LineConfig:
    """The line with another speed of its belt [m/s]."""
    return _cell(line, "belt", speed=speed)


def set_limits(line: LineConfig, percent: float) -> LineConfig:
    """The line whose robots without limits of their own move at a share of their limits [%]."""
    return _cell(line, "limits", percent=[percent])


def set_share(line: LineConfig, item: str, percent: float) -> LineConfig:
    """The line with another share of an item among the objects [%]; the others keep their shares of the rest."""
    now = dict(zip(line.cell.items, line.cell.shares().tolist(), strict=True))
    rest = sum(share for name, share in now.items() if name != item)
    if not 0.0 <= percent < 100.0 or rest == 0.0:
        raise ConfigError(
            f"the share of {item} is {percent:g} %; it must be at least 0 % and below 100 %, and other items must come"
        )
    now[item] = rest * percent / (100.0 - percent)
    mix = {name: round(share, 9) for name, share in now.items()}
    came = {name: share for name, share in mix.items() if share > 0.0}
    return LineConfig.load(line, **cell_differences(line, mix=came))


def set_rate(line: LineConfig, per_minute: float) -> LineConfig:
    """The line with another number of objects a minute."""
    arrivals = line.arrivals.model_dump(mode="json", exclude_unset=True)
    return LineConfig.load(line, arrivals={**arrivals, "rate": per_minute / 60.0})


def set_value(line: LineConfig, item: str, value: float) -> LineConfig:
    """The line with another value of a sorted object of an item."""
    section = line.value.model_dump(mode="json", exclude_unset=True)
    return LineConfig.load(line, value={**section, "of": {**section.get("of", {}), item: value}})


def set_standstill(line: LineConfig, robot: str | None, seconds: float) -> LineConfig:
    """The line with one robot that stands still from the middle of the shift on [s]; None for no standstill."""
    if robot is None or seconds <= 0.0:
        return LineConfig.load(line, down=[])
    start = line.duration / 2.0
    return LineConfig.load(line, down=[{"robot": robot, "start": start, "end": start + seconds}])
