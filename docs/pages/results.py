"""Chapters of results/README.md, and what the papers' verdicts count."""

from __future__ import annotations

import os
import re
from pathlib import Path

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT
from agents.reproduce.record import Record
from agents.reproduce.record import verdicts as counted

from .marks import table

RESULTS = ROOT / "results"


def chapter(title: str) -> str:
    """A chapter of the generated results by its title, without that; drawings lead back to their files."""
    text = (RESULTS / "README.md").read_text(encoding="utf-8")
    found = re.search(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", text, flags=re.MULTILINE | re.DOTALL)
    if found is None:
        raise ValueError(f"results/README.md has no chapter {title!r}")
    return found[1].replace("](figures/", "](/../results/figures/").strip()


def pointer(title: str, page: Path) -> str:
    """Where a chapter stands in the repository, seen from a page."""
    place = Path(os.path.relpath(RESULTS / "README.md", page.parent)).as_posix()
    anchor = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
    return f"[The chapter *{title}* of the results]({place}#{anchor}) has the tables."


def verdicts(_: str) -> str:
    """How many figures of each paper came out how."""
    record: Record = read_json(RESULTS / "reproduction.json")
    counts = {paper: {row[0]: row[1] for row in counted(record, paper).rows} for paper in record["titles"]}
    kinds = list(dict.fromkeys(kind for found in counts.values() for kind in found))
    rows = [(title, *(counts[paper].get(kind, "0") for kind in kinds)) for paper, title in record["titles"].items()]
    return table(("paper", *kinds), rows)
