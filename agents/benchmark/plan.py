"""What is to be measured: controllers x throws to learn from x seeds x levels, cut into pieces."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, Self, final

from pydantic import Field, ValidationError, model_validator

from pnt_gym.cells.base.config import LevelConfig, Section, first_problem

from ..cli import UsageError
from ..cluster import Needs
from ..controllers import NAMES
from ..controllers.adaptive import READY, is_told
from ..controllers.between import MOST, OVER, PLANNER
from ..environments import core_of, make_vector
from ..files import read_yaml
from ..parcel import own_code
from ..places import SHIPPED
from ..runs import ALGORITHMS
from ..work import code_digest, key

Count = Annotated[int, Field(ge=0)]
LEARNERS = ("mean_shift", "virtual_goal", "newton_goal", "ridge", "mlp", *ALGORITHMS)
_CODE = (
    "pnt_gym/**/*.py",
    "agents/actor.py",
    "agents/controllers/**/*.py",
    "agents/benchmark/run.py",
    "agents/evaluation.py",
    "agents/throws.py",
    "agents/environments.py",
    "agents/sb3.py",
    "agents/train.py",
)
"""The code that decides where objects land."""


@final
class Entry(Section):
    """One line of the benchmark."""

    label: str = Field(min_length=1)
    controller: str = Field(description="A controller's name or MODULE:CLASS, or an algorithm of agents.train.")
    throws: tuple[Count, ...] = Field((0,), min_length=1, description="Practice or training before the evaluation.")
    seeds: tuple[Count, ...] | None = Field(None, description="Of the learning; default: the plan's.")
    levels: tuple[str, ...] | None = Field(None, description="To be evaluated on; default: the plan's.")
    train_level: str | None = Field(None, description="To learn on; default: the plan's.")
    options: Mapping[str, Any] = Field({}, description="Settings of the controller.")
    also: tuple[str, ...] = Field((), description="Controllers that take over what it learned, evaluated beside it.")
    online: bool = Field(False, description="It goes on learning in the evaluation, every cell for itself.")
    stack: int = Field(1, description="Of an algorithm: observations that its policy sees at once.")
    over: str = Field(PLANNER, description="Of an algorithm: the controller to whose action its policy's is added.")
    fidelity: Literal["full", "flight"] = Field(
        "full", description="Of an algorithm: what is simulated to learn from; it is judged in the level's own."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        known = ", ".join(NAMES)
        if self.controller in ALGORITHMS and (self.also or self.online):
            raise ValueError(f"entry {self.label!r}: also and online are not for {', '.join(ALGORITHMS)}")
        for name in self.also:
            if name not in NAMES:
                raise ValueError(f"entry {self.label!r}: unknown controller {name!r} in also; known are {known}")
        if ":" not in self.controller:
            self._check_name()
        return self

    def _check_name(self) -> None:
        if self.controller not in (*NAMES, *ALGORITHMS):
            known = ", ".join((*NAMES, *ALGORITHMS, "MODULE:CLASS"))
            raise ValueError(f"unknown controller {self.controller!r}; known are {known}")
        if self.controller not in ALGORITHMS and (self.stack, self.over, self.fidelity) != (1, PLANNER, "full"):
            raise ValueError(f"entry {self.label!r}: stack, over and fidelity are for {', '.join(ALGORITHMS)}")
        if not 1 <= self.stack <= MOST or self.over not in OVER:
            raise ValueError(
                f"entry {self.label!r} has stack {self.stack} over {self.over!r}; it must be 1 to {MOST} over one of "
                f"{', '.join(OVER)}"
            )
        if self.controller in READY or self.online:
            return
        if (self.controller in LEARNERS) != all(t > 0 for t in self.throws):
            raise ValueError(f"entry {self.label!r} with controller {self.controller!r} has throws {self.throws}")


def labels_of(entry: Entry) -> list[str]:
    """Labels of an entry's results: its own, and after it those of the controllers that take over what it learned."""
    taken = [name if entry.label == entry.controller else f"{name}_{entry.label}" for name in entry.also]
    return [entry.label, *taken]


@final
class Choice(Section):
    """One result of the benchmark: a label and what it learned from."""

    label: str
    throws: Count = 0


@final
class Plan(Section):
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
        labels = [label for entry in self.entries for label in labels_of(entry)]
        if len(set(labels)) != len(labels):
            raise ValueError(f"entries: labels {labels} must differ from one another")
        known = {(label, t) for entry in self.entries for label in labels_of(entry) for t in entry.throws}
        for choice in (*self.learned, *self.references):
            if (choice.label, choice.throws) not in known:
                raise ValueError(f"no entry gives {choice.label!r} after {choice.throws} throws")
        for level, label in self.floors.items():
            if label not in labels:
                raise ValueError(f"floors.{level}: no entry is labelled {label!r}")
        return self


