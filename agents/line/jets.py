"""Arm against jet: what air jets or plain diverters would make of a line's stream of objects.

Both eject one fraction a station, to one side, and whatever lies in the blown or pushed window goes along: the model of
co-deflection by the proximity of particles (Udoudo 2010, University of Exeter). docs/line.md has the equations and all
assumptions. Objects are as the line's camera classifies them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, NamedTuple, Protocol, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.conveyor.objects.records import half_extent
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.stream import Stream

AIR_DENSITY: Final = 1.204
"""Density of air at 20 degrees C and 1.013 bar [kg/m3]."""
AMBIENT: Final = 1.013e5
"""Ambient pressure [Pa]."""
MOST_OBJECTS: Final = 2000
"""Objects of each stream that are sorted at most: pairs of objects are compared."""


class Station(Protocol):
    """A station that ejects some objects of a stream to one side."""

    @property
    def speed(self) -> float | None:
        """Speed of the station's belt; None for the line's own [m/s]."""
        ...

    def window(self, speed: float) -> tuple[float, float]:
        """What is ejected beyond an object's outline, along and across the belt, both sides together [m]."""
        ...

    def moves(self, objects: Outlines, speed: float) -> Bools:
        """Whether the station can eject each object (N,)."""
        ...

    def energy(self, objects: Outlines, speed: float) -> Floats:
        """Energy of ejecting each object (N,) [J]; NaN where the model has none."""
        ...


class Outlines(NamedTuple):
    """N objects on a belt, as rectangles."""

    x: Floats
    """Position along the belt (N,) [m]."""
    y: Floats
    """Position across the belt (N,) [m]."""
    length: Floats
    """Extent along the belt (N,) [m]."""
    width: Floats
    """Extent across the belt (N,) [m]."""
    mass: Floats
    """Mass (N,) [kg]."""


@final
@dataclass(frozen=True)
class AirJets:
    """A bar of nozzles behind the end of an acceleration belt."""

    speed: float = 3.0
    """Speed of the acceleration belt; plants run 2.2 to 3.7 (Ecoembes, guide to sorting plants, p. 117) [m/s]."""
    pitch: float = 0.025
    """Distance of the nozzles; assumed [m]."""
    nozzle: float = 0.003
    """Diameter of a nozzle; assumed [m]."""
    pressure: float = 7.0e5
    """Absolute pressure before the nozzles; assumed [Pa]."""
    lag: float = 0.010
    """Time that a valve is open beyond the passing of the object; assumed [s]."""
    distance: float = 0.05
    """Distance of the objects from the nozzles; assumed [m]."""
    splitter: tuple[float, float] = (0.35, 0.15)
    """Distance of the splitter behind the nozzles, and the deflection that clears it; assumed [m]."""
    compressor: float = 4.0e5
    """Energy of a cubic metre of air at ambient pressure: 0.11 kWh, usual for screw compressors at 7 bar [J/m3]."""

    @property
    def area(self) -> float:
        """Cross-section of a nozzle [m2]."""
        return np.pi / 4.0 * self.nozzle**2

    @property
    def thrust(self) -> float:
        """Thrust of a choked converging nozzle: A (1.268 p0 - pa), for air with a ratio of heats of 1.4 [N]."""
        return self.area * (1.268 * self.pressure - AMBIENT)

    @property
    def flow(self) -> float:
        """Mass flow of a choked nozzle: 0.0404 A p0 / sqrt(T0), at 293 K [kg/s]."""
        return 0.0404 * self.area * self.pressure / np.sqrt(293.0)

    @property
    def radius(self) -> float:
        """Radius of a free jet that holds 95 % of its momentum: 1.22 x 0.107 z (Fischer et al. 1979) [m]."""
        return 1.22 * 0.107 * self.distance

    def window(self, speed: float) -> tuple[float, float]:
        """Travel during the valve's lag; a nozzle's pitch, since nozzles do not lie where objects do, and two radii."""
        return speed * self.lag, self.pitch + 2.0 * self.radius

    def limit(self, objects: Outlines, speed: float) -> Floats:
        """Largest mass that clears the splitter: n F (l / v) / u with u = D v / d (N,) [kg]."""
        nozzles = np.maximum(np.floor(objects.width / self.pitch), 1.0)
        distance, deflection = self.splitter
        return nozzles * self.thrust * objects.length / speed / (deflection * speed / distance)

    def moves(self, objects: Outlines, speed: float) -> Bools:
        """Whether each object is light enough (N,)."""
        return objects.mass <= self.limit(objects, speed)

    def energy(self, objects: Outlines, speed: float) -> Floats:
        """Energy of the compressed air for each object (N,) [J]."""
        nozzles = objects.width / self.pitch + 1.0
        return nozzles * self.flow / AIR_DENSITY * (objects.length / speed + self.lag) * self.compressor


