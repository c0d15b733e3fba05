"""What changes in a cell during a shift and no sensor tells, as a level says it: valve, camera, encoder and draught.

Values are assumed, of the size that maintenance reports of such cells speak of; every one is centred at zero, so that
nothing that does not adapt can gain by their mean.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Self, final

import numpy as np
from pydantic import Field, model_validator

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.config import Section


class Wander(Section):
    """Abstract: how one thing that nobody sees changes; the parts add up, and the sum stays within `most`."""

    key: ClassVar[str]
    unit: ClassVar[str]
    bound: ClassVar[float]
    """What none of its numbers may exceed."""

    even: float = Field(default=0.0, description="Constant in a shift, uniform within +- this.")
    normal: float = Field(default=0.0, description="Constant in a shift, normal with this standard deviation.")
    step: float = Field(default=0.0, description="A new value after every `steps_every` picks, uniform within +- this.")
    walk: float = Field(default=0.0, description="Random walk: standard deviation of a change between picks.")
    ramp: float = Field(
        default=0.0,
        description="A straight line through the shift, zero in its middle; its end is uniform within +- this.",
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
        """Whether it is ever anything but zero."""
        return self.most > 0.0 and any((self.even, self.normal, self.step, self.walk, self.ramp))

    def path(self, random: np.random.Generator, picks: int, steps_every: int) -> Floats:
        """Its values at the picks of a shift (P,); the same number of draws whatever the level says."""
        even, ramp, level = random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.standard_normal()
        steps = random.uniform(-1.0, 1.0, picks)[np.arange(picks) // steps_every]
        walk = np.concatenate([[0.0], np.cumsum(random.standard_normal(picks)[1:])])
        through = np.linspace(-1.0, 1.0, picks) if picks > 1 else np.zeros(1)
        parts = (even * self.even, level * self.normal, steps * self.step, walk * self.walk, ramp * through * self.ramp)
        return np.clip(sum(parts, np.zeros(picks)), -self.most, self.most)


@final
class Valve(Wander):
    """Release later than the vacuum alone explains [s]: supply pressure, temperature, a film on the cup."""

    key, unit, bound = "delay", "s", 0.03

    most: float = Field(default=0.02, description="The sum never leaves +- this.")
    film: float = Field(
        default=0.0,
        description="Dirt on the cup: the delay grows evenly by this until the cup is cleaned, half of it below zero.",
    )
    cleaned: Annotated[int, Field(ge=2, le=100_000)] = Field(
        default=25, description="Picks between two cleanings; a shift begins anywhere between."
    )

    @property
    def moves(self) -> bool:
        """Whether it is ever anything but zero."""
        return super().moves or (self.most > 0.0 and self.film > 0.0)

    def path(self, random: np.random.Generator, picks: int, steps_every: int) -> Floats:
        """Its values at the picks of a shift (P,) [s]."""
        others = super().path(random, picks, steps_every)
        since = (random.integers(self.cleaned) + np.arange(picks)) % self.cleaned
        return np.clip(others + self.film * (since / (self.cleaned - 1) - 0.5), -self.most, self.most)


@final
class CameraOffset(Wander):
    """Where the camera takes objects to be, against where they are, along x and along y [m]: each on its own."""

    key, unit, bound = "camera", "m", 0.05

    most: float = Field(default=0.03, description="The sum never leaves +- this.")


@final
class Encoder(Wander):
    """Relative error of the belt's encoder; what it adds up to grows from the camera on."""

    key, unit, bound = "encoder", "of the speed", 0.05

    most: float = Field(default=0.03, description="The sum never leaves +- this.")


@final
class Draught(Wander):
    """Air that moves through the cell along x and along y, each on its own [m/s]."""

    key, unit, bound = "draught", "m/s", 3.0

    most: float = Field(default=1.5, description="The sum never leaves +- this.")


@final
class Drift(Section):
    """What changes during a shift; it scales with the mismatch, and by default nothing does."""

    delay: Valve = Valve()
    camera: CameraOffset = CameraOffset()
    encoder: Encoder = Encoder()
    draught: Draught = Draught()
    steps_every: Annotated[int, Field(ge=1, le=100_000)] = Field(
        default=25, description="Picks between two values of a `step`, counted from the beginning of a shift."
    )

    @property
    def moves(self) -> bool:
        """Whether anything ever changes."""
        return any(one.moves for one in (self.delay, self.camera, self.encoder, self.draught))


@final
class Feedback(Section):
    """What the camera over a bin tells of the throw before: of `PnTAdapt-v0`."""

    noise: Annotated[float, Field(ge=0, le=0.1)] = Field(
        default=0.005, description="Standard deviation of the landing it sees, along and across [m]."
    )
    unseen: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.05, description="Share of the landings that it misses by chance."
    )
    view: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.25, description="It sees what comes down within this of the target [m]."
    )
