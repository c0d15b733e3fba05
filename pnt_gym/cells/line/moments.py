"""Every moment in which a robot of a line can lift an object. Compiled.

Time is cut into steps. A moment stands for all lifts of an object within one step, by one robot, for one bin and one
speed setting. What a moment says is never worse than any of these lifts: it ends the earliest and brings the most. So
the best order of moments is at least as good as any order of picks.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from pnt_gym.cells.line.choose import landing_chance
from pnt_gym.cells.line.plan import lay_out, pick_height, space_of, stop_rules, write_throw
from pnt_gym.cells.line.rows import Choice, Rider, Tables
from pnt_gym.cells.line.simulate import later_draw
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.planning.motion.kernel import space_margin
from pnt_gym.planning.straight.kernel import choose_slopes, release_rows, reserve_shift, stays_inside
from pnt_gym.planning.straight.rows import Throw
from pnt_gym.rows import Row, Rows1, Triple, field

MOST_FAILURES: Final = 8
"""An object counts as one that no cup holds if so many attempts fail by its draws."""


class Passage(Row):
    """An object that passes the window of a robot, for one bin, one speed setting, and one result of the seal."""

    robot: int = field("-", "index of the robot")
    index: int = field("-", "index of the object in the stream")
    site: int = field("-", "site of the bin")
    setting: int = field("-", "speed setting")
    begin: float = field("s", "first time of a lift")
    end: float = field("s", "last time of a lift")
    first_step: int = field("-", "step of the first moment")
    count: int = field("-", "number of moments")
    first_row: int = field("-", "row of the first moment among all moments")
    seal: float = field("-", "chance that the cup seals: 0 or 1 by the object's draws, or the chance of its item")
    failures: int = field("-", "attempts that fail by the object's draws before one seals")


class Moment(Row):
    """Lifts of an object within one step."""

    can_throw: bool = field("-", "whether a throw is possible from some of its places")
    free: float = field("s", "earliest time at which the hand is free after a throw")
    stop: Triple = field("m", "place where the hand stops after a throw, from the robot's base")
    empty_free: float = field("s", "earliest time at which the hand is free after an attempt whose cup did not seal")
    empty_stop: Triple = field("m", "place of the hand at that time")
    spread: float = field("m", "largest distance of a lift's places from `stop` and `empty_stop`")
    worth: float = field("-", "largest value that a sealed attempt brings, by the object's draws or expected")


PASSAGE, MOMENT, CHOICE, THROW = Passage.dtype, Moment.dtype, Choice.dtype, Throw.dtype


@kernel_part
def _write_times(tables: Tables, rider: Rider, step: float, passage: Passage) -> bool:
    """Write the times of a passage of known robot and setting; returns whether there are any."""
    line, setting = tables.line[0], tables.settings[passage.setting]
    place = rider.x - tables.stations[passage.robot].base - setting.early
    passage.begin = max((setting.low - place) / line.speed + line.dwell, 0.0)
    passage.end = min((setting.high - place) / line.speed + line.dwell, line.duration)
    passage.first_step = math.floor(passage.begin / step)
    passage.count = math.floor(passage.end / step) - passage.first_step + 1
    return passage.end > passage.begin


@kernel
def list_passages(tables: Tables, riders: Rows1[Rider], step: float, is_drawn: bool) -> Rows1[Passage]:
    """List the passages of objects in which a robot can bring the object into a bin that takes it.

    An object whose first attempts fail has a second passage for these attempts, beside the one for the attempt that
    seals.

    Args:
        tables: what the level says.
        riders: the objects (M,).
        step: length of a step [s].
        is_drawn: whether cups seal and throws land as the objects' draws say, and not with the chances of the table.

    Returns:
        The passages, robot by robot, the most downstream object first.
    """
    variants, sites, settings = 0, len(tables.sites), len(tables.settings)
    for station in tables.stations:
        variants += 2 * (station.end_site - station.first_site) * (station.end_setting - station.first_setting)
    passages, count, row = empty_rows(variants * len(riders), PASSAGE), 0, 0
    for r in range(len(tables.stations)):
        station = tables.stations[r]
        for variant in range(len(riders) * sites * settings):
            i, site, setting = variant // (sites * settings), variant // settings % sites, variant % settings
            rider = riders[i]
            is_own = station.first_site <= site < station.end_site and (
                station.first_setting <= setting < station.end_setting
            )
            takes = tables.can_take[r, rider.seen] and tables.accepts[site, rider.seen]
            picked, failures = float(tables.chances.picked[rider.kind]), 0
            # Attempts that fail by the object's draws before one seals.
            while is_drawn and failures < MOST_FAILURES and later_draw(rider.seal, failures) < 1.0 - picked:
                failures += 1
            if not (is_own and takes and tables.accepts[site, rider.kind]) or failures == MOST_FAILURES:
                continue
            for fails in range(1 + (failures > 0)):
                passage = passages[count]
                passage.robot, passage.index, passage.site, passage.setting = r, i, site, setting
                passage.seal, passage.failures = 1.0 - fails if is_drawn else picked, failures
                passage.first_row = row
                if _write_times(tables, rider, step, passage):
                    row += passage.count
                    count += 1
    return passages[:count]


@kernel_part
def _write_lifts(tables: Tables, rider: Rider, passage: Passage, step: float, lifts: Rows1[Choice]) -> None:
    """Write the lifts at the borders of a passage's moments; `real` says whether a throw is possible."""
    line, setting, site = tables.line[0], tables.settings[passage.setting], tables.sites[passage.site]
    throws, shifts = empty_rows(len(lifts), THROW), np.empty((len(lifts), 2))
    rules, space = stop_rules(line), space_of(setting)
    begin = rider.x - tables.stations[passage.robot].base - setting.early + setting.behind
    for k in range(len(lifts)):
        lift = lifts[k]
        lift.lift = min(max((passage.first_step + k) * step, passage.begin), passage.end)
        lift.pick[0], lift.pick[1] = begin + line.speed * (lift.lift - line.dwell), rider.lane_y
        lift.pick[2] = pick_height(line, rider)
        lift.away[0], lift.away[1] = site.centre[0] - lift.pick[0], site.centre[1] - lift.pick[1]
        lift.percent = setting.percent
        lift.fading, lift.real = lay_out(line, setting, site, lift.pick, throws[k])
        lift.real &= space_margin(lift.pick[0], lift.pick[1], lift.pick[2], space) >= 0.0
        shifts[k, 0], shifts[k, 1] = reserve_shift(throws[k], lift.pick, line.reserve)
    releases = release_rows(throws, False, False, choose_slopes(throws, False))
    for k in range(len(lifts)):
        lift, shift = lifts[k], (shifts[k, 0], shifts[k, 1])
        lift.real = lift.real and stays_inside(throws[k], releases[k], shift, rules, space)
        if lift.real:
            write_throw(rules, throws[k], releases[k], lift.fading, lift)


