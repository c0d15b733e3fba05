"""Plans of benchmarks: controllers x throws or decisions to learn from x seeds x levels, cut into pieces of work."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Final, Self, final

from pydantic import Field, ValidationError, model_validator

from pnt_gym.cells.base.config import FileName, LevelConfig, Section
from pnt_gym.cells.base.problems import list_problems
from pnt_gym.names import unknown_name
from pnt_gym.reading import MOST_NUMBERS, bytes_of

from ..controllers.protocol import Controller
from ..ground import parcel, shipped
from ..ground.cli import UsageError, about, check_libraries, check_once
from ..ground.cluster import Needs
from ..ground.environments import config_of
from ..ground.files import read_yaml
from ..ground.places import SHIPPED, at
from ..ground.shipped import is_shipped, module_of
from ..ground.versions import code_digest
from ..ground.work import key
from ..judging import trials
from ..judging.trial import Trial
from ..judging.trials import open_trial
from ..learning.runs import POLICY
from . import entries
from .entries import EACH, FITTED, LEARNED_BY, TRAINED, Choice, Count, Entry, Several, is_learned, settings_of

CODE: Final = ("pnt_gym/**/*.py", "agents/controllers/*.py", "agents/dispatchers/*.py")
"""Code on which results depend and which is loaded by a name; all other code is found by following imports."""


@final
class Plan(Section):
    """A benchmark; the defaults are what the paired comparison needs."""

    name: FileName = Field(pattern=r"^[A-Za-z0-9_-]+$")
    env: str = Field(
        "PnTRelease-v0",
        description="Its objects do not depend on the actions: throws, or shifts of a line, are paired.",
    )
    train_level: str = Field(description=f"To learn on; {EACH!r}: each that is evaluated on, for itself.")
    levels: tuple[str, ...] = Field(
        min_length=1,
        description="Names or files; or a mapping of labels to levels as a level's file would say them, for instance "
        "{careful: {base: waste, grip: {safety: 1.5}}}, or to null for a level that has the label's name.",
    )
    inline: Mapping[str, Mapping[str, Any]] = Field(
        {}, description="Levels of such a mapping; there is no need for it."
    )
    picks: Several = Field(1000, description="Held-out throws of every seed; not of a line.")
    picks_on: dict[str, Several] = Field(
        {}, description="The same of single levels: more of them where what is compared differs more."
    )
    shifts: Several = Field(100, description="Held-out work shifts of every seed; of a line.")
    seed: Count = Field(0, description="Names the held-out throws or shifts.")
    seeds: tuple[Count, ...] = Field((0, 1, 2), min_length=1)
    num_envs: Annotated[int, Field(ge=1)] = 16
    entries: tuple[Entry, ...] = Field(min_length=1)
    learned: tuple[Choice, ...] = Field(
        (), description="Compared with each of `references`, throw by throw or shift by shift."
    )
    references: tuple[Choice, ...] = ()
    floors: Mapping[str, str] = Field({}, description="Per level the label whose error is the noise floor.")

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any) -> Any:
        """Split `levels`, if it is a mapping, into the labels in `levels` and the levels in `inline`."""
        if not (isinstance(data, Mapping) and isinstance(data.get("levels"), Mapping)):
            return data
        levels = data["levels"]
        inline = {str(label): level for label, level in levels.items() if level is not None}
        return {**data, "levels": [*map(str, levels)], "inline": {**data.get("inline", {}), **inline}}

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_once({"levels": self.levels, "seeds": self.seeds})
        labels = [label for entry in self.entries for label in entries.labels(entry)]
        if len(set(labels)) != len(labels):
            raise ValueError(f"entries: labels {labels} must differ from one another")
        results = {(label, t) for entry in self.entries for label in entries.labels(entry) for t in entry.throws}
        for choice in (*self.learned, *self.references):
            if (choice.label, choice.throws) not in results:
                known = [f"{label} after {throws}" for label, throws in results]
                raise ValueError(unknown_name("result", f"{choice.label} after {choice.throws}", known, " throws"))
        for level, label in self.floors.items():
            if label not in labels:
                raise ValueError(f"floors.{level}: {unknown_name('label', label, labels)}")
        for level in self.picks_on:
            if level not in self.evaluation_levels:
                raise ValueError(f"picks_on: {unknown_name('level', level, self.evaluation_levels)}")
        return self

    @property
    def evaluation_levels(self) -> tuple[str, ...]:
        """Names of all levels on which an entry is evaluated, sorted."""
        return tuple(sorted({level for entry in self.entries for level in entry.levels or self.levels}))

    def level(self, name: str) -> str | dict[str, Any]:
        """A level as environments take it: its name or file, or the mapping in the plan."""
        return {"name": name, **self.inline[name]} if name in self.inline else name

    def config(self, name: str) -> Any:
        """Config of a level, as the environment reads it."""
        return _config(self.env, json.dumps(self.level(name), default=str))

    def count(self, trial: type[Trial], level: str, entry: Entry | None = None) -> int:
        """Number of held-out units per seed on a level: for all entries, or for one entry, which may have fewer."""
        entry_count = None if entry is None else getattr(entry, trial.option, None)
        return entry_count or self.picks_on.get(level) or int(getattr(self, trial.option))


@final
@dataclass(frozen=True)
class Piece:
    """A piece of work that one process does and whose results one file keeps."""

    plan: Plan
    entry: Entry
    throws: tuple[int, ...]
    """Numbers of throws to learn from; a training is evaluated at each of these numbers on its way."""
    seed: int
    levels: tuple[str, ...]
    train_level: str
    configs: Mapping[str, LevelConfig]
    """Configs of the levels that do not ship: their files may change while the piece waits, and lie on this machine
    alone."""
    key: str
    """Digest of everything that the results depend on."""
    copy: str
    """Prefix that tells the entry's copies for several levels apart."""
    cost: int
    """Number of throws or decisions to be simulated; those of slow controllers count several times."""

    @property
    def name(self) -> str:
        """Name of the piece, for people and file names."""
        return self._name(self.throws)

    @property
    def rows(self) -> list[tuple[str, int, int, str, str]]:
        """What names each row of the piece: label, throws, seed, level, level of the learning."""
        labels = entries.labels(self.entry)
        return [*product(labels, self.throws, (self.seed,), self.levels, (self.train_level,))]

    def policy_file(self, throws: int) -> str:
        """Name of the file of what the entry has learned from a number of throws."""
        return re.sub(r"[^\w.+-]+", "-", self._name((throws,))) + ".npz"

    def _name(self, throws: tuple[int, ...]) -> str:
        return f"{self.entry.label}-{self.copy}{'-'.join(map(str, throws))}-seed{self.seed}"


