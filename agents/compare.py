"""Compare controllers until it is clear which one is better: `python -m agents.compare analytic mlp`."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import tyro

from .ground.cli import NUM_ENVS, at_least, option, run
from .ground.outputs import check_drawing, check_ending, check_writable, deliver_json, deliver_text
from .ground.tables import Grid, console, throws_bar

if TYPE_CHECKING:
    from .judging.comparison import Comparison

FIGURES: Final = (
    "Figures to compare, of which the first decides: landing_error_m, success, sorted_per_min; on a line "
    "value_per_min, sorted_per_min, recovery, value_recovery."
)


@dataclass(frozen=True)
class Arguments:
    """Let controllers throw the same held-out objects, and stop as soon as their difference is settled.

    Means of comparisons that stop when a difference is settled lie farther from zero than the truth, on average.
    """

    controllers: Annotated[
        tuple[str, ...],
        tyro.conf.Positional,
        tyro.conf.arg(metavar="A B [C ...]", help_behavior_hint="(required)"),
    ] = ()
    """Two or more controllers, each as `--controller` of `evaluate` takes it."""
    trust: bool = False
    """Load a stable-baselines3 model or an RL-Zoo folder, whose code then runs; run folders hold no code."""
    env: Annotated[str | None, option("PnTConveyor-v0, or that of the run folder", "ID|MODULE:ID")] = None
    """Environment id; MODULE:ID imports a module of yours first, which registers the id."""
    trial: Annotated[str | None, option("the one that the levels name", "MODULE:CLASS")] = None
    """Judge by another trial: a subclass of `Trial` in a module of yours, whose code then runs."""
    level: Annotated[str | None, option("the environment's own, or that of the run folder", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    figures: Annotated[tuple[str, ...] | None, option("all", "NAME ...", FIGURES)] = None
    margin: Annotated[float | None, option("none", "X")] = None
    """Stop also when the difference is settled to be smaller than this, in the unit of the first figure, such as mm."""
    cap: Annotated[float | None, option("100 mm of landing error", "X")] = None
    """Largest difference of two throws that counts, in the unit of the first figure."""
    budget: Annotated[int | None, option("1000; 160 work shifts of a line", "N")] = None
    """Largest number of throws of each controller."""
    seed: int = 0
    """Seed of the objects; training, practice and evaluation never see these objects, whatever their seed."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write the verdicts, all mean differences and how their intervals narrowed to this file."""
    picture: Annotated[Path | None, option("none", "FILE.svg")] = None
    """Draw how the intervals of the first figure narrowed."""
    num_envs: int = NUM_ENVS
    """Cells simulated side by side; the objects depend on the seed and on this number."""
    threads: int = 2
    """Threads of the simulation; results do not depend on this number."""
    practice: Annotated[int | None, option("120, or 0 for a controller that ships pre-trained", "N")] = None
    """Practice throws of learning controllers before the comparison; other controllers do not practise."""


def main(arguments: Arguments) -> None:
    """Compare the controllers, print the verdict, and write the files asked for; Ctrl-C gives the verdict so far."""
    from .judging.comparison import Comparison, Rules, prepare
    from .judging.trials import open_trial
    from .learning.trained import resolve_shared_task

    at_least(vars(arguments), budget=1, seed=0, num_envs=1, threads=1, practice=0)
    check_writable(arguments.json, arguments.picture)
    check_ending("picture", arguments.picture, (".svg",))
    check_drawing(picture=arguments.picture)
    env_id, level, mode = resolve_shared_task(arguments.controllers, arguments.env, arguments.level)
    rules = Rules(arguments.figures, arguments.margin, arguments.cap, arguments.budget)
    cells = env_id, level, arguments.num_envs, arguments.threads, mode
    with closing(open_trial(*cells, trial=arguments.trial)) as trial:
        rules.measures(trial.record)  # a mistake is reported before the practice
        with throws_bar() as bar:
            controllers, steps = prepare(
                trial, arguments.controllers, arguments.seed, arguments.practice, trust=arguments.trust,
                progress=lambda name, count: partial(bar.advance, bar.add_task(f"practice of {name}", total=count)),
            )  # fmt: skip
        comparison = Comparison(trial, controllers, arguments.seed, rules)
        head = {"env": env_id, "level": trial.core.config.name, "seed": arguments.seed, "practice": steps}
        try:
            _run(comparison)
        finally:  # after Ctrl-C, too: the verdict so far is as valid as any other
            if comparison.count:
                _write(comparison, head, arguments)


def _run(comparison: Comparison) -> None:
    """Run a comparison with a line of progress for each pair."""
    with throws_bar("interval") as bar:
        names = [" and ".join(pair.names) for pair in comparison.pairs]
        tasks = [bar.add_task(name, total=comparison.budget, interval="") for name in names]
        for units in comparison.blocks():
            for task, pair in zip(tasks, comparison.pairs, strict=True):
                bar.update(task, advance=units, interval=comparison.text(pair, next(iter(comparison.measures))))


def _write(comparison: Comparison, head: dict[str, Any], arguments: Arguments) -> None:
    """Print the differences and the verdicts, and write the files asked for."""
    pairs, labels = comparison.pairs, {name: measure.label for name, measure in comparison.measures.items()}
    rows = [(" minus ".join(pair.names), *(comparison.text(pair, name) for name in labels)) for pair in pairs]
    title = f"{head['env']}, level {head['level']}, {comparison.count:,} {comparison.trial.unit} each"
    console().print(Grid(title, ("mean difference (95 % interval)", *labels.values()), rows).terminal())
    for sentence in (*comparison.notes(), *map(comparison.sentence, pairs)):
        console().print(sentence, highlight=False, markup=False, soft_wrap=True)
    report = {**head, **comparison.report()}
    if arguments.picture is not None:
        from .ground.drawings import intervals

        deliver_text(arguments.picture, intervals(report))
    if arguments.json is not None:
        deliver_json(arguments.json, report)


if __name__ == "__main__":
    run(main, Arguments, "agents.compare")
