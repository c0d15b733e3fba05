"""Every form of file that a command reads: a sound example that the suite makes, and what reads it.

A file that is read by another function than those here needs one line in `FORMATS`; `python benchmarks/fuzz.py --kind
NAME --cases 2000` then changes one thing in it, 2,000 times. A test reads every example as it is.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable
from functools import cache
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Final, NamedTuple

from agents.dataset import collection
from agents.dispatchers.settings import MADE
from agents.learning import trained
from agents.results import study
from agents.results.plan import pieces, read_plan
from benchmarks.fuzz_cases import examples, readers
from benchmarks.fuzz_cases.examples import CHECKPOINT, CONFIGS, LEARNERS, TOY


class Format(NamedTuple):
    """A form of file."""

    make: Callable[[Path], object]
    """Writes sound files into an empty folder."""
    read: Callable[[Path], object]
    """Reads one of these files as commands do, whatever stands beside it."""
    files: tuple[str, ...]
    """Paths in the folder of the files to change; the ending of each says its form."""
    line: str = ""
    """Command line that reads the changed file, FILE, and ends within seconds; empty for none."""
    verdict: str = ""
    """What the command prints with an exit code that is a verdict, and neither 0 nor 2; empty for none."""


@cache
def example(name: str) -> Path:
    """A folder with the sound files of a form; nobody writes to them."""
    folder = Path(mkdtemp(prefix="example"))
    atexit.register(rmtree, folder, ignore_errors=True)
    FORMATS[name].make(folder)
    return folder


FORMATS: Final[dict[str, Format]] = {
    "log-file": Format(
        examples.make_log, readers.read_whole_log, ("log.csv",),
        "agents.fit FILE --level waste --free valve --out fitted.yaml --page page.html --json figures.json",
        "THE MODEL DOES NOT FIT",
    ),
    "level-file": Format(
        examples.make_levels, readers.read_level, tuple(f"{name}.yaml" for name in CONFIGS), "agents.levels --show FILE"
    ),
    "design-file": Format(
        examples.make_design, readers.read_design, ("line.yaml",),
        "agents.line plan --level FILE --robots 3 --shifts 2 --minutes 0.5 --throws 100 --check 0 --fidelity flight"
        " --no-mend",
    ),
    "study-plan": Format(examples.make_study_plan, lambda path: study.read(path).cases(), ("plan.yaml",)),
    "plan-file": Format(examples.make_plan, lambda path: pieces(read_plan(path)), ("plan.yaml",)),
    "chances-file": Format(
        examples.make_chances, readers.read_chances, ("table.json",),
        "agents.evaluate --env PnTLine-v0 --controller fifo --level line.yaml --shifts 2 --num-envs 2",
    ),
    "rules-file": Format(
        examples.make_rules, readers.read_rules, (str(MADE),),
        "agents.evaluate --env PnTLine-v0 --controller guided_beam --level line.yaml --shifts 2 --num-envs 2",
    ),
    "policy-file": Format(
        examples.make_policies, readers.read_policy, ("policy.npz", "memory.npz", "seeing.npz", "scorer.npz"),
        "agents.evaluate --env PnTLine-v0 --controller FILE --level single --shifts 2 --num-envs 2",
    ),
    "state-file": Format(
        examples.make_states, readers.read_learned, tuple(f"{name}.npz" for name in LEARNERS),
        f"agents.evaluate --env {TOY} --controller ridge --load FILE --picks 4 --num-envs 4",
    ),
    "network-file": Format(examples.make_networks, readers.read_network, ("local_mlp.npz",)),
    "dataset-chunk": Format(examples.make_chunk, lambda path: list(collection.unpack(path)), ("chunk.npz",)),
    "run-folder": Format(
        examples.make_run, readers.read_run, ("args.yml", "env.yaml", "policy.npz"),
        "agents.evaluate --controller . --picks 4 --num-envs 4",
    ),
    "resumed-folder": Format(
        examples.make_run, readers.resume_run,
        ("args.yml", "env.yaml", "config.yml", "progress.csv",
         *(f"{CHECKPOINT}/{name}" for name in ("model.zip", "replay_buffer.npz", "random.json"))),
        "agents.train --resume . --steps 12 --eval-picks 0 --threads 1",
    ),
    "zoo-folder": Format(
        examples.make_zoo, lambda path: trained.find(path.parents[1]), ("MyEnv-v0/args.yml", "MyEnv-v0/config.yml")
    ),
    "settings-file": Format(examples.make_settings, readers.read_settings_of, ("sac.yml", "ppo.yml")),
    "benchmark-file": Format(
        examples.make_benchmark, readers.read_report,
        tuple(f"{trial}/results{end}" for end in ("/rows.npz", ".json") for trial in ("throws", "shifts")),
        "agents.benchmark.verify FILE --rows 1 --throws 2", "figures of the file are those of its throws",
    ),
    "study-file": Format(examples.make_study, readers.read_report, ("results.json",)),
    "reproduction-file": Format(examples.make_reproduction, readers.read_report, ("results.json",)),
}  # fmt: skip
"""Every form by its name: what makes it, what reads it, its files, and a command line that reads one of them."""
