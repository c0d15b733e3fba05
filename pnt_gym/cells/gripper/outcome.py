"""Recorded throws of the gripper robot, and their outcome."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, in_order
from pnt_gym.cells.base.plant import touching
from pnt_gym.cells.base.recorded import Landed, MotorRecord, ObjectFlight, loads_of_steps, touchdown
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.motion import TossPlans
from pnt_gym.cells.gripper.scene import SENSORS

BRUSHING: Final = 0.010
"""Time without a touch of a pad after which an object is free; contacts come and go while the claws part [s]."""
OFF_TABLE: Final = 0.002
"""Rise above which an object is off the table [m]."""
LIFT: Final = 0.5
"""Least rise of a picked object, as a share of the platform's own rise."""


@final
@dataclass(frozen=True)
class RecordedThrows:
    """N recorded throws, M steps each, before judging. A step's values are those of its start."""

    flight: ObjectFlight
    """Flight from the moment at which no pad touches the object any more; a later touch of a pad is a recontact."""
    hand: Floats
    """Point midway between the relaxed pads (N, M, 3) [m]."""
    release_time: Floats
    """Time at which the object was free of the pads (N,) [s]; the end of the recording if it never was."""
    lifted: Floats
    """Rise of the object between the start and the command to open the claws (N,) [m]."""
    slip: Floats
    """Motion of the object along the pads, in x and z, from leaving the table to the command to open (N,) [m]. Along y
    the object moves with the compliant fingers."""
    peak_torque: Floats
    """Largest motor torque (N,) [N m]."""
    energy: Floats
    """Positive mechanical work of the motors in the simulated throw (N,) [J], see `cells.base.recorded`."""

    @classmethod
    def of(cls, record: MotorRecord, plans: TossPlans, last_step: Ints, step: float) -> Self:
        """Throws from a record.

        Args:
            record: M steps of N throws, whose sensors are those of `SENSORS`; zero after each throw's last step.
            plans: plans of the throws.
            last_step: last recorded step of each throw (N,).
            step: physics step [s].
        """
        rows, sensordata = np.arange(len(last_step)), record.sensors
        position, hand = sensordata[..., SENSORS["object_position"]], sensordata[..., SENSORS["hand_position"]]
        pads = sensordata[..., SENSORS["pad_contact"]]
        touch = touching(pads[..., 0:2]) | touching(pads[..., 2:4])
        grip_step = np.minimum(np.ceil(plans.grip_time / step).astype(np.int64), last_step)
        open_step = np.clip(np.floor(plans.open_time / step).astype(np.int64), grip_step, last_step)
        # First step after the grip from which no pad touches the object for `window` steps (N,).
        window = round(BRUSHING / step)
        steps = np.arange(touch.shape[1], dtype=np.int64)
        total = np.zeros((len(touch), touch.shape[1] + 1), dtype=np.int64)
        np.cumsum(touch, axis=1, out=total[:, 1:])
        ahead = np.minimum(steps + window, touch.shape[1])
        free = (total[:, ahead] == total[:, :-1]) & (steps >= grip_step[:, None]) & (steps <= last_step[:, None])
        release = np.where(free.any(axis=1), free.argmax(axis=1), last_step)
        # First step after the grip with the object off the table (N,); the opening's step if it stays on the table.
        height = position[..., 2]
        steps = np.arange(height.shape[1], dtype=np.int64)
        is_off = (height > height[:, :1] + OFF_TABLE) & (steps >= grip_step[:, None]) & (steps < open_step[:, None])
        off_table_step = np.where(is_off.any(axis=1), is_off.argmax(axis=1), open_step)
        relative_position = position - hand
        peak_torque, energy = loads_of_steps(record, last_step + 1, step)
        return cls(
            flight=ObjectFlight(
                position=position,
                velocity=sensordata[..., SENSORS["object_velocity"]],
                hand_touch=touch,
                any_touch=touching(sensordata[..., SENSORS["any_contact"]]),
                release_step=release,
                last_step=last_step,
            ),
            hand=hand,
            release_time=np.asarray(release * step, dtype=np.float64),
            lifted=position[rows, open_step, 2] - position[rows, 0, 2],
            slip=np.hypot(*(relative_position[rows, open_step] - relative_position[rows, off_table_step])[:, [0, 2]].T),
            peak_torque=peak_torque,
            energy=energy,
        )


@final
@dataclass(frozen=True)
class Outcome(Landed):
    """Outcome of N throws; the bin is a compartment, and a drop points along x.

    The cycle lasts from closing until the object has passed the rim plane and the robot is back above the pick.
    """

    picked: Bools
    """Whether the claws held the lifted object at the command to open (N,)."""
    slip: Floats
    """Motion of the object along the pads, from leaving the table to the command to open (N,) [m]."""
    release_delay: Floats
    """Time at which the object came free, after the planned release of an uncorrected throw (N,) [s]."""
    energy: Floats
    """Positive mechanical work of the motors (N,) [J], without the way back, whose time alone is planned."""


def judge(throws: RecordedThrows, plans: TossPlans, config: GripperConfig, return_time: Floats) -> Outcome:
    """Outcome of N throws.

    Args:
        throws: recorded throws.
        plans: plans of the throws.
        config: level of the cell.
        return_time: time from the end of the throw back above the pick (N,) [s].
    """
    tray, arrival = config.tray, throws.release_time + plans.flight_time
    opening = np.array([tray.opening])
    down = touchdown(ObjectFlight(*in_order(*throws.flight)), plans.target)
    landing = down.landing_fields(plans.target, opening, np.array([tray.depth]), plans.heading)
    return Outcome(
        **landing,
        landing_error=np.hypot(landing["landing_along"], landing["landing_across"]),
        picked=throws.lifted >= LIFT * (plans.release[:, 2] - plans.pick[:, 2]),
        slip=throws.slip,
        release_delay=throws.release_time - plans.release_time,
        cycle_time=np.maximum(arrival, plans.stop_time + return_time),
        peak_torque=throws.peak_torque,
        energy=throws.energy,
    )
