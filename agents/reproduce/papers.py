"""The papers that can be reproduced, their parts, and finished parts kept until the code changes."""

from __future__ import annotations

import hashlib
import importlib
import json
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, final

from agents.cli import one_sentence
from agents.files import write_json
from agents.reproduce.findings import Part
from agents.versions import ROOT, versions
from pnt_gym.errors import PntGymError

PAPERS: Final = {
    "hassan": "agents.reproduce.hassan",
    "choe": "agents.reproduce.choe",
    "miyashita": "agents.reproduce.miyashita",
    "leveziel": "agents.reproduce.leveziel",
}
"""Papers by the name on the command line; each module has `PARTS` and a docstring whose first line is its title."""

_CODE: Final = (
    "pnt_gym/*.py",
    "pnt_gym/planning/**/*.py",
    "pnt_gym/robots/**/*.py",
    "pnt_gym/cells/**/*.py",
    "configs/cells/*.yaml",
    "agents/report/figures.py",
    "agents/reproduce/*.py",
)
_LEARNING: Final = (
    "pnt_gym/envs/*.py",
    "pnt_gym/render/*.py",
    "agents/environments.py",
    "agents/evaluation.py",
    "agents/controllers/*.py",
)
"""What learning in an environment depends on."""
_MORE_CODE: Final = {
    "miyashita": ("configs/cells/pallet/*.yaml", *_LEARNING),
    "leveziel": ("configs/cells/tray/*.yaml", *_LEARNING),
}
"""What a paper depends on beyond that."""
_NO_EFFECT: Final = ("render.py", "metrics.py", "papers.py", "__main__.py")
"""Code that changes no finding."""


@final
@dataclass(frozen=True)
class Job:
    """A part of a paper, by name: a worker process looks it up itself."""

    paper: str
    part: str
    key: str
    """Changes when anything changes that the findings depend on."""

    @property
    def file(self) -> str:
        """Name of the file that keeps its findings."""
        return f"{self.part}-{self.key}.json"


def parts(paper: str) -> tuple[Part, ...]:
    """The parts of a paper, in the order of the report."""
    return importlib.import_module(PAPERS[paper]).PARTS


def jobs(paper: str) -> list[Job]:
    """One job per part."""
    key = _key(paper)
    return [Job(paper, part.name, key) for part in parts(paper)]


def run_job(job: Job, folder: Path) -> float:
    """Run a part and keep what it found in `folder`; returns the seconds it took.

    Raises:
        PntGymError: the part could not be done, with its name.
    """
    began = time.perf_counter()
    part = next(part for part in parts(job.paper) if part.name == job.part)
    try:
        found = part.run()
    except PntGymError as error:
        raise PntGymError(f"{job.paper}, part {job.part}: {one_sentence(error)}") from None
    except ModuleNotFoundError as error:
        raise PntGymError(
            f"{job.paper}, part {job.part}: {error.name} is not installed; `make setup` does it"
        ) from None
    seconds = round(time.perf_counter() - began, 1)
    record: dict[str, Any] = {
        "seconds": seconds,
        "rows": [{**row.as_json(), "paper": job.paper} for row in found.rows],
        "data": dict(found.data),
        "figures": dict(found.figures),
    }
    write_json(folder / job.file, record, indent=None)
    return seconds


@cache
def _key(paper: str) -> str:
    """Digest of versions and of the code of a paper; papers share no code but what belongs to none of them."""
    digest = hashlib.sha256(json.dumps(versions(), sort_keys=True).encode())
    others = tuple(name for name in PAPERS if name != paper)
    for pattern in (*_CODE, *_MORE_CODE.get(paper, ())):
        for path in sorted(ROOT.glob(pattern)):
            if path.name not in _NO_EFFECT and not path.name.startswith(others):
                digest.update(path.relative_to(ROOT).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:12]
