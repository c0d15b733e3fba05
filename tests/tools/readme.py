"""Whether a README says what the results give."""

from __future__ import annotations

from pathlib import Path

from agents.report.blocks import fill_blocks


def stale_readme(readme: Path, results: Path) -> bool:
    """Whether a README's tables differ from what the results give."""
    text = readme.read_text(encoding="utf-8")
    return fill_blocks(text, results) != text
