"""Sequential comparison of controllers: paired by seed, and valid whenever it stops."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from inspect import signature
from itertools import combinations
from pathlib import Path
from typing import Any, Final, final

import gymnasium as gym

from ..controllers.protocol import Controller
from ..ground.cli import UsageError, at_least, check_known, check_once, typed
from ..ground.environments import Env, stream_seed
from ..ground.metrics import CONFIDENCE, Interval
from ..ground.versions import versions
from . import trials
from .evaluation import env_name, open_cells
from .figures import Figure
from .record import Record
from .sequential import ConfidenceSequence
from .trial import Trial

BUDGET: Final = 5
"""Default budget of a comparison, as a multiple of the number of units of an evaluation."""
EARLY: Final = (
    "Means of comparisons that stop when a difference is settled lie farther from zero than the truth, on average."
)
"""What stopping does to a mean: a difference that chance makes large is settled sooner."""


@final
@dataclass(frozen=True)
class Rules:
    """What is compared, and when a comparison stops."""

    figures: tuple[str, ...] | None = None
    """Names of the figures; the first one decides. None: all figures of the record."""
    margin: float | None = None
    """Difference of the first figure that does not matter, in the figure's unit; None: every difference matters."""
    cap: float | None = None
    """Largest difference of the first figure that counts, in the figure's unit; None: the figure's own."""
    budget: int | None = None
    """Largest number of units of each controller; None: five times the units of an evaluation."""

    def measures(self, record: type[Record]) -> dict[str, Figure]:
        """Figures as they are compared, the first of which has the cap.

        Raises:
            UsageError: there is no such figure, a figure is given twice, or margin, cap or budget has no meaning.
        """
        known = record.measures()
        names = list(known if self.figures is None else self.figures)
        check_known("figure", names, known)
        check_once({"figures": names})
        if not names:
            raise UsageError(f"no figure is given; figures here are {', '.join(known)}")
        at_least({"budget": self.budget}, budget=1)
        measures = {name: known[name] for name in names}
        first = measures[names[0]]
        if self.cap is not None:
            if not 0.0 < self.cap < float("inf"):
                raise UsageError(f"--cap is {self.cap:g}; it must be a number above 0")
            measures[names[0]] = first = replace(first, cap=self.cap / first.scale)
        widest = first.bound * first.scale
        if self.margin is not None and not 0.0 <= self.margin < widest:
            unit = f" {first.unit}".rstrip()
            raise UsageError(f"--margin is {self.margin:g}; it must be from 0 to below the cap of {widest:g}{unit}")
        return measures


@final
@dataclass
class Pair:
    """Two controllers, and the confidence sequence of each figure's difference."""

    names: tuple[str, str]
    sequences: dict[str, ConfidenceSequence]
    settled: int | None = None
    """Number of units of each controller after which the first figure was settled."""
    trace: list[tuple[int, float, float, float]] = field(default_factory=list[tuple[int, float, float, float]])
    """Number of units, mean and interval of the first figure's difference after each block."""

    @property
    def first(self) -> ConfidenceSequence:
        """Confidence sequence of the figure that decides."""
        return next(iter(self.sequences.values()))

    def as_json(self, within_margin: bool) -> dict[str, Any]:
        """All figures as JSON values; `within_margin` says whether the first difference is small."""
        figures = {name: sequence.as_json() for name, sequence in self.sequences.items()}
        head = {"a": self.names[0], "b": self.names[1], "settled": self.settled, "within_margin": within_margin}
        return {**head, "figures": figures, "trace": [list(entry) for entry in self.trace]}


