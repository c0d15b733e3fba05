"""A robot by its data sheet: how fast its hand is, where the hand reaches, and what the hand carries.

Shipped sheets are files `robots/NAME.yaml` beside the levels. Heights count in the cell's frame, like `belt.height`;
places count from the robot's base.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Final, Literal, cast, final

import numpy as np
from pydantic import Field, model_validator

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.config import Finite, Label, NonNegative, Positive, Range, Section, locate_files, shipped_folder
from pnt_gym.errors import ConfigError
from pnt_gym.names import list_names, unknown_name
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows, MotionLimits
from pnt_gym.planning.motion.roots import bisect
from pnt_gym.planning.motion.scurve import min_time_scurve
from pnt_gym.reading import parsed_yaml, text_of

WAY: Final = 0.355
"""Way of half a standard cycle: 25 mm up, 305 mm across and 25 mm down [m]."""
JERKS: Final = (1.0, 1e6)
"""Jerks among which the jerk of a standard cycle is looked for [m/s3]."""
HALVINGS: Final = 52
"""Halvings of the bracket of a jerk, until a double resolves no more."""
AGREEMENT: Final = 0.10
"""Largest difference of a sheet's standard cycle from that of its limits, as a share."""
_GIVEN: Final[Mapping[str, tuple[str, ...]]] = {
    "ellipse": ("semi_x", "semi_y"), "circle": ("radius",), "ring": ("radius", "hole"),
}  # fmt: skip
"""Lengths that each shape of a reach needs."""


@final
class Reach(Section):
    """Where a robot's hand reaches, in top view."""

    shape: Literal["ellipse", "circle", "ring"] = Field(
        description="Outline: a `ring` is a circle with a hole, which the robot's own base fills."
    )
    semi_x: Positive | None = Field(default=None, description="Semi-axis of the ellipse along the belt [m].")
    semi_y: Positive | None = Field(default=None, description="Semi-axis of the ellipse across the belt [m].")
    radius: Positive | None = Field(default=None, description="Radius of the circle, outer radius of the ring [m].")
    hole: Positive | None = Field(default=None, description="Inner radius of the ring [m].")
    x: Finite = Field(default=0.0, description="Centre along the belt, from the robot's base [m].")
    y: Finite = Field(default=0.0, description="Centre across the belt, from the robot's base [m].")

    @model_validator(mode="after")
    def _check(self) -> Reach:
        lengths = ("semi_x", "semi_y", "radius", "hole")
        given, needed = [name for name in lengths if getattr(self, name) is not None], _GIVEN[self.shape]
        if set(given) != set(needed):
            raise ValueError(f"a reach of shape {self.shape!r} has {list_names(needed)}, and not {list_names(given)}")
        if self.hole is not None and self.radius is not None and self.hole >= self.radius:
            raise ValueError(f"hole is {self.hole:g} m; it must be below the radius, {self.radius:g} m")
        return self

    @property
    def semi_axes(self) -> tuple[float, float]:
        """Semi-axes along and across the belt [m]."""
        return self.semi_x or self.radius or 0.0, self.semi_y or self.radius or 0.0


@final
class ModelSection(Section):
    """A serial arm by its model file: joints, masses and motors of the robot, for `fidelity: full`."""

    file: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        description="MJCF or URDF, in a path from the file that names it."
    )
    base: tuple[Finite, Finite, Finite] = Field(
        default=(0.0, 0.0, 0.0), description="Place of the model's origin, in the cell's frame [m]."
    )
    turn: tuple[Finite, Finite, Finite] = Field(
        default=(0.0, 0.0, 0.0), description="Rotation vector of the model's axes in the cell [rad]."
    )
    tool: Label | None = Field(
        default=None,
        description="Site or body of the model whose z axis points out of the flange; null: the body behind the last "
        "joint.",
    )
    stem: Annotated[float, Field(ge=0, le=2)] = Field(
        default=0.1, description="Distance of the cup's tip from the tool, along its z axis [m]."
    )
    hand: NonNegative = Field(
        default=0.5, description="Mass of the cup and its mount, in the middle of the stem; assumed [kg]."
    )
    home: tuple[Finite, ...] | None = Field(
        default=None,
        description="Positions of the joints in which the cup hangs over the belt, and near which the arm works; "
        "null: all 0 [rad, m].",
    )
    speed: tuple[Positive, ...] | None = Field(
        default=None, description="Largest speed of each joint; null: those of the URDF [rad/s, m/s]."
    )
    torque: tuple[Positive, ...] | None = Field(
        default=None, description="Largest torque of each motor; null: those of the file [N m, N]."
    )


