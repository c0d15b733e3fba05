"""Config sections of what no sensor measures: drift during a shift, differences between cells, and fitted constants.

Values of drift are assumed, of the size in maintenance reports of such cells. Every drift is centred at zero, so that a
controller without adaptation cannot gain from its mean. Ranges of what differs between cells are assumed as well. The
constants are those of one cell, from its measured throws.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Self, final

import numpy as np
from pydantic import Field, model_validator

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.config import Section, check_ranges


class Wander(Section):
    """Abstract: how one hidden value changes during a shift; its parts add up, and the sum stays within `most`."""

    key: ClassVar[str]
    unit: ClassVar[str]
    bound: ClassVar[float]
    """Bound of all numbers of this section."""

    even: float = Field(
        default=0.0, description="Constant in a shift: drawn uniformly from minus this value to this value."
    )
    normal: float = Field(
        default=0.0, description="Constant in a shift: drawn from a normal distribution with this standard deviation."
    )
    step: float = Field(
        default=0.0,
        description="Jumps: a new value after every `steps_every` picks, drawn uniformly from minus this value to "
        "this value.",
    )
    walk: float = Field(default=0.0, description="Random walk: standard deviation of the change from pick to pick.")
    ramp: float = Field(
        default=0.0,
        description="Straight line through the shift, zero in its middle; the end is drawn uniformly from minus "
        "this value to this value.",
    )
    most: float

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name, value in self:
            if isinstance(value, float) and not 0.0 <= value <= self.bound:
                raise ValueError(
                    f"drift.{self.key}.{name} is {value:g} {self.unit}; it must be 0 to {self.bound:g} {self.unit}"
                )
        return self

    @property
    def moves(self) -> bool:
        """Whether the drift is ever different from zero."""
        return self.most > 0.0 and any((self.even, self.normal, self.step, self.walk, self.ramp))

    def path(self, random: np.random.Generator, picks: int, steps_every: int) -> Floats:
        """Values at the picks of a shift (P,); the number of draws does not depend on the level."""
        # Every part is drawn at every level, so the draws that follow do not depend on the parts that a level uses.
        even, ramp, level = random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.standard_normal()
        steps = random.uniform(-1.0, 1.0, picks)[np.arange(picks) // steps_every]
        walk = np.concatenate([[0.0], np.cumsum(random.standard_normal(picks)[1:])])
        # From -1 to 1, so that the ramp's mean over a shift is zero.
        through = np.linspace(-1.0, 1.0, picks) if picks > 1 else np.zeros(1)
        parts = (even * self.even, level * self.normal, steps * self.step, walk * self.walk, ramp * through * self.ramp)
        return np.clip(sum(parts, np.zeros(picks)), -self.most, self.most)


@final
class Valve(Wander):
    """Release delay beyond that of the vacuum [s]: supply pressure, temperature, a film on the cup."""

    key, unit, bound = "delay", "s", 0.03

    most: float = Field(default=0.02, description="Bound of the sum of all parts, up and down.")
    film: float = Field(
        default=0.0,
        description="Dirt on the cup: the delay grows evenly by this value until the cup is cleaned, from minus "
        "half of it to half of it.",
    )
    cleaned: Annotated[int, Field(ge=2, le=100_000)] = Field(
        default=25, description="Picks between two cleanings; a shift begins anywhere between two cleanings."
    )

    @property
    def moves(self) -> bool:
        """Whether the drift is ever different from zero."""
        return super().moves or (self.most > 0.0 and self.film > 0.0)

    def path(self, random: np.random.Generator, picks: int, steps_every: int) -> Floats:
        """Values at the picks of a shift (P,) [s]."""
        parts = super().path(random, picks, steps_every)
        since = (random.integers(self.cleaned) + np.arange(picks)) % self.cleaned
        # Half of the growth is taken off, so that the film's mean is zero.
        return np.clip(parts + self.film * (since / (self.cleaned - 1) - 0.5), -self.most, self.most)


@final
class CameraOffset(Wander):
    """Error of the camera's object positions, along x and along y, independent of each other [m]."""

    key, unit, bound = "camera", "m", 0.05

    most: float = Field(default=0.03, description="Bound of the sum of all parts, up and down.")


@final
class Encoder(Wander):
    """Relative error of the belt's encoder; the position error grows with the distance from the camera."""

    key, unit, bound = "encoder", "of the speed", 0.05

    most: float = Field(default=0.03, description="Bound of the sum of all parts, up and down.")


@final
class Draught(Wander):
    """Velocity of air through the cell, along x and along y, independent of each other [m/s]."""

    key, unit, bound = "draught", "m/s", 3.0

    most: float = Field(default=1.5, description="Bound of the sum of all parts, up and down.")


