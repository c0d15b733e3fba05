"""What learning from flights costs and saves: three ways to learn, each judged in the full physics.

`full` learns in the full physics, `flight` from flights alone, `flight then full` from flights and, for the last fifth
of its throws, in full. SAC is judged on its way; the MLP learns anew for each number of throws. Seconds are processor
time of learning alone, with 16 cells on one core, so that what else the machine does is not in them.

Run: python benchmarks/study_training.py --json results/training.json      (an hour; resumes)
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, Final, NamedTuple

import torch

from agents.controllers import make_controller
from agents.controllers.between import PLANNER
from agents.controllers.own import run_policy
from agents.controllers.protocol import Controller
from agents.ground.amounts import NUM_ENVS
from agents.ground.environments import Env, core_of, make_vector
from agents.ground.files import read_json, write_json
from agents.judging.loop import held_out, practise
from agents.judging.throws.data import summary
from agents.learning.hyperparameters import hyperparameters
from agents.learning.progress import Stop
from agents.learning.runs import RunFolder
from agents.learning.sb3 import build
from agents.learning.vec_env import SameStepVecEnv
from agents.training.course import learn
from benchmarks.checks import check_parser

ENV: Final = "PnTRelease-v0"
LEVEL: Final = "waste"
WAYS: Final = {"full": 0.0, "flight": 1.0, "flight then full": 0.8}
"""Share of the throws that are flights."""
MOST: Final = 10_000
"""Throws to learn from; flights alone go on to twice as many, in less time than the full physics takes for these."""
TABLED: Final = (2000, MOST)
SAC_MARKS: Final = tuple(range(2000, 2 * MOST + 1, 2000))
MLP_MARKS: Final = (500, 2000, MOST, 2 * MOST)


class Cells(NamedTuple):
    """The same cells twice."""

    full: Env
    flight: Env


def judged(controller: Controller, cells: Cells, picks: int) -> dict[str, float]:
    """What a controller is worth in the full physics; lengths in m."""
    found = summary(held_out(controller, cells.full, picks, 0))
    return {name: float(found[name]) for name in ("landing_error_mean_m", "success_rate", "sorted_per_min")}


def sac(cells: Cells, share: float, seed: int, most: int, picks: int) -> Iterator[dict[str, float]]:
    """Trainings, judged on their way; one that changes its physics is judged when it is over."""
    if share in (0.0, 1.0):
        yield from _training(cells, share, seed, [mark for mark in SAC_MARKS if mark <= most], picks)
        return
    for total in (mark for mark in TABLED if mark <= most):
        yield list(_training(cells, share, seed, [round(share * total), total], picks))[-1]


def _training(cells: Cells, share: float, seed: int, marks: list[int], picks: int) -> Iterator[dict[str, float]]:
    """One training, judged at each mark."""
    env, seconds = SameStepVecEnv(cells.full), 0.0
    asked = {"env": ENV, "level": LEVEL, "algo": "sac", "seed": seed, "num_envs": NUM_ENVS, "steps": marks[-1]}
    asked |= {"checkpoint_every": 2 * MOST, "action_mode": core_of(cells.full).action_mode, "stack": 1, "over": PLANNER}
    with tempfile.TemporaryDirectory() as place:
        folder, settings = Path(place) / "run", hyperparameters("sac", ENV)
        model = build("sac", env, settings, seed)
        RunFolder.create(folder, asked, settings, core_of(cells.full).config, model)
        for mark in marks:
            quick = cells.flight if mark <= share * marks[-1] else None
            began = time.process_time()
            learn(model, env, folder, {**asked, "steps": mark}, Stop(), quick=quick, quiet=True)
            seconds += time.process_time() - began
            actor = RunFolder(folder).load_actor(RunFolder(folder).checkpoints[-1])
            policy = run_policy(actor, asked, cells.full, "sac")
            yield {"throws": mark, "seconds": seconds, **judged(policy, cells, picks)}


def mlp(cells: Cells, share: float, seed: int, most: int, picks: int) -> Iterator[dict[str, float]]:
    """Regressions, each from throws of its own."""
    for mark in MLP_MARKS:
        if mark > most:
            return
        controller = make_controller("mlp", cells.full)
        controller.reset(seed)
        flights = round(share * mark)
        began = time.process_time()
        practise(controller, cells.flight, flights, seed)
        practise(controller, cells.full, mark - flights, seed, start=flights)
        seconds = time.process_time() - began
        yield {"throws": mark, "seconds": seconds, **judged(controller, cells, picks)}


LEARNERS: Final = {"sac": sac, "mlp": mlp}


def started(file: Path, head: dict[str, Any]) -> dict[str, Any]:
    """What an earlier run with the same settings has found."""
    if file.is_file():
        before = read_json(file)
        if {name: before.get(name) for name in head} == head:
            return before["training"]
    return {learner: {way: [] for way in WAYS} for learner in LEARNERS}


def main() -> None:
    parser = check_parser(__doc__)
    parser.add_argument("--picks", type=int, default=1000, help="held-out throws by which a policy is judged")
    parser.add_argument("--most", type=int, default=MOST, help="throws to learn from")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1])
    parser.add_argument("--json", type=Path, required=True, help="file of the figures; what is in it is not done again")
    options = parser.parse_args()
    if options.picks < 1 or options.most < TABLED[0]:
        parser.error(f"--picks must be at least 1 and --most at least {TABLED[0]}")
    torch.set_num_threads(1)
    head = {"level": LEVEL, "picks": options.picks, "most": options.most}
    found = started(options.json, head)
    flying = {"base": LEVEL, "fidelity": "flight"}
    with (
        closing(make_vector(ENV, LEVEL, NUM_ENVS, 1)) as full,
        closing(make_vector(ENV, flying, NUM_ENVS, 1)) as flight,
    ):
        cells = Cells(full, flight)
        for seed in options.seeds:
            for learner, study in LEARNERS.items():
                for way, share in WAYS.items():
                    if any(row["seed"] == seed for row in found[learner][way]):
                        continue
                    rows = study(cells, share, seed, options.most * (2 if share == 1.0 else 1), options.picks)
                    found[learner][way] += [{"seed": seed, **row} for row in rows]
                    print(f"seed {seed} {learner} {way:<17}{found[learner][way][-1]}")
                    sys.stdout.flush()
                    write_json(options.json, {**head, "training": found})


if __name__ == "__main__":
    main()
