"""Try levels, actions, calls, command lines and changed files by hypothesis, and look for tracebacks, hangs and NaN.

`python benchmarks/fuzz.py` tries 10,000 cases in bunches of one kind; `--first 10` begins with bunch 10 of each kind,
`--kind log-file` tries one kind alone, and `--bunch level:3` repeats one bunch. A find is shown by the simplest case
that leads to it. The exit code is 1 after a find. A case that crashes its process or hangs is a find, too.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

from agents.ground.files import write_json
from benchmarks.checks import check_parser, show
from benchmarks.fuzz_cases.cases import SHARES, judge_cases

PATIENCE = 60.0
"""A case that takes longer hangs [s]."""
MEMORY = 3 * 2**30
"""A case that wants more addresses on top of what its process has is a find [bytes]."""
MOST = 200
"""Cases of one process."""
Judge = Callable[[str, int, int, Callable[[], object]], str | None]
"""What is wrong with a bunch of cases, as `judge_cases` says it."""


class Bunch(NamedTuple):
    """Cases of one kind, tried in one process."""

    kind: str
    number: int
    count: int


def bunches(kinds: dict[str, float], cases: int, first: int) -> Iterator[Bunch]:
    """Bunches of each kind by its share of the cases, from the number ``first`` on."""
    for kind, share in kinds.items():
        remaining, number = round(cases * share), first
        while remaining > 0:
            yield Bunch(kind, number, min(MOST, remaining))
            remaining, number = remaining - MOST, number + 1


def attempt(bunch: Bunch, channel: Connection, judge: Judge, place: str) -> None:
    """Try a bunch in a process of its own, which leaves its files in a folder.

    The process sends None before each case, and at the end what is wrong, empty for nothing.
    """
    tempfile.tempdir = place
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 2)

    def before() -> None:
        pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
        resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MEMORY, resource.RLIM_INFINITY))
        channel.send(None)

    channel.send(judge(*bunch, before) or "")


def find(bunch: Bunch, judge: Judge = judge_cases) -> str:
    """What is wrong with a bunch, empty for nothing."""
    place = tempfile.mkdtemp()
    context = multiprocessing.get_context("forkserver")
    # What takes seconds to import, before there is any thread.
    context.set_forkserver_preload(["benchmarks.fuzz_cases.cases"])
    receiver, sender = context.Pipe(duplex=False)
    # The process may have processes of its own.
    process = context.Process(target=attempt, args=(bunch, sender, judge, place))
    process.start()
    sender.close()
    answer, count = None, 0
    try:
        while answer is None and receiver.poll(PATIENCE):
            answer = receiver.recv()
            count += answer is None
        answer = f"hangs for more than {PATIENCE:.0f} s in case {count}" if answer is None else answer
    except EOFError:
        process.join()
        answer = f"ends its process with {process.exitcode} in case {count}"
    process.kill()
    process.join()
    shutil.rmtree(place, ignore_errors=True)
    return answer


def main() -> int:
    """Try everything; exit code 1 at a find."""
    parser = check_parser(__doc__)
    parser.add_argument("--cases", type=int, default=10_000, metavar="N", help="number of cases")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first bunch of each kind")
    parser.add_argument("--bunch", metavar="KIND:NUMBER", help="repeat one bunch")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the finds to this file")
    parser.add_argument("--kind", choices=sorted(SHARES), help="try cases of this kind alone")
    arguments = parser.parse_args()
    if arguments.bunch:
        kind, _, number = arguments.bunch.partition(":")
        print(judge_cases(kind, int(number), MOST) or "nothing is wrong")
        return 0
    began, records, count = time.monotonic(), list[dict[str, str]](), 0
    kinds = {arguments.kind: 1.0} if arguments.kind else SHARES
    chosen = list(bunches(kinds, arguments.cases, arguments.first))
    total = sum(bunch.count for bunch in chosen)
    for bunch in chosen:
        if answer := find(bunch):
            line = f"python benchmarks/fuzz.py --bunch {bunch.kind}:{bunch.number}"
            records.append({"line": line, "find": answer})
            print(f"\nFIND {line}\n  {answer[:600]}", flush=True)
        count += bunch.count
        show(f"{count} of {total} cases, {len(records)} finds, {time.monotonic() - began:.0f} s")
    print()
    if arguments.json is not None:
        write_json(arguments.json, records)
    return int(bool(records))


if __name__ == "__main__":
    sys.exit(main())
