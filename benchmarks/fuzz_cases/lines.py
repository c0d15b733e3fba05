"""Command lines of options that may be right or wrong, tried in this process."""

from __future__ import annotations

import contextlib
import json
import shutil
import traceback
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import Any, Final, Literal, get_args, get_origin

import numpy as np
import yaml

from agents.ground.places import POLICY
from benchmarks.fuzz_cases.basis import Draws, Find
from tests.tools.commands import call_here
from tests.tools.toy_cell import register_toy
from tests.tools.wrong import Option, module_of, options

register_toy()
NUMBERS: Final = ("4", "0", "-1", "1", "x", "1.5", "", "1e3", "nan", "٣", "4 4")
FILES: Final = (
    "good.yaml", "bad.yaml", "text", "folder", "none", "", ".", "x" * 300, "ü ö/ß.json", "policy", "out.json",
    "/proc/none", "../up", "saved.npz", "model.zip", "--", "=", "*",
)  # fmt: skip
NAMES: Final = ("analytic", "ridge", "oracle", "random", "nobody", "os:path", "os:", ":", "é", *FILES)
TOY: Final = ("--env", "ToyThrow-v0")
SMALL: Final = ("--num-envs", "4")
COMMANDS: Final[dict[str, tuple[str, ...]]] = {
    "evaluate": ("--controller", "analytic", *TOY, "--picks", "4", *SMALL),
    "train": (*TOY, "--steps", "4", *SMALL, "--eval-picks", "0", "--config", "sac.yml"),
    "compare": ("analytic", "random", *TOY, "--budget", "4", *SMALL),
    "benchmark": ("--config", "bad.yaml"),
    "verify": ("text",),
    "reproduce": ("hassan", "--only", "nothing"),
    "report": ("--results", "folder"),
    "publish": ("policy", "--env", "x:y"),
    "play": ("--picture", "folder"),
    "fit": ("--design", "4"),
    "line calibrate": ("--throws", "0"),
    "levels": (),
    "controllers": (),
    "dataset": (
        "--throws", "4", "--score-throws", "4", *SMALL, "--expert", "analytic", "--root", "data", "--jobs", "1",
        "--work", "work",
    ),
}  # fmt: skip
"""Commands, and what each is given before the options drawn, so that it ends soon."""
WORDS: Final = {
    "env": ("ToyThrow-v0", "PnTRelease-v0", "CartPole-v1", "", "a:b", "os:ToyThrow-v0", "é"),
    "level": ("waste", "nominal", "nowhere", *FILES),
    "action_mode": ("release_point", "release_xyz", "virtual_goal", "x", ""),
    "name": ("one/two-v0", "one-v1", *FILES),
    "seed": (*NUMBERS, "99999999999999999999"),
    "jobs": ("0", "-1", "x"),
    "cluster": ("", "x", "127.0.0.1:1"),
}
"""Words for options of a name; those of all others follow from the type."""
LEFT_OUT: Final = frozenset({"viewer", "address", "twins"})
"""Options with which a command goes on for minutes, or until somebody ends it."""


@cache
def place() -> Path:
    """A folder with files of every kind."""
    folder = Path(mkdtemp())
    (folder / "folder").mkdir()
    (folder / "text").write_text("text")
    (folder / "good.yaml").write_text("mismatch: 0.5\n")
    (folder / "bad.yaml").write_text("bins: 2020-13-45\n")
    (folder / "model.zip").write_text("text")
    np.savez(folder / "saved.npz", controller=np.array("ridge"))
    small = {"policy_kwargs": {"net_arch": [8]}, "buffer_size": 100, "learning_starts": 4, "batch_size": 4}
    (folder / "sac.yml").write_text(yaml.safe_dump({"default": small}))
    shutil.copytree(POLICY, folder / "policy")
    return folder


def line_case(draws: Draws) -> str:
    """A command with one to three of its options, given words that may be right or wrong."""
    command = draws.pick(COMMANDS)
    chosen = list(COMMANDS[command])
    known = [option for option in options() if option.command == command and option.name not in LEFT_OUT]
    for _ in range(draws.integer(1, 4)):
        option = draws.pick(known)
        if option.word and option.word in chosen:
            at = chosen.index(option.word)
            del chosen[at : at + 2]
        chosen += [option.word] if option.word else []
        chosen += [] if is_switch(option) else [draws.pick(words_for(option))]
    if draws.chance(0.1):
        chosen += ["--picsk", "4"]
    line = json.dumps([command, *chosen], ensure_ascii=False)
    if (complaint := answer(module_of(command), *chosen)) is not None:
        raise Find(f"{line}: {complaint}")
    return line


def is_switch(option: Option) -> bool:
    """Whether an option takes no word."""
    return bool in option.kinds


def words_for(option: Option) -> tuple[str, ...]:
    """Words that an option may be given."""
    choices = [word for kind in option.kinds if get_origin(kind) is Literal for word in get_args(kind)]
    if choices:
        return (*choices, "x", "")
    return WORDS.get(option.name, NUMBERS if {int, float} & {*option.kinds} else NAMES)


def answer(module: str, *arguments: str) -> str | None:
    """What is wrong with the answer to a command line: 0, or 2 with one sentence."""
    with TemporaryDirectory() as name:
        folder = Path(name) / "here"
        shutil.copytree(place(), folder)
        try:
            process: Any = call_here(module, *arguments, folder=folder)
        except BaseException:
            return traceback.format_exc(limit=-3)
        with contextlib.suppress(OSError):
            leftovers = [p.name for p in folder.rglob("*.tmp")]
            if leftovers:
                return f"left {leftovers}"
    return complaint(process)


def complaint(process: Any) -> str | None:
    """What is wrong with how a command ended: it must be with 0, or with 2 and one sentence."""
    words = process.stderr
    if process.returncode == 0 and "Traceback" not in words:
        return None
    if process.returncode != 2 or "Traceback" in words or not words:
        return f"exit code {process.returncode}: {words[-300:]!r}"
    *_, last = (line for line in words.splitlines() if not line.startswith("- "))
    if last.startswith("error: ") and len(last) < 700:
        return None
    return f"no sentence: {words[-300:]!r}"