@final
class RobotSheet(Section):
    """A robot by its data sheet."""

    name: Label = Field(
        default="own",
        description="Name of the robot. In place of the section, its name takes a shipped sheet: `robot: scara_700`.",
    )
    velocity: Positive = Field(description="Largest speed of the hand [m/s].")
    acceleration: Positive = Field(description="Largest acceleration of the hand [m/s2].")
    jerk: Positive | None = Field(
        default=None, description="Largest jerk of the hand [m/s3]; null: the jerk that gives the standard cycle."
    )
    standard_cycle: Annotated[float, Field(gt=0, le=10)] | None = Field(
        default=None,
        description="Time of the standard cycle, 25 mm up, 305 mm across, 25 mm down and back [s]. The corners are "
        "rounded, so half a cycle is taken as one stroke of 355 mm.",
    )
    reach: Reach = Field(description="Where the hand reaches.")
    height: Range = Field(description="Least and greatest height of the tip of the cup, in the cell's frame [m].")
    payload: Positive = Field(description="Largest mass that the cup carries [kg].")
    accuracy: Annotated[float, Field(ge=0, le=0.05)] = Field(
        default=0.0, description="Standard deviation of the hand's place in a throw, along each axis [m]."
    )
    energy: NonNegative | None = Field(
        default=None,
        description="Energy of a standard cycle [J]; a throw takes as much in the same time. null: no figure, and "
        "results have none.",
    )
    source: Annotated[str, Field(max_length=400)] = Field(
        default="", description="Where the numbers are from, and which of them are assumed."
    )
    model: ModelSection | None = Field(
        default=None,
        description="Joints and motors of a serial arm; null: the sheet alone is known, and its hand is simulated with "
        "`fidelity: flight`.",
    )

    @model_validator(mode="before")
    @classmethod
    def _read(cls, value: Any) -> Any:
        """The values of a shipped sheet, from its name."""
        return read_sheet(value) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _check_together(self) -> RobotSheet:
        if problems := [*self._problems()]:
            raise ValueError(*problems)
        return self

    def _problems(self) -> Iterator[str]:
        if self.height[0] >= self.height[1]:
            yield f"robot.height runs from {self.height[0]:g} to {self.height[1]:g} m; the first value must be smaller"
        stated = self.standard_cycle
        if self.jerk is None and stated is None:
            yield "robot.jerk and standard_cycle are missing; give the jerk, or the cycle from which it follows"
        elif self.jerk is None and stated is not None:
            least, most = self._cycle(JERKS[1]), self._cycle(JERKS[0])
            if not least < stated < most:
                yield (
                    f"robot.standard_cycle is {stated:g} s; with velocity {self.velocity:g} m/s and acceleration "
                    f"{self.acceleration:g} m/s2 it takes more than {least:.3g} s, and less than {most:.3g} s"
                )
        elif self.jerk is not None and stated is not None:
            cycle = self._cycle(self.jerk)
            if abs(cycle / stated - 1.0) > AGREEMENT:
                yield (
                    f"robot.standard_cycle is {stated:g} s, and the limits give {cycle:.3g} s; leave one of jerk and "
                    f"standard_cycle out, or let them agree within {AGREEMENT:.0%}"
                )

    def _cycle(self, jerk: float) -> float:
        """Time of the standard cycle with a jerk [s]."""
        return 2.0 * min_time_scurve(WAY, MotionLimits(self.velocity, self.acceleration, jerk)).duration

    @cached_property
    def full_jerk(self) -> float:
        """The largest jerk: that of the sheet, or the jerk with which its standard cycle takes its time [m/s3]."""
        if self.jerk is not None:
            return self.jerk
        stated, (low, high) = self.standard_cycle or 0.0, np.log(JERKS)[:, None]
        jerk, _ = bisect(lambda log: np.array([self._cycle(math.exp(log[0])) > stated]), low, high, HALVINGS)
        return math.exp(jerk[0])

    @cached_property
    def cycle(self) -> float:
        """Time of the standard cycle with the robot's limits [s]."""
        return self._cycle(self.full_jerk)

    def limits(self, percent: Floats) -> LimitRows:
        """Limits with V, A and J scaled together (Hassan et al. 2022, IV-B3), by shares (N,) of the whole [%]."""
        full = self.velocity, self.acceleration, self.full_jerk
        return LimitRows(*(limit * percent / 100.0 for limit in full))

    @property
    def workspace(self) -> EllipticWorkspace:
        """Where the hand may be."""
        reach, (low, high) = self.reach, self.height
        return EllipticWorkspace(*reach.semi_axes, low, high, reach.x, reach.y, reach.hole or 0.0)

    @cached_property
    def has_model(self) -> bool:
        """Whether joints and torques of the robot are simulated: those of the T3KR and of arms are."""
        return self.model is not None or self == T3KR


def sheet_names() -> tuple[str, ...]:
    """Names of the shipped sheets."""
    return tuple(sorted(path.stem for path in shipped_folder("robots").glob("*.yaml")))


def read_sheet(name: str) -> dict[str, Any]:
    """Values of a shipped sheet.

    Raises:
        ConfigError: there is no such sheet.
    """
    if name not in sheet_names():
        raise ConfigError(unknown_name("robot", name, sheet_names(), ", or a section with its data sheet"))
    folder = shipped_folder("robots")
    return {"name": name, **_located(parsed_yaml(text_of(folder / f"{name}.yaml")), folder)}


def _located(sheet: dict[str, Any], folder: Path) -> dict[str, Any]:
    """A sheet with the path of its model file in a folder, if it names a file there."""
    model = sheet.get("model")
    return {**sheet, "model": locate_files(cast("Any", model), folder, "file")} if isinstance(model, dict) else sheet


def locate_robot(section: Any, folder: Path) -> Any:
    """A section whose key `robot` may hold a sheet, with the path of the sheet's model file in a folder."""
    if not isinstance(section, dict) or not isinstance(cast("Any", section).get("robot"), dict):
        return cast("Any", section)
    return {**cast("Any", section), "robot": _located(cast("Any", section)["robot"], folder)}


T3KR: Final = RobotSheet.model_validate("t3kr")
"""The robot of Hassan et al. 2022."""
