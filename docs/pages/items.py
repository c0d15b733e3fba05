"""The catalogue of items, and the meaning of an item's keys."""

from __future__ import annotations

from pnt_gym.cells.base.catalogue import CATALOGUE, CLAW_ITEMS, HELD_OUT_ITEMS, LIGHT_ITEMS, PAPER_ITEMS, SEEN_ITEMS
from pnt_gym.cells.base.items import Item

from .levels import format_default
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


def key_table(_: str) -> str:
    """A table of the keys of an item."""
    fields = Item.model_fields
    rows = [(f"`{name}`", f"`{format_default(fields[name])}`", meaning) for name, meaning in attributes(Item).items()]
    return table(("key", "default", "meaning"), rows)
