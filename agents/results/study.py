"""Files of studies: what their rows have in common, and rows of figures, of which no throws are kept."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from ..judging.form import Count, check_model


class StudyFile(BaseModel):
    """Form of a study's file; the figures of its rows are those of its plan."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    study: Annotated[str, Field(max_length=100)]
    version: Annotated[str, Field(max_length=100)]
    seed: Annotated[int, Field(ge=0)]
    throws: Count
    digest: Annotated[str, Field(max_length=100)] = ""
    rows: list[dict[str, Any]]


def is_study(data: Any) -> bool:
    """Whether a file of results is that of a study."""
    return isinstance(data, dict) and {"study", "rows", "throws"} <= data.keys()


def check_study(path: Path, data: Any) -> None:
    """Make sure that a study's file has its form.

    Raises:
        UsageError: it has another one.
    """
    check_model(path, StudyFile, data)
