"""The verdict on a line's plans: which plan is enough, or why none is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig

from ..dispatchers.decisions import make_release
from ..dispatchers.registry import NAMES
from ..ground.cli import UsageError, at_least, check_known, check_once, typed
from ..ground.versions import versions
from . import plans, reasons, sensitivity
from .changes import Change, Gain, gain, possible_changes, try_changes
from .goal import USUAL, Goal
from .plans import Conditions, Planned, Sweep, make_plans
from .reasons import answer, check_text, reason

ANALYTIC: Final = "analytic"
LEAST: Final = {"shifts": 2, "seed": 0, "throws": 100, "check": 0, "threads": 1}
"""Least values of options; the interval of a recovery needs two shifts."""
LEARNED: Final = "shipped:waste-sac"
"""Release with which the analytic one is compared; it holds for the vacuum and the cup of level `waste`."""


@dataclass(frozen=True)
class Verdict:
    """Verdict on plans with one release, compared with another release."""

    plan: Planned
    """The smallest plan that reaches the recovery, or else the best one."""
    release: str
    twin: Planned
    """The same plan with the other release."""
    other_release: str
    checked: dict[str, Any] | None
    """Figures of the plan's first shifts in the full physics; None if no shift was checked."""
    gains: Sequence[Gain]
    """What changes of the plan bring, the best first."""
    swings: Sequence[Gain]
    """What ends of assumed numbers bring, the number that decides most first; none if no number was tried."""
    sentences: tuple[str, ...]
    """The plan, its shifts in the full physics, and the reason why it does not sort more."""

    @property
    def entries(self) -> dict[str, Any]:
        """The verdict by the names of the JSON contract."""
        other = {"release": self.other_release, **self.twin.row}
        points = {gain.words: [gain.points.value, gain.points.low, gain.points.high] for gain in self.gains}
        return {
            "release": self.release,
            "sentences": list(self.sentences),
            "checked": self.checked,
            "changes": {gain.words: gain.recovery for gain in self.gains},
            "gains": points,
            "sensitivity": sensitivity.entries(self.swings),
            "other_release": other,
        }


def judge_again(plan: Planned, conditions: Conditions, release: str | None) -> Planned:
    """A plan judged once more, by chances of the throws that its own controller chooses."""
    config = plan.config.model_copy(update={"chances": None})
    return plans.judge(plan.numbers, config, conditions, release, recount=True)


def recount_chosen(plans: Sequence[Planned], goal: Goal, conditions: Conditions, release: str | None) -> list[Planned]:
    """The plans, of which the chosen one has chances of the throws that its own controller chooses.

    If such chances make another plan the chosen one, that plan is judged again too.
    """
    judged, recounted = list(plans), set[int]()
    while True:
        chosen, _ = reasons.choose(judged, goal)
        index = next(place for place, plan in enumerate(judged) if plan is chosen)
        if index in recounted:
            return judged
        judged[index] = judge_again(chosen, conditions, release)
        recounted.add(index)


@dataclass(frozen=True)
class Judged:
    """Judged plans of a line."""

    level: LineConfig
    conditions: Conditions
    plans: Sequence[Planned]
    verdict: Verdict

    @property
    def entries(self) -> dict[str, Any]:
        """All figures by the names of the JSON contract."""
        head = {"level": self.level.name, "controller": self.conditions.controller, "seed": self.conditions.seed}
        return {**head, "versions": versions(), "plans": [plan.row for plan in self.plans], **self.verdict.entries}


