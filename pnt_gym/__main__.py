"""The command `pnt-gym`, or `python -m pnt_gym`: the commands ship inside the package, a checkout has them beside."""

from __future__ import annotations

import importlib
import importlib.util


def main() -> None:
    """Hand over to the commands."""
    inside = importlib.util.find_spec("pnt_gym.agents") is not None
    importlib.import_module("pnt_gym.agents.console" if inside else "agents.console").main()


if __name__ == "__main__":
    main()
