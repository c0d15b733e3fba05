"""The catalogue of items: the paper's three objects, household waste, and what claws pick, one line of origin each.

No weighing and no wind tunnel stands behind most of the numbers; an item says what is assumed and why it is plausible.
Levels draw from a set of names (`PAPER_ITEMS`, `SEEN_ITEMS`, `HELD_OUT_ITEMS`, `CLAW_ITEMS`) and may add their own.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final, NamedTuple, Self, final

from pydantic import Field, model_validator

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.base.items import Item, Shape


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
    "rubber": _Material(0.80, 0.60, "friction and restitution assumed: rubber grips and springs back"),
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
    of: str,
    source: str,
    seal: float | None = None,
    com: float = 0.5,
    **more: Any,
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
        friction=material.friction,
        rolling_friction=_ROLLING_FRICTION[shape],
        restitution=material.restitution,
        source=f"{source}; {material.source}",
        **more,
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
    _item("paper_ball", "ellipsoid", (0.080, 0.080, 0.075), 0.0050, 0.55, seal=4.0, of="paper", opening_delay=0.040,
          source="mass: A4 at 80 g/m2 (arithmetic); rest assumed: rough, so above a sphere's 0.47, leaking"),
    _item("can", "cylinder", (0.115, 0.066, 0.066), 0.0135, 0.80, seal=18.0, of="aluminium", container=True,
          source="mass: 13-15 g (packaging.world-aluminium.org, mjpackages.com); others assumed"),
    _item("can_crushed", "box", (0.095, 0.075, 0.035), 0.0135, 1.00, seal=10.0, of="aluminium", opening_delay=0.025,
          source="mass: that of the can; size, drag, F0 assumed: the can stamped flat, creases leak"),
    _item("pet_05", "cylinder", (0.205, 0.065, 0.065), 0.0220, 0.80, seal=16.0, of="pet", com=0.52,
          container=True, source="all assumed: a 0.5 l bottle, rounded ends, smooth but yielding wall"),
    _item("pet_crushed", "box", (0.190, 0.085, 0.045), 0.0300, 1.00, seal=12.0, of="pet", com=0.55,
          container=True, source="all assumed: a larger bottle pressed flat, heavier at the cap, creased"),
    _item("yoghurt_cup", "cylinder", (0.080, 0.070, 0.070), 0.0060, 0.85, seal=14.0, of="pp",
          container=True, opening_delay=0.010,
          source="all assumed: a 150-180 g cup, open end adds drag, thin smooth wall"),
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
          pad_friction=0.8, opening_delay=0.018, oversize=0.02,
          source="size: Leveziel et al., VI-B; rest assumed: 20 cm3 at 0.2 g/cm3, small porous face"),
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

# What Leveziel et al. (section VI-B) pick with claws: the cork of above, and these. How late claws come free of an item
# is assumed: crumpled paper and rubber follow the pads as they part, a crushed can hangs on a crease.
_CLAWED = (
    _item("bottle_cap", "cylinder", (0.014, 0.028, 0.028), 0.0025, 1.10, of="pp", upright=True,
          pad_friction=0.6, opening_delay=0.008, oversize=-0.01,
          source="all assumed: a common plastic bottle cap, its size is not published"),
    _item("rubber_block", "box", (0.040, 0.020, 0.015), 0.0140, 1.05, of="rubber",
          pad_friction=1.0, opening_delay=0.038, oversize=0.03,
          source="all assumed: a rubber parallelepiped, its size is not published; 12 cm3 at 1.17 g/cm3"),
)  # fmt: skip

CATALOGUE: Final[Mapping[str, Item]] = MappingProxyType({i.name: i for i in (*_PAPER, *_SEEN, *_HELD_OUT, *_CLAWED)})
PAPER_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _PAPER)
SEEN_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _SEEN)
HELD_OUT_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _HELD_OUT)
CLAW_ITEMS: Final[tuple[str, ...]] = ("cork", *(item.name for item in _CLAWED))


class ItemsConfig(LevelConfig):
    """Abstract: the config of a cell whose robot picks items of the catalogue, and a user's own."""

    items: tuple[str, ...] = Field(min_length=1)
    extra_items: tuple[Item, ...] = Field(default=(), description="A user's own items, usable in `items` by name.")

    @model_validator(mode="after")
    def _check_items(self) -> Self:
        known = self.item_definitions()
        for name in self.items:
            if name not in known:
                raise ValueError(f"items: unknown item {name!r}; known are {', '.join(sorted(known))}")
        return self

    def item_definitions(self) -> Mapping[str, Item]:
        """The catalogue together with this cell's own items, by name."""
        return {**CATALOGUE, **{item.name: item for item in self.extra_items}}

    def item_list(self) -> tuple[Item, ...]:
        """The items that occur in this cell, in the order of `items`."""
        known = self.item_definitions()
        return tuple(known[name] for name in self.items)
