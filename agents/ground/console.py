"""The command `pnt-gym`, whose first one or two words name what to do."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from typing import Final

from pnt_gym.names import unknown_name

from .cli import BAD_USAGE, run

COMMANDS: Final = {
    "demo": ("demo", "compare the planner and a trained policy on the same 64 throws, within a minute"),
    "train": ("train", "train a policy that corrects the planner, then compare the two"),
    "evaluate": ("evaluate", "judge a controller on held-out throws, in picks per minute"),
    "compare": ("compare", "settle which of two controllers is better, with as few throws as that takes"),
    "fit": ("fit.__main__", "fit a level to measured throws, with intervals, and choose the next throws"),
    "play": ("play", "watch a controller throw: video, picture or window"),
    "publish": ("publish.__main__", "write a folder with a trained policy, its card, its film and its ONNX file"),
    "dataset": ("dataset.__main__", "collect throws of a controller as a Minari dataset, for offline learning"),
    "benchmark": ("benchmark.__main__", "let every controller of a plan learn, and compare them throw by throw"),
    "verify": ("benchmark.verify", "throw a sample of a benchmark's results again, and compare"),
    "submit": ("benchmark.submit", "measure a controller of yours on the benchmark's throws, in a file to hand in"),
    "levels": ("levels", "list the shipped levels, print one in full, or write a new one to start from"),
    "controllers": ("roster", "list the controllers, and the policies that ship"),
    "doctor": ("doctor", "print versions and rendering, and throw for a second: the text for a bug report"),
    "design": ("design.__main__", "design a line on a page in a browser: drag bins and robots, see what is sorted"),
    "line plan": ("line.plan", "sweep robots and belt speeds: the line that a stream of objects needs"),
    "line tune": ("line.tune", "find the settings of rules and planners of a line"),
    "line calibrate": ("line.calibrate", "count the chances of throws in the full physics, for the table of a line"),
}
"""Module below `agents` and purpose of each command."""


def main() -> None:
    """Run the command that the command line names."""
    choose("pnt-gym ", sys.argv[1:])


def choose(program: str, words: Sequence[str]) -> None:
    """Run the command that the first words name, or list the commands that begin with these words.

    Args:
        program: what the user typed before the first word.
        words: the words and options after `program`.
    """
    room = words[0] if words[:1] == ["line"] else ""
    name = " ".join(words[: 2 if room else 1])
    if name in ("", room, "-h", "--help", f"{room} -h", f"{room} --help"):
        print(f"usage: {program}COMMAND [OPTIONS]\n\nSorting by throwing.\n")
        print("\n".join(f"  {name:<16}{purpose}" for name, (_, purpose) in COMMANDS.items() if name.startswith(room)))
        print(f"\n`{program}COMMAND --help` lists the options of a command.")
    elif name in COMMANDS:
        module = importlib.import_module(f"...{COMMANDS[name][0]}", __name__)
        run(module.main, module.Arguments, f"{program}{name}", words[len(name.split()) :])
    else:
        known = [command for command in COMMANDS if command.startswith(room)]
        print(f"error: {unknown_name('command', name, known)}", file=sys.stderr)
        sys.exit(BAD_USAGE)
