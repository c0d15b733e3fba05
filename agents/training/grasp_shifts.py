"""Practice of many simulated shifts of grasps: `python -m agents.training.grasp_shifts --out FILE.npz`."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np

from pnt_gym.arrays import concatenate_records
from pnt_gym.cells.grasp.config import GraspConfig

from ..controllers.protocol import State
from ..controllers.remembering import Remembering
from ..controllers.shift_values import ShiftValues
from ..controllers.state import read, write_state
from ..grasping.attention import TryNetwork, show_tries
from ..grasping.foretelling import Foretold, Straight, networks_foretell
from ..grasping.memory import MakesMemory, NoMemory, ShiftMemory
from ..ground.cli import UsageError, at_least, check_libraries, option, run
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
PICKS: Final = 51_200
ROUNDS: Final = (0.3, 0.6)
"""Shares of the practice after which the networks are fitted; the last fit is after all of it."""
OBJECTS, SEEDS = 6_400, 12
"""Objects of one seed of the kinds whose simulated tries teach the attention, and number of these seeds."""
SHOWN: Final = 3000
"""First of these seeds, far from those of the level and of the practice."""
ATTENTION_STEPS: Final = 20_000
QUICK_STEPS, STEPS = 400, 5000
"""Gradient steps of a fit in practice, and of the last one."""
KINDS: Final = 1000
"""Seed of the kinds in practice, for seed 0; the level's own seed is far from these."""


@dataclass(frozen=True)
class Arguments:
    """Practise shifts of grasps whose kinds are drawn with seeds of their own, and write the networks."""

    picks: int = PICKS
    """Picks in all shifts together."""
    seed: int = 0
    """Seed of kinds, shifts, choices and fits."""
    memory: bool = True
    """Whether what the shift has shown is among the features; without, the networks learn from the same shifts."""
    rule: bool = False
    """Whether to fit the linear regression of `remembering` alone, without a robot."""
    gauge: Annotated[Path | None, option("practise it", "FILE.npz")] = None
    """File of a former practice, of which what foretells the gauge is taken over."""
    out: Annotated[Path | None, option("none", "FILE.npz")] = None
    """File of the arrays: the option `file` of shift_values, or of remembering."""


def main(arguments: Arguments) -> None:
    """Practise and save."""
    at_least(vars(arguments), picks=1000, seed=0)
    check_ending("--out", arguments.out, (".npz",))
    check_writable(arguments.out)
    if arguments.rule and arguments.gauge is not None:
        raise UsageError("--gauge has no effect on the regression that --rule asks for")
    if arguments.rule:
        name, state = Remembering.name, practise_gauge(Foretold(Straight()), RULE_TRIES)
    else:
        check_libraries("torch")
        former = arguments.gauge
        gauge = practise_attention(networks_foretell(), TRIES, SEEDS) if former is None else read_gauge(former)
        memory = ShiftMemory if arguments.memory else NoMemory
        learned = practise_shifts(arguments.seed, memory, arguments.picks, gauge)
        name, state = learned.name, learned.state()
    if arguments.out is not None:
        write_state(name, state, arguments.out)


def read_gauge(file: Path) -> State:
    """States of what foretells the gauge, from the file of a former practice.

    Raises:
        UsageError: the file is missing, damaged, or holds no such states.
    """
    owner, state = read(file)
    if owner != ShiftValues.name or not any(name.startswith("attention ") for name in state):
        raise UsageError(f"{str(file)!r} holds no networks of {ShiftValues.name!r} that foretell the gauge")
    return state


@on_one_thread
def practise_gauge(foretold: Foretold, tries: int) -> State:
    """State of what foretells the gauge, from tries at drawn kinds in a calibrated cell."""
    foretold.practise(GraspConfig.load({"base": "grasp_shift", "drawn": {"seed": KINDS}}), tries, 0)
    return foretold.state()


@on_one_thread
def practise_attention(foretold: Foretold, tries: int, seeds: int) -> State:
    """States of what foretells the gauge, first from the picture alone and then with attention to earlier tries.

    Args:
        foretold: foretells from the picture; it practises first.
        tries: tries of that practice.
        seeds: numbers of the drawn kinds from which the attention learns, each by `OBJECTS` objects.
    """
    gauge, attention = practise_gauge(foretold, tries), TryNetwork()
    levels = [GraspConfig.load({"base": "grasp_shift", "drawn": {"seed": SHOWN + seed}}) for seed in range(seeds)]
    shown = [show_tries(level, foretold, OBJECTS, SHOWN + seed) for seed, level in enumerate(levels)]
    kinds = [one.kind + len(level.items) * k for k, (one, level) in enumerate(zip(shown, levels, strict=True))]
    together = concatenate_records([one._replace(kind=kind) for one, kind in zip(shown, kinds, strict=True)])
    attention.fit(together, 0, ATTENTION_STEPS)
    parts = {"gauge": gauge, "attention": attention.state()}
    return {f"{part} {name}": array for part, own in parts.items() for name, array in own.items()}


@on_one_thread
def practise_shifts(seed: int, memory: MakesMemory, picks: int, gauge: State) -> ShiftValues:
    """A controller that has practised on shifts with drawn kinds.

    Args:
        seed: seed of kinds, shifts, choices and fits.
        memory: makes the memory of the shifts.
        picks: picks in all shifts together.
        gauge: states of what foretells the gauge, see `practise_attention`.
    """
    level = {"base": "grasp_shift", "drawn": {"seed": KINDS + seed}}
    with closing(make_vector(ENV, level, ROWS, 1)) as env:
        core: Any = core_of(env)
        controller = ShiftValues(core, file=None, memory=memory)
        controller.begin_shifts(seed, gauge)
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
