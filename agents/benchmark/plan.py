"""What is to be measured: controllers x throws to learn from x seeds x levels, cut into cells of work."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Self, final

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from agents.cli import UsageError
from agents.controllers import NAMES
from agents.environments import level_in_full
from agents.runs import ALGORITHMS
from agents.versions import ROOT, versions

Count = Annotated[int, Field(ge=0)]
LEARNERS = ("mean_shift", "virtual_goal", "ridge", "mlp", *ALGORITHMS)
_CODE = (
    "pnt_gym/**/*.py",
    "agents/controllers/*.py",
    "agents/evaluation.py",
    "agents/environments.py",
    "agents/sb3.py",
    "agents/train.py",
)
_NO_EFFECT = ("pnt_gym/render/", "pnt_gym/metrics.py")
"""Code that changes no throw."""


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


@final
class Entry(_Section):
    """One line of the benchmark."""

    label: str = Field(min_length=1)
    controller: str = Field(description="A controller's name, or an algorithm of agents.train.")
    throws: tuple[Count, ...] = Field((0,), min_length=1, description="Practice or training before the evaluation.")
    seeds: tuple[Count, ...] | None = Field(None, description="Of the learning; default: the plan's.")
    levels: tuple[str, ...] | None = Field(None, description="To be evaluated on; default: the plan's.")
    train_level: str | None = Field(None, description="To learn on; default: the plan's.")
    options: Mapping[str, Any] = Field({}, description="Settings of the controller.")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.controller not in (*NAMES, *ALGORITHMS):
            known = ", ".join((*NAMES, *ALGORITHMS))
            raise ValueError(f"unknown controller {self.controller!r}; known are {known}")
        if (self.controller in LEARNERS) != all(t > 0 for t in self.throws):
            raise ValueError(f"entry {self.label!r} with controller {self.controller!r} has throws {self.throws}")
        return self


@final
class Choice(_Section):
    """One result of the benchmark: a label and what it learned from."""

    label: str
    throws: Count = 0


@final
class Plan(_Section):
    """A benchmark; the defaults are what the paired comparison needs."""

    name: str = Field(pattern=r"^[A-Za-z0-9_-]+$")
    env: str = Field("PnTRelease-v0", description="Its objects do not depend on the actions: throws are paired.")
    train_level: str
    levels: tuple[str, ...] = Field(min_length=1)
    picks: Annotated[int, Field(ge=2)] = 1000
    seed: Count = Field(0, description="Names the held-out throws.")
    seeds: tuple[Count, ...] = Field((0, 1, 2), min_length=1)
    num_envs: Annotated[int, Field(ge=1)] = 16
    entries: tuple[Entry, ...] = Field(min_length=1)
    learned: tuple[Choice, ...] = Field((), description="Compared with each of `references`, throw by throw.")
    references: tuple[Choice, ...] = ()
    floors: Mapping[str, str] = Field({}, description="Per level the label whose error is the noise floor.")

    @model_validator(mode="after")
    def _check(self) -> Self:
        labels = [entry.label for entry in self.entries]
        if len(set(labels)) != len(labels):
            raise ValueError(f"entries: labels {labels} must differ from one another")
        known = {(entry.label, throws) for entry in self.entries for throws in entry.throws}
        for choice in (*self.learned, *self.references):
            if (choice.label, choice.throws) not in known:
                raise ValueError(f"no entry gives {choice.label!r} after {choice.throws} throws")
        for level, label in self.floors.items():
            if label not in labels:
                raise ValueError(f"floors.{level}: no entry is labelled {label!r}")
        return self


@final
@dataclass(frozen=True)
class Cell:
    """A piece of work that one process does and one file keeps."""

    entry: Entry
    throws: tuple[int, ...]
    """Training is evaluated on its way, at each of these."""
    seed: int
    levels: tuple[str, ...]
    train_level: str
    env: str
    picks: int
    eval_seed: int
    num_envs: int
    key: str
    """Changes when anything changes that the numbers depend on."""

    @property
    def name(self) -> str:
        """For people and file names."""
        throws = "-".join(str(t) for t in self.throws)
        return f"{self.entry.label}-{throws}-seed{self.seed}-{self.key}"

    @property
    def cost(self) -> int:
        """Throws that will be simulated; the oracle simulates each one several times."""
        learning = max(self.throws)
        times = 5 if self.entry.controller == "oracle" else 1
        return learning + times * len(self.throws) * len(self.levels) * self.picks


def read_plan(path: Path) -> Plan:
    """The plan in a YAML file.

    Raises:
        UsageError: the file is missing or damaged, or its plan does not hold together.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot read benchmark {str(path)!r}: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UsageError(f"benchmark {str(path)!r} is not valid YAML: {str(error).splitlines()[0]}") from None
    try:
        return Plan.model_validate(data)
    except ValidationError as error:
        problem = error.errors()[0]
        where = ".".join(str(part) for part in problem["loc"])
        message = problem["msg"].removeprefix("Value error, ")
        raise UsageError(f"benchmark {str(path)!r}: {f'{where}: ' if where else ''}{message}") from None


def cells(plan: Plan) -> list[Cell]:
    """The plan's work, longest first.

    Raises:
        UsageError: the environment does not exist.
        ConfigError: a level does not exist.
    """
    code = _code_digest()
    made: list[Cell] = []
    for entry in plan.entries:
        learns = entry.controller in LEARNERS
        seeds = (entry.seeds or plan.seeds) if learns else (plan.seeds[0],)
        # A training run passes through its smaller throw counts; practice is planned for each count anew.
        groups = [tuple(sorted(entry.throws))] if entry.controller in ALGORITHMS else [(t,) for t in entry.throws]
        made += [_cell(plan, entry, group, seed, code) for group in groups for seed in seeds]
    return sorted(made, key=lambda cell: -cell.cost)


def _cell(plan: Plan, entry: Entry, throws: tuple[int, ...], seed: int, code: str) -> Cell:
    levels = entry.levels or plan.levels
    train_level = entry.train_level or plan.train_level
    inputs = {
        "entry": entry.model_dump(mode="json", include={"controller", "options"}),
        "throws": throws,
        "seed": seed,
        "levels": [_level(plan.env, level) for level in levels],
        "train_level": _level(plan.env, train_level),
        "settings": _settings_text(entry.controller),
        "plan": plan.model_dump(mode="json", include={"env", "picks", "seed", "num_envs"}),
        "versions": versions(),
        "code": code,
    }
    key = hashlib.sha256(json.dumps(inputs, sort_keys=True).encode()).hexdigest()[:12]
    return Cell(entry, throws, seed, levels, train_level, plan.env, plan.picks, plan.seed, plan.num_envs, key)


@cache
def _level(env_id: str, name: str) -> dict[str, Any]:
    """A level in full."""
    return level_in_full(env_id, name).model_dump(mode="json")


def _settings_text(controller: str) -> str:
    """Hyperparameters of an algorithm; nothing for other controllers."""
    path = ROOT / "configs" / "rl" / f"{controller}.yml"
    return path.read_text(encoding="utf-8") if controller in ALGORITHMS else ""


def _code_digest() -> str:
    """Digest of the code that decides where objects land."""
    digest = hashlib.sha256()
    for pattern in _CODE:
        for path in sorted(ROOT.glob(pattern)):
            name = path.relative_to(ROOT).as_posix()
            if not name.startswith(_NO_EFFECT):
                digest.update(name.encode() + path.read_bytes())
    return digest.hexdigest()
