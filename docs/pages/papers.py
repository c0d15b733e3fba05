"""The parts of a reproduction, from the papers' packages."""

from __future__ import annotations

import inspect
from functools import partial
from typing import Any

from agents.ground.places import SHIPPED as ROOT
from agents.report import contents
from agents.report.page import caption
from agents.reproduce.papers import package
from agents.reproduce.record import Record

from .marks import table


def part_table(paper: str) -> str:
    """A table of the parts of a paper, which `python -m agents.reproduce PAPER --only PART` computes."""
    rows = [(f"`{name}`", _purpose(compute)) for name, compute in package(paper).PARTS.items()]
    return table(("part", "what it computes"), rows)


def drawings(paper: str) -> str:
    """The drawings of a paper that its page does not show, each under its words, folded."""
    record: Record = contents.read(ROOT / "results" / "reproduction.json")
    page = (ROOT / "docs" / "papers" / f"{paper}.md").read_text(encoding="utf-8").partition("<!-- made: drawings")[0]
    names = [name for name in record["figures"][paper] if name not in page]
    shown = [f"![{caption(name)}](../../results/figures/{name})\n\n*{caption(name)}*" for name in names]
    summary = f"<details><summary>{len(names)} more drawings</summary>"
    return "\n\n".join([summary, *shown, "</details>"])


def _purpose(compute: Any) -> str:
    """The first line of a docstring, of the function behind a partial too."""
    function = compute.func if isinstance(compute, partial) else compute
    return (inspect.getdoc(function) or "").partition("\n")[0].rstrip(".")