@kernel_part
def _write_moment(
    tables: Tables, rider: Rider, passage: Passage, before: Choice, after: Choice, moment: Moment
) -> None:
    """Write a moment from the lifts at its begin and at its end."""
    speed, luck = tables.line[0].speed, later_draw(rider.luck, passage.failures)
    moment.can_throw, moment.free, moment.worth = before.real or after.real, math.inf, 0.0
    moment.empty_free = before.lift + min(before.fading, after.fading)
    # Places move with the belt, and those of throws by what the ends of the step say.
    first, last = before if before.real else after, after if after.real else before
    apart = 0.0
    for axis in range(3):
        moment.empty_stop[axis] = 0.5 * (before.pick[axis] + after.pick[axis])
        moment.stop[axis] = 0.5 * (first.stop[axis] + last.stop[axis])
        apart += (last.stop[axis] - first.stop[axis]) ** 2
    moment.empty_stop[0] += speed * 0.25 * (before.fading + after.fading)
    # The middle of both ends is half as far away as a single end.
    share = 0.5 if before.real and after.real else 1.0
    moment.spread = max(share * speed * (after.lift - before.lift), 0.5 * math.sqrt(apart))
    for lift in (before, after):
        if lift.real:
            moment.free = min(moment.free, before.lift + lift.throwing)
            chance = landing_chance(tables.chances, rider.kind, lift)
            # By the table a sealed attempt brings its expected value; by the object's draws, all or nothing.
            share = chance if 0.0 < passage.seal < 1.0 else 1.0 if luck < chance else 0.0
            if lift.lift + lift.throwing <= tables.line[0].duration:
                moment.worth = max(moment.worth, rider.worth * share)


@kernel
def list_moments(tables: Tables, riders: Rows1[Rider], passages: Rows1[Passage], step: float) -> Rows1[Moment]:
    """List the moments of all passages, in their order.

    Args:
        tables: what the level says.
        riders: the objects (M,).
        passages: the passages, of which there is at least one.
        step: length of a step [s].
    """
    last = passages[len(passages) - 1]
    moments = empty_rows(last.first_row + last.count, MOMENT)
    for passage in passages:
        rider, lifts = riders[passage.index], empty_rows(passage.count + 1, CHOICE)
        _write_lifts(tables, rider, passage, step, lifts)
        for k in range(passage.count):
            _write_moment(tables, rider, passage, lifts[k], lifts[k + 1], moments[passage.first_row + k])
    return moments
