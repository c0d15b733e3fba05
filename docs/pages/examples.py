"""The examples, each with its code."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Final

from agents.ground.places import SHIPPED as ROOT

from .marks import fence

FOLDER: Final = ROOT / "examples"
SHOWN: Final = 40
"""Lines of a file whose code stands on the page; a longer one is a link, and what its docstring says."""


def example_code(name: str) -> str:
    """The code of one example; without a name the README of the folder and the code of every example, with titles."""
    if name:
        return fence(_code(FOLDER / name), "python")
    files = sorted(FOLDER.glob("*.py"))
    readme = (FOLDER / "README.md").read_text(encoding="utf-8").strip()
    return "\n\n".join([readme, *(f"## {_title(file)}\n\n{_named_block(file)}" for file in files)])


def _code(file: Path) -> str:
    return file.read_text(encoding="utf-8")


def _title(file: Path) -> str:
    """Number of an example, and the first words of its docstring."""
    line = (ast.get_docstring(ast.parse(_code(file))) or "").partition("\n")[0]
    return f"{int(file.name.partition('_')[0])}. {line.partition(':')[0].rstrip('.')}"


def _named_block(file: Path) -> str:
    code = _code(file)
    lines = len(code.splitlines())
    if lines <= SHOWN:
        return fence(code, f'python title="examples/{file.name}"')
    words = (ast.get_docstring(ast.parse(code)) or "").partition("\n")[2].strip("\n")
    return f"[`examples/{file.name}`](../examples/{file.name}), {lines} lines.\n\n{words}"
