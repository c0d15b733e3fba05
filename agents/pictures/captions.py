"""What is written into the frames of films: who throws, what, how far off it lands, and how much is sorted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, final

from PIL import Image, ImageDraw, ImageFont

from pnt_gym.cells.base.canvas import Frame

INK: Final = (255, 255, 255)
SHADE: Final = (24, 30, 38, 205)
"""Ground of words."""
GOOD: Final = (94, 214, 126)
BAD: Final = (255, 112, 92)
Ink = tuple[int, int, int]
Words = Sequence[tuple[str, Any, Ink]]
"""Texts with their fonts and colours."""
BORDER: Final = 14
"""Distance of words from the edges of a frame 540 pixels high [pixels]."""


@final
@dataclass(frozen=True)
class Caption:
    """Words of one frame.

    Attributes:
        title: who acts, at the top.
        item: what is thrown, at the bottom.
        result: how it ended, behind the item; empty before that.
        is_good: whether it ended well.
        rate: a figure at the bottom right, and its unit; empty for none.
    """

    title: str
    item: str = ""
    result: str = ""
    is_good: bool = True
    rate: tuple[str, str] = ("", "")


@cache
def font(size: int) -> Any:
    """Pillow's own font in a size [pixels]."""
    return ImageFont.load_default(size)


def write_caption(frame: Frame, caption: Caption) -> Any:
    """A picture of a frame with a caption."""
    image = Image.fromarray(frame).convert("RGB")
    brush, (wide, high) = ImageDraw.Draw(image, "RGBA"), image.size
    label, figure = font(high // 22), font(high // 12)
    _plate(brush, (BORDER, BORDER), [(caption.title, label, INK)])
    words: list[tuple[str, Any, Ink]] = [(caption.item, label, INK)] if caption.item else []
    if caption.result:
        words.append((caption.result, label, GOOD if caption.is_good else BAD))
    value, unit = caption.rate
    ground, free = high - BORDER, float(wide - BORDER)
    if value:
        corner = (wide - BORDER, ground)
        free, above = _plate(brush, corner, [(value, figure, INK), (unit, label, INK)], up=True, left=True)
        if BORDER + _length(brush, words) > free - BORDER:
            ground = above - BORDER // 2
    if words:
        _plate(brush, (BORDER, ground), words, up=True)
    return image


def _length(brush: Any, words: Words) -> float:
    """Length of words in a row on their ground [pixels]."""
    pad = int(0.45 * max((kind.size for _, kind, _ in words), default=0))
    return sum(brush.textlength(text, font=kind) for text, kind, _ in words) + pad * (len(words) + 1)


def _plate(
    brush: Any,
    corner: tuple[int, int],
    words: Words,
    *,
    up: bool = False,
    left: bool = False,
) -> tuple[float, int]:
    """Draw words in a row on one ground, from a corner down and to the right, or up and to the left; gives its x, y."""
    most, wide = max(kind.size for _, kind, _ in words), _length(brush, words)
    pad = int(0.45 * most)
    high = int(1.1 * most) + pad
    x, y = corner[0] - (wide if left else 0), corner[1] - (high if up else 0)
    brush.rounded_rectangle((x, y, x + wide, y + high), radius=high // 4, fill=SHADE)
    at = x + pad
    for text, kind, colour in words:
        brush.text((at, y + high - 0.8 * pad), text, font=kind, fill=colour, anchor="ls")
        at += brush.textlength(text, font=kind) + pad
    return x, y


def inset(image: Any, panels: Sequence[Frame], names: Sequence[str]) -> None:
    """Draw small pictures with their names in a column at the top right of a picture."""
    brush, label, y = ImageDraw.Draw(image, "RGBA"), font(image.height // 32), BORDER
    for panel, name in zip(panels, names, strict=True):
        side = panel.shape[0]
        x = image.width - BORDER - side
        brush.rectangle((x - 3, y - 3, x + side + 2, y + side + label.size + 8), fill=SHADE)
        image.paste(Image.fromarray(panel), (x, y))
        brush.text((x + side / 2, y + side + label.size + 3), name, font=label, fill=INK, anchor="ms")
        y += side + label.size + 16
