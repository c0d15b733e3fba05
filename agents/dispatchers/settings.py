"""Settings of rules and planners of a line, level by level, from `pnt-gym line tune`: shipped ones and a user's own."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Final, final

from pydantic import Field, ValidationError

from pnt_gym.cells.base.config import LARGEST_NUMBER, Finite, NonNegative, Section
from pnt_gym.cells.base.problems import list_problems
from pnt_gym.cells.line.rows import CHOICES
from pnt_gym.reading import ReadError, parsed_yaml, text_of

from ..ground.cli import UsageError
from ..ground.places import SHIPPED

FILE: Final = SHIPPED / "configs" / "line_rules.yaml"
MADE: Final = Path("runs") / "line_rules.yaml"
"""File of the settings that `pnt-gym line tune` finds, in the working folder; shipped ones come first."""
USUAL: Final = {"atc": {"patience": 1.0}, "price": {"patience": 1.0, "share": 0.5}}
"""Settings on levels without tuned ones."""
PLANNERS: Final = ("beam", "price_beam", "guided_beam")
"""Planners that compare plans by a price of time."""


@final
class RuleSettings(Section):
    """Settings that a rule or a planner may have; each has some of them."""

    patience: Annotated[float, Field(ge=0.01, le=1000)] = 1.0
    share: Annotated[float, Field(ge=0, le=1)] = 0.0
    price: NonNegative = 1.0
    weights: Mapping[str, Finite] = {}
    trust: Finite = 5.0
    few: Annotated[int, Field(ge=1, le=CHOICES)] = 4
    width: Annotated[int, Field(ge=1, le=10**6)] = 20
    horizon: Annotated[float, Field(gt=0, le=100)] = 4.0
    depth: Annotated[int, Field(ge=1, le=100)] = 24
    joint: bool = False
    per_choice: bool = False
    by_rate: bool = False
    guide: str = "index"


def check(name: str, chosen: Mapping[str, Any]) -> None:
    """Make sure that the settings of a controller of lines are in their ranges; whether it has them, it says itself.

    Raises:
        UsageError: a setting is not in its range.
    """
    try:
        RuleSettings.model_validate({key: value for key, value in chosen.items() if key in RuleSettings.model_fields})
    except ValidationError as error:
        raise UsageError(*list_problems(f"settings of controller {name!r}", error, RuleSettings)) from None


def read_settings() -> dict[str, Any]:
    """All settings by level: those in the working folder, and the shipped ones."""
    return settings_in(MADE) | settings_in(FILE)


def settings_in(file: Path) -> dict[str, Any]:
    """Settings by level in a file; none without the file.

    Raises:
        UsageError: the file cannot be read, or holds other data.
    """
    # A link to nowhere is there, and cannot be read.
    content = (_read(file) or {}) if os.path.lexists(file) else {}
    if not isinstance(content, dict) or not all(map(_fits, content.values())):
        raise UsageError(f"{str(file)!r} is not a file of settings by level")
    return content


def _fits(entry: Any) -> bool:
    """Whether an entry is that of a level: settings by controller, and a number `rate`."""
    if not isinstance(entry, dict):
        return False
    rest = [value for key, value in entry.items() if key != "rate"]
    value = entry.get("rate", 0.0)
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value < LARGEST_NUMBER
    return is_number and all(isinstance(part, dict) for part in rest)


_parsed = lru_cache(maxsize=4)(parsed_yaml)
"""The data of a text, which a plan of a benchmark asks for hundreds of times."""


def _read(file: Path) -> Any:
    """Data of a file of settings; nobody writes to them."""
    try:
        return _parsed(text_of(file, form="YAML"))
    except ReadError as error:
        raise UsageError(f"cannot read settings of rules {str(file)!r}: {error}") from None


def settings(level: str, name: str, robots: int = 1) -> dict[str, Any]:
    """Settings of one controller on a level with so many robots; `USUAL` where the level has none.

    A planner without a tuned price of time uses the tuned ATC rule's value per second and robot. `price_beam` without a
    tuned share uses that of the rule `price`. `guided_beam` uses both values of `price_beam`.
    """
    level_settings = read_settings().get(level) or {}
    usual = dict(USUAL.get(name, {}))
    if name in PLANNERS and "rate" in level_settings:
        usual["price"] = round(level_settings["rate"] / robots, 3)
    if name == "price_beam":
        usual["share"] = settings(level, "price")["share"]
    if name == "guided_beam":
        usual = settings(level, "price_beam", robots)
    return {**usual, **level_settings.get(name, {})}


def rate(level: str) -> float | None:
    """Value per second of the tuned ATC rule on a level; None on a level without tuned settings."""
    value: Any = (read_settings().get(level) or {}).get("rate")
    return None if value is None else float(value)