@final
class Comparison:
    """Controllers that carry out the same blocks of held-out units until their order is settled.

    Block k has its own seed, from a stream that no training, practice or evaluation uses. All intervals of all pairs
    and figures hold together, at all times, with a probability of 95 % (Bonferroni over pairs and figures).

    Args:
        trial: trial of the environment.
        controllers: controllers by name, at least two, which have learned already.
        seed: seed of the units.
        rules: what is compared, and when the comparison stops.

    Raises:
        UsageError: a rule has no meaning here.
    """

    def __init__(self, trial: Trial, controllers: Mapping[str, Controller], seed: int, rules: Rules) -> None:
        self.trial, self.rules, self.count, self._seed, self._blocks = trial, rules, 0, seed, 0
        self._controllers = dict(controllers)
        self.measures = rules.measures(trial.record)
        self.budget = BUDGET * trial.count() if rules.budget is None else rules.budget
        self._first = next(iter(self.measures.values()))
        self._margin = None if rules.margin is None else rules.margin / self._first.scale
        pairs = list(combinations(controllers, 2))
        alpha = (1.0 - CONFIDENCE) / (len(pairs) * len(self.measures))
        self.pairs = [
            Pair(names, {figure: ConfidenceSequence(m.bound, alpha) for figure, m in self.measures.items()})
            for names in pairs
        ]

    def blocks(self) -> Iterator[int]:
        """Carry out blocks until the first figure is settled for every pair, or the budget is used up.

        Yields:
            Number of units that each controller carried out in the block.
        """
        while self.count < self.budget and any(pair.settled is None for pair in self.pairs):
            units = self.trial.block(self.budget - self.count)
            seed = stream_seed("compare", self._seed, self._blocks)
            values = {
                name: self.trial.run(controller, units, seed).observations()
                for name, controller in self._controllers.items()
            }
            self.count, self._blocks = self.count + units, self._blocks + 1
            for pair in self.pairs:
                self._update(pair, *(values[name] for name in pair.names))
            yield units

    def sentence(self, pair: Pair) -> str:
        """Verdict about a pair as a sentence."""
        first, measure, (a, b), unit = pair.first, self._first, pair.names, self.trial.unit
        ends = f"{measure.number(first.low)} to {measure.number(first.high)}"
        label = measure.label
        if pair.settled is None:
            value = measure.text(first.value)
            return f"not settled after {self.count:,} {unit}: {label} of {a} minus that of {b} is {value} ({ends})"
        after = f"settled after {pair.settled:,} {unit}"
        if first.excludes_zero:
            text = measure.sentence(pair.names, unit, first.value, first.low, first.high)
            return f"{text}, {after}{', and less than the margin' if self._is_small(pair) else ''}"
        margin = measure.text(self._margin)
        return f"{a} and {b} differ by less than the margin of {margin} in {label} ({ends}), {after}"

    def notes(self) -> list[str]:
        """What to know of the means: which of them lie outside of their intervals and why, and what stopping does."""
        outside = [self._outside(pair, name) for pair in self.pairs for name, s in pair.sequences.items() if s.outside]
        return [*outside, *([EARLY] if any(pair.first.excludes_zero for pair in self.pairs) else [])]

    def text(self, pair: Pair, figure: str) -> str:
        """Mean difference of a pair in a figure, with its interval and unit."""
        sequence, shown = pair.sequences[figure], self.measures[figure]
        return shown.interval(Interval(sequence.value, sequence.low, sequence.high), "+")

    def report(self) -> dict[str, Any]:
        """All figures as JSON values, in SI units."""
        return {
            "unit": self.trial.unit,
            "count": self.count,
            "budget": self.budget,
            "confidence": CONFIDENCE,
            "margin": self._margin,
            "settled": all(pair.settled is not None for pair in self.pairs),
            "figures": {name: _as_json(measure) for name, measure in self.measures.items()},
            "pairs": [pair.as_json(self._is_small(pair)) for pair in self.pairs],
            "sentences": [self.sentence(pair) for pair in self.pairs],
            "notes": self.notes(),
            "versions": versions(),
        }

    def _update(self, pair: Pair, a: Mapping[str, Any], b: Mapping[str, Any]) -> None:
        for name, measure in self.measures.items():
            pair.sequences[name].update(measure.differences(a[name], b[name]), self.count)
        first = pair.first
        if pair.settled is None and (first.excludes_zero or self._is_small(pair)):
            pair.settled = self.count
        if first.count:
            pair.trace.append((self.count, first.value, first.low, first.high))

    def _outside(self, pair: Pair, name: str) -> str:
        """Sentence about a mean that lies outside of its interval: which limit it crosses, from when, and why."""
        sequence, measure, (a, b), unit = pair.sequences[name], self.measures[name], pair.names, self.trial.unit
        above = sequence.value > sequence.high
        limit, date = ("upper", sequence.high_since) if above else ("lower", sequence.low_since)
        side, chance = "above" if above else "below", f"{100 * (1.0 - CONFIDENCE):.0f} %"
        ends = f"{measure.number(sequence.low)} to {measure.number(sequence.high)}"
        return (
            f"The mean of {a} minus {b} in {measure.label}, {measure.text(sequence.value)}, lies outside "
            f"of its interval ({ends}): an interval never widens, its {limit} limit dates from after {date:,} {unit}, "
            f"and later {unit} lie {side} this limit on average; either chance moved the mean, or the interval misses "
            f"the truth (a chance of at most {chance}), or later {unit} differ from earlier ones."
        )

    def _is_small(self, pair: Pair) -> bool:
        return self._margin is not None and pair.first.is_within(self._margin)


def _as_json(figure: Figure) -> dict[str, Any]:
    """Label, unit, factor from SI units to that unit, and cap in SI units, as JSON values."""
    return {"label": figure.label, "unit": figure.unit, "scale": figure.scale, "cap": figure.cap}


