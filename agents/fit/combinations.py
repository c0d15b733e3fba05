"""Combinations of parameters that a log tells well where it does not tell them apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import ItemTable, item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.drawing import release_delay

from ..judging.log import ThrowLog


class Combination(NamedTuple):
    """A figure that follows from several parameters.

    Attributes:
        name: name in files.
        label: name for people, with the formula.
        unit: unit of the figure.
        needs: names of the parameters.
        of: the figure of SI values by name.
    """

    name: str
    label: str
    unit: str
    needs: tuple[str, ...]
    of: Callable[[Mapping[str, Any]], Any]


def combinations(log: ThrowLog, config: ConveyorConfig) -> list[Combination]:
    """Camera and encoder together at the picks, and the delay of each item's release."""
    way = float(log.pick[:, 0].mean() - config.belt.camera_x)
    place = Combination(
        "camera_at_picks", f"camera along the belt + {way:.2f} m x encoder", "mm", ("camera_x", "encoder"),
        lambda values: 1e3 * (values["camera_x"] + way * values["encoder"]),
    )  # fmt: skip
    table = item_arrays(config.item_list())
    delays = [
        Combination(
            f"delay_{config.items[kind]}", f"delay of {config.items[kind]}", "ms", ("valve", "tau"),
            partial(_delay, table, int(kind), config),
        )
        for kind in np.unique(log.kind)
    ]  # fmt: skip
    return [place, *delays]


def _delay(table: ItemTable, kind: int, config: ConveyorConfig, values: Mapping[str, Any]) -> Floats:
    """Mean delay [ms] of an item's release at a valve's delay and a time constant."""
    unit = config.suction.model_copy(update={"valve": 0.0, "tau": 1.0})
    decay = release_delay(table.seal_force[kind : kind + 1], table.mass[kind : kind + 1], unit)[0]
    delay = values["valve"] + values["tau"] * decay + table.clings[kind]
    return 1e3 * config.mismatch * np.maximum(delay, 0.0)
