"""Docstrings for Sphinx: text with code in backticks, in which nothing else is markup."""

from __future__ import annotations

import re
from typing import Any, Final

ATTRIBUTES: Final = ("attribute", "data", "property")
_hidden: dict[str, list[str]] = {}
"""Docstrings that Napoleon does not see, by name."""
CODE: Final = re.compile(r"(`+[^`]*`+)")
MARKUP: Final = re.compile(r"[|*]|(?<=\w)_(?=\W|$)")
"""What reStructuredText would take for markup: an absolute value, a product, a symbol with an index left open."""

ARRAY: Final = re.compile(r"~?numpy\.ndarray\[tuple\[~?typing\.Any, \.\.\.\], ~?numpy\.dtype\[(~?[\w.]+)\]\]")
LIKE: Final = re.compile(
    r"~?numpy\._typing\.ArrayLike|"
    r"[\w.~]*_?Buffer \| .*?_SupportsArray.*? \| complex \| bytes \| str \| .*?\[complex \| bytes \| str\]"
)


def named(signature: str | None) -> str | None:
    """A signature in which arrays are called as the code calls them."""
    return signature and LIKE.sub("ArrayLike", ARRAY.sub(r"NDArray[\1]", signature))


def readable(lines: list[str]) -> list[str]:
    """Lines of a docstring with such characters escaped, and with indented lines after a colon as code."""
    said: list[str] = []
    code: int | None = None
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if code is not None and line.strip() and _indent(line) <= code:
            code = None
        said.append(line if code is not None else _escaped(line))
        if code is None and _introduces(line, below, lines, len(said)):
            said[-1] += ":"
            code = _indent(line)
    return said


def _introduces(line: str, below: str, lines: list[str], following: int) -> bool:
    """Whether a line ends with a colon, and an empty and an indented one follow."""
    after = next((text for text in lines[following:] if text.strip()), "")
    return line.endswith(":") and not below.strip() and _indent(after) > _indent(line)


def _escaped(line: str) -> str:
    parts = CODE.split(line)
    return "".join(part if part.startswith("`") else MARKUP.sub(r"\\\g<0>", part) for part in parts)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _read(_app: Any, what: str, name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Before Napoleon, which takes what stands before a colon in an attribute's docstring for its type."""
    said = readable(lines)
    if what in ATTRIBUTES:
        _hidden[name], said = said, []
    lines[:] = said


def _show(_app: Any, _what: str, name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """After Napoleon."""
    lines[:] = _hidden.pop(name, lines)


def _signature(_app: Any, _what: str, _name: str, _object: Any, _options: Any, given: str, returned: str) -> Any:
    return named(given), named(returned)


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx on both sides of Napoleon, whose priority is 500."""
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", _read, priority=100)
    app.connect("autodoc-process-docstring", _show, priority=900)
    app.connect("autodoc-process-signature", _signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
