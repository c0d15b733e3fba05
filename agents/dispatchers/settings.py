"""The settings with which rules and planners of a line ship, level by level, as `pnt-gym line tune` has found them."""

from __future__ import annotations

from typing import Any, Final

from ..ground.files import read_yaml
from ..ground.places import SHIPPED

FILE: Final = SHIPPED / "configs" / "line_rules.yaml"
USUAL: Final = {"atc": {"patience": 1.0}, "price": {"patience": 1.0, "share": 0.5}}
"""On levels that nobody has tuned them for."""
PLANNERS: Final = ("beam", "price_beam", "joint_beam", "guided_beam")
"""Those that look ahead and compare by a price of time."""


def written_settings() -> dict[str, Any]:
    """All that is written there, by level."""
    told: Any = read_yaml(FILE, "settings of rules") if FILE.is_file() else {}
    return dict(told or {})


def settings(level: str, name: str, robots: int = 1) -> dict[str, Any]:
    """Settings of one controller on a level with so many robots; of `USUAL` where the level has none.

    A planner whose price of time nobody has tuned has what a robot brings in a second by the tuned ATC rule, and
    `price_beam` without a share that of the rule `price`. `guided_beam` has both of `price_beam`.
    """
    own = written_settings().get(level) or {}
    usual = dict(USUAL.get(name, {}))
    if name in PLANNERS and "rate" in own:
        usual["price"] = round(own["rate"] / robots, 3)
    if name == "price_beam":
        usual["share"] = settings(level, "price")["share"]
    if name == "guided_beam":
        usual = settings(level, "price_beam", robots)
    return {**usual, **own.get(name, {})}


def rate(level: str) -> float | None:
    """Value that the tuned ATC rule brings in a second on a level; None on one that nobody has tuned."""
    found: Any = (written_settings().get(level) or {}).get("rate")
    return None if found is None else float(found)
