"""The papers that a checkout reproduces, and their parts as jobs."""

from __future__ import annotations

import importlib
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final, Protocol, cast

from pnt_gym.errors import PntGymError, one_sentence

from ..ground.cli import UsageError
from ..ground.files import read_json
from ..ground.places import CODE, SHIPPED
from ..ground.versions import code_digest
from ..ground.work import Job, key
from .finding import Overview, Parts

PAPERS: Final = {"hassan": "conveyor", "choe": "conveyor", "miyashita": "one_joint", "leveziel": "gripper"}
"""Robot whose levels each paper simulates, by the name of the paper's folder in `papers/`."""
PART_NAMES: Final = {
    "hassan": ("table1", "methods", "statements", "figures", "space"),
    "choe": ("example", "length", "curvature", "speed", "joints", "claims", "lengths", "fig-8-times"),
    "miyashita": (
        "example", "margins", "accessible", "learning", "acceptance", "sorting", "assembly", "formulas",
    ),
    "leveziel": ("workspace", "indices", "circle", "moves", "closing", "cycle", "grasps", "formulas"),
}  # fmt: skip
"""Parts of each paper, for the help: to import the papers would take seconds."""
OPTIMA: Final = ("choe/speed", "choe/joints", "choe/fig-8-times")
"""Parts that plan motions as one optimum, for which casadi is needed."""


class Paper(Protocol):
    """Interface of a paper's package."""

    SHORT: str
    """Authors and year."""
    PARTS: Parts

    def overview(self, rows: Mapping[str, Mapping[str, Any]]) -> Overview:
        """Overview of all parts, from rows by quantity, some of which may be missing."""
        ...


PUBLISHED_RESULTS: Final = SHIPPED / "results" / "reproduction.json"


def describe(paper: str) -> str:
    """Names of a paper's parts, each with the processor time that it took when the committed results were made."""
    seconds: Mapping[str, float] = read_json(PUBLISHED_RESULTS)["seconds"] if PUBLISHED_RESULTS.is_file() else {}
    known = {name: seconds.get(f"{paper}/{name}") for name in PART_NAMES[paper]}
    return ", ".join(name if took is None else f"{name} ({duration(took)})" for name, took in known.items())


def duration(seconds: float) -> str:
    """A processor time as text, in seconds below 100 s and in minutes above."""
    return f"{max(seconds, 1.0):.0f} s" if seconds < 100.0 else f"{seconds / 60.0:.0f} min"


def package(name: str) -> Paper:
    """Import the package of a paper.

    Raises:
        UsageError: this is no checkout; an installed package has no papers.
    """
    if not (SHIPPED / "papers" / name).is_dir():
        raise UsageError(f"{name} is reproduced in a checkout of pnt_gym, and {str(SHIPPED)!r} has no folder papers")
    return cast(Paper, importlib.import_module(f"papers.{name}"))


def jobs(name: str) -> list[Job]:
    """One job per part of a paper.

    Raises:
        UsageError: see `package`.
    """
    parts = package(name).PARTS
    files = ("pnt_gym/**/*.py", f"configs/cells/{PAPERS[name]}/*.yaml")
    digest = key(code=code_digest(files, [f"papers.{name}"], CODE))
    return [Job(f"{name}/{part}", digest, partial(run, name, part)) for part in parts]


def run(name: str, part: str, _folder: Path) -> dict[str, Any]:
    """Run a part of a paper; its findings as JSON values.

    Raises:
        PntGymError: the part failed; the message has its name.
    """
    began = time.process_time()
    try:
        findings = package(name).PARTS[part]()
    except PntGymError as error:
        raise PntGymError(f"{name}, part {part}: {one_sentence(error)}") from None
    except ModuleNotFoundError as error:
        raise PntGymError(f"{name}, part {part}: {error.name} is not installed; `make setup` does it") from None
    return {
        # Processor time, which other work on the machine changes little, instead of the job's own clock.
        "seconds": round(time.process_time() - began, 1),
        "rows": [{**row.as_json(), "paper": name} for row in findings.rows],
        "data": dict(findings.data),
        "figures": dict(findings.figures),
        "grids": [grid._asdict() for grid in findings.grids],
    }
