"""Try random levels, actions, calls, command lines and changed files, and look for tracebacks, hangs and NaN.

`python benchmarks/fuzz.py` tries 10,000 cases, each drawn by its number; `--first 4000` begins with case 4000,
`--kind log-file` tries one kind alone, and `--case level:17` repeats one case. The exit code is 1 after a finding. A
case that crashes its process or hangs is a finding, too.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection
from pathlib import Path

from agents.ground.files import write_json
from benchmarks.checks import check_parser, show
from benchmarks.fuzz_cases.cases import SHARES, judge_case

PATIENCE = 60.0
"""A case that takes longer hangs [s]."""
MEMORY = 3 * 2**30
"""A case that wants more on top of what its process has is a find [bytes]."""
BUNCH = 200
"""Cases of one process."""
Judge = Callable[[str, int], str | None]
"""What is wrong with a case, by its kind and number; None for nothing."""


def cases(first: int, count: int) -> Iterator[tuple[str, int]]:
    """Kind and number of each case from the first on, the kinds mixed by their shares."""
    owed = dict.fromkeys(SHARES, 0.0)
    numbers = dict.fromkeys(SHARES, 0)
    for case in range(first + count):
        for kind, share in SHARES.items():
            owed[kind] += share
        kind = max(owed, key=lambda name: owed[name])
        owed[kind] -= 1.0
        if case >= first:
            yield kind, numbers[kind]
        numbers[kind] += 1


def attempt(bunch: Sequence[tuple[str, int]], channel: Connection, judge: Judge, place: str) -> None:
    """Try cases in a process of its own, which leaves its files in a folder.

    The process reports the number of each case before it, and the finding after it.
    """
    tempfile.tempdir = place
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MEMORY, resource.RLIM_INFINITY))
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 2)
    for kind, number in bunch:
        channel.send((kind, number, None))
        channel.send((kind, number, judge(kind, number) or ""))


def finds(bunch: Sequence[tuple[str, int]], judge: Judge = judge_case) -> Iterator[tuple[str, int, str]]:
    """Kind, number and find, empty for none, of every case; a new process goes on after one that ended or hangs."""
    remaining = list(bunch)
    context = multiprocessing.get_context("forkserver")
    # What takes seconds to import, before there is any thread.
    context.set_forkserver_preload(["benchmarks.fuzz_cases.cases"])
    while remaining:
        place = tempfile.mkdtemp()
        receiver, sender = context.Pipe(duplex=False)
        # The process may have processes of its own.
        process = context.Process(target=attempt, args=(remaining, sender, judge, place))
        process.start()
        sender.close()
        while remaining:
            kind, number = remaining[0]
            try:
                answer = receiver.recv()[2] if receiver.poll(PATIENCE) else f"hangs for more than {PATIENCE:.0f} s"
            except EOFError:
                process.join()
                answer = f"ends its process with {process.exitcode}"
            if answer is None:
                continue
            remaining.pop(0)
            yield kind, number, answer
            if answer.startswith(("hangs for", "ends its")):
                process.kill()
                break
        process.join()
        shutil.rmtree(place, ignore_errors=True)


def main() -> int:
    """Try everything; exit code 1 at a find."""
    parser = check_parser(__doc__)
    parser.add_argument("--cases", type=int, default=10_000, metavar="N", help="number of cases")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first case")
    parser.add_argument("--case", metavar="KIND:NUMBER", help="repeat one case")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the findings to this file")
    parser.add_argument("--kind", choices=sorted(SHARES), help="try cases of this kind alone")
    arguments = parser.parse_args()
    if arguments.case:
        kind, _, number = arguments.case.partition(":")
        print(judge_case(kind, int(number)) or "nothing is wrong")
        return 0
    began, records = time.monotonic(), list[dict[str, str]]()
    numbers = range(arguments.first, arguments.first + arguments.cases)
    chosen = [(arguments.kind, n) for n in numbers] if arguments.kind else list(cases(arguments.first, arguments.cases))
    for start in range(0, len(chosen), BUNCH):
        for kind, number, answer in finds(chosen[start : start + BUNCH]):
            if answer:
                line = f"python benchmarks/fuzz.py --case {kind}:{number}"
                records.append({"line": line, "find": answer})
                print(f"\nFIND {line}\n  {answer[:600]}", flush=True)
        count = min(start + BUNCH, len(chosen))
        words = f"{arguments.first + count} of {arguments.first + len(chosen)} cases, {len(records)} finds"
        show(f"{words}, {time.monotonic() - began:.0f} s")
    print()
    if arguments.json is not None:
        write_json(arguments.json, records)
    return int(bool(records))


if __name__ == "__main__":
    sys.exit(main())