def read_plan(path: Path) -> Plan:
    """The plan in a YAML file.

    Raises:
        UsageError: the file is missing or damaged, or the plan contradicts itself.
    """
    try:
        return Plan.model_validate(read_yaml(path, "benchmark"))
    except ValidationError as error:
        raise UsageError(*list_problems(f"benchmark {str(path)!r}", error, Plan)) from None


def trial_of_plan(plan: Plan) -> type[Trial]:
    """The kind of trial by which the plan's controllers are judged."""
    return trials.find(plan.config(plan.levels[0]))


def trial_name(plan: Plan) -> str:
    """Name of the kind of trial, as the config of a level gives it."""
    return str(getattr(plan.config(plan.levels[0]), "trial", "throws"))


def pieces(plan: Plan) -> list[Piece]:
    """The plan's pieces of work, longest first.

    Raises:
        UsageError: the environment does not exist, or does not fit the plan.
        ConfigError: a level does not exist.
    """
    kind = trial_of_plan(plan)
    # Make sure that plan and entries have no keys that only other kinds of trials use.
    plan_keys = {name: name in plan.model_fields_set for name in ("picks", "picks_on", "floors", "shifts")}
    trials.check(kind, plan_keys, repr(plan.env), dashes="")
    for entry in plan.entries:
        entry_keys = {name: bool(getattr(entry, name)) for name in ("shifts", "also", "online")}
        trials.check(kind, entry_keys, repr(plan.env), dashes="")
        entry_count, plan_count = getattr(entry, kind.option, None) or 0, int(getattr(plan, kind.option))
        if entry_count > plan_count:
            raise UsageError(f"entry {entry.label!r} has {kind.option} {entry_count}; the plan has {plan_count}")
    for level in plan.evaluation_levels:
        _check_level(plan, level)
    code = results_code()
    work: list[Piece] = []
    for entry, where in entries_by_level(plan):
        # A training run passes through its smaller throw counts; practice is planned for each count anew.
        groups = [tuple(sorted(entry.throws))] if entry.controller in TRAINED else [(t,) for t in entry.throws]
        for group, seed in product(groups, seeds_of(plan, entry)):
            work.append(_make(plan, kind, entry, group, seed, where, code))
    return sorted(work, key=lambda piece: -piece.cost)


