"""Colours and finishes of everything that pictures show.

A colour is the name of its finish: pictures look up a geom's colour here. The physics knows colours alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from colorsys import hsv_to_rgb
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, TypeAlias, final

import numpy as np

Colour: TypeAlias = tuple[float, float, float, float]
"""Red, green, blue, opacity."""

PAINT: Final[Colour] = (0.90, 0.91, 0.92, 1.0)
"""White castings of robots."""
STEEL: Final[Colour] = (0.62, 0.65, 0.69, 1.0)
MOTOR: Final[Colour] = (0.16, 0.18, 0.21, 1.0)
ACCENT: Final[Colour] = (0.96, 0.44, 0.07, 1.0)
"""Orange of arms, rings and marks."""
CARBON: Final[Colour] = (0.09, 0.09, 0.10, 1.0)
ALUMINIUM: Final[Colour] = (0.80, 0.82, 0.85, 1.0)
PRINT: Final[Colour] = (0.20, 0.48, 0.74, 1.0)
"""Blue of printed plastic."""
RUBBER: Final[Colour] = (0.13, 0.14, 0.16, 1.0)
"""Pads of claws."""
HAND: Final[Colour] = (0.10, 0.42, 0.78, 1.0)
"""Body of a suction cup."""
LIP: Final[Colour] = (0.25, 0.25, 0.27, 1.0)
"""Rubber lip of a compliant cup."""
FRAME: Final[Colour] = (0.30, 0.34, 0.39, 1.0)
"""Steelwork of belts, stands and tables."""
FLOOR: Final[Colour] = (0.82, 0.83, 0.84, 1.0)
BELT: Final[Colour] = (0.20, 0.22, 0.24, 1.0)
SLAT: Final[Colour] = (0.29, 0.31, 0.34, 1.0)
"""Marks that show a belt's motion."""
TABLE: Final[Colour] = (0.86, 0.80, 0.70, 1.0)
BOARD: Final[Colour] = (0.24, 0.31, 0.38, 1.0)
"""Board behind a thrower, with squares of 0.1 m."""
BLOCK: Final[Colour] = (0.93, 0.80, 0.36, 1.0)
CROSS: Final[Colour] = (0.90, 0.55, 0.25, 1.0)
AITCH: Final[Colour] = (0.55, 0.72, 0.45, 1.0)
WOOD: Final[Colour] = (0.72, 0.55, 0.36, 1.0)
DARK_WOOD: Final[Colour] = (0.45, 0.33, 0.22, 1.0)
CLEAR: Final = 0.24
"""Opacity of bins, so that the objects in the bins are visible."""
BINS: Final[Sequence[Colour]] = (
    (0.13, 0.45, 0.72, CLEAR),
    (0.20, 0.58, 0.42, CLEAR),
    (0.50, 0.34, 0.64, CLEAR),
    (0.66, 0.38, 0.24, CLEAR),
)
"""Colours of the bins in their order; a fifth bin has the first colour again."""
UNUSED: Final[Colour] = (0.62, 0.64, 0.66, CLEAR)
"""A bin into which its robot throws nothing."""
PLAN: Final[Colour] = (0.10, 0.45, 0.90, 1.0)
"""Dots along a planned flight."""
FLIGHT: Final[Colour] = (0.95, 0.35, 0.10, 1.0)
"""Dots along a simulated flight."""
TARGET: Final[Colour] = (0.20, 0.70, 0.35, 1.0)
ITEMS: Final = np.array([(*hsv_to_rgb((0.13 + 0.618 * kind) % 1.0, 0.62, 0.93), 1.0) for kind in range(64)])
"""Colours of the item kinds (64, 4): hues a golden section apart, so that no two neighbours look alike."""


def bin_colour(kind: int) -> Colour:
    """Colour of a clear bin for a kind of items."""
    red, green, blue = (0.9 * float(value) for value in ITEMS[kind, :3])
    return red, green, blue, CLEAR


SKY: Final = ((0.84, 0.855, 0.87), (0.70, 0.745, 0.80))
"""Colours of the hall far away: at the floor, and above."""


@final
@dataclass(frozen=True)
class Finish:
    """How light meets a surface in pictures.

    Attributes:
        texture: name in `textures.TEXTURES`; empty for the colour alone.
        solid: name in `solids.SOLIDS` of the shape that is drawn in place of the geom; empty for the geom itself.
        specular: strength of highlights, 0 to 1.
        shininess: sharpness of highlights, 0 to 1.
        glow: light of its own, 0 to 1.
        tint: colour of clear bins for items with this finish; None for that of the item's kind.
    """

    texture: str = ""
    solid: str = ""
    specular: float = 0.2
    shininess: float = 0.3
    glow: float = 0.0
    tint: tuple[float, float, float] | None = None


