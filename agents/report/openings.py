"""What a page of results opens with: a sentence for the index, five numbers, and a small picture of some of them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, Final, NamedTuple, final

from ..ground.files import read_yaml
from ..ground.looks import colours, look
from . import templates

FIGURE: Final = re.compile(r"[+-]?[\d,]*\.?\d+")
"""The first number of a text."""
WIDTH: Final = 260
ROW: Final = 22
NAMES: Final = 106
"""Room for the names of bars."""
LONGEST: Final = 104
"""Longest bar."""
FEWEST: Final = 4
"""Rows of every small picture, drawn or not, so that all are equally high. All sizes are in pixels."""


@final
class Opening(NamedTuple):
    """Templates of an opening, or its texts.

    Attributes:
        short: the answer in a sentence.
        numbers: five numbers with their units and intervals, and what each is.
        unit: what the bars count.
        bars: names, of controllers or others, and texts that begin with the numbers.
    """

    short: str
    numbers: Sequence[tuple[str, str]]
    unit: str
    bars: Sequence[tuple[str, str]]

    def filled(self, values: Mapping[str, Any]) -> Opening:
        """The texts from values.

        Raises:
            NoFigure: a template names something that is not among the values.
        """

        def pairs(of: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
            return [(templates.fill(one, values), templates.fill(other, values)) for one, other in of]

        return Opening(
            templates.fill(self.short, values),
            pairs(self.numbers),
            templates.fill(self.unit, values),
            pairs(self.bars),
        )

    def markdown(self) -> str:
        """The numbers as a list of Markdown."""
        return "\n".join(f"* **{number}** {words}" for number, words in self.numbers)

    def picture(self) -> str:
        """The bars as SVG, each from zero, in the colours of their controllers."""
        names = [name for name, _ in self.bars]
        values = [_first(text) for _, text in self.bars]
        scale = LONGEST / (max(map(abs, values), default=0.0) or 1.0)
        colour = colours(names)
        height = ROW * max(FEWEST, len(names)) + 24
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
            f'height="{height}" font-family="sans-serif" font-size="12">',
            f'<rect width="{WIDTH}" height="{height}" rx="4" fill="#fff"/>',
        ]
        for row, (name, value) in enumerate(zip(names, values, strict=True)):
            own = look(name) if ", " not in name else None  # which says what the controller has learned from
            shown, y, width = (own.name if own else "") or name, 4 + ROW * row, scale * abs(value)
            parts.append(f'<text x="{NAMES - 4}" y="{y + 15}" text-anchor="end" fill="#222">{escape(shown)}</text>')
            parts.append(f'<rect x="{NAMES}" y="{y + 3}" width="{width:.1f}" height="16" fill="{colour[name]}"/>')
            parts.append(f'<text x="{NAMES + width + 4:.1f}" y="{y + 15}" fill="#222">{value:g}</text>')
        unit = escape(self.unit.replace("`", ""))
        parts.append(f'<text x="{WIDTH / 2}" y="{height - 8}" text-anchor="middle" fill="#555">{unit}</text>')
        return "\n".join([*parts, "</svg>", ""])


def _first(text: str) -> float:
    """The first number of a text; zero without one, which is a bar without length."""
    found = FIGURE.search(text)
    return float(found[0].replace(",", "")) if found else 0.0


def _read() -> dict[str, Opening]:
    entries = read_yaml(Path(__file__).with_name("openings.yaml"), "openings")
    return {name: Opening(**entry) for name, entry in entries.items()}


OPENINGS: Final = _read()
"""By the names of the questions."""


def small_picture(name: str) -> str:
    """File of the small picture of a question."""
    return f"small_{name}.svg"