@final
@dataclass(frozen=True)
class Piece:
    """A piece of work that one process does and one file keeps."""

    plan: Plan
    entry: Entry
    throws: tuple[int, ...]
    """Training is evaluated on its way, at each of these."""
    seed: int
    levels: tuple[str, ...]
    train_level: str
    configs: Mapping[str, LevelConfig]
    """What the levels say that do not ship: a file may change while others wait, and lies on this machine alone."""
    key: str
    """Changes when anything changes that the numbers depend on."""

    @property
    def name(self) -> str:
        """For people and file names."""
        return f"{self.entry.label}-{'-'.join(map(str, self.throws))}-seed{self.seed}"

    @property
    def cost(self) -> int:
        """Throws that will be simulated; the oracle simulates each one several times."""
        learning = max(self.throws)
        times = 15 if self.entry.controller == "oracle" else 1
        return learning + times * len(self.throws) * len(self.levels) * self.plan.picks


def read_plan(path: Path) -> Plan:
    """The plan in a YAML file.

    Raises:
        UsageError: the file is missing or damaged, or its plan does not hold together.
    """
    try:
        return Plan.model_validate(read_yaml(path, "benchmark"))
    except ValidationError as error:
        raise UsageError(f"benchmark {str(path)!r}: {first_problem(error)}") from None


def pieces(plan: Plan) -> list[Piece]:
    """The plan's work, longest first.

    Raises:
        UsageError: the environment does not exist.
        ConfigError: a level does not exist.
    """
    for level in plan.levels:
        _check_whole(plan, level)
    code = code_digest(_CODE)
    made: list[Piece] = []
    for entry in plan.entries:
        learns = any(entry.throws)
        seeds = (entry.seeds or plan.seeds) if learns else (plan.seeds[0],)
        # A training run passes through its smaller throw counts; practice is planned for each count anew.
        groups = [tuple(sorted(entry.throws))] if entry.controller in ALGORITHMS else [(t,) for t in entry.throws]
        made += [_piece(plan, entry, group, seed, code) for group in groups for seed in seeds]
    return sorted(made, key=lambda piece: -piece.cost)


def _piece(plan: Plan, entry: Entry, throws: tuple[int, ...], seed: int, code: str) -> Piece:
    levels = entry.levels or plan.levels
    train_level = entry.train_level or plan.train_level
    settings = SHIPPED / "configs" / "rl" / f"{entry.controller}.yml"
    inputs = {
        "entry": entry.model_dump(mode="json", exclude={"label", "throws", "seeds", "levels", "train_level"}),
        "throws": throws,
        "seed": seed,
        "levels": [_config(plan.env, level).model_dump(mode="json") for level in levels],
        "train_level": _config(plan.env, train_level).model_dump(mode="json"),
        "settings": settings.read_text(encoding="utf-8") if entry.controller in ALGORITHMS else "",
        "plan": plan.model_dump(mode="json", include={"env", "picks", "seed", "num_envs"}),
        "code": code,
        "own": [own_code(name.partition(":")[0]) for name in (entry.controller, plan.env) if ":" in name],
    }
    known = {level: _config(plan.env, level) for level in (*levels, train_level)}
    own = {level: config for level, config in known.items() if _is_own(level, config)}
    return Piece(plan, entry, throws, seed, levels, train_level, own, key(**inputs))


def _check_whole(plan: Plan, level: str) -> None:
    """Make sure that throws which depend on those before are measured in whole episodes."""
    with closing(make_vector(plan.env, level, num_envs=1, threads=1)) as env:
        core = core_of(env)
        if not is_told(core):
            return
        together = plan.num_envs * core.cell.episode
        if plan.picks % together > 0:
            raise UsageError(
                f"picks is {plan.picks}; with num_envs {plan.num_envs} and shifts of {core.cell.episode} picks on "
                f"level {level!r} it must be a multiple of {together}"
            )


@cache
def _config(env_id: str, level: str) -> Any:
    """A level in full, as the environment reads it."""
    with closing(make_vector(env_id, level, num_envs=1, threads=1)) as env:
        return core_of(env).config


def _is_own(level: str, config: Any) -> bool:
    """Whether a level is a file of the user's, and an environment can be made with what it says instead."""
    return isinstance(config, LevelConfig) and level not in config.level_names()


def needs(plan: Plan) -> Needs:
    """What the work needs of another machine than this one.

    Raises:
        UsageError: it reads what lies on this machine alone.
    """
    for entry in plan.entries:
        for level in {*(entry.levels or plan.levels), entry.train_level or plan.train_level}:
            if not isinstance(_config(plan.env, level), LevelConfig) and os.path.exists(level):
                raise UsageError(f"level {level!r} is a file, which {plan.env!r} would have to read on another machine")
        for name, value in entry.options.items():
            if isinstance(value, str) and os.path.isfile(value):
                raise UsageError(f"entry {entry.label!r}: {name} {value!r} is a file, which lies on this machine alone")
    named = [entry.controller for entry in plan.entries]
    modules = sorted({name.partition(":")[0] for name in (plan.env, *named) if ":" in name})
    return Needs(tuple(modules), torch=any(name in (*ALGORITHMS, "mlp") for name in named))
