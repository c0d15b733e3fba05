"""The sentence on objects and bins that no learner of places saw."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

Data = Mapping[str, Any]
NEAR: Final = "unseen"
FAR: Final = "unseen, far bins"
"""Levels of the study `grasp_targets`, of which the residual saw neither kinds nor, in the second, bins."""


def unseen_sentence(data: Data) -> str:
    """What is sorted of unseen kinds into near and far bins."""
    paces = {(row["who"], row["level"]): row["sorted_per_min"] for row in data["rows"] if "who" in row}

    def near_and_far(who: str) -> str:
        return f"{paces[who, NEAR]:.1f} and {paces[who, FAR]:.1f}"

    return (
        "Of unseen kinds into near bins, and into bins farther away than any in training, the rule sorts "
        f"{near_and_far('tuned rule')} a minute, networks of three seeds {near_and_far('network')}, and the oracle "
        f"{near_and_far('oracle')}."
    )
