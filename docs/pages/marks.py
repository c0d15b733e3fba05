"""Markdown that several pages need: tables, blocks of code, attributes of a docstring."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Sequence


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; cells are Markdown on one line, and columns of whole numbers stand at the right."""
    cells = [list(row) for row in rows]
    marks = ["---:" if cells and all(row[k].isdecimal() for row in cells) else "---" for k in range(len(header))]
    return "\n".join(f"| {' | '.join(' '.join(cell.split()) for cell in line)} |" for line in (header, marks, *cells))


def fence(text: str, language: str = "text") -> str:
    """A block of code."""
    return f"```{language}\n{text.rstrip()}\n```"


def attributes(owner: type) -> dict[str, str]:
    """The entries of the section `Attributes` of a docstring, by name."""
    text = (inspect.getdoc(owner) or "").partition("Attributes:\n")[2]
    entries = re.findall(r"^ {4}(\w+): (.*(?:\n {6,}.*)*)", text, flags=re.MULTILINE)
    return {name: " ".join(meaning.split()) for name, meaning in entries}
