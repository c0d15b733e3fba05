"""Surfaces of items: zones in which an item is deeper, rougher, leakier or looks different than elsewhere."""

from __future__ import annotations

from typing import Annotated, Final, Literal, Self, TypeAlias, final, get_args

from pydantic import ConfigDict, Field, model_validator

from pnt_gym.cells.base.config import Section, Share
from pnt_gym.errors import ConfigError

ZoneShape = Literal["rect", "disc", "bowl"]
ZONE_SHAPES: Final[tuple[ZoneShape, ...]] = get_args(ZoneShape)
MOST_ZONES: Final = 6
"""Largest number of zones of an item."""
_Place = Annotated[float, Field(ge=-1.0, le=1.0)]
_Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
_Amplitude = Annotated[float, Field(ge=0.0, le=0.02)]
_Wavelength = Annotated[float, Field(ge=0.002, le=0.5)]
Waves: TypeAlias = tuple[_Amplitude, _Wavelength]
"""Amplitude and wavelength of a surface that is not flat [m]."""
Look: TypeAlias = tuple[_Fraction, _Place, _Fraction, _Fraction]
"""Brightness (0 black, 1 white), warmth (-1 blue, 1 orange), gloss (0 matte, 1 mirror) and texture (0 plain)."""
PLAIN_LOOK: Final[Look] = (0.5, 0.0, 0.2, 0.05)


@final
class Zone(Section):
    """A part of an item's upper face; what a zone does not give is as beside the zone.

    The axes are those of the item: x along its length, y across. An object lies either way round, so a zone is as often
    at the other end, and as often on the other side.

    Attributes:
        shape: `rect` a rectangle, `disc` an ellipse, both of one depth; `bowl` an ellipse, deepest in its middle.
        at: middle in shares of the item's half length and half width, each -1 to 1.
        size: extents in shares of the item's length and width.
        chance: probability that an object has the zone.
        depth: depth below the surface around it, in m; negative where the zone stands out.
        leak: how well air flows through the surface, in multiples of what the item's own surface lets through.
        relief: amplitude of bumps that replace those of the item, in m; they have the item's wavelength.
        ribs: amplitude and wavelength of ribs across the item's length, in m.
        look: brightness, warmth, gloss and texture.
        spread: largest deviation of the middle from `at`, in shares as there; the zone stays on the item.
    """

    model_config = ConfigDict(allow_inf_nan=False)

    shape: ZoneShape = "rect"
    at: tuple[_Place, _Place] = (0.0, 0.0)
    size: tuple[Share, Share] = (1.0, 1.0)
    chance: Share = 1.0
    depth: float = Field(default=0.0, ge=-0.02, le=0.2, json_schema_extra={"unit": "m"})
    leak: float | None = Field(default=None, ge=0.0, le=1000.0)
    relief: _Amplitude | None = None
    ribs: Waves | None = None
    look: Look | None = None
    spread: _Fraction = 0.0

    @model_validator(mode="after")
    def _check(self) -> Self:
        for place, extent, axis in zip(self.at, self.size, "xy", strict=True):
            if abs(place) + extent > 1.0 + 1e-9:
                raise ConfigError(
                    f"a zone of size {extent} at {axis} = {place} is partly outside of its item: |at| + size is "
                    f"{abs(place) + extent:g}, but must be from 0 to 1."
                )
        return self
