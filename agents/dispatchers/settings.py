"""Settings of rules and planners of a line, level by level, from `pnt-gym line tune`: shipped ones and a user's own."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any, Final

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


def read_settings() -> dict[str, Any]:
    """All settings by level: those in the working folder, and the shipped ones."""
    levels: dict[str, Any] = {}
    for file in (MADE, FILE):
        if file.is_file():
            levels |= dict(_content(file) or {})
    return levels


_parsed = lru_cache(maxsize=4)(parsed_yaml)
"""The data of a text, which a plan of a benchmark asks for hundreds of times."""


def _content(file: Path) -> Any:
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
