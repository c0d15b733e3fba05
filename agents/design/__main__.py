"""Design a sorting line on a page in a browser: `python -m agents.design skills3`."""

from __future__ import annotations

import gc
import threading
import warnings
from contextlib import ExitStack, closing
from dataclasses import dataclass
from typing import Annotated

import tyro

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.engine import mute_warnings

from ..ground.cli import UsageError, check_libraries, option, run
from ..pictures.door import LOOPBACK, PORTS, open_front

HOST = (
    "Address of this machine at which the page is served, such as 0.0.0.0 for all of them. Everyone who reaches this "
    "address and knows the page's token sees and changes the design; nothing is encrypted."
)


@dataclass(frozen=True)
class Arguments:
    """Design a sorting line on a page in a browser: drag bins and robots, move sliders, and see what the line sorts.

    The page's figures are those of `pnt-gym line plan`. The page writes no file but by the browser's download, and asks
    no other machine for anything. Ctrl-C ends the page.
    """

    level: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="NAME|FILE.yaml")] = "skills3"
    """The line to begin with: a shipped level's name or a YAML file."""
    port: Annotated[int | None, option(f"the first free one from {PORTS[0]} on", "N")] = None
    """Port of the page."""
    host: Annotated[str, tyro.conf.arg(metavar="IP", help=HOST)] = LOOPBACK
    browser: bool = True
    """Open a browser, where there is a display."""


def main(arguments: Arguments) -> None:
    """Serve the page until Ctrl-C."""
    if arguments.port is not None and not 1 <= arguments.port <= 65535:
        raise UsageError(f"--port is {arguments.port}; it must be from 1 to 65535")
    check_libraries("viser")
    line = LineConfig.load(arguments.level, throws="table")
    ports = PORTS if arguments.port is None else range(arguments.port, arguments.port + 1)
    with ExitStack() as ends:
        front = ends.enter_context(open_front(arguments.host, ports, "--host"))
        from .gate import announce, new_token  # noqa: PLC0415 - viser is there now
        from .page import Page  # noqa: PLC0415 - takes a second

        warnings.simplefilter("ignore", UserWarning)  # what is out of reach, the page itself shows
        ends.enter_context(mute_warnings())  # the page refuses an unstable design in a sentence
        token = new_token()
        ends.enter_context(closing(Page(line, front, token)))
        announce(front, token, "design", arguments.browser)
        try:
            threading.Event().wait()
        finally:
            gc.freeze()  # so that Python's end does not look through all objects once more, which takes a second


if __name__ == "__main__":
    run(main, Arguments, "agents.design")
