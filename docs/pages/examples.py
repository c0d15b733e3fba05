"""The examples, each with its code."""

from __future__ import annotations

from typing import Final

from agents.ground.places import SHIPPED as ROOT

from .marks import fenced

FOLDER: Final = ROOT / "examples"


def listed(name: str) -> str:
    """The code of one example; without a name the README of the folder and the code of all."""
    if name:
        return fenced((FOLDER / name).read_text(encoding="utf-8"), "python")
    files = sorted(FOLDER.glob("*.py"))
    readme = (FOLDER / "README.md").read_text(encoding="utf-8").strip()
    return "\n\n".join([readme, *(f"## {file.name}\n\n{listed(file.name)}" for file in files)])
