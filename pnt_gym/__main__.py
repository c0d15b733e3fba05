"""The command `pnt-gym`, or `python -m pnt_gym`."""

from __future__ import annotations

from pnt_gym.commands import command_module


def main() -> None:
    """Do what the command line asks for."""
    command_module("ground.console").main()


if __name__ == "__main__":
    main()
