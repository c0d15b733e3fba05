"""Two closed-form corrections of the conveyor: for the object's height, and for the mean delay of the valve.

Both use the nominal plan in the observation and drag-free flight; both have nothing to learn.
"""

from __future__ import annotations

from typing import final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.drawing import release_delay
from pnt_gym.cells.conveyor.observation import decode
from pnt_gym.constants import GRAVITY

from .protocol import Actions, Controller, Observation
from .shift import to_action


def landing_change(plan: dict[str, Floats], forward: Floats | float, up: Floats | float) -> Floats:
    """Change of the landing distance (N,) [m] when the release point moves at constant velocity.

    Args:
        plan: decoded observations; `release_speed`, `elevation` and `flight_time` are read.
        forward: horizontal move along the throw [m].
        up: vertical move [m].
    """
    speed, angle, flight = plan["release_speed"], plan["elevation"], plan["flight_time"]
    # Drag-free flight from height z: t = (w + sqrt(w^2 + 2 g z)) / g with the vertical velocity w.
    rise = speed * np.sin(angle)
    drop = 0.5 * GRAVITY * flight**2 - rise * flight  # release height above the rim
    # A release that never reaches the rim lands nowhere; the apex is used instead.
    before, after = (np.sqrt(np.maximum(rise**2 + 2.0 * GRAVITY * z, 0.0)) for z in (drop, drop + up))
    return forward + speed * np.cos(angle) * (after - before) / GRAVITY


def later_release(plan: dict[str, Floats], delay: float) -> Floats:
    """Change of the landing distance (N,) [m] for a release that is later on its line by `delay` [s]."""
    late = plan["release_speed"] * delay
    return landing_change(plan, late * np.cos(plan["elevation"]), late * np.sin(plan["elevation"]))


def mean_delay(config: ConveyorConfig) -> float:
    """Mean release delay [s] over the level's items at their catalogue values, scaled with the mismatch."""
    table = item_arrays(config.item_list())
    return config.mismatch * float(np.mean(release_delay(table.seal_force, table.mass, config.suction)))


def _along(shift: Floats, correction: Correction) -> Actions:
    return to_action(np.stack([shift, np.zeros_like(shift)], axis=-1), correction)


@final
class AnalyticHeight(Controller):
    """The planner for an object of height h, whose centre of mass leaves from h/2 below the cup.

    The share of h/2 scales with the mismatch, as the cell's own centre of mass does.
    """

    name = "analytic_height"

    def __init__(self, config: ConveyorConfig, correction: Correction) -> None:
        self._config, self._correction = config, correction

    def act(self, observation: Observation) -> Actions:
        """Actions (N, 2) that cancel the landing change of the lower release."""
        plan = decode(observation.features)
        lower = -0.5 * self._config.mismatch * plan["height"]
        return _along(-landing_change(plan, 0.0, lower), self._correction)


@final
class MeanLead(Controller):
    """The planner with the valve advanced by the mean delay: one number for the whole cell."""

    name = "mean_lead"

    def __init__(self, config: ConveyorConfig, correction: Correction) -> None:
        self._correction = correction
        self.delay = mean_delay(config)

    def act(self, observation: Observation) -> Actions:
        """Actions (N, 2) that cancel the landing change of a release later by the mean delay."""
        return _along(-later_release(decode(observation.features), self.delay), self._correction)
