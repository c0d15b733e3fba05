"""Practice of many simulated shifts of grasps: `python -m agents.training.grasp_shifts --out FILE.npz`."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np

from pnt_gym.cells.grasp.config import GraspConfig

from ..controllers.protocol import State
from ..controllers.remembering import Remembering
from ..controllers.shift_values import ShiftValues
from ..controllers.state import write_state
from ..grasping.foretelling import Foretold, Straight, networks_foretell
from ..ground.cli import at_least, check_libraries, option, run
from ..ground.environments import core_of, make_vector, stream_seed
from ..ground.fitting import on_one_thread
from ..ground.infos import rows_thrown
from ..ground.outputs import check_ending, check_writable
from ..judging.loop import observed

ENV: Final = "PnTGrasp-v0"
ROWS: Final = 64
"""Shifts side by side; a part of what a seed means."""
RULE_TRIES: Final = 8_000
"""Tries of the linear regression."""
TRIES: Final = 16_000
"""Tries in a calibrated cell, from which the gauge is foretold; the same for all seeds of the learning."""
ROUNDS: Final = (0.3, 0.6)
"""Shares of the practice after which the networks are fitted; the last fit is after all of it."""
QUICK_STEPS, STEPS = 400, 1500
"""Gradient steps of a fit in practice, and of the last one."""
KINDS: Final = 1000
"""Seed of the kinds in practice, for seed 0; the level's own seed is far from these."""


@dataclass(frozen=True)
class Arguments:
    """Practise shifts of grasps whose kinds are drawn with seeds of their own, and write the networks."""

    picks: int = 6_400
    """Picks in all shifts together."""
    seed: int = 0
    """Seed of kinds, shifts, choices and fits."""
    memory: bool = True
    """Whether what the shift has shown is among the features; without, the networks learn from the same shifts."""
    rule: bool = False
    """Whether to fit the linear regression of `remembering` alone, without a robot."""
    out: Annotated[Path | None, option("none", "FILE.npz")] = None
    """File of the arrays: the option `file` of shift_values, or of remembering."""


def main(arguments: Arguments) -> None:
    """Practise and save."""
    at_least(vars(arguments), picks=1000, seed=0)
    check_ending("--out", arguments.out, (".npz",))
    check_writable(arguments.out)
    if arguments.rule:
        name, state = Remembering.name, practise_gauge(Foretold(Straight()), RULE_TRIES)
    else:
        check_libraries("torch")
        gauge = practise_gauge(networks_foretell(), TRIES)
        learned = practise_shifts(arguments.seed, arguments.memory, arguments.picks, gauge)
        name, state = learned.name, learned.state()
    if arguments.out is not None:
        write_state(name, state, arguments.out)


@on_one_thread
def practise_gauge(foretold: Foretold, tries: int) -> State:
    """State of what foretells the gauge, from tries at drawn kinds in a calibrated cell."""
    foretold.practise(GraspConfig.load({"base": "grasp_shift", "drawn": {"seed": KINDS}}), tries, 0)
    return foretold.state()


@on_one_thread
def practise_shifts(seed: int, remembers: bool, picks: int, gauge: State) -> ShiftValues:
    """A controller that has practised on shifts with drawn kinds.

    Args:
        seed: seed of kinds, shifts, choices and fits.
        remembers: whether the memory is among the features.
        picks: picks in all shifts together.
        gauge: state of what foretells the gauge, see `practise_gauge`.
    """
    level = {"base": "grasp_shift", "drawn": {"seed": KINDS + seed}}
    with closing(make_vector(ENV, level, ROWS, 1)) as env:
        core: Any = core_of(env)
        controller = ShiftValues(core, file=None)
        controller.begin_shifts(seed, remembers, gauge)
        features, info = env.reset(seed=stream_seed("practice", seed))
        done, due = 0, [round(share * picks) for share in ROUNDS]
        while done < picks:
            features, _, _, _, info = env.step(controller.act(observed(features, info["kind"])))
            rows = np.flatnonzero(rows_thrown(info, ROWS))
            if rows.size == 0:
                continue
            controller.settle(rows, observed(features, info["kind"]), info["sorted"][rows], info["cycle_time"][rows])
            done += len(rows)
            if due and done >= due[0]:
                due = due[1:]
                controller.fit(QUICK_STEPS)
        controller.fit(STEPS)
        controller.end_shifts()
    return controller


if __name__ == "__main__":
    run(main, Arguments, "agents.training.grasp_shifts")
