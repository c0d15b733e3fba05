"""Table I of Hassan et al. 2022 without its drawing."""

import pytest

from papers.hassan import table as hassan_table


@pytest.fixture
def found_table(monkeypatch):
    """The findings of Table I, whose drawing is the names of its protocols."""
    with monkeypatch.context() as patch:
        patch.setattr(hassan_table, "table_figure", lambda reproduced: str(sorted(reproduced)))
        return hassan_table.table_findings()