PLAIN: Final = Finish()
GLASS: Final = Finish(specular=0.9, shininess=0.9)
"""Finish of everything that light passes."""
FINISHES: Final[Mapping[Colour, Finish]] = MappingProxyType({
    PAINT: Finish(solid="block", specular=0.55, shininess=0.75),
    STEEL: Finish(solid="block", specular=0.8, shininess=0.6),
    MOTOR: Finish(solid="block", specular=0.45, shininess=0.5),
    ACCENT: Finish(solid="block", specular=0.55, shininess=0.75),
    CARBON: Finish(specular=0.7, shininess=0.8),
    ALUMINIUM: Finish(solid="block", specular=0.8, shininess=0.6),
    PRINT: Finish(solid="block", specular=0.3, shininess=0.3),
    RUBBER: Finish(solid="block", specular=0.1, shininess=0.2),
    HAND: Finish(solid="bellows", specular=0.5, shininess=0.6),
    LIP: Finish(solid="bellows", specular=0.25, shininess=0.3),
    FRAME: Finish(solid="block", specular=0.3, shininess=0.4),
    FLOOR: Finish("floor", specular=0.12, shininess=0.5),
    BELT: Finish("belt", specular=0.15, shininess=0.25),
    TABLE: Finish("wood", specular=0.15, shininess=0.3),
    WOOD: Finish("wood", specular=0.15, shininess=0.3),
    DARK_WOOD: Finish("wood", specular=0.15, shininess=0.3),
    BOARD: Finish("board", specular=0.05, shininess=0.2),
    BLOCK: Finish(specular=0.4, shininess=0.6),
    PLAN: Finish(glow=0.5),
    FLIGHT: Finish(glow=0.5),
    TARGET: Finish(glow=0.5),
})  # fmt: skip
"""Finishes by colour."""

_SHEEN: Final = (0.6, 0.7)
_DULL: Final = (0.08, 0.2)
STYLES: Final[Mapping[str, Finish]] = MappingProxyType({
    "paper": Finish("paper", "crumpled_ball", *_DULL, tint=(0.9, 0.9, 0.86)),
    "napkin": Finish("paper", "crumpled_ball", *_DULL, tint=(0.9, 0.9, 0.86)),
    "sheet": Finish("paper", "block", *_DULL, tint=(0.9, 0.9, 0.86)),
    "can": Finish("can", "can", *_SHEEN, tint=(0.86, 0.08, 0.12)),
    "crushed": Finish("can", "crumpled_block", *_SHEEN, tint=(0.62, 0.06, 0.1)),
    "pet": Finish("bottle", "bottle", *_SHEEN, tint=(0.3, 0.62, 0.9)),
    "bottle": Finish("bottle", "bottle", *_SHEEN, tint=(0.3, 0.62, 0.9)),
    "pet_crushed": Finish("film", "crumpled_block", *_SHEEN, tint=(0.36, 0.72, 0.62)),
    "yoghurt": Finish("cup", "cup", specular=0.35, shininess=0.5, tint=(0.9, 0.34, 0.55)),
    "coffee": Finish("cup", "cup", *_DULL, tint=(0.8, 0.62, 0.42)),
    "cup": Finish("cup", "cup", specular=0.35, shininess=0.5, tint=(0.9, 0.34, 0.55)),
    "tetra": Finish("drink", "block", specular=0.3, shininess=0.5, tint=(0.14, 0.48, 0.8)),
    "carton": Finish("carton", "block", *_DULL, tint=(0.74, 0.55, 0.34)),
    "egg": Finish("carton", "block", *_DULL, tint=(0.74, 0.55, 0.34)),
    "box": Finish("carton", "block", *_DULL, tint=(0.74, 0.55, 0.34)),
    "jar": Finish("lid", "lid", *_SHEEN, tint=(0.92, 0.52, 0.48)),
    "lid": Finish("lid", "lid", *_SHEEN, tint=(0.92, 0.52, 0.48)),
    "cap": Finish("plastic", "rod", specular=0.4, shininess=0.5, tint=(0.95, 0.7, 0.15)),
    "bottle_cap": Finish("plastic", "rod", specular=0.4, shininess=0.5, tint=(0.95, 0.7, 0.15)),
    "cork": Finish("cork", "rod", *_DULL, tint=(0.72, 0.52, 0.32)),
    "foil": Finish("foil", "crumpled_ball", specular=0.9, shininess=0.7, tint=(0.74, 0.76, 0.8)),
    "foil_tray": Finish("foil", "tray", specular=0.9, shininess=0.7, tint=(0.74, 0.76, 0.8)),
    "tray": Finish("tray", "tray", *_SHEEN, tint=(0.05, 0.62, 0.64)),
    "tin": Finish("tin", "tin", *_SHEEN, tint=(0.2, 0.5, 0.28)),
    "steel": Finish("tin", "tin", *_SHEEN, tint=(0.2, 0.5, 0.28)),
    "detergent": Finish("plastic", "block", specular=0.4, shininess=0.6, tint=(0.95, 0.7, 0.15)),
    "shampoo": Finish("plastic", "block", specular=0.4, shininess=0.6, tint=(0.95, 0.7, 0.15)),
    "plastic": Finish("plastic", "block", specular=0.4, shininess=0.6, tint=(0.95, 0.7, 0.15)),
    "film": Finish("film", "block", *_SHEEN, tint=(0.36, 0.72, 0.62)),
    "bag": Finish("film", "block", *_SHEEN, tint=(0.36, 0.72, 0.62)),
    "wood": Finish("wood", "block", *_DULL, tint=(0.7, 0.5, 0.3)),
    "rubber": Finish("", "block", *_DULL, tint=(0.3, 0.3, 0.32)),
})  # fmt: skip
"""Finishes of items by a word of their names; of several words the longest."""
BY_SHAPE: Final[Mapping[str, Finish]] = MappingProxyType({
    "sphere": Finish("", "ball", *_SHEEN),
    "ellipsoid": Finish("", "ball", *_SHEEN),
    "cylinder": Finish("", "rod", *_SHEEN),
    "box": Finish("", "block", *_SHEEN),
})  # fmt: skip
"""Finishes of items whose names say nothing, in their own colours."""
