"""The papers that can be reproduced, and their parts as jobs."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final, Protocol, cast

from pnt_gym.errors import PntGymError, one_sentence

from ..ground.places import CODE
from ..jobs.code import code_digest
from ..jobs.work import Job, key
from .finding import Overview, Parts

PAPERS: Final = {"hassan": "conveyor", "choe": "conveyor", "miyashita": "one_joint", "leveziel": "gripper"}
"""Papers by the name of their package here, and whose levels they simulate."""


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
    files = ("pnt_gym/**/*.py", f"configs/cells/{PAPERS[name]}/*.yaml")
    digest = key(code=code_digest(files, [f"agents.reproduce.{name}"], CODE))
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
