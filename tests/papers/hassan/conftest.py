"""Table I of Hassan et al. 2022 as it takes no time."""

import pytest

from papers.hassan import cases
from papers.hassan import table as hassan_table


@pytest.fixture
def quick_table(monkeypatch):
    """Table I by the protocols that take no time; the optima take long and are tested for themselves."""
    quick = {name: protocol for name, protocol in cases.PROTOCOLS.items() if protocol.rules.returning == "straight"}
    with monkeypatch.context() as patch:
        patch.setattr(cases, "PROTOCOLS", quick)
        patch.setattr(cases, "SIMULATED", ())
        patch.setattr(hassan_table, "table_figure", lambda reproduced: str(sorted(reproduced)))
        return quick, hassan_table.table_findings()
