"""The catalogue of items, as the file `items.yaml` beside this one has it, and configs of cells that draw from it.

Levels draw from sets of names (`PAPER_ITEMS`, `SEEN_ITEMS`, `HELD_OUT_ITEMS`, `LIGHT_ITEMS`, `CLAW_ITEMS`) and may add
their own.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Self

from pydantic import Field, model_validator

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.base.items import Item
from pnt_gym.reading import yaml_of


def _groups(file: Path) -> dict[str, tuple[Item, ...]]:
    """The items of a file, group by group."""
    data: dict[str, Any] = yaml_of(file)
    materials, rolling = data.pop("materials"), data.pop("rolling_friction")

    def item(entry: dict[str, Any]) -> Item:
        material = materials[entry.pop("of")]
        told: dict[str, Any] = {**material, **entry, "source": f"{entry['source']}; {material['source']}"}
        return Item(rolling_friction=rolling[entry["shape"]], **told)

    return {group: tuple(map(item, entries)) for group, entries in data.items()}


_GROUPS: Final = _groups(Path(__file__).with_name("items.yaml"))
CATALOGUE: Final[Mapping[str, Item]] = MappingProxyType({i.name: i for group in _GROUPS.values() for i in group})
PAPER_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _GROUPS["paper"])
SEEN_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _GROUPS["seen"])
HELD_OUT_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _GROUPS["held_out"])
LIGHT_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _GROUPS["light"])
CLAW_ITEMS: Final[tuple[str, ...]] = ("cork", *(item.name for item in _GROUPS["claws"]))


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
