"""The level of a plant, as an engineer writes it from the page on plans alone; the page shows the same text."""

import re
from typing import Any, Final

from agents.ground.places import SHIPPED
from pnt_gym.reading import parsed_yaml

PAGE: Final = SHIPPED / "docs" / "plan.md"


def plant_text() -> str:
    """The block `plant.yaml` of the page."""
    block = re.search(r'^```yaml title="plant.yaml"\n(.*?)^```$', PAGE.read_text(encoding="utf-8"), re.M | re.S)
    assert block is not None
    return block[1]


def plant() -> dict[str, Any]:
    """The level as a mapping."""
    return parsed_yaml(plant_text())