def entries_by_level(plan: Plan) -> list[tuple[Entry, str]]:
    """Entries, one copy per level where `train_level` is `EACH`, each with a prefix that tells copies apart."""
    pairs: list[tuple[Entry, str]] = []
    for entry in plan.entries:
        if (entry.train_level or plan.train_level) != EACH:
            pairs.append((entry, ""))
            continue
        for level in entry.levels or plan.levels:
            level_entry = entry.model_copy(update={"levels": (level,), "train_level": level})
            pairs.append((level_entry, f"{level if level in plan.inline else Path(level).stem}-"))
    return pairs


def seeds_of(plan: Plan, entry: Entry) -> tuple[int, ...]:
    """Seeds of the learning of an entry; one seed of an entry that learns nothing."""
    return (entry.seeds or plan.seeds) if any(entry.throws) else (plan.seeds[0],)


def _make(
    plan: Plan, kind: type[Trial], entry: Entry, throws: tuple[int, ...], seed: int, copy: str, code: str
) -> Piece:
    levels = entry.levels or plan.levels
    train_level = entry.train_level or plan.train_level
    configs: dict[str, Any] = {level: plan.config(level) for level in (*levels, train_level)}
    counts = {level: plan.count(kind, level, entry) for level in levels}
    excluded = {"label", "throws", "seeds", "levels", "train_level"}
    # Dependencies of an entry's figures beside code and levels: shipped settings and files, and trained policies.
    level_configs = list(configs.values())
    names = [value for _, value in kind.artefact_settings(entry.controller, level_configs, entry.options)]
    parts = [kind.dependencies(name, level_configs, entry.options, throws) for name in (entry.controller, *names)]
    learned = [_digest(name) for name in (entry.controller, *names) if is_learned(name)]
    inputs = {
        "entry": entry.model_dump(mode="json", exclude=excluded),
        "throws": throws,
        "seed": seed,
        "levels": [configs[level].model_dump(mode="json") for level in levels],
        "train_level": configs[train_level].model_dump(mode="json"),
        "settings": settings_of(entry, plan.env) if entry.controller in TRAINED else {},
        "plan": plan.model_dump(mode="json", include={"env", "seed", "num_envs"}),
        "counts": list(counts.values()),
        "code": code,
        "own": [parcel.digest(module) for module in map(module_of, (entry.controller, plan.env)) if module is not None],
        "depends": [*parts, kind.dependencies(entry.over, level_configs, {}, (0,)), *learned],
    }
    # The configs of the user's own levels, which can be sent to another machine instead of their names.
    user_configs = {
        level: config
        for level, config in configs.items()
        if isinstance(config, LevelConfig) and (level in plan.inline or level not in config.level_names())
    }
    efforts = (kind.effort(entry.controller, configs[level], counts[level], plan.num_envs) for level in levels)
    cost = max(throws) + len(throws) * len(entries.labels(entry)) * sum(efforts)
    return Piece(plan, entry, throws, seed, levels, train_level, user_configs, key(**inputs), copy, cost)


