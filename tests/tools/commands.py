"""Calling the command lines as a user does: in a process and a folder of their own."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from unittest.mock import patch

from agents.cli import run
from agents.versions import ROOT


def environment() -> dict[str, str]:
    return {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT), "COLUMNS": "200"}


def call(module: str, *arguments: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", module, *map(str, arguments)]
    return subprocess.run(
        command, cwd=folder, env=environment(), capture_output=True, text=True, timeout=120, check=False
    )


def answered(module: str, *arguments: str | Path) -> tuple[int, str]:
    """Exit code and last words of a command in this process, called as its own would call it."""
    package = find_spec(module)
    assert package is not None
    command = import_module(f"{module}.__main__" if package.submodule_search_locations else module)
    words = io.StringIO()
    with (
        patch.object(sys, "argv", [module, *map(str, arguments)]),
        redirect_stdout(io.StringIO()),
        redirect_stderr(words),
    ):
        try:
            run(command.main, command.Arguments, module)
        except SystemExit as end:
            return int(end.code or 0), words.getvalue()
    return 0, words.getvalue()


def refused(module: str, *arguments: str | Path) -> str:
    """The one sentence with which a command refuses to do something."""
    code, words = answered(module, *arguments)
    assert code == 2, words
    assert words.startswith("error: "), words
    assert words.count("\n") == 1, words
    assert len(words) < 700, words
    return words
