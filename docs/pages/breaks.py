"""Places at which the site may begin a new line: inside long names of code in tables, and never inside short names."""

from __future__ import annotations

import re
from typing import Any, Final

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform

PIECES: Final = re.compile(r"[^._/]+[._/]*|[._/]+")
SHORT: Final = 18
"""Names of at most this length fit on a line [characters]."""
WHOLE: Final = "whole"
"""Class of code that stays on one line: a line may end behind the hyphens of an option otherwise."""
UNIT: Final = re.compile(r"(?<=[\d)]) (?=(?:%|mm|m|s|deg|kg|N)(?:\W|$))")
"""The space between a number, or its interval, and its unit."""


class Breaks(SphinxPostTransform):
    """Puts `<wbr>` between the pieces of long names in tables; keeps short names, and numbers with units, together."""

    default_priority = 400
    formats = ("html",)

    def run(self, **_kwargs: Any) -> None:
        """Change the code of a page, and the numbers in its tables."""
        for literal in self.document.findall(nodes.literal):
            if len(literal.astext()) <= SHORT and " " not in literal.astext():
                literal["classes"].append(WHOLE)
        for table in self.document.findall(nodes.table):
            for text in [*table.findall(nodes.Text)]:
                if not isinstance(text.parent, nodes.literal) and UNIT.search(text):
                    text.parent.replace(text, nodes.Text(UNIT.sub("\N{NO-BREAK SPACE}", text)))
            for literal in [*table.findall(nodes.literal)]:
                name = literal.astext()
                if len(name) > SHORT and " " not in name:
                    literal[:] = _pieces(name)


def _pieces(name: str) -> list[nodes.Node]:
    """The pieces of a name, as text, with places for a new line between them."""
    first, *others = PIECES.findall(name)
    result: list[nodes.Node] = [nodes.Text(first)]
    for piece in others:
        result += [nodes.raw("", "<wbr>", format="html"), nodes.Text(piece)]
    return result


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.add_post_transform(Breaks)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
