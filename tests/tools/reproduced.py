"""What holds of every part of a paper that is computed anew."""

import json
from xml.etree import ElementTree

from agents.reproduce.finding import Findings


def assert_plain(found: Findings, paper: str) -> None:
    """Rows and data are plain JSON, quantities are the paper's and differ, and figures are drawings."""
    text = json.dumps({"rows": [row.as_json() for row in found.rows], "data": found.data}, allow_nan=False)
    quantities = [row["quantity"] for row in json.loads(text)["rows"]]
    assert quantities
    assert len(set(quantities)) == len(quantities)
    assert all(quantity.startswith(f"{paper}/") for quantity in quantities)
    for drawing in found.figures.values():
        assert ElementTree.fromstring(drawing).tag.endswith("svg")
        assert len(drawing) > 5000
