"""What the papers' verdicts count."""

from __future__ import annotations

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT
from agents.reproduce.record import Record
from agents.reproduce.record import verdicts as counted

from .marks import table

RESULTS = ROOT / "results"


def verdicts(_: str) -> str:
    """How many figures of each paper came out how."""
    record: Record = read_json(RESULTS / "reproduction.json")
    counts = {paper: {row[0]: row[1] for row in counted(record, paper).rows} for paper in record["titles"]}
    kinds = list(dict.fromkeys(kind for found in counts.values() for kind in found))
    rows = [(title, *(counts[paper].get(kind, "0") for kind in kinds)) for paper, title in record["titles"].items()]
    return table(("paper", *kinds), rows)
