"""Submissions: files of results that others hand in, which must be of the benchmark's held-out throws."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from ..ground.cli import UsageError
from ..ground.places import SHIPPED
from .content import Content, check_figures, read_form
from .plan import read_plan

BENCHMARK: Final = SHIPPED / "configs" / "benchmark.yaml"
"""Plan whose held-out throws every submission throws."""
FRAME: Final = ("env", "levels", "inline", "picks", "picks_on", "seed", "num_envs")
"""Keys of a plan by which held-out throws are named."""
ABOUT: Final = ("by", "about", "command")
"""What a submission says of itself, beside what a benchmark's file says."""
DIGESTS: Final = ("code", "policy", "level")
"""Digests that each row of a submission has."""


def is_submission(data: Mapping[str, Any]) -> bool:
    """Whether the content of a file of results is that of a submission."""
    return not data.keys().isdisjoint(ABOUT)


def read_submission(path: Path) -> Content:
    """Content of a submission's file.

    Raises:
        UsageError: the file is damaged, says other than its rows, or is no submission.
    """
    content = read_form(path)
    check_submission(path, content)
    return check_figures(path, content)


def check_submission(path: Path, content: Content) -> None:
    """Check what the content of a submission's file has beside that of a benchmark's file.

    Raises:
        UsageError: the file says too little of itself, or its throws are not the benchmark's.
    """
    plan, data = content
    missing = [name for name in ABOUT if name not in data]
    if missing:
        raise UsageError(f"submission {str(path)!r} has no {missing[0]!r}")
    has_digests = all(all(row.get("digests", {}).get(name) for name in DIGESTS) for row in data["results"])
    labels = {row["label"] for row in data["results"]}
    if not has_digests or labels != {path.stem}:
        raise UsageError(f"submission {str(path)!r}: its rows must have the label {path.stem!r} and digests")
    frame = read_plan(BENCHMARK)
    for key in FRAME:
        if getattr(plan, key) != getattr(frame, key):
            raise UsageError(
                f"submission {str(path)!r} has {key} {getattr(plan, key)!r}; the benchmark has {getattr(frame, key)!r}"
            )
