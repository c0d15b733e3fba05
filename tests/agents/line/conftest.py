"""A line with short shifts."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture
def short(tmp_path: Path) -> str:
    """A level with shifts of ten seconds, as a file."""
    file = tmp_path / "short.yaml"
    file.write_text("base: value\nname: short\nduration: 10\n")
    return str(file)
