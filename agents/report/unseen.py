"""The sentence on objects and bins that no learner of places saw."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..ground.metrics import Interval
from ..ground.tables import interval_text

Data = Mapping[str, Any]
NEAR: Final = "unseen"
FAR: Final = "unseen, far bins"
"""Levels of the study `grasp_targets`, of which the residual saw neither kinds nor, in the second, bins."""
OTHERS: Final = {
    "network": "for networks that see colours and depths",
    "network on depths": "for those that see depths alone",
    "network, 100 kinds drawn": "for those that learned from 100 drawn kinds too",
    "network on depths, 100 kinds drawn": "for those with both",
}
"""Networks of the study, and how the sentence calls them."""


def unseen_sentence(data: Data) -> str:
    """What is sorted of unseen kinds into near and far bins."""
    paces = {(row["who"], row["level"]): row["sorted_per_min"] for row in data["rows"] if "who" in row}

    def near_and_far(who: str) -> str:
        return f"{paces[who, NEAR]:.1f} and {paces[who, FAR]:.1f}"

    return (
        "Of unseen kinds into near bins, and into bins farther away than any in training, the rule sorts "
        f"{near_and_far('tuned rule')} a minute, networks of three seeds {near_and_far('network')}, and the oracle "
        f"{near_and_far('oracle')}.{_gains(data)}"
    )


def _gains(data: Data) -> str:
    """What other pictures and further kinds bring on the rule, of unseen kinds into near bins."""
    rows = [row for row in data["rows"] if row.get("level") == NEAR and row.get("who") in OTHERS]
    if not rows:
        return ""
    gains = [f"{OTHERS[row['who']]} {interval_text(Interval(**row['gain']), '+')}" for row in rows]
    return f" There the gain on the rule is {', '.join(gains)}."
