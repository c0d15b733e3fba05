"""Kinds of objects that are drawn from ranges: sizes, masses, drags and surfaces of no real object."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Final

import numpy as np

from pnt_gym.cells.base.catalogue import TYPICAL, complete_item
from pnt_gym.cells.base.items import CUP_RADIUS, Item
from pnt_gym.cells.base.zones import MOST_ZONES, ZONE_SHAPES

SIZES: Final = ((0.05, 0.20), (0.6, 1.0), (0.15, 1.0))
"""Lengths [m], widths over lengths, heights over widths of drawn kinds, from and to; about those of the catalogue."""
DENSITY: Final = (15.0, 90.0)
"""Masses over the volumes of the enclosing boxes, from and to [kg/m3]."""
SHARE_SMOOTH: Final = 0.6
"""Share of the kinds without a relief."""
POROUS, TIGHT = (3.0, 30.0), (0.3, 0.8)
"""Leaks of porous and of tight zones, from and to."""
CUP_SHARE: Final = 0.45
"""Width of a cup over that of a round kind: an arc of that width rises by less than a fifth of the cup's radius."""
DRAG: Final = (0.6, 1.6)
"""Drags over those that are typical of the shapes, from and to."""


@lru_cache
def drawn_kinds(count: int, seed: int, areal: float = 0.0) -> tuple[Item, ...]:
    """A number of kinds; the first of them are the same for any number.

    Args:
        count: number of kinds.
        seed: seed of the draws.
        areal: least mass over the area from above [kg/m2]; lighter kinds are drawn again.
    """
    items = list[Item]()
    for k in range(count):
        name, random = f"drawn_{k}", np.random.default_rng([seed, k])
        kind = draw_kind(name, random)
        while kind["mass"] < areal * kind["size"][0] * kind["size"][1]:
            kind = draw_kind(name, random)
        if kind["shape"] != "box":  # a cup that follows the round surface
            kind["cup_radius"] = min(CUP_RADIUS, CUP_SHARE * kind["size"][1] / 2.0)
        items.append(Item.model_validate(complete_item(kind)))
    return tuple(items)


def draw_kind(name: str, random: np.random.Generator) -> dict[str, Any]:
    """A kind as a level gives it; what is not drawn is typical of the shape."""
    shape = str(random.choice([*TYPICAL]))
    length, width, height = (_between(random, *share) for share in SIZES)
    width *= length
    size = (length, width, width if shape == "cylinder" else max(height * width, 0.010))
    mass = _between(random, *DENSITY) * float(np.prod(size))
    kind: dict[str, Any] = {
        "name": name,
        "shape": shape,
        "size": size,
        "mass": mass,
        "seal_force": max(_between(random, 8.0, 20.0), 30.0 * mass),
        "com": float(random.uniform(0.0, 0.1)),
        "look": _draw_look(random, None),
        "zones": [_draw_zone(random, size[2]) for _ in range(random.integers(1, MOST_ZONES + 1))],
        "source": "drawn at random",
    }
    if random.random() > SHARE_SMOOTH:
        kind["relief"] = (_between(random, 0.0004, 0.003), _between(random, 0.012, 0.05))
    kind["drag"] = TYPICAL[shape]["drag"] * _between(random, *DRAG)  # last, so that all other draws are as before it
    return kind


def _draw_zone(random: np.random.Generator, height: float) -> dict[str, Any]:
    """A dent, a hill, ribs, or a patch that leaks more or less than the surface around it."""
    size = random.uniform(0.10, 0.80, 2)
    zone: dict[str, Any] = {
        "shape": str(random.choice(ZONE_SHAPES)),
        "size": tuple(size),
        "at": tuple((1.0 - size) * random.uniform(-1.0, 1.0, 2)),
        "spread": float(random.uniform(0.0, 0.5)),
        "chance": float(random.uniform(0.2, 1.0)),
    }
    sort = random.integers(4)
    if sort == 0:
        zone["depth"] = float(np.clip(random.normal(0.004, 0.008), -0.02, 0.6 * height))
    elif sort == 1:
        zone["ribs"] = (_between(random, 0.0004, 0.002), _between(random, 0.003, 0.015))
    else:
        zone["leak"] = _between(random, *(POROUS if sort == 2 else TIGHT))
        zone["look"] = _draw_look(random, zone["leak"])
    return zone


def _draw_look(random: np.random.Generator, leak: float | None) -> tuple[float, float, float, float]:
    """A look; porous surfaces are matte, and films that seal are glossy: paper and foam do not shine."""
    gloss = (0.0, 0.9) if leak is None else ((0.0, 0.2) if leak > 1.0 else (0.3, 0.9))
    return (
        float(random.uniform(0.1, 0.95)), float(random.uniform(-1.0, 1.0)), float(random.uniform(*gloss)),
        float(random.uniform(0.0, 0.3)),
    )  # fmt: skip


def _between(random: np.random.Generator, low: float, high: float) -> float:
    """A number between two, whose logarithm is drawn evenly."""
    drawn: float = random.uniform(float(np.log(low)), float(np.log(high)))
    return float(np.exp(drawn))