def results_code() -> str:
    """Digest of the code on which results depend."""
    return code_digest(CODE, ["agents.benchmark.run"])


def _digest(name: str) -> str:
    """Digest of a trained policy: of its file, or of the policy in a run folder."""
    place = shipped.place(name)
    return hashlib.sha256(bytes_of(place / POLICY if place.is_dir() else place, MOST_NUMBERS)).hexdigest()


def _check_level(plan: Plan, level: str) -> None:
    """Make sure, before hours of work, that the entries of a level can be made and that the number of units is fair.

    Raises:
        UsageError: an entry cannot be made, or the number of units is not fair.
    """
    entries = [entry for entry in plan.entries if level in (entry.levels or plan.levels)]
    for mode in dict.fromkeys(entry.action_mode for entry in entries):
        with closing(open_trial(plan.env, plan.level(level), 1, 1, mode)) as trial:
            trial.check_count(plan.count(type(trial), level), plan.num_envs, level)
            for entry in entries:
                if entry.action_mode == mode:
                    _check_entry(plan, entry, trial)


def _check_entry(plan: Plan, entry: Entry, trial: Trial) -> None:
    """Make sure that the controllers of an entry can act, or its algorithm learn, in a trial."""
    with about(f"entry {entry.label!r}"):
        if entry.controller in TRAINED:
            trial.check_training({**entry.model_dump(), "algo": entry.controller, "env": plan.env})
            check_libraries("torch", "stable_baselines3", "sb3_contrib")
            return
        if any(entry.throws):
            check_libraries(*LEARNED_BY.get(entry.controller, ()))
        for name in (entry.controller, *entry.also):
            entry_controller(trial, entry, name)


def entry_controller(trial: Trial, entry: Entry, name: str) -> Controller:
    """A controller of an entry by name; the entry's options apply only to the entry's own controller.

    Raises:
        UsageError: there is no such controller, or the controller has no such settings.
    """
    return trials.controller(trial, name, entry.options if name == entry.controller else {})


@cache
def _config(env_id: str, level: str) -> Any:
    """Config of a level from the level's JSON text; cached."""
    return config_of(env_id, json.loads(level))


def needs(plan: Plan) -> Needs:
    """Requirements of the plan's work on another machine.

    Raises:
        UsageError: the work reads a file that lies on this machine alone.
    """
    kind = trial_of_plan(plan)
    for entry, _ in entries_by_level(plan):
        configs = {
            level: plan.config(level)
            for level in {*(entry.levels or plan.levels), entry.train_level or plan.train_level}
        }
        for level, config in configs.items():
            if not isinstance(config, LevelConfig) and os.path.exists(level):
                raise UsageError(f"level {level!r} is a file, which {plan.env!r} would have to read on another machine")
        files = kind.artefact_settings(entry.controller, list(configs.values()), entry.options)
        learned = [("controller", entry.controller), *files]
        for name, value in (*learned, ("config", entry.config), *entry.options.items()):
            if _is_local_file(name, value):
                raise UsageError(f"entry {entry.label!r}: {name} {value!r} is a file, which lies on this machine alone")
    controllers = [entry.controller for entry in plan.entries]
    modules = sorted({module for module in map(module_of, (plan.env, *controllers)) if module is not None})
    # Torch's arithmetic counts where torch fits a network; what a module of the user's computes with is not known.
    fitted = [entry for entry in plan.entries if entry.controller in FITTED]
    return Needs(tuple(modules), torch=any(max(entry.throws) > 0 or entry.online for entry in fitted))


def _is_local_file(name: str, value: Any) -> bool:
    """Whether an entry's setting names a file that other machines lack; they have what ships."""
    if name in ("controller", "guide"):
        return is_learned(str(value)) and not is_shipped(str(value))
    ships = name == "config" and at(str(value)).resolve().is_relative_to(SHIPPED / "configs")
    return isinstance(value, str) and os.path.isfile(value) and not ships
