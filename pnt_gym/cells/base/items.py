"""Items: size, mass, drag, seal, grip and contact of each kind of object; and tables of items as arrays."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, Literal, NamedTuple, Self, TypeAlias, TypeVar, final, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, ConfigDict, Field, StringConstraints, model_validator
from pydantic_core import PydanticCustomError

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.config import LONGEST_NAME, Section
from pnt_gym.cells.base.zones import MOST_ZONES, PLAIN_LOOK, Look, Waves, Zone
from pnt_gym.constants import GRAVITY
from pnt_gym.errors import ConfigError
from pnt_gym.names import unknown_name

Shape = Literal["ellipsoid", "cylinder", "box"]
SHAPES: Final[tuple[Shape, ...]] = get_args(Shape)
ELLIPSOID, CYLINDER, BOX = range(len(SHAPES))

CUP_RADIUS: Final = 0.018
"""Bellows suction cup for light waste, 36 mm wide [m]."""
Surface: TypeAlias = Literal["smooth", "rough", "wet"]


class Contact(NamedTuple):
    """Constants of the contact between a cup's lip and a surface."""

    friction: float
    safety: float
    """Smallest factor by which a holding force should be divided."""


SURFACES: Final[dict[str, Contact]] = {
    "smooth": Contact(0.5, 1.5),
    "rough": Contact(0.6, 2.0),
    "wet": Contact(0.25, 2.0),
}
"""Schmalz, same source: friction 0.5 on wood, metal, glass and stone, 0.6 on rough, 0.2 to 0.3 on wet ones; safety at
least 1.5 on smooth and dense workpieces, 2 on others."""

_Scalar = TypeVar("_Scalar", bound=np.generic)

_Extent = Annotated[float, Field(gt=0.0, le=1.0)]
_CUP_SHARE: Final = 0.8
"""Width of a suction cup over the width of its item, where the item is too small for the standard cup."""
_Line = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, pattern=r"^[^\n\r]*$")]


