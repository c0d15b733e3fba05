"""What is to be measured: controllers x throws or decisions to learn from x seeds x levels, cut into pieces."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Self, final

from pydantic import Field, ValidationError, model_validator

from pnt_gym.cells.base.config import FileName, LevelConfig, Section, first_problem
from pnt_gym.cells.line.config import LineConfig

from ..controllers import NAMES
from ..controllers.adaptive import READY, is_told
from ..dispatchers.registry import NAMES as DECIDING
from ..ground.cli import UsageError
from ..ground.environments import core_of, make_vector
from ..ground.files import read_yaml
from ..ground.places import ADAPTIVE, SHIPPED, at
from ..jobs.cluster import Needs
from ..jobs.code import code_digest
from ..jobs.parcel import own_code
from ..jobs.work import key
from ..learning.runs import CHOOSING
from . import lines
from .entries import EACH, TRAINED, Choice, Count, Entry, Several, labels_of, settings_of

_CODE = ("pnt_gym/**/*.py", "agents/controllers/*.py", "agents/dispatchers/*.py")
"""Code that decides where objects land or what comes next, and is found by a name; the rest is imported."""


@final
class Plan(Section):
    """A benchmark; the defaults are what the paired comparison needs."""

    name: FileName = Field(pattern=r"^[A-Za-z0-9_-]+$")
    env: str = Field(
        "PnTRelease-v0",
        description="Its objects do not depend on the actions: throws, or shifts of a line, are paired.",
    )
    train_level: str = Field(description=f"To learn on; {EACH!r}: each that is evaluated on, for itself.")
    levels: tuple[str, ...] = Field(min_length=1)
    picks: Several = Field(1000, description="Held-out throws of every seed; not of a line.")
    picks_on: dict[str, Several] = Field(
        {}, description="The same of single levels: more of them where what is compared differs more."
    )
    shifts: Several = Field(lines.SHIFTS, description="Held-out shifts of every seed; of a line.")
    seed: Count = Field(0, description="Names the held-out throws or shifts.")
    seeds: tuple[Count, ...] = Field((0, 1, 2), min_length=1)
    num_envs: Annotated[int, Field(ge=1)] = 16
    entries: tuple[Entry, ...] = Field(min_length=1)
    learned: tuple[Choice, ...] = Field(
        (), description="Compared with each of `references`, throw by throw or shift by shift."
    )
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
        for level in self.picks_on:
            if level not in self.judged:
                raise ValueError(f"picks_on.{level}: no entry is evaluated there, but on {', '.join(self.judged)}")
        return self

    @property
    def judged(self) -> tuple[str, ...]:
        """Every level that something is evaluated on."""
        return tuple(sorted({level for entry in self.entries for level in entry.levels or self.levels}))

    def picks_of(self, level: str) -> int:
        """Held-out throws of every seed on a level."""
        return self.picks_on.get(level, self.picks)


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
    name: str
    """For people and file names."""
    cost: int
    """Throws that will be simulated, or decisions that will be taken; who takes long counts several times."""


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
        UsageError: the environment does not exist, or is none for what the plan says.
        ConfigError: a level does not exist.
    """
    for level in plan.judged:
        _check_whole(plan, level)
    line = is_of_line(plan)
    _check_kind(plan, line)
    code = code_digest(_CODE, ["agents.benchmark.run"])
    made: list[Piece] = []
    for entry, where in _by_level(plan):
        learns = any(entry.throws)
        seeds = (entry.seeds or plan.seeds) if learns else (plan.seeds[0],)
        # A training run passes through its smaller throw counts; practice is planned for each count anew.
        groups = [tuple(sorted(entry.throws))] if entry.controller in TRAINED else [(t,) for t in entry.throws]
        for group, seed in product(groups, seeds):
            name = f"{entry.label}-{where}{'-'.join(map(str, group))}-seed{seed}"
            made.append(_piece(plan, entry, group, seed, name, code))
    return sorted(made, key=lambda piece: -piece.cost)


def is_of_line(plan: Plan) -> bool:
    """Whether what is planned are shifts of a line instead of throws."""
    return isinstance(_config(plan.env, plan.levels[0]), LineConfig)


def _by_level(plan: Plan) -> list[tuple[Entry, str]]:
    """Entries, each for every level apart where it is learned on for itself, and what tells their pieces apart."""
    found: list[tuple[Entry, str]] = []
    for entry in plan.entries:
        if (entry.train_level or plan.train_level) != EACH:
            found.append((entry, ""))
            continue
        for level in entry.levels or plan.levels:
            alone = entry.model_copy(update={"levels": (level,), "train_level": level})
            found.append((alone, f"{Path(level).stem}-"))
    return found


