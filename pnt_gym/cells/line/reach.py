"""Reach of a line's robots: objects that a robot can throw from where they lie into a bin for them. Compiled."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.cells.line.plan import lay_out, pick_height, space_of, stop_rules
from pnt_gym.cells.line.rows import Rider, Setting, Site, Tables
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.planning.motion.kernel import space_margin
from pnt_gym.planning.straight.kernel import choose_slopes, release_rows, reserve_shift, stays_inside
from pnt_gym.planning.straight.rows import Throw
from pnt_gym.rows import Bools2, Floats1, Rows1

PLACES: Final = 17
"""Places of a window, at equal distances from end to end, from which a throw is tried."""
_THROW: Final = Throw.dtype


@kernel_part
def _can_throw(tables: Tables, setting: Setting, site: Site, pick: Floats1, throws: Rows1[Throw]) -> bool:
    """Whether a hand at a speed setting can throw from a pick into a site; one row of `throws` is overwritten."""
    line, space, throw = tables.line[0], space_of(setting), throws[0]
    _, is_possible = lay_out(line, setting, site, pick, throw)
    if not is_possible or space_margin(pick[0], pick[1], pick[2], space) < 0.0:
        return False
    shift = reserve_shift(throw, pick, line.reserve)
    releases = release_rows(throws, False, False, choose_slopes(throws, False))
    return stays_inside(throw, releases[0], shift, stop_rules(line), space)


@kernel_part
def reaches(tables: Tables, robot: int, rider: Rider) -> bool:
    """Whether a robot can throw an object, from some place in its window, into a bin that takes the object.

    The object counts as the item that the camera sees. The time that the hand needs to meet the object does not count.
    """
    line, station, kind = tables.line[0], tables.stations[robot], rider.seen
    throws, pick = empty_rows(1, _THROW), np.empty(3)
    pick[1], pick[2] = rider.lane_y, pick_height(line, rider)
    if not tables.can_take[robot, kind]:
        return False
    for place in range(PLACES):
        # From the middle of the window to its ends: most throws are possible from the middle.
        share = 0.5 + (1 - 2 * (place % 2)) * ((place + 1) // 2) / (PLACES - 1)
        for index in range(station.first_setting, station.end_setting):
            setting = tables.settings[index]
            pick[0] = setting.low + setting.behind + share * (setting.high - setting.low)
            for site in range(station.first_site, station.end_site):
                if tables.accepts[site, kind] and _can_throw(tables, setting, tables.sites[site], pick, throws):
                    return True
    return False


@kernel
def find_reach(tables: Tables, riders: Rows1[Rider]) -> Bools2:
    """Find which of R robots can throw which of M objects into a bin that takes the object (M, R)."""
    reached = np.empty((len(riders), len(tables.stations)), dtype=np.bool_)
    for row in range(len(riders)):
        for robot in range(len(tables.stations)):
            reached[row, robot] = reaches(tables, robot, riders[row])
    return reached
