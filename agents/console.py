"""The command `pnt-gym`: one word for each thing to do."""

from __future__ import annotations

import importlib
import sys
from typing import Final

from .cli import BAD_USAGE, run

COMMANDS: Final = {
    "demo": ("demo", "the planner and a trained policy on the same 64 throws, within a minute"),
    "train": ("train", "train a policy that corrects the planner, then compare the two"),
    "evaluate": ("evaluate", "judge a controller on held-out throws, in picks per minute"),
    "play": ("play", "watch a controller throw: video, picture or window"),
    "publish": ("publish", "keep a trained policy with its card, a film of it, and as ONNX"),
    "dataset": ("dataset", "collect throws of a controller as a Minari dataset, for offline learning"),
    "tune": ("tune", "find the settings of rules and planners of a line, on shifts of their own"),
    "imitate": ("imitate", "teach a quick policy what a slow planner of a line decides"),
    "calibrate": ("calibrate", "count what becomes of throws on a line, for levels whose throws go by a table"),
    "plan_line": ("plan_line", "how many robots, how fast a belt: what a line needs to sort what comes"),
    "benchmark": ("benchmark.__main__", "let every controller of a plan learn, and compare them throw by throw"),
    "levels": ("levels", "the levels that ship, and what one says"),
    "doctor": ("doctor", "versions, rendering, and throws for a second: what to send with a bug report"),
}
"""Module and purpose of each."""


def main() -> None:
    """Do what the first word asks for."""
    given = sys.argv[1:2]
    name = given[0] if given else "--help"
    if name in ("-h", "--help"):
        print("usage: pnt-gym COMMAND [OPTIONS]\n\nSorting by throwing.\n")
        print("\n".join(f"  {name:<11}{purpose}" for name, (_, purpose) in COMMANDS.items()))
        print("\n`pnt-gym COMMAND --help` lists the options of a command.")
    elif name not in COMMANDS:
        print(f"error: {name!r} is no command; commands are {', '.join(COMMANDS)}", file=sys.stderr)
        sys.exit(BAD_USAGE)
    else:
        module = importlib.import_module(f".{COMMANDS[name][0]}", __package__)
        run(module.main, module.Arguments, f"pnt-gym {name}", sys.argv[2:])
