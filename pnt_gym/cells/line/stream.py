"""Objects that come along N belts in a shift: all drawn when the shift begins, whatever the robots do."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.base.cell import Generators, Purpose, draw_aside
from pnt_gym.cells.conveyor.objects.records import Objects, half_extent
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line import lie
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.rows import Rider
from pnt_gym.errors import ConfigError
from pnt_gym.rows import Rows2, put

_ALONG_AND_ACROSS: Final = np.array([0.0, np.pi / 2])[:, None, None]
"""Headings along and across the belt (2, 1, 1) [rad]."""


class Stream(NamedTuple):
    """M objects on each of N belts, in the order of their arrival (N, M)."""

    objects: Objects
    riders: Rows2[Rider]
    """What decisions and the table of throws need of each object."""

    @classmethod
    def of(cls, objects: Objects, x: Floats, worth: Floats, luck: Floats) -> Self:
        """Stream of objects with their positions when the shift begins [m], values, and draws of their luck."""
        riders = Rider.empty(*x.shape)
        riders["x"], riders["worth"], riders["luck"] = x, worth, luck
        riders["lane_y"], riders["known_depth"] = objects.draws.lane_y, objects.known_depth
        riders["height"], riders["measured_height"] = objects.size[..., 2], objects.measured.size[..., 2]
        riders["kind"], riders["seen"], riders["seal"] = objects.kind, objects.measured.kind, objects.pick_draw
        return cls(objects, riders)

    @property
    def x(self) -> Floats:
        """Positions along the belt when the shift begins (N, M) [m]."""
        return self.riders["x"]

    def write(self, lines: Ints, streams: Stream) -> None:
        """Write the streams of some lines, in place."""
        self.objects.put(lines, streams.objects)
        put(self.riders, lines, streams.riders)


@final
@dataclass(frozen=True)
class ComingStream:
    """The stream of a shift that has not begun (1, M), with the states of its generator before and after its draws."""

    stream: Stream
    before: Any
    after: Any


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

    def empty(self, count: int) -> Stream:
        """Arrays for N streams, filled with an arbitrary stream."""
        objects, riders = self._draw([np.random.default_rng(0)])
        first = np.zeros(count, dtype=np.int64)
        return Stream(take(objects, first), take(riders, first))

    def draw(self, streams: Stream, rows: Ints, generators: Generators) -> None:
        """Write newly drawn streams of some lines, in place.

        Args:
            streams: streams of N lines.
            rows: lines with new streams (K,).
            generators: one generator for each of these lines.
        """
        missing = list[int]()
        for place, (row, generator) in enumerate(zip(rows, generators, strict=True)):
            # The draws that were made ahead count if the generator is as it was then.
            coming = self._coming.pop(int(row), None)
            if coming is None or generator.bit_generator.state != coming.before:
                missing.append(place)
            else:
                generator.bit_generator.state = coming.after
                streams.write(rows[[place]], coming.stream)
        if missing:
            streams.write(rows[missing], self._draw([generators[place] for place in missing]))

    def draw_ahead(self, row: int, generator: np.random.Generator) -> None:
        """Draw the stream that `draw` will give a line for its generator as it is, and leave the generator so."""
        bits = generator.bit_generator
        before = bits.state
        try:
            self._coming[row] = ComingStream(self._draw([generator]), before, bits.state)
        except ConfigError:
            self._coming.pop(row, None)  # `draw` raises the error where the shift does begin
        finally:
            bits.state = before

    def _draw(self, generators: Generators) -> Stream:
        """New streams, one from each of K generators (K, M)."""
        config, count = self._config, len(generators)
        gaps, worth, luck = draws = np.empty((3, count, self.length))
        for place, generator in enumerate(generators):
            draw_aside(generator, (Purpose.ARRIVAL, partial(self._fill_arrivals, draws[:, place])))
        objects = self._planner.draw(generators, np.arange(count), self.length)
        distance = config.cell.belt.speed / config.arrivals.rate * np.cumsum(gaps, axis=1)
        x = self._settle(config.reach[1] - distance, objects)
        # An object that gave way may lie upstream of a later object.
        order = np.arange(count)[:, None], np.argsort(-x, axis=1, kind="stable")
        spread = config.value.spread
        # Lognormal factor of mean 1: exp(s z - s^2 / 2).
        factor = np.exp(spread * worth - 0.5 * spread * spread)
        worth = config.values()[objects.kind] * factor
        return Stream.of(take(objects, order), x[order], worth[order], luck[order])

    def _fill_arrivals(self, draws: Floats, generator: np.random.Generator) -> None:
        """Fill draws (3, M) of a line: gaps over their mean, standard normal draws of values, and draws of luck."""
        regularity = self._config.arrivals.regularity
        draws[0] = generator.gamma(regularity, size=self.length) / regularity
        generator.standard_normal(out=draws[1])
        generator.random(out=draws[2])

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
