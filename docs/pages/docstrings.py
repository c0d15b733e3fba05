"""Docstrings for Sphinx: text with code in backticks, in which nothing else is markup."""

from __future__ import annotations

import re
from typing import Any, Final

from docutils import nodes
from sphinx import addnodes

ATTRIBUTES: Final = ("attribute", "data", "property")
_attribute_lines: dict[str, list[str]] = {}
"""Lines of attributes' docstrings, by name, which Napoleon must not change."""
CODE: Final = re.compile(r"(`+[^`]*`+)")
MARKUP: Final = re.compile(r"[|*]|(?<=\w)_(?=\W|$)")
"""Text that reStructuredText would read as markup: an absolute value, a product, a symbol with an index left open."""

ARRAY: Final = re.compile(
    r"~?(?:numpy\.)?ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?(?:numpy\.)?dtype\[(~?[\w.]+)\]\]"
)
LIKE: Final = re.compile(
    r"~?numpy\._typing\.ArrayLike|"
    r"[\w.~]*_?Buffer \| .*?_SupportsArray.*? \| complex \| bytes \| str \| .*?\[complex \| bytes \| str\]"
)

RANGE: Final = re.compile(r"~?(?:typing\.)?Annotated\[(~?[\w.]+), (?:[^][]|\[(?:[^][]|\[[^][]*\])*\])*\]")
"""A type with the range that pydantic checks."""
FIELD: Final = re.compile(r"Alias for field number \d+")
FOREIGN: Final = "model_config"
"""Attribute whose docstring is pydantic's own, in another markup."""


def shorten_signature(signature: str | None) -> str | None:
    """A signature with the code's own names of arrays, without the ranges of fields, and with ... as a made default."""
    if signature is None:
        return None
    # Sphinx shortens the types only of a signature that it can parse
    arrays = LIKE.sub("ArrayLike", ARRAY.sub(r"NDArray[\1]", signature.replace("<factory>", "...")))
    return RANGE.sub(r"\1", arrays)


def escape_docstring(lines: list[str]) -> list[str]:
    """Lines of a docstring with the characters of `MARKUP` escaped, and with indented lines after a colon as code."""
    result: list[str] = []
    code: int | None = None
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if code is not None and line.strip() and _indent(line) <= code:
            code = None
        result.append(line if code is not None else _escape(line))
        if code is None and _introduces(line, below, lines, len(result)):
            result[-1] += ":"
            code = _indent(line)
    return result


def _introduces(line: str, below: str, lines: list[str], following: int) -> bool:
    """Whether a line ends with a colon, and an empty line and an indented line follow."""
    after = next((text for text in lines[following:] if text.strip()), "")
    return line.endswith(":") and not below.strip() and _indent(after) > _indent(line)


def _escape(line: str) -> str:
    parts = CODE.split(line)
    return "".join(part if part.startswith("`") else MARKUP.sub(r"\\\g<0>", part) for part in parts)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _prepare(_app: Any, kind: str, name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Prepare a docstring before Napoleon, which reads text before a colon in an attribute's docstring as a type."""
    result = escape_docstring(lines)
    if kind in ATTRIBUTES:
        _attribute_lines[name], result = result, []
    lines[:] = result


def _show(_app: Any, _what: str, name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Restore an attribute's docstring after Napoleon, without the text that Python gives fields of a named tuple."""
    lines[:] = [line for line in _attribute_lines.pop(name, lines) if not FIELD.fullmatch(line)]


def _signature(_app: Any, _what: str, _name: str, _object: Any, _options: Any, arguments: str, result: str) -> Any:
    return shorten_signature(arguments), shorten_signature(result)


def _shorten_types(_app: Any, _domain: str, _kind: str, content: nodes.Element) -> None:
    """Shorten the types of attributes, which no event of autodoc passes on."""
    assert content.parent is not None
    for annotation in content.parent.findall(addnodes.desc_annotation):
        text = annotation.astext()
        short = shorten_signature(text)
        if short != text:
            annotation[:] = [nodes.Text(short)]


def _skip(_app: Any, _kind: str, name: str, _object: Any, _skips: bool, _options: Any) -> bool | None:
    return True if name == FOREIGN else None


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx on both sides of Napoleon, whose priority is 500."""
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", _prepare, priority=100)
    app.connect("autodoc-process-docstring", _show, priority=900)
    app.connect("autodoc-process-signature", _signature)
    app.connect("autodoc-skip-member", _skip)
    app.connect("object-description-transform", _shorten_types)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
