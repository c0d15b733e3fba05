"""Tools of a line of robots: `python -m agents.line plan|tune|calibrate`."""

from __future__ import annotations

import sys

from ..ground.console import choose
from ..ground.places import module_name

if __name__ == "__main__":
    choose(f"python -m {module_name('agents.')}", ["line", *sys.argv[1:]])
