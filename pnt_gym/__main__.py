"""The command `pnt-gym`, or `python -m pnt_gym`."""

from __future__ import annotations

from pnt_gym.commands import command_module


def main() -> None:
    """Run the command that the command line names."""
    command_module("ground.console").main()


if __name__ == "__main__":
    main()
