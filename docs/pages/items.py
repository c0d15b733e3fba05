"""The catalogue of items, and the meaning of an item's keys."""

from __future__ import annotations

from pnt_gym.cells.base.catalogue import (
    BY_SHAPE,
    CATALOGUE,
    CLAW_ITEMS,
    HELD_OUT_ITEMS,
    LIGHT_ITEMS,
    PAPER_ITEMS,
    SEEN_ITEMS,
    TYPICAL,
)
from pnt_gym.cells.base.items import SHAPES, Item
from pnt_gym.cells.base.zones import Zone

from .levels import item_default, settings
from .marks import attributes, table

SETS = {"paper": PAPER_ITEMS, "seen": SEEN_ITEMS, "unseen": HELD_OUT_ITEMS, "light": LIGHT_ITEMS, "claws": CLAW_ITEMS}


def item_table(set_name: str) -> str:
    """A table of one set of items."""
    rows = [_row(CATALOGUE[name]) for name in SETS[set_name]]
    return table(("item", "shape", "size [mm]", "mass [g]", "drag", "seal [N]", "where the numbers come from"), rows)


def _row(item: Item) -> tuple[str, ...]:
    size = "\u00d7".join(f"{1000 * extent:g}" for extent in item.size)
    seal = "-" if item.seal_force is None else f"{item.seal_force:g}"
    return f"`{item.name}`", item.shape, size, f"{1000 * item.mass:g}", f"{item.drag:g}", seal, item.source


def shape_table(_: str) -> str:
    """A table of the defaults of an item by its shape."""
    rows = [(shape, *(f"{TYPICAL[shape][key]:g}" for key in BY_SHAPE)) for shape in SHAPES]
    return table(("shape", *(f"`{key}`" for key in BY_SHAPE)), rows)


def key_table(_: str) -> str:
    """A table of the keys of an item, and of its zones."""
    rows = [(f"`{name}`", item_default(name), meaning) for name, meaning in attributes(Item).items()]
    rows += [(f"`{key}`", *facts) for key, *facts in settings(Zone, "zones[].")]
    like = ("`like`", "-", "item of the catalogue from which all keys that the entry does not give are taken.")
    return table(("key", "default or *required*", "meaning"), [*rows, like])