def _piece(plan: Plan, entry: Entry, throws: tuple[int, ...], seed: int, name: str, code: str) -> Piece:
    levels = entry.levels or plan.levels
    train_level = entry.train_level or plan.train_level
    known: dict[str, Any] = {level: _config(plan.env, level) for level in (*levels, train_level)}
    settled = {"label", "throws", "seeds", "levels", "train_level"}
    line = is_of_line(plan)
    inputs = {
        "entry": entry.model_dump(mode="json", exclude=settled),
        "throws": throws,
        "seed": seed,
        "levels": [known[level].model_dump(mode="json") for level in levels],
        "train_level": known[train_level].model_dump(mode="json"),
        "settings": settings_of(entry, plan.env) if entry.controller in TRAINED else {},
        "plan": plan.model_dump(mode="json", include={"env", "seed", "num_envs"}),
        "counts": [plan.shifts if line else plan.picks_of(level) for level in levels],
        "code": code,
        "own": [own_code(name.partition(":")[0]) for name in (entry.controller, plan.env) if ":" in name],
        "knows": code_digest(("*.npz",), root=ADAPTIVE) if _is_given(entry, throws) else "",
        **(lines.depends(entry.controller, list(known.values()), entry.options) if line else {}),
    }
    own = {level: config for level, config in known.items() if _is_own(level, config)}
    each = sum(_effort(plan, entry, level, known[level]) for level in levels)
    cost = max(throws) + len(throws) * len(labels_of(entry)) * each
    return Piece(plan, entry, throws, seed, levels, train_level, own, key(**inputs), name, cost)


def _is_given(entry: Entry, throws: tuple[int, ...]) -> bool:
    """Whether what ships is known beforehand, by the controller itself or by the one that it learns to correct."""
    return entry.over in READY or (max(throws) == 0 and entry.controller in (*READY, "oracle_drift"))


def _effort(plan: Plan, entry: Entry, level: str, config: Any) -> int:
    """Throws or decisions of one evaluation; the oracle simulates each throw several times."""
    if isinstance(config, LineConfig):
        return lines.effort(entry.controller, config, entry.shifts or plan.shifts, plan.num_envs)
    return (15 if entry.controller == "oracle" else 1) * plan.picks_of(level)


def _check_kind(plan: Plan, line: bool) -> None:
    """Make sure that a plan says what its environment has a use for: throws, or shifts of a line.

    Raises:
        UsageError: it does not.
    """
    said = plan.model_fields_set
    if line:
        if unused := {"picks", "picks_on", "floors"} & said:
            raise UsageError(f"{min(unused)} goes with throws; {plan.env!r} is a line, which is judged by its shifts")
        _check_line(plan)
        return
    if "shifts" in said:
        raise UsageError(f"shifts goes with a line, such as PnTLine-v0; on {plan.env!r} throws are counted, by picks")
    for entry in plan.entries:
        name = entry.controller
        if entry.shifts is not None or name in {*DECIDING, *CHOOSING} - {*NAMES} or lines.is_learned(name):
            raise UsageError(
                f"entry {entry.label!r}: controller {name!r}, shifts and the like are of a line, such as PnTLine-v0, "
                f"and not of {plan.env!r}"
            )


def _check_line(plan: Plan) -> None:
    """Make sure that entries can be made, before any of them works for hours.

    Raises:
        UsageError: one cannot.
    """
    for entry in plan.entries:
        if entry.also or entry.online:
            raise UsageError(f"entry {entry.label!r}: also and online go with throws, and {plan.env!r} is a line")
        if (entry.shifts or plan.shifts) > plan.shifts:
            raise UsageError(f"entry {entry.label!r} has shifts {entry.shifts}; the plan has {plan.shifts}")
    for level in plan.judged:
        with closing(make_vector(plan.env, level, num_envs=1, threads=1)) as env:
            for entry in plan.entries:
                if level in (entry.levels or plan.levels) and entry.controller not in CHOOSING:
                    lines.controller(entry.label, entry.controller, env, entry.options)


def _check_whole(plan: Plan, level: str) -> None:
    """Make sure that throws which depend on those before are measured in whole episodes."""
    with closing(make_vector(plan.env, level, num_envs=1, threads=1)) as env:
        core = core_of(env)
        if not is_told(core):
            return
        together = plan.num_envs * core.cell.episode
        if (picks := plan.picks_of(level)) % together > 0:
            raise UsageError(
                f"picks is {picks}; with num_envs {plan.num_envs} and shifts of {core.cell.episode} picks on level "
                f"{level!r} it must be a multiple of {together}"
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
    for entry, _ in _by_level(plan):
        known = {
            level: _config(plan.env, level)
            for level in {*(entry.levels or plan.levels), entry.train_level or plan.train_level}
        }
        for level, config in known.items():
            if not isinstance(config, LevelConfig) and os.path.exists(level):
                raise UsageError(f"level {level!r} is a file, which {plan.env!r} would have to read on another machine")
            if isinstance(config, LineConfig) and config.chances is not None:
                raise UsageError(f"level {level!r}: chances {config.chances!r} is a file, which lies on this machine")
        guides = lines.guides(entry.controller, list(known.values()), entry.options)
        learned = [("controller", entry.controller), *(("guide", guide) for guide in guides)]
        for name, value in (*learned, ("config", entry.config), *entry.options.items()):
            if _lies_here_alone(name, value):
                raise UsageError(f"entry {entry.label!r}: {name} {value!r} is a file, which lies on this machine alone")
    named = [entry.controller for entry in plan.entries]
    modules = sorted({name.partition(":")[0] for name in (plan.env, *named) if ":" in name})
    return Needs(tuple(modules), torch=any(name in (*TRAINED, "mlp") for name in named))


def _lies_here_alone(name: str, value: Any) -> bool:
    """Whether an entry's setting names a file that no other machine has; of what ships, hyperparameters are there."""
    if name in ("controller", "guide"):
        return lines.is_learned(str(value))
    there = name == "config" and at(str(value)).resolve().is_relative_to(SHIPPED / "configs")
    return isinstance(value, str) and os.path.isfile(value) and not there
