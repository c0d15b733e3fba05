"""A robot's joints in random throws of the full physics: shares of their limits, and how the hand follows its path."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.cells import CELLS, infos, make_seeded_cells
from pnt_gym.arrays import Floats, Ints, length
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.hand import ThrowClock
from pnt_gym.cells.conveyor.plant import ConveyorPlant
from pnt_gym.cells.conveyor.scene import SENSORS

LIMITS: Final = ("range", "speed", "torque")
FULL: Final = 0.999
"""Share of its largest torque from which on a motor gives all that it has."""


class Watch:
    """Rolls the robot of a plant out as the plant does, and keeps what its joints and its hand did."""

    def __init__(self, plant: ConveyorPlant) -> None:
        self.plant, self._roll_out = plant, plant._roll_out_robot
        self.apart: list[Floats] = []
        """Distances of the hands from their paths at the releases [m]."""
        self.unlike: list[Floats] = []
        """Differences of the hands' velocities from those of the paths at the releases, as shares of the speeds."""
        self.planned: list[Floats] = []
        """Largest share of each limit in each planned cycle (3,)."""
        self.simulated: list[Floats] = []
        """Largest share of the speeds and torques in each simulated throw (2,)."""

    def roll_out(self, rows: Ints, context: Context, clock: ThrowClock, until: Ints) -> dict[str, Floats]:
        """As `ConveyorPlant._roll_out_robot`."""
        record = self._roll_out(rows, context, clock, until)
        robot, each = self.plant.scene.robot, np.arange(len(rows))
        hand = record["sensordata"][..., SENSORS["hand_position"]]
        last, before = clock.hand(clock.release[:, None]), clock.hand(clock.release[:, None] - 1)
        self.apart.append(length(hand[each, clock.release] - last.position[:, 0]))
        moved = (hand[each, clock.release] - hand[each, clock.release - 1]) / clock.step
        wanted = (last.position - before.position)[:, 0] / clock.step
        self.unlike.append(length(moved - wanted) / length(wanted))
        steps = np.arange(0, max(clock.end.tolist()), clock.stride, dtype=np.int64)
        motion = robot.motion(*clock.hand(np.minimum(steps, clock.end[:, None])))
        self.planned.append(robot.limits.shares(motion).max(axis=-1).T)
        speed = np.abs(record["qvel"][..., self.plant._motors]) / robot.limits.speed
        torque = np.abs(record["sensordata"][..., SENSORS["torque"]]) / robot.limits.torque
        self.simulated.append(np.stack([share.max(axis=(1, 2)) for share in (speed, torque)], axis=-1))
        return record


def throws(settings: Settings, amount: Amount) -> Figures:
    """Joints and hand of a robot in random throws, lengths in m.

    Args:
        settings: `level`, and `actions`, the largest random correction as a share of the largest there is.
        amount: throws.
    """
    config = ConveyorConfig.load({**settings["level"], "fidelity": "full"})
    core = make_seeded_cells(config, "independent", CELLS, amount.seed)
    assert isinstance(core.cell, ConveyorCell)
    watch = Watch(core.cell.plant)
    setattr(core.cell.plant, "_roll_out_robot", watch.roll_out)  # noqa: B010 - in place of the method
    random, largest = np.random.default_rng(amount.seed), settings["actions"]
    info = infos(core, lambda _: random.uniform(-largest, largest, (CELLS, *core.action_space.shape)), amount.throws)
    return {"throws": int(info["picked"].sum()), "sorted": float(info["is_success"].mean()), **_figures(watch)}


def _figures(watch: Watch) -> dict[str, Any]:
    """Figures of what was watched."""
    apart, unlike = np.concatenate(watch.apart), np.concatenate(watch.unlike)
    planned, simulated = np.concatenate(watch.planned), np.concatenate(watch.simulated)
    return {
        "apart_mean_m": float(apart.mean()),
        "apart_most_m": float(apart.max()),
        "unlike_mean": float(unlike.mean()),
        "unlike_most": float(unlike.max()),
        **{f"planned_{name}_most": float(share) for name, share in zip(LIMITS, planned.max(axis=0), strict=True)},
        "planned_beyond": int((planned > 1.0).any(axis=1).sum()),
        **{f"{name}_most": float(share) for name, share in zip(LIMITS[1:], simulated.max(axis=0), strict=True)},
        "too_fast": int((simulated[:, 0] > 1.0).sum()),
        "at_full_torque": int((simulated[:, 1] >= FULL).sum()),
    }