def _check_item_name(name: str) -> str:
    """Return the name of an item, after refusing names that are no key.

    Raises:
        PydanticCustomError: the name has other characters.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise PydanticCustomError(
            "item_name", "it must begin with a small letter, and hold small letters, digits and _"
        )
    return name


def shape_index(shape: str) -> int:
    """Index of a shape in `SHAPES`: 0 ellipsoid, 1 cylinder, 2 box.

    Raises:
        ConfigError: the shape is none of these.
    """
    for index, name in enumerate(SHAPES):
        if shape == name:
            return index
    raise ConfigError(unknown_name("shape", shape, SHAPES))


@final
class Item(Section):
    """One kind of object as it lies on the belt, SI units.

    Attributes:
        name: key in the catalogue.
        shape: body of the same extents used for contact and drag.
        size: full extents (L, W, H) in m, H vertical; a cylinder lies with its axis along L and has W = H.
        mass: mass in kg, empty and dry.
        drag: drag coefficient Cd on the area facing the flow.
        com_depth: depth of the centre of mass below the top, as a share of the height.
        seal_force: holding force F0 of the suction cup on this surface in N, greater than the weight; None where no cup
            holds the item.
        residue: mean residue of content in the item, in masses of the empty item.
        friction: sliding friction coefficient.
        rolling_friction: longest arm in m at which a contact can oppose rolling (MuJoCo's rolling friction).
        restitution: rebound speed over impact speed, 0 to 1.
        upright: whether claws grip the item with its first axis vertical instead of across the claws.
        pad_friction: friction against the pads of claws; None: the same as `friction`.
        opening_delay: delay of the claws' opening while they hold the item, at m = 1, in s.
        oversize: share by which the item is larger than the planner of the claws takes it to be, at m = 1.
        cup_radius: radius in m of the suction cup for this item; the cup must not be wider than the item. None:
            0.018, or four fifths of half the item's width where that is less.
        pick_chance: probability that a suction cup seals well inside the item's outline, in levels in which picks fail.
        clings: delay with which a wet or sticky face leaves the suction cup after the vacuum's release, at m = 1, in s.
        surface: surface under a suction cup; gives the friction and the safety factor of a grip, see `SURFACES`.
        zones: parts of the upper face that differ from the rest, at most 6; where they overlap, the later one counts.
        relief: amplitude and wavelength in m of bumps all over the item; None: the surface is smooth.
        look: brightness, warmth (-1 blue to 1 orange), gloss and texture of the surface in a picture.
        com: distance of the centre of mass from the middle along the length, towards either end, as a share of the
            length, in levels in which objects have surfaces.
        source: one line: the sources of the numbers, and which numbers are assumed, and why.
        assumed: keys that a level did not give, whose values are those of the shape or of a similar item.
    """

    model_config = ConfigDict(allow_inf_nan=False)
    former: ClassVar[Mapping[str, str]] = {"container": "give the mean `residue` of the item instead"}

    name: Annotated[str, StringConstraints(max_length=LONGEST_NAME), AfterValidator(_check_item_name)]
    shape: Shape
    size: tuple[_Extent, _Extent, _Extent] = Field(json_schema_extra={"unit": "m"})
    mass: float = Field(gt=0.0, le=5.0, json_schema_extra={"unit": "kg"})
    drag: float = Field(gt=0.0, le=3.0)
    com_depth: float = Field(default=0.5, gt=0.0, lt=1.0)
    seal_force: float | None = Field(default=None, gt=0.0, le=200.0)
    residue: float = Field(default=0.0, ge=0.0, le=10.0)
    friction: float = Field(gt=0.0, le=2.0)
    rolling_friction: float = Field(gt=0.0, le=0.1)
    restitution: float = Field(ge=0.0, le=1.0)
    upright: bool = False
    pad_friction: float | None = Field(default=None, gt=0.0, le=2.0)
    opening_delay: float = Field(default=0.0, ge=0.0, le=1.0)
    oversize: float = Field(default=0.0, gt=-0.5, le=1.0)
    cup_radius: float | None = Field(default=None, gt=0.0, le=0.1)
    pick_chance: float = Field(default=0.9, gt=0.0, le=1.0)
    clings: float = Field(default=0.0, ge=0.0, le=0.05)
    surface: Surface = "smooth"
    zones: tuple[Zone, ...] = Field(default=(), max_length=MOST_ZONES)
    relief: Waves | None = None
    look: Look = PLAIN_LOOK
    com: float = Field(default=0.0, ge=0.0, le=0.4)
    source: _Line
    assumed: tuple[str, ...] = ()

    @property
    def height(self) -> float:
        """Vertical extent of the item between claws [m]."""
        return self.size[0] if self.upright else self.size[2]

    @property
    def width(self) -> float:
        """Smaller extent in top view [m]."""
        return min(self.size[:2])

    @property
    def fitted_radius(self) -> float:
        """Radius of the suction cup for this item [m]."""
        return min(CUP_RADIUS, _CUP_SHARE * self.width / 2.0) if self.cup_radius is None else self.cup_radius

    @model_validator(mode="after")
    def _check(self) -> Self:
        _, width, height = self.size
        if self.shape == "cylinder" and width != height:
            raise ConfigError(f"cylinder {self.name!r} needs one diameter, but W = {width} m and H = {height} m.")
        weight = self.mass * GRAVITY
        if self.seal_force is not None and self.seal_force <= weight:
            origin = ", assumed" if "seal_force" in self.assumed else ""
            value_text = f"seal_force of {self.name!r} is {self.seal_force} N{origin}"
            raise ConfigError(f"{value_text}, but must exceed its weight of {weight:.3f} N.")
        if 2.0 * self.fitted_radius > self.width:
            cup, item = (f"{1e3 * wide:g} mm" for wide in (2.0 * self.fitted_radius, self.width))
            value_text = f"cup_radius of {self.name!r} is {self.cup_radius} m"
            raise ConfigError(f"{value_text}, but its cup, {cup} wide, must not be wider than the item, {item} across.")
        if self.zones and (depth := max(zone.depth for zone in self.zones)) >= height:
            value_text = f"depth of a zone of {self.name!r} is {depth} m"
            raise ConfigError(f"{value_text}, but must be from -0.02 m to less than the item's height of {height} m.")
        return self


@final
@dataclass(frozen=True)
class ItemTable:
    """K items as read-only arrays, from which cells draw by index; `Item` explains the columns.

    Attributes:
        names: K names.
        shape: (K,) index in `SHAPES`.
        size: (K, 3) m.
        mass: (K,) kg.
        drag: (K,).
        com_depth: (K,) share of the height.
        seal_force: (K,) N; NaN where no cup holds the item.
        residue: (K,) mean content over the mass of the empty item.
        friction: (K,).
        rolling_friction: (K,) m.
        restitution: (K,) rebound speed over impact speed.
        cup_friction: (K,) friction against a suction cup's lip.
        cup_radius: (K,) m, radius of the suction cup for the item.
        safety: (K,) safety factor of a suction cup's grip, see `SURFACES`.
        pick_chance: (K,) probability that a suction cup seals.
        clings: (K,) s, delay of leaving a suction cup.
    """

    names: tuple[str, ...]
    shape: Ints
    size: Floats
    mass: Floats
    drag: Floats
    com_depth: Floats
    seal_force: Floats
    residue: Floats
    friction: Floats
    rolling_friction: Floats
    restitution: Floats
    cup_friction: Floats
    cup_radius: Floats
    safety: Floats
    pick_chance: Floats
    clings: Floats


def item_arrays(items: Sequence[Item]) -> ItemTable:
    """Stack items into arrays, in the order given.

    Args:
        items: K >= 1 items; an item may occur twice.

    Returns:
        Read-only arrays with K rows.

    Raises:
        ConfigError: no items.
    """
    if len(items) == 0:
        raise ConfigError("0 items given, but a table needs at least 1.")

    plain = (
        "size", "mass", "drag", "com_depth", "seal_force", "residue", "friction", "rolling_friction", "restitution",
        "pick_chance", "clings",
    )  # fmt: skip
    columns = {name: _read_only(np.array([getattr(i, name) for i in items], dtype=np.float64)) for name in plain}
    return ItemTable(
        names=tuple(i.name for i in items),
        shape=_read_only(np.array([shape_index(i.shape) for i in items], dtype=np.int64)),
        cup_radius=_read_only(np.array([i.fitted_radius for i in items])),
        cup_friction=_read_only(np.array([SURFACES[i.surface].friction for i in items])),
        safety=_read_only(np.array([SURFACES[i.surface].safety for i in items])),
        **columns,
    )


def _read_only(array: NDArray[_Scalar]) -> NDArray[_Scalar]:
    array.flags.writeable = False
    return array
