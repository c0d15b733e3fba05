"""Differences of two controllers of a benchmark in sorted objects per minute, with intervals, for sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from ..ground import metrics
from ..judging.throw_record import ThrowRecord

Data = Mapping[str, Any]
KEYS: Final = ("label", "throws")
"""What names a controller in a benchmark."""


def difference(data: Data, level: str, learner: Data, reference: Data) -> str:
    """The difference in sorted objects per minute, with its paired interval where the two had the same objects."""
    pace = interval(data, level, learner, reference)
    if pace is None:
        return f"{learner['sorted_per_min'] - reference['sorted_per_min']:+.1f}"
    text = f"{pace.value:+.1f}, 95 % interval {pace.low:+.1f} to {pace.high:+.1f}"
    return text if pace.excludes_zero else f"{text}, not distinguishable"


def interval(data: Data, level: str, learner: Data, reference: Data) -> metrics.Interval | None:
    """The paired difference in sorted objects per minute, of plan or throws; None where the objects differ."""
    for row in data["comparisons"]:
        sides = (row["learned"], learner), (row["reference"], reference)
        if row["level"] == level and all(side[name] == whole[name] for side, whole in sides for name in KEYS):
            return metrics.Interval(*(row["sorted_per_min"][name] for name in ("value", "low", "high")))
    results = [result for result in data.get("results", ()) if result["level"] == level]
    one, other = ([r for r in results if all(r[k] == row[k] for k in KEYS)] for row in (learner, reference))
    objects = [ThrowRecord.objects(side[0]["columns"]) for side in (one, other) if side]
    if len(objects) < 2 or objects[0] != objects[1]:
        return None
    columns = (ThrowRecord.paired_columns(side, (one, other), data["plan"]["num_envs"]) for side in (one, other))
    means = [[np.mean(column, axis=0) for column in side["sorted_per_min"]] for side in columns]
    return metrics.rate_difference(*means[0], *means[1])
