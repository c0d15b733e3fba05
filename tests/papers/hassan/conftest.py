"""Table I of Hassan et al. 2022 as it takes no time."""

import pytest

from papers.hassan import table as hassan_table
from papers.hassan.cases import PROTOCOLS


@pytest.fixture
def quick_table(monkeypatch):
    """Table I by the protocols that take no time; the optima take long and are tested for themselves."""
    quick = {name: protocol for name, protocol in PROTOCOLS.items() if protocol.rules.returning == "straight"}
    monkeypatch.setattr(hassan_table, "PROTOCOLS", quick)
    monkeypatch.setattr(hassan_table, "SIMULATED", ())
    monkeypatch.setattr(hassan_table, "table_figure", lambda reproduced: str(sorted(reproduced)))
    return quick, hassan_table.table_findings()
