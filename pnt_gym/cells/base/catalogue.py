"""The catalogue of items in the file `items.yaml` beside this module, and configs of cells that use the catalogue.

Levels name items of the sets `PAPER_ITEMS`, `SEEN_ITEMS`, `HELD_OUT_ITEMS`, `LIGHT_ITEMS` and `CLAW_ITEMS`, and may add
new items.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median_low
from types import MappingProxyType
from typing import Any, Final, cast

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.base.items import SHAPES, Item
from pnt_gym.errors import one_sentence
from pnt_gym.names import BRIEF, list_names, unknown_name, unknown_names
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


BY_SHAPE: Final = ("drag", "seal_force", "friction", "rolling_friction", "restitution")
"""Keys of an item of a level whose defaults depend on the shape."""
OF_ITEM: Final = ("com_depth", "pick_chance", "surface")
"""Keys with one default for all shapes, on which the throws depend too."""


TYPICAL: Final[Mapping[str, Mapping[str, Any]]] = MappingProxyType(
    {
        shape: {
            key: median_low([getattr(item, key) for item in _GROUPS["seen"] if item.shape == shape]) for key in BY_SHAPE
        }
        for shape in SHAPES
    }
)
"""Defaults of the keys `BY_SHAPE`, by shape: medians of the catalogue's seen waste of this shape."""


def complete_item(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An item of a level with every key: what the level does not give is that of an item `like` it, or of its shape.

    Args:
        entry: the keys that the level gives.

    Returns:
        The item's keys; `assumed` names those that the level does not give, none of an item that is `like` itself.

    Raises:
        ValueError: `like` names no item of the catalogue.
    """
    given = {key: value for key, value in entry.items() if key != "like"}
    like = entry.get("like")
    if like is None:
        values = {"source": "not given", **TYPICAL.get(str(given.get("shape")), TYPICAL["box"])}
    elif isinstance(like, str) and like in CATALOGUE:
        values = CATALOGUE[like].model_dump(exclude={"name", "assumed"})
        values["source"] = f"as {like}: {values['source']}"
        if given.get("shape", values["shape"]) != values["shape"]:
            values["rolling_friction"] = TYPICAL.get(str(given["shape"]), values)["rolling_friction"]
        if "size" in given:
            values.pop("cup_radius")  # the cup is fitted to the size
    else:
        name = one_sentence(repr(entry.get("name")), 60)
        raise ValueError(
            f"extra_items: item {name} is like {unknown_name('item', like, sorted(CATALOGUE), room=BRIEF)}"
        )
    physical = {key for key, value in values.items() if value != Item.model_fields[key].default} - {"source"}
    assumed = [key for key in Item.model_fields if key in physical | {*OF_ITEM} and key not in given]
    is_itself = like is not None and like == given.get("name")
    return {"assumed": () if is_itself else tuple(assumed), **values, **given}


def _entries(value: object) -> Sequence[object]:
    """Entries of a list; none of anything else."""
    return cast("Sequence[object]", value) if isinstance(value, list | tuple) else ()


class ItemsConfig(LevelConfig):
    """Abstract: the config of a cell whose robot picks items of the catalogue and items that a level adds."""

    items: tuple[str, ...] = Field(
        min_length=1, description="Names of the items that the robot throws; see the catalogue of items."
    )
    extra_items: tuple[Item, ...] = Field(
        default=(),
        description="Items of your own, which `items` may then name. Each needs a name, shape, size and mass, or a "
        "name and an item of the catalogue that it is `like`; the other keys have defaults.",
    )

    @field_validator("items", mode="before")
    @classmethod
    def _refuse_descriptions(cls, value: object) -> object:
        """Refuse an item's description where the item's name should stand."""
        if any(isinstance(entry, Mapping) for entry in [value, *_entries(value)]):
            hint = "describe an item of your own in extra_items and name it here"
            raise PydanticCustomError("names", "input should be a list of names; {hint}", {"hint": hint})
        return value

    @field_validator("extra_items", mode="before")
    @classmethod
    def _complete_items(cls, value: object) -> object:
        """The items with the defaults of their shape, or the values of the item that they are `like`."""
        # Items of a level with every key; a value that is no list stays as it is.
        entries = _entries(value)
        completed = [complete_item(cast("dict[str, Any]", e)) if isinstance(e, dict) else e for e in entries]
        return completed or value  # what is no list is refused by its form

    def problems(self) -> Iterator[str]:
        """A sentence for each problem of values that are possible alone, and not together; here in names of items."""
        yield from super().problems()
        definitions, names = self.item_definitions(), [item.name for item in self.extra_items]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            yield f"extra_items: {list_names(twice)} {'stands' if len(twice) == 1 else 'stand'} there more than once"
        if unknown := [name for name in self.items if name not in definitions]:
            yield f"items: {unknown_names('item', unknown, sorted(definitions), room=BRIEF)}"

    def assumed(self) -> dict[str, dict[str, Any]]:
        """Values of added items that are those of their shape or of a similar item, by item and key."""
        items = [item for item in self.extra_items if item.assumed]
        return {item.name: {key: getattr(item, key) for key in item.assumed} for item in items}

    def item_definitions(self) -> Mapping[str, Item]:
        """The items of the catalogue and of `extra_items`, by name."""
        return {**CATALOGUE, **{item.name: item for item in self.extra_items}}

    def item_list(self) -> tuple[Item, ...]:
        """The items that occur in this cell, in the order of `items`."""
        definitions = self.item_definitions()
        return tuple(definitions[name] for name in self.items)
