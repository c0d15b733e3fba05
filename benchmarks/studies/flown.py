"""How much longer the hands of the full robot take than was planned."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Floats

ARRIVED: Final = 0.001
"""A hand this close to its next pick for good has arrived [m]."""


class Watch:
    """Keeps what a cell of the conveyor last handed to its plant."""

    def __init__(self, cell: Any) -> None:
        self._fly = cell.plant.fly
        self.last: tuple[Any, Any] | None = None
        cell.plant.fly = self

    def __call__(self, thrown: Any, plans: Any, cells: Any = None) -> Any:
        """Hand throws on to the plant."""
        self.last = thrown, plans
        return self._fly(thrown, plans, cells)


def arrival(place: Floats, end: Floats, times: Floats, duration: Floats) -> Floats:
    """Last times (N,) at which hands (N, M, 3) are away from their ends (N, 3), until durations (N,) [s]."""
    away = (np.linalg.norm(place - end[:, None], axis=2) > ARRIVED) & (times <= duration[:, None])
    return np.take_along_axis(times, (away.shape[1] - 1 - away[:, ::-1].argmax(axis=1))[:, None], axis=1)[:, 0]


def time_ratio(cell: Any, watch: Watch) -> float:
    """How many times the planned way the hands take from lift to their next picks, the robot simulated to the end."""
    if watch.last is None:
        raise RuntimeError("nothing was thrown yet")
    thrown, plans = watch.last
    followed, path = cell.plant.follow(thrown, plans), plans.path
    steps = np.arange(followed.hand.shape[1])
    times = followed.start[:, None] + steps * cell.config.timestep
    end = path.end + thrown.cup_offset
    planned = path.sample(times).position + thrown.cup_offset[:, None]
    arrived, due = (arrival(place, end, times, path.duration) for place in (followed.hand, planned))
    return float(((path.duration + arrived - due) / path.duration).mean())
