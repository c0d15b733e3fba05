"""Robot of a cell: the prototype, a larger robot of its form, or a robot with a user's own parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Annotated, Any, Final, Self, cast

from pydantic import AfterValidator, Field, model_validator

from pnt_gym.cells.base.config import LARGEST_NUMBER, Positive, Section, leaves_of
from pnt_gym.errors import ConfigError, one_sentence
from pnt_gym.names import unknown_name
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD, Build, Claws, MotorServo
from pnt_gym.robots.gripper.geometry import PROTOTYPE, Dimensions


def _check(part: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the values of a part, after refusing numbers that no cell has."""
    for name, value in part.items():
        for number in leaves_of(value):
            if isinstance(number, int | float) and not abs(number) < LARGEST_NUMBER:
                shown = one_sentence(repr(number), 40)
                raise ConfigError(
                    f"{name!r} has the number {shown}; it must be less than {LARGEST_NUMBER:g} either way"
                )
    return part


_Part = Annotated[Mapping[str, Any], AfterValidator(_check)]
_NAMES: Final = {
    "servo": tuple(field.name for field in fields(MotorServo)),
    "claws": tuple(field.name for field in fields(Claws)),
    "masses": tuple(field.name for field in fields(Build) if field.name.endswith("_mass")),
}
"""Names of the values that each part of a robot has."""


class Robot(Section):
    """The robot's parts; parts that are not given are the prototype's, `scale` times as long.

    Masses grow with the square of the scale and the fingers' springs with its cube; the servos do not.
    """

    scale: Positive = Field(default=1.0, description="Factor of every length of the prototype.")
    dimensions: _Part = Field(
        default_factory=dict,
        description="Lengths, strokes and home pose that differ from the prototype's, by the names of `Dimensions`.",
    )
    servo: _Part = Field(
        default_factory=dict,
        description="Values of the servos that differ from the prototype's, by the names of `MotorServo`.",
    )
    claws: _Part = Field(
        default_factory=dict,
        description="Values of the claws that differ from the prototype's, by the names of `Claws`.",
    )
    masses: _Part = Field(
        default_factory=dict, description="Masses that differ from the prototype's, by the names of `Build` [kg]."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        self.parts()
        return self

    @property
    def size(self) -> float:
        """Span of the arms over the prototype's."""
        dimensions, _ = self.parts()
        return (dimensions.r + dimensions.l) / (PROTOTYPE.r + PROTOTYPE.l)

    def parts(self) -> tuple[Dimensions, Build]:
        """Lengths of the robot, and its build: masses, servos and claws.

        Raises:
            ConfigError: a name belongs to no part, or the values describe no possible robot.
        """
        lengths = asdict(PROTOTYPE.with_scale(self.scale)) | dict(self.dimensions)
        servo = replace(PROTOTYPE_BUILD.servo, **_check_values("servo", self.servo))
        build = PROTOTYPE_BUILD.with_scale(self.scale, servo)
        claws = replace(build.claws, **_check_values("claws", self.claws))
        masses = _check_values("masses", self.masses)
        return Dimensions.from_mapping(lengths), replace(build, **masses, claws=claws)


def _check_values(part: str, values: _Part) -> dict[str, Any]:
    """The values of a part, if all of them have a known name and are numbers."""
    for name, value in values.items():
        if name not in _NAMES[part]:
            raise ConfigError(f"robot.{part}: {unknown_name('key', name, _NAMES[part])}")
        is_sequence = name == "pad" and isinstance(value, list | tuple)
        numbers: list[object] = [*cast("list[object]", value)] if is_sequence else [value]
        count, form = (3, "three lengths in m") if name == "pad" else (1, "a number")
        if len(numbers) != count or any(isinstance(v, bool) or not isinstance(v, int | float) for v in numbers):
            raise ConfigError(f"robot.{part}.{name} is {value!r}; it must be {form}")
    return {name: tuple(value) if name == "pad" else value for name, value in values.items()}
