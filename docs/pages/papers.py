"""The parts of a reproduction, from the papers' packages."""

from __future__ import annotations

import inspect
from functools import partial
from typing import Any

from agents.reproduce.papers import package

from .marks import table


def part_table(paper: str) -> str:
    """A table of the parts of a paper, which `python -m agents.reproduce PAPER --only PART` computes."""
    rows = [(f"`{name}`", _purpose(compute)) for name, compute in package(paper).PARTS.items()]
    return table(("part", "what it computes"), rows)


def _purpose(compute: Any) -> str:
    """The first line of a docstring, of the function behind a partial too."""
    function = compute.func if isinstance(compute, partial) else compute
    return (inspect.getdoc(function) or "").partition("\n")[0].rstrip(".")
