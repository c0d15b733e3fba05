"""Command lines of options that may be right or wrong, tried in this process."""

from __future__ import annotations

import contextlib
import json
import shutil
import traceback
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import Any, Final, NamedTuple

import numpy as np
import yaml

from agents.ground.places import POLICY
from tests.tools.commands import call_here
from tests.tools.toy_cell import register_toy

register_toy()
NUMBERS: Final = ("4", "0", "-1", "1", "x", "1.5", "", "1e3", "nan", "٣", "4 4")
SEEDS: Final = (*NUMBERS, "99999999999999999999")
FILES: Final = (
    "good.yaml", "bad.yaml", "text", "folder", "none", "", ".", "x" * 300, "ü ö/ß.json", "policy", "out.json",
    "/proc/none", "../up", "saved.npz", "model.zip", "--", "=", "*",
)  # fmt: skip
TOYS: Final = ("ToyThrow-v0", "ToyThrow-v0", "ToyThrow-v0")
ENVS: Final = (*TOYS, "PnTRelease-v0", "CartPole-v1", "", "a:b", "os:ToyThrow-v0", "é")
LEVELS: Final = ("waste", "nominal", "nowhere", *FILES)
NAMES: Final = ("analytic", "ridge", "oracle", "random", "nobody", "os:path", "os:", ":", *FILES)
MODES: Final = ("release_point", "release_xyz", "virtual_goal", "x", "")
SMALL: Final = ("--picks", "4", "--num-envs", "4")
OPTIONS: Final[dict[str, dict[str, tuple[str, ...]]]] = {
    "agents.evaluate": {
        "--controller": NAMES, "--env": ENVS, "--level": LEVELS, "--picks": NUMBERS, "--seed": SEEDS, "--json": FILES,
        "--num-envs": NUMBERS, "--threads": NUMBERS, "--practice": NUMBERS, "--action-mode": MODES, "--load": FILES,
        "--save": FILES, "--online": ("",), "--trust": ("",), "--picsk": NUMBERS,
    },
    "agents.train": {
        "--env": ENVS, "--level": LEVELS, "--algo": ("sac", "ppo", "dqn", ""), "--steps": NUMBERS, "--seed": SEEDS,
        "--out": FILES, "--resume": FILES, "--num-envs": NUMBERS, "--threads": NUMBERS, "--action-mode": MODES,
        "--checkpoint-every": NUMBERS, "--config": FILES, "--eval-picks": NUMBERS, "--tensorboard": ("",),
    },
    "agents.benchmark": {"--config": FILES, "--jobs": ("0", "-1", "x"), "--out": FILES, "--work": FILES},
    "agents.reproduce": {
        "hassan": ("",), "nobody": ("",), "": ("",), "--json": FILES, "--only": ("nothing", "", "x y"), "--work": FILES,
        "--jobs": ("0", "-1", "x"), "--figures": FILES,
    },
    "agents.report": {"--results": FILES, "--readme": FILES},
    "agents.publish": {"policy": ("",), "folder": ("",), "--to": FILES, "--picks": NUMBERS, "--levels": LEVELS},
    "agents.play": {"--controller": NAMES, "--picture": ("folder", ""), "--video": ("folder", ""), "--slow": NUMBERS},
    "agents.line calibrate": {
        "--level": (*LEVELS, "single", "skills3"), "--throws": ("0", "-1", "99", "x", ""), "--seed": SEEDS,
        "--out": FILES, "--num-envs": NUMBERS, "--threads": NUMBERS,
    },
    "agents.levels": {"": ("",), "waste": ("",), "nowhere": ("",)},
    "agents.dataset": {
        "--controller": ("expert", *NAMES), "--expert": NAMES, "--env": ("PnTRelease-v0", *ENVS), "--level": LEVELS,
        "--throws": NUMBERS, "--seed": SEEDS, "--name": ("one/two-v0", "one-v1", *FILES), "--root": ("data", *FILES),
        "--practice": NUMBERS, "--score-throws": NUMBERS, "--num-envs": NUMBERS, "--jobs": NUMBERS,
        "--action-mode": MODES, "--work": FILES, "--cluster": ("", "x", "127.0.0.1:1"),
        "--author": FILES, "--trust": ("",),
    },
}  # fmt: skip
ALWAYS: Final = {
    "agents.evaluate": ("--controller", "analytic", "--env", "ToyThrow-v0", *SMALL),
    "agents.train": (
        "--env",
        "ToyThrow-v0",
        "--steps",
        "4",
        "--num-envs",
        "4",
        "--eval-picks",
        "0",
        "--config",
        "sac.yml",
    ),
    "agents.benchmark": ("--config", "bad.yaml"),
    "agents.reproduce": ("hassan", "--only", "nothing"),
    "agents.report": ("--results", "folder"),
    "agents.publish": ("policy", "--env", "x:y"),
    "agents.play": ("--picture", "folder"),
    "agents.line calibrate": ("--throws", "0"),
    "agents.dataset": (
        "--throws", "4", "--score-throws", "4", "--num-envs", "4", "--expert", "analytic", "--root", "data",
        "--jobs", "1", "--work", "work",
    ),
}  # fmt: skip
"""What a command is given before the options drawn, so that it ends soon; options that come again go before."""


class LineResult(NamedTuple):
    """A command line, and what is wrong with how it was answered; None if nothing."""

    line: str
    find: str | None


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


def try_line(random: np.random.Generator) -> LineResult:
    """A command line drawn at random, in a copy of the folder of files."""
    module = list(OPTIONS)[int(random.integers(len(OPTIONS)))]
    chosen = list(ALWAYS.get(module, ()))
    for _ in range(int(random.integers(1, 4))):
        name = list(OPTIONS[module])[int(random.integers(len(OPTIONS[module])))]
        value = OPTIONS[module][name][int(random.integers(len(OPTIONS[module][name])))]
        if name in chosen and name.startswith("--"):
            at = chosen.index(name)
            del chosen[at : at + 2]
        chosen += [name, *([value] if name.startswith("--") and OPTIONS[module][name] != ("",) else [])]
    return LineResult(json.dumps([module, *chosen], ensure_ascii=False), answer(module, *chosen))


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
