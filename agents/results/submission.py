"""Submissions: results that others hand in, which must be of the benchmark's held-out throws."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from ..ground.cli import UsageError
from ..ground.places import SHIPPED
from .compare import check_figures
from .content import ABOUT, Content, read_form
from .plan import read_plan

BENCHMARK: Final = SHIPPED / "configs" / "benchmark.yaml"
"""Plan whose held-out throws every submission throws."""
FRAME: Final = ("env", "levels", "inline", "picks", "picks_on", "seed", "num_envs")
"""Keys of a plan by which held-out throws are named."""


def read_submission(path: Path) -> Content:
    """Content of a submission's file.

    Raises:
        UsageError: the file is damaged, says other than its rows, or is no submission.
    """
    content = read_form(path)
    check_submission(content)
    return check_figures(content)


def check_submission(content: Content) -> None:
    """Check what the content of a submission's file has beside that of a benchmark's file.

    Raises:
        UsageError: the file says too little of itself, or its throws are not the benchmark's.
    """
    plan, data, path = content
    missing = [name for name in ABOUT if name not in data]
    if missing:
        raise UsageError(f"submission {str(path)!r} has no {missing[0]!r}")
    if {row["label"] for row in data["results"]} != {path.stem}:
        raise UsageError(f"submission {str(path)!r}: its rows must have the label {path.stem!r}")
    frame = read_plan(BENCHMARK)
    for key in FRAME:
        if getattr(plan, key) != getattr(frame, key):
            raise UsageError(
                f"submission {str(path)!r} has {key} {getattr(plan, key)!r}; the benchmark has {getattr(frame, key)!r}"
            )
