"""Teach a quick policy what a slow planner of a line decides: `pnt-gym line imitate --level value --of beam`."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import tyro

from pnt_gym.cells.line.config import LineConfig

from ..dispatchers.registry import ENV, line_controller, the_line
from ..dispatchers.scored import Scored
from ..dispatchers.settings import settings
from ..ground.cli import at_least, option
from ..ground.environments import make_vector, stream_seed
from ..ground.outputs import check_writable, deliver
from ..ground.places import module_name
from ..ground.tables import console, shifts_comparison, throws_bar
from ..judging.evaluation import NUM_ENVS
from ..judging.work_shifts import SHIFTS, judged

if TYPE_CHECKING:
    from ..lessons.imitation import Labels
    from ..policies.scorer import Scorer

TAUGHT = 1000
"""Seeds of its shifts begin so far after those of tuning."""


@dataclass(frozen=True)
class Arguments:
    """Collect what a planner of a line decides, teach a scorer to choose alike, and compare both with the ATC rule."""

    level: Annotated[str, tyro.conf.arg(metavar="NAME|FILE.yaml")] = "single"
    """A shipped level's name or a YAML file; throws go by its table."""
    of: Literal["beam", "price_beam", "joint_beam", "pair"] = "beam"
    """Whose decisions are learned."""
    shifts: int = 64
    """Shifts in which the planner tells what it would do."""
    rounds: int = 2
    """In the first round the planner works; in each later one what was learned until then does."""
    hidden: tuple[int, ...] = (64, 64)
    """Widths of the scorer's layers."""
    seed: int = 0
    """Names the shifts of the lesson, which no evaluation sees; and the weights."""
    out: Annotated[Path | None, option("runs/OF-LEVEL.npz", "FILE.npz")] = None
    """Where the scorer goes; `evaluate --controller FILE.npz` works with it."""
    eval_shifts: int = SHIFTS
    """Held-out shifts of each controller in the table at the end; 0 for no table."""


def main(arguments: Arguments) -> None:
    """Collect, teach, keep, compare."""
    least = {"shifts": 1, "rounds": 1, "seed": 0, "eval_shifts": 0}
    at_least(vars(arguments) | {"hidden": min(arguments.hidden, default=1)}, **least, hidden=1)
    level = LineConfig.load(arguments.level, throws="table")
    place = arguments.out or Path("runs") / f"{arguments.of}-{level.name}.npz"
    check_writable(place)
    scorer = taught(level, arguments)
    deliver(place, scorer.save)
    console().print(f"the scorer is in {place}; {module_name('agents.evaluate')} --controller {place} works with it")
    if arguments.eval_shifts:
        compare(level, scorer, arguments)


def taught(level: LineConfig, arguments: Arguments) -> Scorer:
    """The scorer after all rounds."""
    from ..lessons.imitation import Labels, fitted  # noqa: PLC0415 - torch takes a second to import

    patience = settings(level.name, "atc")["patience"]
    parts: list[Labels] = []
    shares = np.array_split(np.arange(arguments.shifts), arguments.rounds)
    scorer: Scorer | None = None
    for number, share in enumerate(part for part in shares if part.size > 0):
        parts.append(lesson(level, share, scorer, arguments))
        labels = Labels.joined(parts)
        scorer, alike = fitted(labels, patience, arguments.hidden, arguments.seed)
        console().print(f"round {number + 1}: {len(labels.choice)} decisions, {alike:.1%} of others chosen alike")
    assert scorer is not None
    return scorer


def lesson(level: LineConfig, share: np.ndarray, scorer: Scorer | None, arguments: Arguments) -> Labels:
    """What the planner would do in some of the shifts, worked by itself or by a scorer."""
    from ..lessons.imitation import collected  # noqa: PLC0415 - as above

    first = stream_seed("practice", arguments.seed) + TAUGHT
    with closing(make_vector(ENV, level, len(share), 1)) as env, throws_bar() as bar:
        core = the_line(env)
        expert = line_controller(arguments.of, core)
        worker = expert if scorer is None else Scored(arguments.of, scorer)
        task = bar.add_task(f"shifts of {worker.name if scorer is None else 'the scorer'}", total=len(share))
        return collected(expert, worker, env, first + share, lambda count: bar.advance(task, count))


def compare(level: LineConfig, scorer: Scorer, arguments: Arguments) -> None:
    """The rule, the planner and the scorer on the same held-out shifts, in a table."""
    rows = []
    with closing(make_vector(ENV, level, NUM_ENVS, 1)) as env, throws_bar() as bar:
        core = the_line(env)
        learned = Scored(f"imitation of {arguments.of}", scorer)
        for controller in (line_controller("atc", core), line_controller(arguments.of, core), learned):
            task = bar.add_task(controller.name, total=arguments.eval_shifts)
            found = judged(
                controller,
                env,
                arguments.eval_shifts,
                arguments.seed,
                lambda count, task=task: bar.advance(task, count),
            )
            rows.append((controller.name, 0, found))
    title = f"{arguments.eval_shifts} held-out shifts each, level {level.name}"
    console().print(shifts_comparison(title, rows, "atc"))
