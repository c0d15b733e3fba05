"""What every command line of `agents` does alike: parse, run, and turn a user's mistake into one sentence."""

from __future__ import annotations

import contextlib
import io
import re
import signal
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import tyro

from pnt_gym.errors import PntGymError, one_sentence

from .places import module_name
from .signals import REASONS, Interrupt, handled, interrupt
from .streams import is_printed

Arguments = TypeVar("Arguments")

BAD_USAGE = 2
EXTRAS = {
    "torch": "rl",
    "stable_baselines3": "rl",
    "sb3_contrib": "rl",
    "tensorboard": "rl",
    "cma": "rl",
    "casadi": "optimal",
    "matplotlib": "report",
    "jinja2": "report",
    "imageio": "video",
    "PIL": "video",
    "onnx": "onnx",
    "onnxruntime": "onnx",
    "minari": "data",
    "h5py": "data",
    "ray": "cluster",
}
"""Libraries that not every command needs, and the extra of the package that brings them."""


class UsageError(PntGymError):
    """A command line that asks for something that does not exist or cannot be."""


def option(default: str, metavar: str | None = None) -> Any:
    """How the help shows an option that is None unless given: what happens then, and what to give."""
    return tyro.conf.arg(metavar=metavar, help_behavior_hint=f"(default: {default})")


def run(
    command: Callable[[Arguments], None], arguments: type[Arguments], name: str, given: Sequence[str] | None = None
) -> None:
    """Parse a command line into `arguments` and run `command`.

    Exit codes: 0 done, 2 with one sentence on stderr for a mistake of the user's, a full disk or too little memory, 128
    and the signal's number where one of `signals.REASONS` ended the command.

    Where the command writes data to standard output, what people read goes to standard error.

    Args:
        command: what to do.
        arguments: what it takes.
        name: of the module that is run by `python -m`, or what else the user typed.
        given: the command line without that; None for this process's.
    """
    # A redirected stream of another encoding must not turn a table into a traceback.
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="replace")
    try:
        parsed = _parsed(arguments, f"python -m {module_name(name)}" if given is None else name, given)
        with warnings.catch_warnings():
            warnings.showwarning = lambda said, *_, **__: print(f"warning: {one_sentence(said)}", file=sys.stderr)
            with handled(interrupt), _printing(parsed):
                command(parsed)
    except (PntGymError, OSError, MemoryError) as error:
        print(f"error: {explained(error)}", file=sys.stderr)
        sys.exit(BAD_USAGE)
    except ModuleNotFoundError as error:
        library = (error.name or "").partition(".")[0]
        extra = EXTRAS.get(library)
        if extra is None:
            raise
        print(f"error: this needs {library}: pip install 'pnt_gym[{extra}]'", file=sys.stderr)
        sys.exit(BAD_USAGE)
    except KeyboardInterrupt as error:
        number = error.number if isinstance(error, Interrupt) else signal.SIGINT
        with contextlib.suppress(OSError):  # a terminal that is closed
            print(REASONS[number], file=sys.stderr)
        sys.exit(128 + number)


def _printing(arguments: Any) -> contextlib.AbstractContextManager[object]:
    """Where the command prints what people read: to standard error if an option has it write to standard output."""
    places = [value for value in vars(arguments).values() if isinstance(value, Path)]
    return contextlib.redirect_stdout(sys.stderr) if any(map(is_printed, places)) else contextlib.nullcontext()


def _parsed(arguments: type[Arguments], program: str, given: Sequence[str] | None) -> Arguments:
    """The options given; what tyro says of wrong ones in a box of several lines as one sentence."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            return tyro.cli(arguments, prog=program, args=given)
    except SystemExit as end:
        if not end.code:
            raise
    box = re.sub(r"\x1b\[[\d;]*m|[│╭╮╰╯─]|-{5,}", "", said.getvalue())
    problem = re.split(r"\n\s*\n", box.partition("\n")[2].strip())[0]
    hint = re.search(r"Perhaps you meant:\s+(.*)", box)
    meant = f"; perhaps you meant {hint[1].strip()}" if hint else ""
    raise UsageError(f"{one_sentence(problem.rstrip(' .:'), 200)}{meant}; see {program} --help")


def explained(error: Exception) -> str:
    """What went wrong as one sentence, be it a mistake, the disk or the memory."""
    if isinstance(error, OSError):
        place = f" {one_sentence(repr(error.filename), 80)}" if error.filename is not None else ""
        return one_sentence(f"cannot read or write{place}: {error.strerror or error}")
    if isinstance(error, MemoryError):
        return one_sentence(f"not enough memory for so large a task: {error}".removesuffix(": "))
    return one_sentence(error)


def at_least(given: Mapping[str, Any], **least: int) -> None:
    """Make sure that no option lies below its least value; one that was not given is None.

    Raises:
        UsageError: one does.
    """
    for name, bound in least.items():
        if given[name] is not None and given[name] < bound:
            raise UsageError(f"--{name.replace('_', '-')} is {given[name]}; it must be at least {bound}")
