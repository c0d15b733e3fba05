"""What is learned along a line from reward alone: every level, several seeds, on the shifts of `study_line.py`.

PPO is trained by `agents.train` with the hyperparameters that ship, and `index` is found by evolution as `agents.tune`
does it. All are then worked on the same held-out shifts as the rules and planners, so they pair, and figures
are added to those of `study_line.py`. Runs and figures that are there already are not made again, and an interrupted
training goes on.

Run: python benchmarks/study_line_learning.py --json results/line.json      (four hours; --algo index three more)
"""

from __future__ import annotations

import argparse
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from agents import runs, train
from agents.controllers.protocol import Controller
from agents.environments import make_vector, stream_seed
from agents.files import read_json, write_json
from agents.line.evaluation import worked
from agents.line.making import line_controller, the_line
from agents.line.scored import run_scores
from agents.line.searching import searched
from agents.line.tuned import settings
from agents.line.tuning import Bench, best
from agents.runs import CHOOSING
from agents.versions import versions
from benchmarks.study_line import ENV, LEVELS, ROWS, say, told
from pnt_gym.cells.line.config import LineConfig

ALGO: Final = "residual_ppo"
INDEX: Final = "index"
SEEDS: Final = 5
RUNS: Final = Path("runs") / "line"
SHIFTS: Final = 64
"""By which the search for an index compares its end with its beginning."""
GENERATIONS: Final = 40


def trained(level: str, algo: str, seed: int, place: Path) -> tuple[Controller, dict[str, Any]]:
    """What a run has learned, and what it took; it is trained, or trained on, where it is not complete."""
    folder = place / f"{level}-{algo}-seed{seed}"
    if not folder.is_dir():
        train.main(train.Arguments(env=ENV, level=level, algo=algo, seed=seed, out=folder, threads=1, eval_picks=0))
    elif runs.load_model(folder).num_timesteps < runs.read_arguments(folder)["steps"]:
        train.main(train.Arguments(resume=folder, threads=1, eval_picks=0))
    last = (folder / "progress.csv").read_text().splitlines()[-1].split(",")
    return run_scores(folder), {"decisions": int(last[0]), "seconds": float(last[1])}


def found(level: str, seed: int) -> tuple[Controller, dict[str, Any]]:
    """An index that evolution has found, and its settings."""
    first = stream_seed("practice", seed)
    bench = Bench(LineConfig.load(level, throws="table"), np.arange(first, first + SHIFTS))
    end = best(searched(bench, settings(level, "atc")["patience"], GENERATIONS, seed)).settings
    with closing(make_vector(ENV, level, 1, 1)) as env:
        return line_controller(INDEX, the_line(env), **end), {"settings": end, "generations": GENERATIONS}


def judged(level: str, controller: Controller, shifts: int, seed: int) -> dict[str, Any]:
    """Figures of what was learned, on the held-out shifts of a seed."""
    with closing(make_vector(ENV, level, ROWS, 1)) as env:
        return told(worked(controller, env, shifts, stream_seed("evaluate", seed)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, required=True, help="file of study_line.py, which figures are added to")
    parser.add_argument("--seeds", type=int, default=SEEDS, help="runs for each level")
    parser.add_argument("--runs", type=Path, default=RUNS, help="where run folders are")
    parser.add_argument("--level", action="append", choices=LEVELS, help="only this level; may be given more than once")
    parser.add_argument("--algo", choices=(*CHOOSING, INDEX), default=ALGO)
    options = parser.parse_args()
    result: dict[str, Any] = read_json(options.json)
    for level in options.level or LEVELS:
        each = result.setdefault("learned", {}).setdefault(level, {}).setdefault(options.algo, {})
        for number in (number for number in range(options.seeds) if str(number) not in each):
            of_index = options.algo == INDEX
            learned, how = found(level, number) if of_index else trained(level, options.algo, number, options.runs)
            each[str(number)] = {**how, **judged(level, learned, result["shifts"], result["seed"])}
            say(level, f"{options.algo} {number}", each[str(number)])
            write_json(options.json, {**result, "versions": versions()})


if __name__ == "__main__":
    main()