@final
class Drift(Section):
    """Drift during a shift; every drift scales with the mismatch, and by default there is none."""

    delay: Valve = Valve()
    camera: CameraOffset = CameraOffset()
    encoder: Encoder = Encoder()
    draught: Draught = Draught()
    steps_every: Annotated[int, Field(ge=1, le=100_000)] = Field(
        default=25, description="Picks between two values of a `step`, counted from the beginning of a shift."
    )

    @property
    def moves(self) -> bool:
        """Whether any drift is ever different from zero."""
        return any(section.moves for section in (self.delay, self.camera, self.encoder, self.draught))


_Time = Annotated[float, Field(ge=0, le=0.1)]
_Speed = Annotated[float, Field(ge=0, le=1)]
_Stiffness = Annotated[float, Field(ge=0.05, le=100)]
_Factor = Annotated[float, Field(ge=0.1, le=10)]
_Points = Annotated[float, Field(ge=-0.5, le=0.5)]
_Scale = Annotated[float, Field(ge=-0.1, le=0.1)]


@final
class Cells(Section):
    """Ranges from which each episode draws the cell in which it takes place; null: as the level's other sections say.

    A range whose ends are equal fixes its value. Differences scale with the mismatch.
    """

    valve: tuple[_Time, _Time] | None = Field(default=None, description="Delay of the valve, drawn uniformly [s].")
    tau: tuple[_Time, _Time] | None = Field(
        default=None, description="Time constant of the vacuum under a tight seal, drawn uniformly [s]."
    )
    blow_off: tuple[_Speed, _Speed] | None = Field(
        default=None,
        description="Speed downwards that air blown into the cup gives an object at its release, drawn uniformly "
        "[m/s].",
    )
    stiffness: tuple[_Stiffness, _Stiffness] | None = Field(
        default=None, description="Stiffness of the lip, whose logarithm is drawn uniformly [N m/rad]."
    )
    drag: tuple[_Factor, _Factor] | None = Field(
        default=None, description="Factor of every item's drag, drawn uniformly."
    )
    restitution: tuple[_Factor, _Factor] | None = Field(
        default=None, description="Factor of every object's restitution, which stays at most 1, drawn uniformly."
    )
    seal: tuple[_Points, _Points] | None = Field(
        default=None,
        description="Difference of every item's chance that a cup seals, which stays between 0 and 1, drawn uniformly.",
    )
    camera: tuple[_Scale, _Scale] | None = Field(
        default=None,
        description="True distance of an object from the middle of the belt's lane over that of the belt's camera, "
        "minus 1, drawn uniformly.",
    )
    encoder: tuple[_Scale, _Scale] | None = Field(
        default=None, description="True speed of the belt over the encoder's, minus 1, drawn uniformly."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_ranges(self, "cells", *self.ranges)
        return self

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The ranges that are given, by key."""
        return {name: getattr(self, name) for name in type(self).model_fields if getattr(self, name) is not None}

    def draw(self, random: np.random.Generator) -> dict[str, float]:
        """Values of one cell by the keys of the given ranges; each value has a draw of its own at every level."""
        shares = dict(zip(type(self).model_fields, random.random(len(type(self).model_fields)).tolist(), strict=True))
        drawn = dict[str, float]()
        for name, (low, high) in self.ranges.items():
            is_log = name == "stiffness"
            ends = np.log((low, high)) if is_log else np.array((low, high))
            value = ends[0] + shares[name] * (ends[1] - ends[0])
            drawn[name] = float(np.clip(np.exp(value) if is_log else value, low, high))
        return drawn


_Offset = Annotated[float, Field(ge=-CameraOffset.bound, le=CameraOffset.bound)]


@final
class Bias(Section):
    """Constants by which a cell is off its data sheet, such as `pnt-gym fit` finds; each scales with the mismatch."""

    camera: tuple[_Offset, _Offset] = Field(
        default=(0.0, 0.0), description="True position of an object minus that of the belt's camera, along x, y [m]."
    )
    encoder: Annotated[float, Field(ge=-Encoder.bound, le=Encoder.bound)] = Field(
        default=0.0, description="True speed of the belt over the encoder's, minus 1."
    )
    drag: Annotated[float, Field(ge=-0.9, le=9.0)] = Field(
        default=0.0, description="True drag of every item over the catalogue's, minus 1."
    )
    delay: Annotated[float, Field(ge=-Valve.bound, le=Valve.bound)] = Field(
        default=0.0, description="Delay of every release beyond that of `suction` [s]."
    )

    @property
    def applies(self) -> bool:
        """Whether any constant is different from zero."""
        return any((*self.camera, self.encoder, self.drag, self.delay))


@final
class Feedback(Section):
    """The camera over a bin that measures the landing of the previous throw, in `PnTAdapt-v0`."""

    noise: Annotated[float, Field(ge=0, le=0.1)] = Field(
        default=0.005,
        description="Standard deviation of the landing that the camera measures, along and across the throw [m].",
    )
    unseen: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.05, description="Share of the landings that the camera misses by chance."
    )
    view: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.25, description="Largest distance from the target at which the camera sees a landing [m]."
    )
