"""Objects that come along N belts in a shift: all drawn when the shift begins, whatever the robots do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.base.cell import Generators, Purpose, move_aside
from pnt_gym.cells.conveyor.objects.records import Objects, half_extent
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line import lie
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError

STRETCH: Final = 1000.0 + (np.sqrt(5.0) - 1.0) / 2.0
"""A uniform draw times this number, modulo 1, is practically independent of the draw."""

_ALONG_AND_ACROSS: Final = np.array([0.0, np.pi / 2])[:, None, None]
"""Headings along and across the belt (2, 1, 1) [rad]."""


@final
@dataclass(frozen=True)
class Stream:
    """M objects on each of N belts, in the order of their arrival (N, M)."""

    objects: Objects
    x: Floats
    """Position along the belt when the shift begins; x 0 is the base of a robot at 0 [m]."""
    worth: Floats
    """Value in a bin that takes the object."""
    luck: Floats
    """Uniform draws that decide the results of throws by the table."""


def redraw(draws: Floats, attempt: Ints) -> Floats:
    """Uniform draws for later attempts; draws of 1, which stand for attempts that never fail, stay 1."""
    redrawn = draws
    for number in range(int(attempt.max(initial=0))):
        redrawn = np.where((attempt > number) & (draws < 1.0), redrawn * STRETCH % 1.0, redrawn)
    return redrawn


@final
@dataclass(frozen=True)
class ComingStream:
    """The stream of a shift that has not begun (1, M), with the states of its generator before and after its draws."""

    stream: Stream
    before: Any
    after: Any


def _overwrite(streams: Stream, rows: Ints, fresh: Stream) -> None:
    """Write some lines' streams, in place."""
    streams.objects.overwrite(rows, fresh.objects)
    streams.x[rows], streams.worth[rows], streams.luck[rows] = fresh.x, fresh.worth, fresh.luck


@final
class StreamSampler:
    """Draws streams of objects.

    Args:
        config: level of the line.
        planner: planner that draws the objects.

    Raises:
        ConfigError: objects come faster than they find room; the methods raise this too.
    """

    def __init__(self, config: LineConfig, planner: PickPlanner) -> None:
        self._config, self._planner = config, planner
        self.length = int(config.objects)
        self._coming: dict[int, ComingStream] = {}
        """Streams that were drawn ahead, by their lines."""

    def empty_streams(self, count: int) -> Stream:
        """Arrays for N streams, filled with an arbitrary stream."""
        return take(self._draw_streams([np.random.default_rng(0)]), np.zeros(count, dtype=np.int64))

    def draw(self, streams: Stream, rows: Ints, generators: Generators, in_place: bool) -> Stream:
        """The streams with newly drawn ones in some rows.

        Args:
            streams: streams of N lines.
            rows: lines with new streams (K,).
            generators: one generator for each of these lines.
            in_place: whether the streams may be overwritten; a copy takes longer than a step of the lines.
        """
        fresh, missing = list[tuple[Ints, Stream]](), list[int]()
        for place, (row, generator) in enumerate(zip(rows, generators, strict=True)):
            stream = self._take_drawn(int(row), generator)
            if stream is None:
                missing.append(place)
            else:
                fresh.append((rows[[place]], stream))
        if missing:
            fresh.append((rows[missing], self._draw_streams([generators[place] for place in missing])))
        if np.array_equal(fresh[0][0], np.arange(len(streams.x))):
            return fresh[0][1]
        streams = streams if in_place else take(streams, np.arange(len(streams.x)))
        for fresh_rows, stream in fresh:
            _overwrite(streams, fresh_rows, stream)
        return streams

    def draw_ahead(self, row: int, generator: np.random.Generator) -> None:
        """Draw the stream that `draw` will give a line for its generator as it is, and leave the generator so."""
        bits = generator.bit_generator
        before = bits.state
        try:
            self._coming[row] = ComingStream(self._draw_streams([generator]), before, bits.state)
        except ConfigError:
            self._coming.pop(row, None)  # `draw` raises the error where the shift does begin
        finally:
            bits.state = before

    def _take_drawn(self, row: int, generator: np.random.Generator) -> Stream | None:
        """The stream that was drawn ahead for a line, if its generator is as it was then; the draws then count."""
        coming = self._coming.pop(row, None)
        if coming is None or generator.bit_generator.state != coming.before:
            return None
        generator.bit_generator.state = coming.after
        return coming.stream

    def _draw_streams(self, generators: Generators) -> Stream:
        """New streams, one from each of K generators (K, M)."""
        config, count = self._config, len(generators)
        gaps, worth, luck = np.empty((3, count, self.length))
        for place, generator in enumerate(generators):
            with move_aside(generator, Purpose.ARRIVAL):
                gaps[place] = generator.gamma(config.arrivals.regularity, size=self.length) / config.arrivals.regularity
                generator.standard_normal(out=worth[place])
                generator.random(out=luck[place])
        objects = self._planner.draw(generators, np.arange(count), self.length)
        distance = config.cell.belt.speed / config.arrivals.rate * np.cumsum(gaps, axis=1)
        x = self._settle(config.reach[1] - distance, objects)
        # An object that gave way may lie upstream of a later object.
        order = np.arange(count)[:, None], np.argsort(-x, axis=1, kind="stable")
        spread = config.value.spread
        # Lognormal factor of mean 1: exp(s z - s^2 / 2).
        factor = np.exp(spread * worth - 0.5 * spread * spread)
        return Stream(
            objects=take(objects, order),
            x=x[order],
            worth=(config.values()[objects.kind] * factor)[order],
            luck=luck[order],
        )

    def _settle(self, arrival_x: Floats, objects: Objects) -> Floats:
        """Positions of objects along the belt after giving way, from their arrivals, both (K, M) [m].

        Raises:
            ConfigError: objects come faster than they find room.
        """
        arrivals, speed = self._config.arrivals, self._config.cell.belt.speed
        along, across = half_extent(objects, _ALONG_AND_ACROSS)
        belts = zip(arrival_x, objects.draws.lane_y, along, across, strict=True)
        try:
            return np.stack([lie.separate(*belt, arrivals.gap) for belt in belts])
        except lie.Jam as jam:
            raise ConfigError(
                f"level {self._config.name!r}: arrivals.rate is {arrivals.rate:g} objects a second; with arrivals.gap "
                f"{arrivals.gap:g} m the belt has room for about {jam.room * speed:.3g} a second"
            ) from None
