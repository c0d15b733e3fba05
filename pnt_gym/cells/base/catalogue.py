"""The catalogue of items in the file `items.yaml` beside this module, and configs of cells that use the catalogue.

Levels name items of the sets `PAPER_ITEMS`, `SEEN_ITEMS`, `HELD_OUT_ITEMS`, `LIGHT_ITEMS` and `CLAW_ITEMS`, and may add
new items.
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
    """The items in a file, by the names of their groups."""
    data: dict[str, Any] = yaml_of(file)
    materials, rolling = data.pop("materials"), data.pop("rolling_friction")

    def item(entry: dict[str, Any]) -> Item:
        material = materials[entry.pop("of")]
        fields: dict[str, Any] = {**material, **entry, "source": f"{entry['source']}; {material['source']}"}
        return Item(rolling_friction=rolling[entry["shape"]], **fields)

    return {group: tuple(map(item, entries)) for group, entries in data.items()}


_GROUPS: Final = _groups(Path(__file__).with_name("items.yaml"))
CATALOGUE: Final[Mapping[str, Item]] = MappingProxyType({i.name: i for group in _GROUPS.values() for i in group})
PAPER_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _GROUPS["paper"])
SEEN_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _GROUPS["seen"])
HELD_OUT_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _GROUPS["held_out"])
LIGHT_ITEMS: Final[tuple[str, ...]] = tuple(item.name for item in _GROUPS["light"])
CLAW_ITEMS: Final[tuple[str, ...]] = ("cork", *(item.name for item in _GROUPS["claws"]))


class ItemsConfig(LevelConfig):
    """Abstract: the config of a cell whose robot picks items of the catalogue and items that a level adds."""

    items: tuple[str, ...] = Field(
        min_length=1, description="Names of the items that the robot throws; see the catalogue of items."
    )
    extra_items: tuple[Item, ...] = Field(default=(), description="Items of your own, which `items` may then name.")

    @model_validator(mode="after")
    def _check_items(self) -> Self:
        definitions = self.item_definitions()
        for name in self.items:
            if name not in definitions:
                raise ValueError(f"items: unknown item {name!r}; known are {', '.join(sorted(definitions))}")
        return self

    def item_definitions(self) -> Mapping[str, Item]:
        """The items of the catalogue and of `extra_items`, by name."""
        return {**CATALOGUE, **{item.name: item for item in self.extra_items}}

    def item_list(self) -> tuple[Item, ...]:
        """The items that occur in this cell, in the order of `items`."""
        definitions = self.item_definitions()
        return tuple(definitions[name] for name in self.items)
