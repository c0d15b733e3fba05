"""Tosses by the gripper robot of Leveziel et al. in the simulator: the planner, an oracle, and learning when to let go.

The paper shows that the robot tosses and measures nothing, so every figure here is ours.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple, final

import numpy as np

from agents.controllers import make_controller
from agents.environments import make_vector
from agents.evaluation import Env, Throws, evaluate, practise, summary
from agents.report.figures import svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.leveziel_toss_drawings import Release, release_figure
from pnt_gym.metrics import wilson

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENV: Final = "GripperToss-v0"
ROWS: Final = 16
"""Cells side by side."""
SEEDS: Final = (0, 1, 2)
"""Of practice and of the held-out objects."""
HELD: Final = 64
"""Held-out throws of each seed."""
LEVELS: Final = ("nominal", "late", "patient", "drop", "belt")
"""`belt` is the up-scaled robot at the conveyor cell's belt."""
STAGES: Final = (10, 100, 1000)
"""Throws of practice after which a learner is judged."""
LEARNERS: Final[Mapping[str, Mapping[str, Sequence[int]]]] = {
    "virtual_goal": {"nominal": STAGES, "late": STAGES[:2], "belt": STAGES[:2]},
    "ridge": {"nominal": STAGES, "late": STAGES[:2], "belt": STAGES[:2]},
    "mlp": {"nominal": STAGES},
}
"""What learns, where, and when it is judged."""
PLANNERS: Final = {
    "analytic": "the planner alone, which opens the claws at one fixed time before the release",
    "oracle": "a controller that simulates each throw with its hidden values beforehand, all but the scatter of the "
    "opening",
}
DRAWN: Final = ("nominal", "virtual_goal", 100)
"""Level, controller and throws of practice whose releases are drawn."""


class Judged(NamedTuple):
    """Held-out throws of one controller at one stage, seed by seed."""

    level: str
    controller: str
    practice: int
    by_seed: list[Throws]


@final
class CycleCount:
    """Counts throws: each is a whole cycle of grip, lift, toss and landing."""

    def __init__(self) -> None:
        self.cycles = 0

    def add(self, throws: int) -> None:
        """Take in a batch."""
        self.cycles += throws


def planner_findings(
    levels: Sequence[str] = LEVELS, seeds: Sequence[int] = SEEDS, held: int = HELD, rows: int = ROWS
) -> Findings:
    """The planner and the oracle, which learn nothing, on every level."""
    counter, found = CycleCount(), list[Row]()
    for level in levels:
        env = make_vector(ENV, level, rows, threads=1)
        try:
            for name, what in PLANNERS.items():
                judged = Judged(level, name, 0, _held_out(name, env, seeds, held, counter))
                found.append(_row(judged, seeds, env, what))
        finally:
            env.close()
    return Findings((*found, _endurance("planner", counter)))


def _held_out(name: str, env: Env, seeds: Sequence[int], held: int, counter: CycleCount) -> list[Throws]:
    controller = make_controller(name, env)
    return [evaluate(controller, env, held, seed, progress=counter.add) for seed in seeds]


def learner_findings(
    name: str,
    stages: Mapping[str, Sequence[int]],
    seeds: Sequence[int] = SEEDS,
    held: int = HELD,
    rows: int = ROWS,
) -> Findings:
    """A learner, judged after some and again after more throws of one practice, and what it did to the release.

    Args:
        name: of the controller.
        stages: for each level, after how many throws it is judged.
        seeds: of practice and of the held-out objects; each begins anew.
        held: held-out throws of each seed and stage.
        rows: cells side by side.
    """
    counter, found, figures = CycleCount(), list[Row](), dict[str, str]()
    for level, counts in stages.items():
        env = make_vector(ENV, level, rows, threads=1)
        try:
            judged = _learned(name, env, level, counts, seeds, held, counter)
            found += [_row(one, seeds, env, f"{name} after {one.practice:,} throws of practice") for one in judged]
            for one in judged:
                if (one.level, one.controller, one.practice) == DRAWN:
                    figures["leveziel_release.svg"] = svg(_drawing(one, env, seeds, held, counter))
        finally:
            env.close()
    return Findings((*found, _endurance(name, counter)), {}, figures)


