"""Rows of surfaces: of items with their zones, and of objects as compiled functions take them."""

from __future__ import annotations

from typing import Annotated, Any, Final, NamedTuple, final

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.zones import MOST_ZONES
from pnt_gym.rows import Pair, Quadruple, Row, Rows1, Rows2, Triple, field

WAVES: Final = 5
"""Plane waves of a relief."""


@final
class ItemSurface(Row):
    """The surface of an item, as `items.Item` explains."""

    is_real: bool = field("-", "whether the item has a surface; on an item without one every cup seals")
    relief: float = field("m", "amplitude of the relief")
    wavelength: float = field("m", "length of the relief's waves")
    look: Quadruple = field("-", "brightness, warmth, gloss and texture")
    com: float = field("-", "centre of mass from the middle, as a share of the length")


@final
class ItemZone(Row):
    """A zone of an item, as `zones.Zone` explains; -1 where a zone is as the surface around it."""

    shape: int = field("-", "index in `zones.ZONE_SHAPES`; -1 for no zone")
    at: Pair = field("-", "middle, in shares of the item's half extents")
    size: Pair = field("-", "half extents, in shares of the item's half extents")
    chance: float = field("-", "probability that an object has the zone")
    depth: float = field("m", "depth below the surface around the zone")
    leak: float = field("-", "leak over that of the item's own surface")
    relief: float = field("m", "amplitude of the relief")
    ribs: float = field("m", "amplitude of the ribs")
    rib_length: float = field("m", "distance between ribs")
    look: Quadruple = field("-", "brightness, warmth, gloss and texture")
    spread: float = field("-", "largest distance of the middle from `at`, in the same shares")


@final
class SurfaceBody(Row):
    """An object with its surface, in the object's axes."""

    shape: int = field("-", "index in `items.SHAPES`")
    size: Triple = field("m", "full extents")
    yaw: float = field("rad", "yaw")
    count: int = field("-", "number of zones that the object has; -1 where the item has no surface")
    com: Pair = field("m", "centre of mass from the middle of the outline, along the world's axes")
    relief: float = field("m", "amplitude of the relief")
    look: Quadruple = field("-", "brightness, warmth, gloss and texture")
    wave_x: Annotated[Floats, WAVES] = field("rad/m", "wave vectors of the relief along x")
    wave_y: Annotated[Floats, WAVES] = field("rad/m", "wave vectors of the relief along y")
    phase: Annotated[Floats, WAVES] = field("rad", "phases of the relief's waves")


@final
class SurfaceZone(Row):
    """A zone of an object; -1 where a zone is as the surface around it."""

    shape: int = field("-", "index in `zones.ZONE_SHAPES`")
    middle: Pair = field("m", "middle")
    half: Pair = field("m", "half extents")
    depth: float = field("m", "depth below the surface around the zone")
    leak: float = field("-", "leak over that of the item's own surface")
    relief: float = field("m", "amplitude of the relief")
    ribs: float = field("m", "amplitude of the ribs")
    rib_number: float = field("rad/m", "wave number of the ribs")
    look: Quadruple = field("-", "brightness, warmth, gloss and texture")


class SurfaceTable(NamedTuple):
    """Surfaces of K items."""

    items: Rows1[ItemSurface]
    """Relief, look and centre of mass (K,)."""
    zones: Rows2[ItemZone]
    """Zones (K, MOST_ZONES)."""


class Surfaces(NamedTuple):
    """Surfaces of objects; compiled functions take those of N objects."""

    bodies: Rows1[SurfaceBody]
    """The objects, of any leading shape S."""
    zones: Rows2[SurfaceZone]
    """Zones, S + (MOST_ZONES,); the zones that an object has come first."""

    @property
    def com(self) -> Floats:
        """Centres of mass from the middles of the outlines, along the world's axes, S + (2,) [m]."""
        return self.bodies["com"]

    def flat(self) -> Surfaces:
        """The surfaces row after row (N,)."""
        bodies: Any = self.bodies.reshape(-1)
        zones: Any = self.zones.reshape(-1, MOST_ZONES)
        return Surfaces(bodies, zones)
