"""Calling the command lines as a user does: in a process and a folder of their own, or without the process."""

import contextlib
import io
import json
import os
import re
import runpy
import shlex
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any
from unittest import mock

from agents.ground.places import SHIPPED as ROOT


def environment() -> dict[str, str]:
    return {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT), "COLUMNS": "200"}


def run_python(*words: str | Path, check: bool = False, **given: Any) -> subprocess.CompletedProcess[str]:
    """What a Python of its own does, unless something else is given: `run_python("-c", code, cwd=folder)`."""
    usual = {"env": environment(), "capture_output": True, "text": True, "timeout": 300}
    return subprocess.run([sys.executable, *words], check=check, **{**usual, **given})


INTERRUPTIBLE = (
    "import runpy, signal\n"
    "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a shell's background jobs inherit deaf ears
    "runpy.run_module('agents.play', run_name='__main__', alter_sys=True)\n"
)
"""`agents.play` as code that Ctrl-C reaches."""


def complaints(stderr: str) -> str:
    """What a command says on stderr without the lines that tell now and then how far it is: here, a slow machine."""
    return re.sub(r"^.* \d+/\d+ .*\d:\d\d:\d\d +(\d:\d\d:\d\d|-:--:--) *\n", "", stderr, flags=re.MULTILINE)


def call(module: str, *arguments: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    done = run_python("-m", *module.split(), *map(str, arguments), cwd=folder, timeout=120)
    done.stderr = complaints(done.stderr)
    return done


def call_here(module: str, *arguments: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """The same command line run as `__main__` in this process, which has imported already what takes seconds to."""
    command = [*module.split(), *map(str, arguments)]
    said, complained, code = io.StringIO(), io.StringIO(), 0
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(complained),
        mock.patch.object(sys, "argv", command),
        mock.patch.dict(os.environ, {"COLUMNS": "200"}),
        warnings.catch_warnings(),
    ):
        warnings.filterwarnings("ignore", message=".*found in sys.modules", category=RuntimeWarning)
        try:
            runpy.run_module(command[0], run_name="__main__", alter_sys=True)
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
    return subprocess.CompletedProcess(command, code, said.getvalue(), complaints(complained.getvalue()))


def answer(done: subprocess.CompletedProcess[str], path: Path) -> dict[str, Any]:
    """What a command that went well wrote to a JSON file."""
    assert done.returncode == 0, done.stderr
    return json.loads(path.read_text())


def output_of(line: str, folder: Path) -> str:
    """What a command prints that goes well in this process: `evaluate --controller analytic`."""
    command, *words = shlex.split(line)
    done = call_here(f"agents.{command}", *words, folder=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


def figures_of(line: str, folder: Path) -> dict[str, Any]:
    """What such a command writes with `--json`."""
    output_of(f"{line} --json figures.json", folder)
    return json.loads((folder / "figures.json").read_text())


def answered(module: str, *arguments: str | Path) -> tuple[int, str]:
    """Exit code and last words of a command in this process."""
    done = call_here(module, *arguments, folder=Path.cwd())
    return done.returncode, done.stderr


def refused(module: str, *arguments: str | Path) -> str:
    """The words with which a command refuses to do something: one sentence, or a head and a line for each problem."""
    code, words = answered(module, *arguments)
    assert code == 2, words
    head, *problems = words.splitlines()
    assert head.startswith("error: "), words
    assert all(problem.startswith("- ") for problem in problems), words
    assert max(map(len, words.splitlines())) < 700, words
    return words
