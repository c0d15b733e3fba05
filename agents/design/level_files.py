"""Lines as text of YAML files, which `pnt-gym line plan --level` reads, and back."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, cast

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError, one_sentence
from pnt_gym.reading import ReadError, parsed_yaml, yaml_text

LARGEST: Final = 2**20
"""Largest file of a line [byte]."""
WIDTH: Final = 120
HEAD: Final = "# Designed with `pnt-gym design`; judged with `pnt-gym line plan --level {}.yaml`.\n"
_FILES: Final = ("base", "chances")
"""Keys of a level that may name a file."""


def text_of_line(line: LineConfig) -> str:
    """Text of a level file that is the line.

    Raises:
        ConfigError: the text would be another line.
    """
    level = {"name": line.name, "base": "nominal", **line.model_dump(mode="json", exclude_unset=True)}
    text = HEAD.format(line.name) + yaml_text(level, width=WIDTH, default_flow_style=None)
    if line_of_text(text, line.name) != line:
        raise ConfigError(f"line {line.name!r} cannot be written as a level file: read again it is another line")
    return text


def line_of_text(text: str, name: str) -> LineConfig:
    """The line that a level file's text describes; the file stands alone and names no other file.

    Args:
        text: text of the file.
        name: the line's name, if the text gives none.

    Raises:
        ConfigError: the text is no line, or names a file.
    """
    if len(text) > LARGEST:
        raise ConfigError(f"the file has {len(text):,} characters; a line has at most {LARGEST:,}")
    try:
        data: Any = parsed_yaml(text)
    except ReadError as error:
        raise ConfigError(f"the file is no YAML: {one_sentence(error)}") from None
    if not isinstance(data, Mapping) or not data:
        raise ConfigError("the file is no line: it must have keys such as base, cell and robots")
    level = {"name": name, **cast("Mapping[str, Any]", data)}
    _refuse_files(level)
    return LineConfig.load(level, throws="table")


def line_of_file(content: bytes, name: str) -> LineConfig:
    """The line in a level file that a browser has sent.

    Raises:
        ConfigError: the file is no text, or no line.
    """
    try:
        return line_of_text(content.decode("utf-8"), Path(name).stem or "line")
    except UnicodeDecodeError:
        raise ConfigError(f"file {one_sentence(repr(name), 80)} is no text in UTF-8, and so no line") from None


def _refuse_files(level: Mapping[str, Any]) -> None:
    """Refuse a level that names other files: on the page a file has no folder beside which they could lie.

    Raises:
        ConfigError: a key names a file.
    """
    cell = level.get("cell")
    inner = cast("Mapping[str, Any]", cell) if isinstance(cell, Mapping) else {"base": cell}
    named = [(key, level.get(key)) for key in _FILES] + [("cell", inner.get("base"))]
    for key, value in named:
        if isinstance(value, str) and (key == "chances" or Path(value).suffix):
            raise ConfigError(
                f"key {key!r} names the file {one_sentence(repr(value), 80)}; a line that is opened on the page stands "
                "alone: start the page with `pnt-gym design FILE.yaml` instead"
            )