def plan_line(
    level: str | Path = "skills3",
    *,
    recovery: float = USUAL,
    want: str | None = None,
    release: str | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Judge plans of a line; returns what `pnt-gym line plan --json` writes.

    Args:
        level: a shipped level's name or a YAML file.
        recovery: recovery to reach.
        want: instead of it a recovery or a pace to reach, such as 95% or 90/min.
        release: controller that corrects the throws; None for the analytic one.
        options: robots, speeds, percents, skills, minutes, burst, down; controller, shifts, seed, throws, fidelity,
            tables, check, mend, sensitivity
            and threads, as the command takes them.

    Raises:
        PntGymError: the level, a plan or an option is unknown or impossible.
    """
    known = ("level", "recovery", "want", "release", *Sweep.__dataclass_fields__, *Conditions.__dataclass_fields__)
    check_known("argument", options, known)
    return judge(load(level, release), *read(options), Goal.of(recovery, want), release).entries


def read(options: Mapping[str, Any]) -> tuple[Sweep, Conditions]:
    """Plans to judge and their conditions, from options by name; an option that is missing has its default.

    Raises:
        UsageError: an option is impossible.
    """
    at_least(options, **{name: bound for name, bound in LEAST.items() if name in options})
    sweep = typed(Sweep, {name: options[name] for name in Sweep.__dataclass_fields__ if name in options})
    conditions = typed(Conditions, {name: options[name] for name in Conditions.__dataclass_fields__ if name in options})
    check(sweep, conditions)
    return sweep, conditions


def load(level: str | Path, release: str | None) -> LineConfig:
    """The level of a line, with throws by tables; makes sure that the release exists and fits the line."""
    config = LineConfig.load(level, throws="table")
    if release is not None:
        make_release(str(release), config)
    return config


def judge(
    level: LineConfig,
    sweep: Sweep,
    conditions: Conditions,
    goal: Goal,
    release: str | None,
    tell: Callable[[str], object] = lambda text: None,
) -> Judged:
    """Judge every plan of a line, and give the verdict; `tell` is called with the words for each plan."""
    asked, judged = list(make_plans(level, sweep)), list[Planned]()
    for number, (numbers, config) in enumerate(asked, 1):
        text = ", ".join(f"{name} {value}" for name, value in numbers.items())
        tell(f"plan {number} of {len(asked)}: {text}")
        judged.append(plans.judge(numbers, config, conditions, release))
    if conditions.fidelity == "full":
        judged = recount_chosen(judged, goal, conditions, release)
    plan, is_enough = reasons.choose(judged, goal)
    used, other = (ANALYTIC, LEARNED) if release is None else (release, ANALYTIC)
    twin = judge_again(plan, conditions, None if other == ANALYTIC else other)
    checked = plans.check(plan, conditions, release)
    changes = possible_changes(plan.config, reasons.worst_item(plan)) if conditions.mend else []
    gains = [
        *try_changes(plan.config, changes, conditions, release),
        gain(Change("release", other, twin.config), twin, plan),
    ]
    gains.sort(key=lambda each: each.points.value, reverse=True)
    ends = sensitivity.assumptions(plan.config) if conditions.sensitivity else []
    swings = sensitivity.widest_first(try_changes(plan.config, ends, conditions, release)) if ends else []
    sentences = (
        answer(plan, is_enough, goal),
        *([] if checked is None else [check_text(checked)]),
        reason(plan, gains),
    )
    return Judged(level, conditions, judged, Verdict(plan, used, twin, other, checked, gains, swings, sentences))


def check(sweep: Sweep, conditions: Conditions) -> None:
    """Make sure that numbers of robots, a controller and a number of checked shifts are possible.

    Raises:
        UsageError: one of them is not.
    """
    if not (sweep.robots and all(1 <= count <= MOST_ROBOTS for count in sweep.robots)):
        raise UsageError(f"--robots is {sweep.robots}; a line has 1 to {MOST_ROBOTS} robots")
    sweeps = {name: getattr(sweep, name) or () for name in ("robots", "speeds", "percents", "skills")}
    check_once(sweeps)
    check_known("controller of a line", [conditions.controller], NAMES)
    if conditions.check == 1:
        raise UsageError("--check is 1; it must be 0 or at least 2, because one shift has no interval")
