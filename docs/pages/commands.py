"""The commands: a table of all, and the help of each."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import re
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

import tyro

from agents.ground.console import COMMANDS
from agents.ground.places import SHIPPED as ROOT

from .marks import fence, table

CHECKOUT: Final = ("grasping.__main__", "training.grasp_shifts", "reproduce.__main__", "report.__main__")
"""Commands beside `pnt-gym`: they make networks, or need the papers' parts or results."""
WIDTH: Final = 100
"""Columns of the help."""
SECTION: Final = re.compile(r"^ (?:options|positional arguments)\n -+\n(.*?)(?=^$|\Z)", re.DOTALL | re.MULTILINE)
"""Entries of the options, or of the arguments, in the help."""
ENTRY: Final = re.compile(r"^  (\S.*?)(?: {2,}|\n +)(\S.*(?:\n {4,}.*)*)", re.MULTILINE)
"""An option with its value, and what the option means."""
OPTION: Final = re.compile(r"(?<![\w-])--[a-z][a-z-]*[a-z]")
"""The name of an option."""
HELP: Final = "-h, --help"
"""The option that every command has, which the page leaves out."""


def command_table(_: str) -> str:
    """A table of the words that `pnt-gym` takes."""
    links = {name: f"[`pnt-gym {name}`](#pnt-gym-{name.replace(' ', '-')})" for name in COMMANDS}
    return table(("command", "what it does"), [(links[name], purpose) for name, (_, purpose) in COMMANDS.items()])


def command_help(place: str) -> str:
    """The help of all words of `pnt-gym`, or of further commands: a usage line, a text, a list of the options."""
    if place == "checkout":
        modules = {f"python -m agents.{module.removesuffix('.__main__')}": module for module in CHECKOUT}
    else:
        modules = {f"pnt-gym {name}": module for name, (module, _) in COMMANDS.items()}
    return "\n\n".join(f"### `{name}`\n\n{help_list(_help(name, module))}" for name, module in modules.items())


def help_list(text: str) -> str:
    """The help of a command as Markdown, whose lines break on every screen."""
    usage, _, words = SECTION.sub("", text).strip().removeprefix("usage: ").partition("\n\n")
    entries = [entry for section in SECTION.findall(text) for entry in ENTRY.findall(section) if entry[0] != HELP]
    lines = [f"* `{name}`: {_options_as_code(meaning)}" for name, meaning in entries]
    paragraphs = [_options_as_code(paragraph) for paragraph in words.strip().split("\n\n")]
    return "\n\n".join([fence(" ".join(usage.split())), *paragraphs, *(["\n".join(lines)] if lines else [])])


def _options_as_code(text: str) -> str:
    """A text on one line, with names of options between backticks, where no others stand around them."""
    pieces = " ".join(text.split()).split("`")
    return "`".join([OPTION.sub(r"`\g<0>`", piece) if k % 2 == 0 else piece for k, piece in enumerate(pieces)])


def _help(command: str, module: str) -> str:
    arguments: Any = importlib.import_module(f"agents.{module}").Arguments
    output = io.StringIO()
    os.environ["COLUMNS"] = str(WIDTH)
    with _relative(arguments), contextlib.redirect_stdout(output), contextlib.suppress(SystemExit):
        tyro.cli(arguments, prog=command, args=["--help"])
    return re.sub(r"\x1b\[[0-9;]*m| +$", "", output.getvalue(), flags=re.MULTILINE)


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
