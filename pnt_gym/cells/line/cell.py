"""N lines of robots in step: in each step the next free robot of each line carries out one decision."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.cells.base.cell import MOST_CELLS, Generators, check_whole_number
from pnt_gym.cells.base.features import Quantity
from pnt_gym.cells.base.parallel import work_in_parts
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.line import simulate
from pnt_gym.cells.line.acts import CycleHistory, Decision, RobotCycle
from pnt_gym.cells.line.chances import Chances, required_table
from pnt_gym.cells.line.choosing import Chooser
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.hidden import BY_TABLE, SIMULATED, Truth
from pnt_gym.cells.line.observation import ENTRIES, fill_observations
from pnt_gym.cells.line.reach import find_reach
from pnt_gym.cells.line.rows import LineState, Outcome, Result, Rider, Tables
from pnt_gym.cells.line.stream import StreamSampler
from pnt_gym.cells.line.throws import Attempt, SimulatedThrows, TableThrows, ThrowExecutor
from pnt_gym.errors import ConfigError, OrderError, ReachWarning
from pnt_gym.rows import Rows1, Rows2

USUAL_CYCLE: Final = 0.9
"""Typical time of a decision: 0.75 s with good planners, 1.4 s with random choices on the shipped levels [s]."""
MOST_OBJECTS: Final = 5_000_000
"""Objects of all lines together at most: about 5 GB."""


@final
@dataclass(frozen=True)
class Decisions:
    """Decisions of N robots that were carried out, with their results."""

    attempt: Attempt
    """The choices."""
    results: Rows1[Result]
    """Results of the throws."""
    start: Floats
    """Time of the decision, since the begin of the shift (N,) [s]."""
    end: Floats
    """Time at which the robot is free again (N,) [s]."""
    value: Floats
    """Value brought into bins; 0 for throws that end after the shift (N,)."""
    elapsed: Floats
    """Time from this decision to the next decision of the line (N,) [s]."""
    observation: NDArray[np.float32]
    """Observations of the robots that decide next (N, ENTRIES)."""

    @property
    def robot(self) -> Ints:
        """Robot that decided (N,)."""
        return self.attempt.robot

    @property
    def valid(self) -> Bools:
        """Whether the chosen choice existed; otherwise the robot stood still for `IDLE_TIME` (N,)."""
        return self.attempt.valid

    @property
    def index(self) -> Ints:
        """Index of the object in the stream (N,)."""
        return self.attempt.chosen["index"]

    @property
    def context(self) -> Context:
        """Picks and throws; arbitrary rows where `valid` is False (N,)."""
        return self.attempt.context


@final
class LineCell:
    """N lines. `state` holds their states; `take` carries decisions out and advances to the next ones.

    Args:
        config: level of the line.
        count: number of lines N.
        threads: threads of the physics and of the search for choices; results do not depend on their number.

    Raises:
        ConfigError: the table of throws is missing, the robots find nothing to take, or there is not enough memory
            for the objects.
    """

    target_names: tuple[str, ...] = ()

    def __init__(self, config: LineConfig, count: int, threads: int = 1) -> None:
        self.config, self.count = config, count
        self.item_names = config.cell.items
        cells = config.cells()
        self.chances: Chances = required_table(config)
        self.chooser = Chooser(config, cells, self.chances)
        self._threads = threads
        self.arriving = StreamSampler(config, self.chooser.planner)
        _check(config, count, self.arriving.length)
        self.throws: ThrowExecutor = (
            TableThrows(self.chooser.tables)
            if config.throws == "table"
            else SimulatedThrows(cells, self.chooser.can_throw, count, threads)
        )
        self.generators: Generators = [np.random.default_rng(0) for _ in range(count)]
        self.watched: CycleHistory | None = None
        """Recorded cycles of the first line's robots, for pictures; None records nothing."""
        self.stream = self.arriving.empty(count)
        """Objects that come along the belts in this shift; a reset overwrites the streams of its lines."""
        hands = np.tile(self.chooser.initial_hand, (len(config.robots), 1))
        begin = partial(LineState.begin, objects=self.arriving.length, hands=hands, blank=self.chooser.tables.blank)
        self.state = begin(count)
        """States of the lines; each step has arrays of its own, but for the books of objects."""
        self._initial = begin(1)
        """State of a line at the begin of a shift."""
        warn_of_reach(config, self.chooser.tables, self.stream.riders[0])
        self.reset(np.arange(count), self.generators)

    def reset(self, rows: Ints, generators: Generators) -> None:
        """Begin shifts in some lines, each with its own generator."""
        for row, generator in zip(rows, generators, strict=True):
            self.generators[int(row)] = generator
        self.arriving.draw(self.stream, rows, generators)
        state = self.state.next()
        state.put(rows, self._initial)
        work_in_parts(partial(self.chooser.advance, self.stream, state), rows, self._threads)
        self.state = state
        if self.watched is not None and (rows == 0).any():
            self.watched = CycleHistory(self._initial.arms["hand"][0])

    def watch(self) -> None:
        """Record the cycles of the first line's robots from now on, for pictures."""
        self.throws.watched = True
        if self.watched is None:
            self.watched = CycleHistory(self.state.arms["hand"][0].copy(), float(self.state.clock[0]))

    @property
    def acts(self) -> CycleHistory:
        """Recorded cycles of the first line's robots.

        Raises:
            OrderError: nothing was recorded.
        """
        if self.watched is None:
            raise OrderError("the cycles of this line are not recorded; open a view of the line first")
        return self.watched

    @property
    def context(self) -> LineState:
        """The states of the lines, under the name that every cell uses for its coming steps."""
        return self.state

    @context.setter
    def context(self, state: LineState) -> None:
        self.state = state

    @property
    def episode(self) -> int:
        """Approximate number of decisions in a shift: by the objects that come, or by the robots' time."""
        config = self.config
        coming = config.arrivals.rate * config.duration
        return max(1, round(min(coming, len(config.robots) * config.duration / USUAL_CYCLE)))

    @property
    def hidden(self) -> Sequence[Quantity]:
        """Hidden quantities of the coming decisions, each a value of `truth`."""
        return BY_TABLE if isinstance(self.throws, TableThrows) else SIMULATED

    def truth(self) -> Truth:
        """True objects of the coming choices, and the results of their throws where a table decides."""
        state, choices = self.state, self.state.choices
        index = np.arange(self.count)[:, None], choices["index"]
        objects = take(self.stream.objects, index).replace(percent=choices["percent"])
        riders = take(self.stream.riders, index)
        if not isinstance(self.throws, TableThrows):
            nothing: Rows2[Result] = Result.none(*choices.shape)
            return Truth(choices["real"], objects, riders, nothing, np.full(choices.shape, np.nan))
        results = self.throws.predict(state, self.stream, choices)
        in_time = state.clock[:, None] + choices["cycle"] <= self.config.duration
        value = np.where(results["sorted"] & in_time, riders["worth"], 0.0)
        return Truth(choices["real"], objects, riders, results, value)

    @property
    def over(self) -> Bools:
        """Whether each line's shift is over (N,)."""
        return self.state.clock >= self.config.duration

    def take(self, choice: Ints) -> Decisions:
        """Carry out the choice of each line's robot, and advance to the next decisions.

        Args:
            choice: index of the choice (N,), from 0 to `CHOICES` - 1.
        """
        before, state = self.state, self.state.next()
        chosen = take(before.choices, (np.arange(self.count), choice))
        attempt = Attempt(self.chooser, before.robot, self.stream, chosen)
        results, outcomes = self.throws.execute(before, attempt), Outcome.empty(self.count)
        simulate.end_cycles(self.chooser.tables, state, self.stream.riders, chosen, results, outcomes)
        observation = self._advance(state)
        self.state = state
        elapsed = np.maximum(np.minimum(self.state.clock, self.config.duration) - before.clock, 0.0)
        decisions = Decisions(
            attempt=attempt,
            results=results,
            start=before.clock,
            end=outcomes["end"],
            value=outcomes["value"],
            elapsed=elapsed,
            observation=observation,
        )
        if self.watched is not None:
            cycle = self._record(before, decisions, int(choice[0])) if decisions.valid[0] else None
            self.watched = self.watched.advance(float(before.clock[0]), cycle)
        return decisions

    def _advance(self, state: LineState) -> NDArray[np.float32]:
        """Advance all lines in place; observations of the robots that decide next (N, ENTRIES)."""
        observations, goes_on = np.empty((self.count, ENTRIES), dtype=np.float32), ~self.over

        def work(lines: Ints) -> None:
            self.chooser.advance(self.stream, state, lines[goes_on[lines]])
            robots = np.ascontiguousarray(state.robot)
            fill_observations(self.chooser.tables, state, self.stream.riders, robots, lines, observations)

        draws: list[Callable[[], None]] = []
        if self._threads > 1:
            # The next shifts of lines in which no robot is free again before the end of the shift.
            ended = goes_on & (state.arms["free"].min(axis=1) >= self.config.duration)
            draws = [
                partial(self.arriving.draw_ahead, row, self.generators[row]) for row in ended.nonzero()[0].tolist()
            ]
        work_in_parts(work, np.arange(self.count), self._threads, draws)
        return observations

    def _record(self, before: LineState, decisions: Decisions, choice: int) -> RobotCycle:
        """Tracks of the first line's decision, for pictures."""
        robot, start, context = (
            int(decisions.robot[0]),
            float(decisions.start[0]),
            take(decisions.context, np.zeros(1, dtype=np.int64)),
        )
        planner, index = self.chooser.planner_of(robot), int(decisions.index[0])
        x = self.stream.x[0, index] + self.config.cell.belt.speed * start - self.config.robot_x()[robot]
        decision = Decision(
            robot=robot,
            number=index,
            hand=before.arms["hand"][:1, robot],
            place=planner.pick_point(context.objects, np.array([x])),
            start=start,
            lift=start + float(before.choices["lift"][0, choice]),
            end=float(decisions.end[0]),
            context=context,
            picked=bool(decisions.results["picked"][0]),
            in_bin=bool(decisions.results["ended_in"][0] >= 0),
        )
        tip = self.acts.tips(start)[robot] - before.arms["hand"][0, robot]
        return RobotCycle.of(decision, tip, planner.config, planner.mover, self.throws.recording)


