"""Lines from decision to decision: advance to the next decisions, throw by the table, end the cycles. Compiled."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from pnt_gym.cells.line.choose import landing_chance, write_choices
from pnt_gym.cells.line.plan import plan_options
from pnt_gym.cells.line.reach import reaches
from pnt_gym.cells.line.rows import (
    IDLE_TIME,
    NOBODY,
    Account,
    Choice,
    Fate,
    LineState,
    Outcome,
    Result,
    Rider,
    Tables,
    Tally,
    Worth,
)
from pnt_gym.cells.line.sight import next_turns, show_objects
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Floats1, Ints1, Ints2, Rows1, Rows2

STRETCH: Final = float(1000.0 + (np.sqrt(5.0) - 1.0) / 2.0)
"""A uniform draw times this number, modulo 1, is practically independent of the draw."""
RIDES, HELD, SORTED, MISPLACED, FLOOR = map(int, Fate)


@kernel
def advance(tables: Tables, state: LineState, riders: Rows2[Rider], lines: Ints1, looks: int) -> bool:
    """Advance some lines to their next decisions, or to the end of their shifts.

    Args:
        tables: what the level says.
        state: state of the lines, written.
        riders: objects of all lines (N, M).
        lines: indices of the lines (K,).
        looks: looks without a result in a row before a line is declared impossible.

    Returns:
        Whether every line came to an end.
    """
    has_ended, seekers = False, lines
    for _ in range(looks):
        has_ended, seekers = next_turns(tables, state, riders, seekers)
        if not has_ended or len(seekers) == 0:
            break
        seen, robots = show_objects(tables, state, riders, seekers), np.empty_like(seekers)
        hands = np.empty((len(seekers), 3))
        for k in range(len(seekers)):
            robots[k] = state.turns[seekers[k]].robot
            for axis in range(3):
                hands[k, axis] = state.arms[seekers[k], robots[k]].hand[axis]
        planned = plan_options(tables, riders, seekers, seen, robots, hands)
        seekers = write_choices(tables, state, seekers, seen, planned)
    # Remove the choices of lines whose shifts are over; no robot is expected before it is free.
    for n in lines:
        if state.turns[n].clock >= tables.line[0].duration:
            for c in range(state.choices.shape[1]):
                state.choices[n, c].real = False
        for r in range(state.arms.shape[1]):
            arm = state.arms[n, r]
            arm.expected = max(arm.expected, arm.free)
    return has_ended and len(seekers) == 0


@kernel_part
def later_draw(draw: float, attempts: int) -> float:
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
        redrawn[n] = later_draw(draws[n], attempts[n])
    return redrawn


@kernel
def predict(
    tables: Tables, state: LineState, riders: Rows2[Rider], choices: Rows2[Choice], results: Rows2[Result]
) -> None:
    """Write the results of choices of the deciding robots by the table of throws; nothing happens without a choice.

    The same object with the same number of attempts always gives the same result.

    Args:
        tables: what the level says.
        state: state of the lines.
        riders: objects of all lines (N, M).
        choices: choices of each line (N, C).
        results: written, of `Result.none` before (N, C).
    """
    for n in range(len(choices)):
        first_site = tables.stations[state.turns[n].robot].first_site
        for c in range(choices.shape[1]):
            choice, result = choices[n, c], results[n, c]
            if not choice.real:
                continue
            rider, tries = riders[n, choice.index], state.accounts[n, choice.index].attempts
            chance = landing_chance(tables.chances, rider.kind, choice)
            result.picked = later_draw(rider.seal, tries) >= 1.0 - tables.chances.picked[rider.kind]
            result.is_success = result.picked and later_draw(rider.luck, tries) < chance
            result.sorted = result.is_success and tables.accepts[first_site + choice.bin, rider.kind]
            result.ended_in = choice.bin if result.is_success else NOBODY


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
        for axis in range(3):
            arm.hand[axis] = choice.stop[axis] if result.picked else choice.pick[axis]
        cycle = choice.cycle
        if not result.picked:
            # The velocity of the belt fades evenly on average: its way is s T / 2.
            arm.hand[0] += tables.line[0].speed * choice.fading / 2.0
            cycle = choice.lift + choice.fading
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
    tables: Tables,
    ends: Floats1,
    riders: Rows2[Rider],
    accounts: Rows2[Account],
    tallies: Rows2[Tally],
    picks: Ints2,
    worths: Rows2[Worth],
) -> None:
    """Count the objects of the work shifts of K lines by fate and item, and by robot.

    Args:
        tables: what the level says.
        ends: ends of the shifts (K,) [s].
        riders: the objects (K, M).
        accounts: books of the objects (K, M).
        tallies: written to zeros, numbers of objects by item (K, items).
        picks: written to zeros, objects that each robot took and does not hold (K, R).
        worths: written to zeros, values of the objects (K, M).
    """
    border = tables.line[0].sight_high
    for k in range(len(ends)):
        way = tables.line[0].speed * ends[k]
        for i in range(riders.shape[1]):
            account, tally, worth = accounts[k, i], tallies[k, riders[k, i].kind], worths[k, i]
            if account.taker >= 0 and account.fate != HELD:
                picks[k, account.taker] += 1
            if account.fate == HELD or (account.fate == RIDES and not riders[k, i].x + way > border):
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
                is_unreached = not account.planned
                for robot in range(len(tables.stations)):
                    is_unreached = is_unreached and not reaches(tables, robot, riders[k, i])
                tally.unreached += is_unreached
