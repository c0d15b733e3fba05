"""Train a fast policy by imitation of a line's slow planner: `pnt-gym line imitate --level value --of beam`."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import tyro

from pnt_gym.cells.line.config import LineConfig

from ..dispatchers.registry import ENV, line_controller, line_core
from ..dispatchers.scored import ScoreController
from ..dispatchers.settings import settings
from ..ground.amounts import NUM_ENVS
from ..ground.bars import throws_bar
from ..ground.cli import at_least, option
from ..ground.environments import make_vector, stream_seed
from ..ground.outputs import check_writable, deliver
from ..ground.places import module_name
from ..ground.tables import console
from ..judging.evaluation import evaluate_all
from ..judging.trials import open_trial
from ..judging.work_shifts.trial import ShiftTrial

if TYPE_CHECKING:
    from ..dispatchers.imitation import Labels
    from ..policies.scorer import Scorer

TAUGHT = 1000
"""Offset of the seeds of the imitation's shifts from the seeds of tuning."""


@dataclass(frozen=True)
class Arguments:
    """Collect decisions of a line's planner, fit a scorer to them, and compare both with the ATC rule."""

    level: Annotated[str, tyro.conf.arg(metavar="NAME|FILE.yaml")] = "single"
    """A shipped level's name or a YAML file; throws succeed by the level's table of chances."""
    of: Literal["beam", "price_beam", "joint_beam", "pair"] = "beam"
    """The planner whose decisions are learned."""
    shifts: int = 64
    """Shifts in which the planner's decisions are collected."""
    rounds: int = 2
    """Rounds of collecting and fitting: the planner acts in the first round, the fitted scorer in later rounds."""
    hidden: Annotated[tuple[int, ...], tyro.conf.arg(metavar="N ...")] = (64, 64)
    """Widths of the scorer's layers."""
    seed: int = 0
    """Seed of the collected shifts, which no evaluation sees, and of the weights."""
    out: Annotated[Path | None, option("runs/OF-LEVEL.npz", "FILE.npz")] = None
    """File of the scorer, which `evaluate --controller FILE.npz` takes."""
    eval_shifts: int = ShiftTrial.usual
    """Held-out shifts of each controller in the final table; 0 for no table."""


def main(arguments: Arguments) -> None:
    """Collect decisions, fit and save the scorer, and compare it with the planner and the rule."""
    least = {"shifts": 1, "rounds": 1, "seed": 0, "eval_shifts": 0}
    at_least(vars(arguments) | {"hidden": min(arguments.hidden, default=1)}, **least, hidden=1)
    level = LineConfig.load(arguments.level, throws="table")
    place = arguments.out or Path("runs") / f"{arguments.of}-{level.name}.npz"
    check_writable(place)
    scorer = teach(level, arguments)
    deliver(place, scorer.save)
    console().print(f"the scorer is in {place}; {module_name('agents.evaluate')} --controller {place} uses the scorer")
    if arguments.eval_shifts:
        compare_with_rule(level, scorer, arguments)


def teach(level: LineConfig, arguments: Arguments) -> Scorer:
    """The fitted scorer after all rounds."""
    from ..dispatchers.imitation import Labels, fit_scorer  # noqa: PLC0415 - torch takes a second to import

    patience = settings(level.name, "atc")["patience"]
    parts: list[Labels] = []
    shares = np.array_split(np.arange(arguments.shifts), arguments.rounds)
    scorer: Scorer | None = None
    for number, share in enumerate(part for part in shares if part.size > 0):
        parts.append(collect_labels(level, share, scorer, arguments))
        labels = Labels.concatenate(parts)
        scorer, alike = fit_scorer(labels, patience, arguments.hidden, arguments.seed)
        console().print(
            f"round {number + 1}: {len(labels.choice)} decisions; scorer and planner agree on {alike:.1%} of the "
            "held-out decisions"
        )
    assert scorer is not None
    return scorer


def collect_labels(level: LineConfig, share: np.ndarray, scorer: Scorer | None, arguments: Arguments) -> Labels:
    """The planner's decisions in some shifts, in which the planner or a scorer works."""
    from ..dispatchers.imitation import collect_labels  # noqa: PLC0415 - as above

    first = stream_seed("practice", arguments.seed) + TAUGHT
    with closing(make_vector(ENV, level, len(share), 1)) as env, throws_bar() as bar:
        core = line_core(env)
        expert = line_controller(arguments.of, core)
        worker = expert if scorer is None else ScoreController(arguments.of, scorer)
        task = bar.add_task(f"shifts of {worker.name if scorer is None else 'the scorer'}", total=len(share))
        return collect_labels(expert, worker, env, first + share, lambda count: bar.advance(task, count))


def compare_with_rule(level: LineConfig, scorer: Scorer, arguments: Arguments) -> None:
    """Print a table of the rule, the planner and the scorer on the same held-out shifts."""
    with closing(open_trial(ENV, level, NUM_ENVS, 1)) as trial, throws_bar() as bar:
        learned = ScoreController(f"imitation of {arguments.of}", scorer)
        controllers = [trial.controller("atc"), trial.controller(arguments.of), learned]
        count = arguments.eval_shifts
        entries = [(controller.name, controller, 0) for controller in controllers]
        rows = evaluate_all(
            trial, entries, count, arguments.seed,
            progress=lambda label: partial(bar.advance, bar.add_task(label, total=count)),
        )  # fmt: skip
        console().print(trial.record.comparison(f"{count} held-out shifts each, level {level.name}", rows, "atc"))
