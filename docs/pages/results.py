"""The number of figures of each paper by verdict."""

from __future__ import annotations

from typing import Final

from agents.ground.places import SHIPPED as ROOT
from agents.report import contents
from agents.reproduce.record import Record, verdicts

from .marks import table

RESULTS = ROOT / "results"
VERDICTS: Final = ("reproduced", "differs", "misprint", "not reproducible", "ours, not compared")
"""Order of the columns."""


def verdict_table(_: str) -> str:
    """A table of the number of figures of each paper by verdict."""
    record: Record = contents.read(RESULTS / "reproduction.json")
    counts = {paper: {row[0]: row[1] for row in verdicts(record, paper).rows} for paper in record["titles"]}
    rows = [(title, *(counts[paper].get(name, "0") for name in VERDICTS)) for paper, title in record["titles"].items()]
    return table(("paper", *VERDICTS), rows)
