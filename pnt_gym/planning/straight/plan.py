"""Records of planned throws, and the reasons why a throw may not exist."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, length
from pnt_gym.errors import PntGymError
from pnt_gym.planning.reasons import ReasonCode
from pnt_gym.rows import Columns, Triple, field

MIN_REACH = 1e-9
"""Horizontal distances up to this [m] count as zero, so that the throw has no direction."""

CONTACT = 1e-9
"""Distance below the ceiling [m] up to which a release counts as being at the ceiling."""


@final
class Reason(ReasonCode):
    """Why a row of a batch holds no plan."""

    FEASIBLE = 0, "a throw exists"
    NO_REACH = 1, "the target lies straight above or below the pick, or within the tolerance of it"
    CEILING = 2, "every release that hits the target lies above the ceiling"
    WORKSPACE = 3, "every release that hits the target lies outside the workspace"
    ELEVATION = 4, "a line at this elevation does not pass above the target"
    PLANE = 5, "the object never comes down through the plane"
    SAME_POINT = 6, "the release point is the pick, so the hand has no way to gain speed"


@final
class InfeasibleThrow(PntGymError):
    """No throw satisfies the bounds; ``reason`` names the bound that cannot be met."""

    def __init__(self, reason: Reason, detail: str = "") -> None:
        self.reason = reason
        super().__init__(reason.sentence + detail)


@final
@dataclass(frozen=True, eq=False)
class Release:
    """One planned throw.

    Attributes:
        position: release point (3,) [m].
        velocity: velocity of hand and object at the release (3,) [m/s].
        direction: unit vector of pick to release point (3,).
        speed: release speed V_r [m/s].
        acceleration: greatest acceleration on the way to the release [m/s2].
        angle: elevation theta of the line above the horizontal [rad].
        azimuth: direction of the line in top view, from +x to +y [rad].
        distance: way from the pick to the release P_r [m].
        time: time from the pick to the release t_r [s] (Eq. 12).
        flight_time: time from the release to the target [s].
        ceiling_active: whether the ceiling moved the release off the free optimum.
        workspace_active: whether the workspace moved the release off the free optimum.
    """

    position: Floats
    velocity: Floats
    direction: Floats
    speed: float
    acceleration: float
    angle: float
    azimuth: float
    distance: float
    time: float
    flight_time: float
    ceiling_active: bool
    workspace_active: bool


@final
class ReleaseBatch(Columns):
    """N planned throws: the fields of ``Release`` with N first, NaN and False in rows without a plan."""

    position: Triple = field("m", "release point")
    velocity: Triple = field("m/s", "velocity of hand and object at the release")
    direction: Triple = field("-", "unit vector of pick to release point, or of the velocity if not `straight`")
    speed: Floats = field("m/s", "release speed")
    acceleration: Floats = field("m/s2", "greatest acceleration on the way to the release")
    angle: Floats = field("rad", "elevation of the line above the horizontal")
    azimuth: Floats = field("rad", "direction of the line in top view, from +x to +y")
    distance: Floats = field("m", "way from the pick to the release")
    time: Floats = field("s", "time from the pick to the release")
    flight_time: Floats = field("s", "time from the release to the target")
    ceiling_active: Bools = field("-", "whether the ceiling moved the release off the free optimum")
    workspace_active: Bools = field("-", "whether the workspace moved the release off the free optimum")
    feasible: Bools = field("-", "whether the row holds a plan")
    reason: Ints = field("-", "`Reason` code, 0 where feasible")
    straight: Bools = field("-", "whether the hand moves straight to the release; if not, the motion is planned apart")

    @classmethod
    def from_velocities(
        cls,
        pick: Floats,
        position: Floats,
        velocity: Floats,
        ahead: Floats,
        *,
        ceiling_active: Bools,
        reason: Ints,
        **columns: Floats,
    ) -> ReleaseBatch:
        """Return releases that do not lie on straight lines from the picks, without the motions to the releases.

        Args:
            pick: starts of the hands (N, 3) [m].
            position: release points (N, 3) [m].
            velocity: velocities of hands and objects at the releases (N, 3) [m/s].
            ahead: vectors that point along the throws (N, 3); 0 where there is no direction.
            ceiling_active: whether the ceiling moved a release (N,).
            reason: ``Reason`` codes (N,); only the feasible rows hold a plan.
            columns: acceleration, time and flight time of the throws (N,).
        """
        feasible, far = reason == Reason.FEASIBLE, length(ahead)
        flat = np.sqrt(velocity[:, 0] ** 2 + velocity[:, 1] ** 2)
        columns.update(
            speed=length(velocity),
            angle=np.arctan2(velocity[:, 2], flat),
            azimuth=np.arctan2(ahead[:, 1], ahead[:, 0]),
            distance=length(position - pick),
        )
        vectors = {
            "position": position,
            "velocity": velocity,
            "direction": ahead / np.where(far > 0.0, far, 1.0)[:, None],
        }
        gap = np.where(feasible, 0.0, np.nan)
        return cls.of(
            len(reason),
            **{name: vector + gap[:, None] for name, vector in vectors.items()},
            **{name: column + gap for name, column in columns.items()},
            ceiling_active=feasible & ceiling_active,
            feasible=feasible,
            reason=reason,
        )

    def __len__(self) -> int:
        return len(self.rows)

    def row(self, index: int) -> Release:
        """Return the throw of one row.

        Raises:
            InfeasibleThrow: if the row holds no plan.
        """
        position, velocity, direction, *numbers, feasible, reason, _ = self.rows[index].item()
        if not feasible:
            raise InfeasibleThrow(Reason(reason), f" (row {index})")
        return Release(position.copy(), velocity.copy(), direction.copy(), *numbers)


class TargetChoice(NamedTuple):
    """Targets of N throws: index of each target, the releases, and which throws are accepted (N,)."""

    attempt: Ints
    plan: ReleaseBatch
    good: Bools
