"""Kill train, benchmark, reproduce and report at every change of a file and at random moments: is anything lost?

`python benchmarks/kill.py` kills each command before every single change of its folder, then as soon as a file grows
beyond random sizes, then at random moments, and gives the command again after each kill. The command must then end
without an error and leave the same files, to the last bit, as an undisturbed command. The exit code is 1 if a kill
loses anything. `--every 9` is a sample.
"""

from __future__ import annotations

import importlib
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.checks import check_parser, show
from benchmarks.kill_trials.commands import REAL, TOY, benchmark, report, reproduce, small_reproduction, train
from benchmarks.kill_trials.trials import Command, Kill, Trials, start_process

IMPORTED = (
    "agents.benchmark.__main__",
    "agents.learning.progress",
    "agents.report.__main__",
    "agents.learning.sb3",
    "agents.train",
    "matplotlib.backends.backend_svg",
    "torch._dynamo",
    "typeguard",
)
"""What takes the commands seconds to import, and a fork of this process has imported already."""


def commands(folder: Path, env: str) -> Iterator[Command]:
    """What is killed."""
    yield train(env)
    yield report(small_reproduction(folder))
    yield reproduce("length", "example")
    yield benchmark(env, 1)
    yield benchmark(env, 2)


def trial(command: Command, folder: Path, every: int, chances: int) -> Trials:
    """All kills of one command."""
    trials = Trials(command, folder)
    operations = sum(1 for _ in report_losses(trials, trials.every_operation(every)))
    random = np.random.default_rng(0)
    kills = [Kill(size=int(size)) for size in random.integers(1, trials.largest, chances)]
    kills += [Kill(moment=float(moment)) for moment in random.uniform(0.01, trials.seconds, chances)]
    chance = sum(1 for _ in report_losses(trials, (kill for kill in kills if trials.kill_once(kill))))
    print(f"\r{command.name}: {operations} kills at changes, {chance} at random, {len(trials.lost)} lost", flush=True)
    return trials


def as_users_do(command: Command, folder: Path, count: int) -> Trials:
    """Kills of the command as a user starts it, at random moments."""
    trials = Trials(command, folder, start_process)
    moments = np.random.default_rng(1).uniform(0.2, 1.0, count) * trials.seconds
    count = sum(
        1 for _ in report_losses(trials, (k for k in (Kill(moment=float(m)) for m in moments) if trials.kill_once(k)))
    )
    print(f"\r{command.name}: {count} kills of new processes, {len(trials.lost)} lost", flush=True)
    return trials


def report_losses(trials: Trials, kills: Iterator[Kill]) -> Iterator[Kill]:
    """Carry out kills; each prints a sign of life and its losses."""
    lost = 0
    for kill in kills:
        show(f"{trials.command.name}: {trials.kills} kills")
        for loss in trials.lost[lost:]:
            print(f"\nLOST {loss}", flush=True)
        lost = len(trials.lost)
        yield kill


def main() -> int:
    """Kill everything; exit code 1 if something was lost."""
    parser = check_parser(__doc__)
    parser.add_argument("--every", type=int, default=1, metavar="N", help="kill at every N-th change of a file alone")
    parser.add_argument("--chances", type=int, default=15, metavar="N", help="kills at random sizes, and at moments")
    parser.add_argument("--processes", type=int, default=2, metavar="N", help="kills of new processes, at moments")
    parser.add_argument(
        "--only", nargs="*", default=[""], metavar="WORD", help="commands with such a word in their name"
    )
    parser.add_argument("--toy", action="store_true", help="a toy cell without physics; kills no new process")
    arguments = parser.parse_args()
    for name in (*IMPORTED, *(["papers.choe"] if "" in arguments.only else [])):
        importlib.import_module(name)
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        chosen = [
            c for c in commands(folder, TOY if arguments.toy else REAL) if any(w in c.name for w in arguments.only)
        ]
        if not chosen:
            parser.error(f"--only is {' '.join(arguments.only)!r}; it must hold a word of a command's name")
        results = [trial(command, folder, arguments.every, arguments.chances) for command in chosen]
        if not arguments.toy and arguments.processes:
            results += [as_users_do(command, folder, arguments.processes) for command in chosen]
    kills, lost = sum(trials.kills for trials in results), sum(len(trials.lost) for trials in results)
    print(f"{lost} lost of {kills} kills ({time.monotonic() - began:.0f} s)")
    return int(lost > 0 or kills == 0)


if __name__ == "__main__":
    sys.exit(main())