def _check(config: LineConfig, count: int, objects: int) -> None:
    check_whole_number("num_envs", count, MOST_CELLS)
    if count * objects > MOST_OBJECTS:
        raise ConfigError(
            f"num_envs is {count}; a shift of level {config.name!r} draws {objects} objects, and all lines "
            f"together draw at most {MOST_OBJECTS}: set num_envs to at most {MOST_OBJECTS // objects}, or shorten "
            "the shift"
        )


def warn_of_reach(config: LineConfig, tables: Tables, riders: Rows1[Rider]) -> None:
    """Warn of objects (M,) that no robot can throw into a bin that takes them, with the shares of their items."""
    items, kinds = config.cell.items, riders["kind"]
    unreached: Ints = np.flatnonzero(~find_reach(tables, riders).any(axis=1))
    if unreached.size == 0:
        return
    counts = np.bincount(kinds[unreached], minlength=len(items))
    shares = counts / np.maximum(np.bincount(kinds, minlength=len(items)), 1)
    worst = np.argsort(-shares)[: np.count_nonzero(counts)].tolist()
    shares_text = ", ".join(f"{shares[kind]:.1%} of {items[kind]}" for kind in worst)
    warnings.warn(
        f"level {config.name!r}: {len(unreached) / len(riders):.1%} of the objects are out of reach, {shares_text}: no "
        "robot can throw them, from where they lie, into a bin that takes them; move the bins or narrow the lanes",
        ReachWarning,
        stacklevel=2,
    )
