"""The objects the cell picks and throws: size, mass, drag, seal and contact, one line of origin each.

The paper's three objects and a catalogue of household waste. No weighing and no wind tunnel stands behind
most of the numbers; an item says what is assumed and why it is plausible. Levels draw from a set of names
(`PAPER_ITEMS`, `SEEN_ITEMS`, `HELD_OUT_ITEMS`) and index the stacked arrays of `item_arrays`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Final, Literal, NamedTuple, Self, TypeVar, final, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, ConfigDict, Field, StringConstraints, model_validator

from pnt_gym.planning.arrays import Bools, Floats, Ints

Shape = Literal["ellipsoid", "cylinder", "box"]
SHAPES: Final[tuple[Shape, ...]] = get_args(Shape)
ELLIPSOID, CYLINDER, BOX = range(len(SHAPES))

_Scalar = TypeVar("_Scalar", bound=np.generic)
_GRAVITY = 9.81  # m/s2

_Extent = Annotated[float, Field(gt=0.0, le=1.0)]
_Line = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, pattern=r"^[^\n\r]*$")]


def shape_index(shape: str) -> int:
    """Index of a shape in `SHAPES`: 0 ellipsoid, 1 cylinder, 2 box.

    Raises:
        ValueError: the shape is none of these.
    """
    for index, known in enumerate(SHAPES):
        if shape == known:
            return index
    raise ValueError(f"shape {shape!r} is not one of {', '.join(SHAPES)}.")


@final
class Item(BaseModel):
    """One kind of object as it lies on the belt, SI units.

    Attributes:
        name: key in the catalogue.
        shape: body of the same extents used for contact and drag.
        size: full extents (L, W, H) in m, H vertical; a cylinder lies with its axis along L and has W = H.
        mass: kg, empty and dry.
        drag: drag coefficient Cd on the area facing the flow.
        com_depth: depth of the centre of mass below the top, as a share of the height.
        seal_force: holding force F0 of the suction cup on this surface in N; greater than the weight.
        container: it may carry a residue.
        friction: sliding friction coefficient.
        rolling_friction: longest arm in m at which a contact can oppose rolling (MuJoCo's rolling friction).
        restitution: rebound speed over impact speed, 0 to 1.
        source: one line: where the numbers come from, or what is assumed and why.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$")]
    shape: Shape
    size: tuple[_Extent, _Extent, _Extent]
    mass: float = Field(gt=0.0, le=5.0)
    drag: float = Field(gt=0.0, le=3.0)
    com_depth: float = Field(default=0.5, gt=0.0, lt=1.0)
    seal_force: float = Field(gt=0.0, le=200.0)
    container: bool = False
    friction: float = Field(gt=0.0, le=2.0)
    rolling_friction: float = Field(gt=0.0, le=0.1)
    restitution: float = Field(ge=0.0, le=1.0)
    source: _Line

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        _, width, height = self.size
        if self.shape == "cylinder" and width != height:
            raise ValueError(f"cylinder {self.name!r} needs one diameter, but W = {width} m and H = {height} m.")
        weight = self.mass * _GRAVITY
        if self.seal_force <= weight:
            held = f"seal_force of {self.name!r} is {self.seal_force} N"
            raise ValueError(f"{held}, but must exceed its weight of {weight:.3f} N.")
        return self


@final
class _Material(NamedTuple):
    friction: float
    restitution: float
    source: str


# Serway & Jewett, "Physics for Scientists and Engineers", table of friction coefficients: kinetic, on steel.
_MATERIALS: Final = {
    "paper": _Material(0.50, 0.25, "friction and restitution assumed: paper slips near 27 deg, crumples on impact"),
    "board": _Material(0.50, 0.25, "friction and restitution assumed: paperboard slips near 27 deg, walls buckle"),
    "aluminium": _Material(0.47, 0.35, "friction 0.47 (Serway & Jewett); restitution assumed: a thin wall dents"),
    "foil": _Material(0.47, 0.15, "friction 0.47 (Serway & Jewett); restitution assumed: foil stays deformed"),
    "steel": _Material(0.57, 0.40, "friction 0.57 (Serway & Jewett); restitution assumed: stiff, rings, dents little"),
    "pp": _Material(0.40, 0.40, "friction and restitution assumed: inside 0.35-0.50 usual for PP and PE"),
    "pet": _Material(0.35, 0.40, "friction and restitution assumed: PET is smoother than PP, its wall springs back"),
    "cork": _Material(0.60, 0.50, "friction and restitution assumed: soft and elastic, grips a belt"),
}

# Assumed: half a facet of a crumpled ball, a dent or rim of a cylinder; a box stands on its faces.
_ROLLING_FRICTION: Final[Mapping[Shape, float]] = {"ellipsoid": 6e-3, "cylinder": 2e-3, "box": 1e-4}


def _item(
    name: str,
    shape: Shape,
    size: tuple[float, float, float],
    mass: float,
    drag: float,
    *,
    seal: float,
    of: str,
    source: str,
    com: float = 0.5,
    container: bool = False,
) -> Item:
    material = _MATERIALS[of]
    return Item(
        name=name,
        shape=shape,
        size=size,
        mass=mass,
        drag=drag,
        com_depth=com,
        seal_force=seal,
        container=container,
        friction=material.friction,
        rolling_friction=_ROLLING_FRICTION[shape],
        restitution=material.restitution,
        source=f"{source}; {material.source}",
    )


# Drag: the Aeronautical Engineer's Data Book lists 0.68-0.74 for a cylinder across the flow (l/d 2 to 5),
# 0.85-0.91 along it and 1.17 for a square plate; ends, labels and dents put the cylinders at the upper end.
# Seals: a porous or crumpled face leaks and holds a few newtons, a smooth wall up to 20 N.
_PAPER = (
    _item("paper", "ellipsoid", (0.090, 0.090, 0.085), 0.0070, 0.55, seal=4.0, of="paper",
          source="mass: Hassan et al. 2022; rest assumed: 1.4 sheets of A4 in a loose ball, leaking"),
    _item("metal_can", "cylinder", (0.115, 0.066, 0.066), 0.0160, 0.80, seal=18.0, of="aluminium",
          source="mass: Hassan et al. 2022; size: 330 ml can; drag, F0 assumed: cylinder, smooth wall"),
    _item("plastic_package", "box", (0.150, 0.100, 0.050), 0.0490, 1.05, seal=16.0, of="pp",
          source="mass: Hassan et al. 2022; rest assumed: 0.055 m2 of 1 mm PP weigh 49 g, smooth flat lid"),
)  # fmt: skip

_SEEN = (
    _item("paper_ball", "ellipsoid", (0.080, 0.080, 0.075), 0.0050, 0.55, seal=4.0, of="paper",
          source="mass: A4 at 80 g/m2 (arithmetic); rest assumed: rough, so above a sphere's 0.47, leaking"),
    _item("can", "cylinder", (0.115, 0.066, 0.066), 0.0135, 0.80, seal=18.0, of="aluminium", container=True,
          source="mass: 13-15 g (packaging.world-aluminium.org, mjpackages.com); others assumed"),
    _item("can_crushed", "box", (0.095, 0.075, 0.035), 0.0135, 1.00, seal=10.0, of="aluminium",
          source="mass: that of the can; size, drag, F0 assumed: the can stamped flat, creases leak"),
    _item("pet_05", "cylinder", (0.205, 0.065, 0.065), 0.0220, 0.80, seal=16.0, of="pet", com=0.52,
          container=True, source="all assumed: a 0.5 l bottle, rounded ends, smooth but yielding wall"),
    _item("pet_crushed", "box", (0.190, 0.085, 0.045), 0.0300, 1.00, seal=12.0, of="pet", com=0.55,
          container=True, source="all assumed: a larger bottle pressed flat, heavier at the cap, creased"),
    _item("yoghurt_cup", "cylinder", (0.080, 0.070, 0.070), 0.0060, 0.85, seal=14.0, of="pp",
          container=True, source="all assumed: a 150-180 g cup, open end adds drag, thin smooth wall"),
    _item("tetra_1l", "box", (0.195, 0.070, 0.070), 0.0310, 1.05, seal=14.0, of="board", com=0.52,
          container=True, source="all assumed: a 1 l drink carton, sharp edges, coated board"),
    _item("tetra_200", "box", (0.115, 0.060, 0.040), 0.0095, 1.05, seal=12.0, of="board", com=0.52,
          container=True, source="all assumed: a 200 ml drink carton, sharp edges, coated board"),
    _item("carton", "box", (0.125, 0.085, 0.030), 0.0240, 1.10, seal=7.0, of="board",
          source="all assumed: a folded board box, near a flat plate, uncoated and leaking"),
    _item("jar_lid", "box", (0.070, 0.070, 0.012), 0.0110, 1.10, seal=18.0, of="steel", com=0.40,
          source="all assumed: a twist-off lid, near a flat plate, painted and tight, mass on top"),
    _item("cap", "cylinder", (0.052, 0.0425, 0.0425), 0.0090, 0.85, seal=14.0, of="pp", com=0.45,
          source="all assumed: a detergent cap, 45 x 40 mm across taken as their mean 42.5 mm"),
    _item("cork", "cylinder", (0.045, 0.024, 0.024), 0.0040, 0.80, seal=3.5, of="cork",
          source="all assumed: a wine cork, 20 cm3 at 0.2 g/cm3, small porous face"),
    _item("foil_ball", "ellipsoid", (0.048, 0.045, 0.042), 0.0060, 0.50, seal=4.5, of="foil",
          source="all assumed: about 0.15 m2 of 15 um foil pressed by hand, smoother than paper, leaks"),
    _item("tray", "box", (0.140, 0.105, 0.035), 0.0170, 1.15, seal=14.0, of="pet", com=0.40,
          source="all assumed: a food tray upside down, near a flat plate, mass in the floor"),
    _item("steel_tin", "cylinder", (0.108, 0.073, 0.073), 0.0520, 0.85, seal=20.0, of="steel",
          container=True, source="all assumed: a 400 g food tin, beads and open end, stiff smooth wall"),
)  # fmt: skip

_HELD_OUT = (
    _item("detergent", "box", (0.215, 0.090, 0.060), 0.0550, 1.00, seal=16.0, of="pp", com=0.58,
          container=True, source="all assumed: a 0.75 l bottle with rounded edges, thick base, smooth wall"),
    _item("coffee_cup", "cylinder", (0.095, 0.078, 0.078), 0.0095, 0.85, seal=9.0, of="board",
          container=True, source="all assumed: a 250 ml paper cup at its mean diameter, open end, coated"),
    _item("egg_box", "box", (0.150, 0.100, 0.060), 0.0220, 1.10, seal=5.0, of="board",
          source="all assumed: moulded pulp for six eggs, knobbly and porous"),
    _item("shampoo", "box", (0.185, 0.065, 0.042), 0.0310, 1.00, seal=16.0, of="pp", com=0.56,
          container=True, source="all assumed: a 250 ml bottle with rounded edges, thick base, smooth wall"),
    _item("foil_tray", "box", (0.120, 0.095, 0.035), 0.0110, 1.15, seal=10.0, of="foil", com=0.45,
          source="all assumed: a takeaway tray upside down, near a flat plate, ribbed floor"),
    _item("napkin_ball", "ellipsoid", (0.065, 0.062, 0.058), 0.0035, 0.60, seal=3.0, of="paper",
          source="all assumed: a two-ply napkin, rougher and more porous than paper"),
)  # fmt: skip

CATALOGUE: Final[Mapping[str, Item]] = MappingProxyType({i.name: i for i in (*_PAPER, *_SEEN, *_HELD_OUT)})
PAPER_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _PAPER)
SEEN_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _SEEN)
HELD_OUT_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _HELD_OUT)