def prepare(
    trial: Trial,
    policies: Sequence[Any],
    seed: int,
    practice: int | None = None,
    *,
    trust: bool = False,
    progress: Callable[[str, int], Callable[[int], object] | None] | None = None,
) -> tuple[dict[str, Controller], dict[str, int]]:
    """Controllers by name after their practice, and the number of practice steps of each.

    Args:
        trial: trial of the environment.
        policies: at least two, each as `Trial.controller` takes it.
        seed: seed of the controllers and their practice.
        practice: practice steps of controllers that learn; None for the default of each. Other controllers, and those
            that are given as objects, do not practise.
        trust: run the code in an RL-Zoo folder or a model.zip.
        progress: returns the callback of a practice, which is called with the number of steps just done.

    Raises:
        UsageError: fewer than two controllers, one controller twice, or a controller that learns nothing in practice.
    """
    if len(policies) < 2:
        raise UsageError(f"a comparison needs at least 2 controllers, got {len(policies)}")
    at_least({"practice": practice, "seed": seed}, practice=0, seed=0)
    controllers: dict[str, Controller] = {}
    steps: dict[str, int] = {}
    for policy in policies:
        controller = trial.controller(policy, trust=trust)
        # Name of a controller in sentences: as it is given, of a folder or file its last part.
        name = (Path(policy).name if os.path.exists(policy) else policy) if isinstance(policy, str) else controller.name
        if name in controllers:
            raise UsageError(f"controller {name!r} is given twice; the names of compared controllers must differ")
        learns_now = isinstance(policy, str | type)
        if learns_now:
            controller.reset(seed)
        usual = trial.practice(controller) if learns_now else 0
        steps[name] = usual if practice is None or not usual else practice
        if usual and not steps[name]:
            raise UsageError(f"--practice is 0, but controller {name!r} has learned nothing; it must be at least 1")
        controllers[name] = controller
    for name, count in steps.items():
        if count:
            tell = None if progress is None else progress(name, count)
            controllers[name] = trial.practise(controllers[name], count, seed, progress=tell)
    return controllers, steps


def compare(
    a: Any,
    b: Any,
    env: str | gym.Env[Any, Any] | Env,
    seed: int = 0,
    *,
    others: Sequence[Any] = (),
    practice: int | None = None,
    trust: bool = False,
    progress: Callable[[Any], object] | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Compare two or more policies on the same held-out objects until their order is settled.

    The report holds the sentences of the command, and every figure behind them:

        report = compare("analytic", "mlp", "PnTRelease-v0", level="waste")
        print(*report["sentences"], *report["notes"])

    Policies throw block after block of the same objects. Intervals for the mean differences hold at any time, so it is
    allowed to stop when an interval leaves zero out; see `agents.judging.sequential`.

    Args:
        a: a function of observations, a controller or a model of stable-baselines3, each used as it is; the class of a
            controller, or the name of a controller, which practises first if it learns.
        b: likewise, with another name.
        env: as `evaluate` takes it.
        seed: seed of the objects, which no training, practice or evaluation with any seed sees.
        others: further policies; every pair is compared.
        practice: practice throws of policies that learn; None for the default of each.
        trust: run the code in an RL-Zoo folder or a model.zip that a policy names.
        progress: called after each block.
        options: figures, margin, cap and budget, see `Rules`; level, action_mode, num_envs and threads for an id, see
            `make_vector`.

    Returns:
        `sentences`, `notes` on the means, and for each of `pairs` the difference a - b of each figure in SI units: the
        mean (`value`), `low` and `high`, the number of units after which each limit was set (`low_since`,
        `high_since`), and whether the mean lies `outside` of the interval. Means of comparisons that stop when a
        difference is settled lie farther from zero than the truth, on average.

    Raises:
        UsageError: there is no such policy, environment or figure, or a number has no meaning.
    """
    if isinstance(others, str):
        raise UsageError(f"others is {others!r}; it must be a list of policies, as in [{others!r}]")
    given = {name: options.pop(name) for name in Rules.__dataclass_fields__ if name in options}
    with open_cells(env, options, (*signature(compare).parameters, *Rules.__dataclass_fields__)) as cells:
        trial = trials.of(cells)
        rules = typed(Rules, given)
        rules.measures(trial.record)  # a mistake is reported before the practice
        controllers, steps = prepare(trial, (a, b, *others), seed, practice, trust=trust)
        comparison = Comparison(trial, controllers, seed, rules)
        for _ in comparison.blocks():
            if progress is not None:
                progress(comparison)
        name = env if isinstance(env, str) else env_name(cells)
        return {"env": name, "level": trial.core.config.name, "seed": seed, "practice": steps, **comparison.report()}
