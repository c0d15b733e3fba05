"""The papers that can be reproduced, and their parts as jobs."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final, Protocol, cast

from pnt_gym.errors import PntGymError, one_sentence

from ..places import CODE
from ..work import Job, code_digest, key
from .finding import Overview, Parts

_LEARNING: Final = (
    "pnt_gym/envs/*.py",
    "agents/environments.py",
    "agents/evaluation.py",
    "agents/throws.py",
    "agents/controllers/**/*.py",
)
"""What learning in an environment depends on."""
PAPERS: Final[Mapping[str, tuple[str, ...]]] = {
    "hassan": ("configs/cells/conveyor/*.yaml",),
    "choe": ("configs/cells/conveyor/*.yaml",),
    "miyashita": ("configs/cells/one_joint/*.yaml", *_LEARNING),
    "leveziel": ("configs/cells/gripper/*.yaml", *_LEARNING),
}
"""Papers by the name of their package here, and the code they depend on beside their own and what all share."""
_SHARED: Final = (
    "pnt_gym/*.py",
    "pnt_gym/planning/**/*.py",
    "pnt_gym/robots/**/*.py",
    "pnt_gym/cells/**/*.py",
    "agents/drawings.py",
    "agents/reproduce/*.py",
)
_NO_EFFECT: Final = ("agents/reproduce/__main__.py", "agents/reproduce/papers.py", "agents/reproduce/record.py")
"""Code that changes no finding."""


class Paper(Protocol):
    """What the package of a paper offers."""

    SHORT: str
    """Authors and year."""
    PARTS: Parts

    def overview(self, rows: Mapping[str, Mapping[str, Any]]) -> Overview:
        """What all parts show together; of the rows, by quantity, some may be missing."""
        ...


def package(name: str) -> Paper:
    """The package of a paper."""
    return cast(Paper, importlib.import_module(f".{name}", __package__))


def jobs(name: str) -> list[Job]:
    """One job per part of a paper."""
    code = (*_SHARED, *PAPERS[name], f"agents/reproduce/{name}/**/*.py")
    digest = key(code=code_digest(code, _NO_EFFECT, CODE))
    return [Job(f"{name}/{part}", digest, partial(run_part, name, part)) for part in package(name).PARTS]


def run_part(name: str, part: str, _folder: Path) -> dict[str, Any]:
    """What a part of a paper finds.

    Raises:
        PntGymError: the part could not be done, with its name.
    """
    try:
        found = package(name).PARTS[part]()
    except PntGymError as error:
        raise PntGymError(f"{name}, part {part}: {one_sentence(error)}") from None
    except ModuleNotFoundError as error:
        raise PntGymError(f"{name}, part {part}: {error.name} is not installed; `make setup` does it") from None
    return {
        "rows": [{**row.as_json(), "paper": name} for row in found.rows],
        "data": dict(found.data),
        "figures": dict(found.figures),
        "grids": [grid._asdict() for grid in found.grids],
    }
