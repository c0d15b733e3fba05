"""Lines from decision to decision: advance to the next decisions, throw by the table, end the cycles. Compiled."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from pnt_gym.cells.line.choose import landing_chance, write_choices
from pnt_gym.cells.line.plan import fading_time, meet_candidates, plan_throws
from pnt_gym.cells.line.rows import (
    IDLE_TIME,
    NOBODY,
    Account,
    Candidate,
    Choice,
    Fate,
    LineState,
    Outcome,
    Result,
    Rider,
    RobotState,
    Seen,
    Short,
    Tables,
    Tally,
    Worth,
)
from pnt_gym.cells.line.sight import list_candidates, next_turns, show_objects
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.planning.motion.limits import T3KR_ACCELERATION, T3KR_JERK, T3KR_VELOCITY
from pnt_gym.rows import Floats1, Ints1, Ints2, Rows1, Rows2

STRETCH: Final = float(1000.0 + (np.sqrt(5.0) - 1.0) / 2.0)
"""A uniform draw times this number, modulo 1, is practically independent of the draw."""
SEEN, CANDIDATE = Seen.dtype, Candidate.dtype
RIDES, HELD, SORTED, MISPLACED, FLOOR = map(int, Fate)


@kernel_part
def _most_candidates(tables: Tables, robots: Ints1) -> int:
    """Candidates with one object at most, for one of some robots."""
    most = 0
    for r in robots:
        station = tables.stations[r]
        settings = station.end_setting - station.first_setting
        most = max(most, (station.end_site - station.first_site) * settings)
    return most


@kernel_part
def _plan_options(
    tables: Tables, state: LineState, riders: Rows2[Rider], lines: Ints1, ends: Ints2
) -> tuple[Rows2[Seen], Rows1[Choice], Rows1[Short]]:
    """What the deciding robots of some lines see, and the throws that they can plan."""
    count, width = len(lines), 1
    for k in range(count):
        width = max(width, ends[k, 1] - ends[k, 0])
    seen, hands, robots = empty_rows((count, width), SEEN), np.empty((count, 3)), np.empty(count, dtype=np.int64)
    show_objects(tables, state, riders, lines, ends, seen)
    for k in range(count):
        robots[k] = state.turns[lines[k]].robot
        for axis in range(3):
            hands[k, axis] = state.arms[lines[k], robots[k]].hand[axis]
    candidates = empty_rows(_most_candidates(tables, robots) * count * width, CANDIDATE)
    candidates = candidates[: list_candidates(tables, seen, robots, candidates)]
    meetings = meet_candidates(tables, candidates, lines, seen, hands, riders)
    planned, short = plan_throws(tables, candidates, seen, meetings)
    return seen, planned, short


@kernel
def next_decisions(
    tables: Tables, state: LineState, riders: Rows2[Rider], lines: Ints1, looks: int
) -> tuple[bool, Ints1, Rows2[Seen], Rows1[Choice], Rows1[Short]]:
    """Advance some lines to their next decisions, or to the end of their shifts, or until NumPy's roots are needed.

    Args:
        tables: what the level says.
        state: state of the lines, written.
        riders: objects of all lines (N, M).
        lines: indices of the lines (K,).
        looks: looks without a result in a row before a line is declared impossible.

    Returns:
        Whether every line came to an end; and of the lines that wait for the times of short throws: the lines, the
        objects in sight, the planned throws, and the short ones among them.
    """
    seekers = lines
    for _ in range(looks):
        has_candidates, ends = np.empty(len(seekers), dtype=np.bool_), np.empty((len(seekers), 2), dtype=np.int64)
        if not next_turns(tables, state, riders, seekers, has_candidates, ends):
            break
        seekers, ends = seekers[has_candidates], ends[has_candidates]
        seen, planned, short = _plan_options(tables, state, riders, seekers, ends)
        if len(seekers) == 0 or len(short) > 0:
            # Remove the choices of lines whose shifts are over; no robot is expected before it is free.
            for n in lines:
                if state.turns[n].clock >= tables.line[0].duration:
                    for c in range(state.choices.shape[1]):
                        state.choices[n, c].real = False
                for r in range(state.arms.shape[1]):
                    arm = state.arms[n, r]
                    arm.expected = max(arm.expected, arm.free)
            return True, seekers, seen, planned, short
        seekers = write_choices(tables, state, riders, seekers, seen, planned)
    none = lines[:0]
    seen, planned, short = _plan_options(tables, state, riders, none, np.empty((0, 2), dtype=np.int64))
    return False, none, seen, planned, short


@kernel_part
def _redraw(draw: float, attempts: int) -> float:
    """Uniform draw of a later attempt; a draw of 1, which stands for attempts that never fail, stays 1."""
    if draw < 1.0:
        for _ in range(attempts):
            draw = draw * STRETCH % 1.0
    return draw


@kernel
def redraw(draws: Floats1, attempts: Ints1) -> Floats1:
    """Uniform draws for later attempts (N,)."""
    redrawn = np.empty_like(draws)
    for n in range(len(draws)):
        redrawn[n] = _redraw(draws[n], attempts[n])
    return redrawn


@kernel
def throw_by_table(
    tables: Tables, state: LineState, riders: Rows2[Rider], choices: Rows2[Choice], results: Rows2[Result]
) -> None:
    """Write the results of choices of the deciding robots by the table of throws; nothing happens without a choice.

    The same object with the same number of attempts always gives the same result.

    Args:
        tables: what the level says.
        state: state of the lines.
        riders: objects of all lines (N, M).
        choices: choices of each line (N, C).
        results: written, of `no_results` before (N, C).
    """
    for n in range(len(choices)):
        first_site = tables.stations[state.turns[n].robot].first_site
        for c in range(choices.shape[1]):
            choice, result = choices[n, c], results[n, c]
            if not choice.real:
                continue
            rider, tries = riders[n, choice.index], state.accounts[n, choice.index].attempts
            chance = landing_chance(tables.chances, rider.kind, choice)
            result.picked = _redraw(rider.seal, tries) >= 1.0 - tables.chances.picked[rider.kind]
            result.is_success = result.picked and _redraw(rider.luck, tries) < chance
            result.sorted = result.is_success and tables.accepts[first_site + choice.bin, rider.kind]
            result.ended_in = choice.bin if result.is_success else NOBODY


@kernel_part
def _end_cycle(tables: Tables, choice: Choice, picked: bool, arm: RobotState) -> float:
    """Write the place at which a hand is free after a decision; returns the time until then [s]."""
    line = tables.line[0]
    for axis in range(3):
        arm.hand[axis] = choice.stop[axis] if picked else choice.pick[axis]
    if picked:
        return choice.cycle
    if not line.rides:
        return choice.lift
    # Time until an empty hand that rides with the belt stands still, as `stop_motion` [s].
    velocity, peak = T3KR_VELOCITY * choice.percent / 100.0, T3KR_ACCELERATION * choice.percent / 100.0
    stop_time = fading_time(line.speed, velocity, peak, T3KR_JERK * choice.percent / 100.0)
    # The velocity of the belt fades evenly on average: its way is s T / 2.
    arm.hand[0] += line.speed * stop_time / 2.0
    return choice.lift + stop_time


@kernel
def end_cycles(
    tables: Tables,
    state: LineState,
    riders: Rows2[Rider],
    choices: Rows1[Choice],
    results: Rows1[Result],
    outcomes: Rows1[Outcome],
) -> None:
    """Write when and where the hands of N robots are free after their choices, and enter the attempts in the books.

    Args:
        tables: what the level says.
        state: state of the lines; arms and accounts are written.
        riders: objects of all lines (N, M).
        choices: the choice of each line (N,).
        results: results of the choices (N,).
        outcomes: written (N,).
    """
    duration = tables.line[0].duration
    for n in range(len(choices)):
        choice, result, outcome = choices[n], results[n], outcomes[n]
        robot, clock = state.turns[n].robot, state.turns[n].clock
        arm, account = state.arms[n, robot], state.accounts[n, choice.index]
        outcome.value = 0.0
        if not choice.real:
            arm.free = arm.expected = outcome.end = clock + IDLE_TIME
            continue
        cycle = _end_cycle(tables, choice, result.picked, arm)
        arm.free = outcome.end = clock + cycle
        arm.expected = clock + choice.cycle
        arm.busy += cycle - choice.wait
        account.attempts += 1
        account.since = clock + choice.lift
        if result.picked:
            # Enter an object that was lifted in the books.
            is_in_time = outcome.end <= duration
            account.since, account.taker, account.fate = math.inf, robot, HELD
            if is_in_time:
                account.fate = SORTED if result.sorted else MISPLACED if result.ended_in >= 0 else FLOOR
                account.ended_in = result.ended_in
        if result.sorted and outcome.end <= duration:
            outcome.value = riders[n, choice.index].worth


@kernel
def count_fates(
    way: Floats1,
    border: float,
    riders: Rows2[Rider],
    accounts: Rows2[Account],
    tallies: Rows2[Tally],
    picks: Ints2,
    worths: Rows2[Worth],
) -> None:
    """Count the objects of the work shifts of K lines by fate and item, and by robot.

    Args:
        way: ways of the belts in the shifts (K,) [m].
        border: downstream end of the last window [m].
        riders: the objects (K, M).
        accounts: books of the objects (K, M).
        tallies: written to zeros, numbers of objects by item (K, items).
        picks: written to zeros, objects that each robot took and does not hold (K, R).
        worths: written to zeros, values of the objects (K, M).
    """
    for k in range(len(way)):
        for i in range(riders.shape[1]):
            account, tally, worth = accounts[k, i], tallies[k, riders[k, i].kind], worths[k, i]
            if account.taker >= 0 and account.fate != HELD:
                picks[k, account.taker] += 1
            if account.fate == HELD or (account.fate == RIDES and not riders[k, i].x + way[k] > border):
                continue
            worth.arrived = riders[k, i].worth
            if account.fate == SORTED:
                tally.in_right += 1
                worth.sorted = worth.arrived
            elif account.fate == MISPLACED:
                tally.in_wrong += 1
            elif account.fate == FLOOR:
                tally.on_floor += 1
            else:
                tally.passed += 1
                worth.passed = worth.arrived
                tally.tried += account.attempts > 0