@final
@dataclass(frozen=True)
class Diverter:
    """A flap or pusher across the whole belt."""

    stroke: float = 0.3
    """Time from the start of a stroke until the flap is back; assumed [s]."""
    speed: float | None = None

    def window(self, speed: float) -> tuple[float, float]:
        """Travel during the stroke; the whole width of the belt."""
        return speed * self.stroke, np.inf

    def moves(self, objects: Outlines, speed: float) -> Bools:
        """Every object is light enough for a flap (N,)."""
        del speed
        return np.ones(len(objects.x), dtype=np.bool_)

    def energy(self, objects: Outlines, speed: float) -> Floats:
        """Unknown (N,)."""
        del speed
        return np.full(len(objects.x), np.nan)


def ejected(station: Station, objects: Outlines, targets: Bools, speed: float) -> Bools:
    """Objects that a station ejects (N,): the targets, and what lies in their windows, if light enough."""
    along, across = station.window(speed)
    centres = Outlines(*(column[targets & station.moves(objects, speed)] for column in objects))
    near_x = np.abs(objects.x[:, None] - centres.x) < (objects.length[:, None] + centres.length + along) / 2.0
    near_y = np.abs(objects.y[:, None] - centres.y) < (objects.width[:, None] + centres.width + across) / 2.0
    return (near_x & near_y).any(axis=1) & station.moves(objects, speed)


def fractions_of(config: LineConfig) -> Ints:
    """Index of each item's fraction (K,): items that the same bins accept are one fraction."""
    cells = config.cells()
    bins = [
        tuple(sorted({bin_.name for cell in cells for bin_ in cell.bins.fixed if bin_.takes(item)}))
        for item in config.cell.items
    ]
    names = list(dict.fromkeys(bins))
    return np.array([names.index(name) for name in bins])


class StationResult(NamedTuple):
    """What stations in series make of a stream."""

    sorted_share: float
    """Share of the objects in the right fraction."""
    energy: float
    """Energy for each of them [J]; NaN where the model has none."""
    stations: int
    """Number of stations."""


def sort_stream(station: Station, stream: Stream, config: LineConfig) -> StationResult:
    """Sort streams by stations in series, the rarest fraction first; the commonest one passes all stations."""
    fraction, belt = fractions_of(config), config.cell.belt
    speed = belt.speed if station.speed is None else station.speed
    share = np.bincount(fraction, weights=config.cell.shares())
    order = [int(index) for index in np.argsort(share, kind="stable") if share[index] > 0.0]
    right, total, energy = 0, 0, 0.0
    for row in range(len(stream.x)):
        objects, kind, seen = _outlines(stream, row, speed / belt.speed)
        ends = np.full(len(kind), order[-1])
        riding = np.ones(len(kind), dtype=np.bool_)
        for index in order[:-1]:
            targets = riding & (fraction[seen] == index)
            gone = ejected(station, objects, targets, speed) & riding
            energy += float(station.energy(objects, speed)[targets].sum())
            ends[gone], riding = index, riding & ~gone
        right, total = right + int((ends == fraction[kind]).sum()), total + len(kind)
    return StationResult(right / total, energy / max(right, 1), len(order) - 1)


def _outlines(stream: Stream, row: int, stretch: float) -> tuple[Outlines, Ints, Ints]:
    """Outlines, true items and seen items of a stream's objects, on a belt that spreads them by a factor."""
    count, objects = slice(MOST_OBJECTS), stream.objects
    length, width = 2.0 * half_extent(objects)[row, count], 2.0 * half_extent(objects, np.pi / 2)[row, count]
    x, y, mass = stretch * stream.x[row, count], objects.draws.lane_y[row, count], objects.mass[row, count]
    return Outlines(x, y, length, width, mass), objects.kind[row, count], objects.measured.kind[row, count]


def compare_stations(stream: Stream, config: LineConfig) -> dict[str, Any]:
    """Figures of air jets and of diverters on streams, by the names of the JSON contract."""
    figures: dict[str, Any] = {}
    for name, station in (("jets", AirJets()), ("diverters", Diverter())):
        result = sort_stream(station, stream, config)
        energy = result.energy if np.isfinite(result.energy) else None
        figures[name] = {"sorted": result.sorted_share, "stations": result.stations, "energy_per_sorted_j": energy}
    return figures


def stations_text(figures: dict[str, Any], recovery: float, energy: float | None) -> str:
    """Arm against jet and diverter, in one sentence."""
    jets, flaps = figures["jets"], figures["diverters"]
    if not jets["stations"]:
        return "arm against jet: all objects belong to one fraction, so there is nothing to sort"
    arms = f"the arms sort {100 * recovery:.1f} %" + ("" if energy is None else f" at {energy:.0f} J an object")
    return (
        f"arm against jet: {arms}; {_count(jets['stations'], 'air jet')} in series would sort "
        f"{100 * jets['sorted']:.1f} % at {jets['energy_per_sorted_j']:.0f} J, and "
        f"{_count(flaps['stations'], 'plain diverter')} {100 * flaps['sorted']:.1f} %"
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