def _learned(
    name: str, env: Env, level: str, counts: Sequence[int], seeds: Sequence[int], held: int, counter: CycleCount
) -> list[Judged]:
    found = [Judged(level, name, count, []) for count in counts]
    controller = make_controller(name, env)
    for seed in seeds:
        controller.reset(seed)
        done = 0
        for one in found:
            practise(controller, env, one.practice - done, seed, start=done, progress=counter.add)
            done = one.practice
            one.by_seed.append(evaluate(controller, env, held, seed, progress=counter.add))
    return found


def _drawing(learned: Judged, env: Env, seeds: Sequence[int], held: int, counter: CycleCount) -> Figure:
    """Releases and landings before and after practice, on the same held-out objects."""
    before = Throws.concatenate(_held_out("analytic", env, seeds, held, counter))
    after = Throws.concatenate(learned.by_seed)
    panels = {
        "the planner alone": before,
        f"{learned.controller.replace('_', ' ')}, {learned.practice} throws": after,
    }
    drawn = {name: Release(t.item, t.error[:, 2], t.landing_along, t.is_success) for name, t in panels.items()}
    return release_figure(drawn, _core(env).config)


def _core(env: Env) -> Any:
    """The cells behind an environment."""
    core: Any = env.unwrapped.core  # pyright: ignore[reportAttributeAccessIssue]
    return core


def _row(judged: Judged, seeds: Sequence[int], env: Env, what: str) -> Row:
    """Success of one controller, with landing errors and moments of the release among the details."""
    throws, names = Throws.concatenate(judged.by_seed), _core(env).item_names
    figures = summary(throws)
    rate = wilson(int(throws.is_success.sum()), len(throws))
    by_item = {name: throws.item == k for k, name in enumerate(names)}
    delay = {name: throws.error[mine, 2] for name, mine in by_item.items() if mine.any()}
    late = ", ".join(f"{name} {1e3 * times.mean():.1f} +- {1e3 * times.std():.1f} ms" for name, times in delay.items())
    stage = f"{judged.controller}-{judged.practice}" if judged.practice > 0 else judged.controller
    return Row(
        f"leveziel/toss/{judged.level}/{stage}",
        None,
        100.0 * rate.value,
        "%",
        "ours",
        f"of {len(throws)} held-out throws at rest in their compartment, by {what}; level {judged.level}, "
        f"{_seeds(seeds)}, 95 % interval {100.0 * rate.low:.1f} to {100.0 * rate.high:.1f} %. Landing error "
        f"{1e3 * float(figures['landing_error_mean_m']):.1f} mm on average; objects come free against the plan: {late}",
        {
            "level": judged.level,
            "controller": judged.controller,
            "practice": judged.practice,
            "throws": len(throws),
            "success_low": 100.0 * rate.low,
            "success_high": 100.0 * rate.high,
            "success_by_seed": [100.0 * float(t.is_success.mean()) for t in judged.by_seed],
            "success_by_item": {n: 100.0 * float(throws.is_success[m].mean()) for n, m in by_item.items() if m.any()},
            "landing_error_m": figures["landing_error_mean_m"],
            "landing_error_p95_m": figures["landing_error_p95_m"],
            "landing_error_by_seed_m": [float(np.nanmean(t.landing_error)) for t in judged.by_seed],
            "release_delay_s": {name: float(times.mean()) for name, times in delay.items()},
            "release_delay_spread_s": {name: float(times.std()) for name, times in delay.items()},
            "release_delay_error_s": float(np.abs(throws.error[:, 2]).mean()),
            "cycle_time_s": figures["cycle_time_mean_s"],
            "recontact": figures["recontact_rate"],
        },
    )


def _seeds(seeds: Sequence[int]) -> str:
    return f"{'seed' if len(seeds) == 1 else 'seeds'} {', '.join(map(str, seeds))}"


def _endurance(part: str, counter: CycleCount) -> Row:
    return Row(
        f"leveziel/endurance/{part}",
        None,
        float(counter.cycles),
        "-",
        "ours",
        "cycles of grip, lift, toss and landing without a single warning of the physics engine, which would have "
        "stopped the reproduction; counted are the throws of practice and evaluation of this part, not the previews of "
        "the oracle",
        {"warnings": 0},
    )


def _learner_part(name: str, stages: Mapping[str, Sequence[int]]) -> Part:
    run: Callable[[], Findings] = partial(learner_findings, name, stages)
    return Part(f"toss-{name}", run)


PARTS = (Part("toss-planner", planner_findings), *(_learner_part(*learner) for learner in LEARNERS.items()))