@final
@dataclass(frozen=True)
class ItemTable:
    """K items as read-only arrays, to be drawn from by index; the meaning of a column is that of `Item`.

    Attributes:
        names: K names.
        shape: (K,) index in `SHAPES`.
        size: (K, 3) m.
        mass: (K,) kg.
        drag: (K,).
        com_depth: (K,) share of the height.
        seal_force: (K,) N.
        container: (K,) bool.
        friction: (K,).
        rolling_friction: (K,) m.
        restitution: (K,).
    """

    names: tuple[str, ...]
    shape: Ints
    size: Floats
    mass: Floats
    drag: Floats
    com_depth: Floats
    seal_force: Floats
    container: Bools
    friction: Floats
    rolling_friction: Floats
    restitution: Floats

    def __len__(self) -> int:
        return len(self.names)


def item_arrays(items: Sequence[Item]) -> ItemTable:
    """Stack items into arrays, in the order given.

    Args:
        items: K >= 1 items; an item may occur twice.

    Returns:
        Read-only arrays with K rows.

    Raises:
        ValueError: no items.
    """
    if len(items) == 0:
        raise ValueError("0 items given, but a table needs at least 1.")

    def column(values: Sequence[object]) -> Floats:
        return _read_only(np.array(values, dtype=np.float64))

    return ItemTable(
        names=tuple(i.name for i in items),
        shape=_read_only(np.array([shape_index(i.shape) for i in items], dtype=np.int64)),
        size=column([i.size for i in items]),
        mass=column([i.mass for i in items]),
        drag=column([i.drag for i in items]),
        com_depth=column([i.com_depth for i in items]),
        seal_force=column([i.seal_force for i in items]),
        container=_read_only(np.array([i.container for i in items], dtype=np.bool_)),
        friction=column([i.friction for i in items]),
        rolling_friction=column([i.rolling_friction for i in items]),
        restitution=column([i.restitution for i in items]),
    )


