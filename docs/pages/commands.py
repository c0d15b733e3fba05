"""The commands: a table of all, and the help of each."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import re
import textwrap
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

import tyro

from agents.ground.console import COMMANDS
from agents.ground.places import SHIPPED as ROOT

from .marks import fence, table

CHECKOUT: Final = ("reproduce.__main__", "report.__main__")
"""Commands of a checkout alone: they need the papers' parts, or results."""
WIDTH: Final = 100
"""Columns of the help; a description is broken there too, which tyro leaves to the terminal."""


def command_table(_: str) -> str:
    """A table of the words that `pnt-gym` takes."""
    links = {name: f"[`pnt-gym {name}`](#pnt-gym-{name.replace(' ', '-')})" for name in COMMANDS}
    return table(("command", "what it does"), [(links[name], purpose) for name, (_, purpose) in COMMANDS.items()])


def command_help(place: str) -> str:
    """The help of all words of `pnt-gym`, or of the commands that only a checkout has."""
    if place == "checkout":
        modules = {f"python -m agents.{module.removesuffix('.__main__')}": module for module in CHECKOUT}
    else:
        modules = {f"pnt-gym {name}": module for name, (module, _) in COMMANDS.items()}
    helps = {command: fence(_help(command, module), "none") for command, module in modules.items()}
    return "\n\n".join(f"### `{command}`\n\n{text}" for command, text in helps.items())


def _help(command: str, module: str) -> str:
    arguments: Any = importlib.import_module(f"agents.{module}").Arguments
    output = io.StringIO()
    os.environ["COLUMNS"] = str(WIDTH)
    with _relative(arguments), contextlib.redirect_stdout(output), contextlib.suppress(SystemExit):
        tyro.cli(arguments, prog=command, args=["--help"])
    text = re.sub(r"\x1b\[[0-9;]*m| +$", "", output.getvalue(), flags=re.MULTILINE)
    return "\n".join(textwrap.fill(line, WIDTH) if len(line) > WIDTH else line for line in text.split("\n"))


@contextlib.contextmanager
def _relative(arguments: Any) -> Iterator[None]:
    """Show default places relative to the checkout, because the length of an absolute path would change the layout."""
    inside = [field for field in fields(arguments) if isinstance(field.default, Path)]
    places = [field.default for field in inside]
    for field, place in zip(inside, places, strict=True):
        field.default = place.relative_to(ROOT) if place.is_relative_to(ROOT) else place
    try:
        yield
    finally:
        for field, place in zip(inside, places, strict=True):
            field.default = place