def _read_only(array: NDArray[_Scalar]) -> NDArray[_Scalar]:
    array.flags.writeable = False
    return array


_DEAD_TIME_CONSTANT = 0.003  # s, MuJoCo solref of a contact meant not to bounce
_LEAST_BOUNCE = float(np.exp(-2.0))  # rebound of a critically damped contact that cannot pull
_LEAST_DAMPING = 0.005  # keeps the time constant finite at restitution 1
# Damping ratio cos(phi) against rebound exp(-2 phi / tan(phi)), phi from 0 (critical) to pi/2 (none).
_PHI = np.linspace(0.0, np.pi / 2.0, 4097)
_BOUNCE = np.concatenate([[_LEAST_BOUNCE], np.exp(-2.0 * _PHI[1:] / np.tan(_PHI[1:]))])


def contact_solref(restitution: ArrayLike) -> Floats:
    """MuJoCo `solref` (time constant, damping ratio) of a contact that rebounds with the given restitution.

    A contact is a spring and damper with damping ratio zeta = cos(phi) that pushes but never pulls, so the
    body leaves when the force, not the depth, is back at zero. That makes e = exp(-2 phi / tan(phi))
    (Schwager and Poeschel 2007, "Coefficient of restitution and linear-dashpot model revisited"), while the
    more familiar exp(-pi zeta / sqrt(1 - zeta^2)) would rebound up to 0.15 too high. The stiffness rises with
    sqrt(e) so that every impact goes as deep as the critically damped one, 1.1 mm per m/s: even a 12 mm plate
    does not pass a 10 mm wall at 9 m/s. Half a period lasts 3.4 ms or more. Damping cannot bring the rebound
    below exp(-2), which is 0.135: up to there the result is (0.003, 1). At restitution 1 the damping ratio is
    0.005.

    MuJoCo averages the solref of two geoms of equal priority: give the item's geom the higher priority.

    Args:
        restitution: (...) rebound speed over impact speed, 0 to 1.

    Returns:
        (..., 2) time constant in s and damping ratio.

    Raises:
        ValueError: a restitution is outside 0 to 1 or not a number.
    """
    e = np.asarray(restitution, dtype=np.float64)
    if not np.all((e >= 0.0) & (e <= 1.0)):
        bad = e[~((e >= 0.0) & (e <= 1.0))].flat[0]
        raise ValueError(f"restitution is {bad}, but must be from 0 to 1.")
    damping = np.maximum(np.cos(np.interp(e, _BOUNCE, _PHI)), _LEAST_DAMPING)
    stiffening = np.sqrt(np.maximum(e, _LEAST_BOUNCE) / _LEAST_BOUNCE)
    return np.stack([_DEAD_TIME_CONSTANT / (damping * stiffening), damping], axis=-1)
