"""What all commands of `agents` share: parsing the command line, running, and reporting errors in one sentence."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import re
import signal
import sys
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Collection, Generator, Iterable, Mapping, Sequence
from dataclasses import fields
from inspect import signature
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn, TypeVar, get_args, get_type_hints

import tyro

from pnt_gym.errors import PntGymError, one_sentence
from pnt_gym.names import unknown_name

from .places import module_name
from .streams import REASONS, Interrupt, handle_signals, interrupt, is_printed

NUM_ENVS: Final = 16
"""Cells simulated side by side."""
PICKS: Final = 200
"""Throws of an evaluation."""
PRACTICE: Final = 120
"""Practice throws of a controller before an evaluation."""
SHIFTS: Final = 32
"""Work shifts of an evaluation on a line."""


if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Arguments = TypeVar("Arguments")

BAD_USAGE = 2
DEFECT = 70
"""Exit code after a fault of the program, as in sysexits.h."""
_CHOICE: Final = re.compile(r"[Ii]nvalid choice '(.*)' for argument '(.*)'\. Expected one of \((.*)\)")
"""Sentence of tyro about a value that is none of an option's choices, which tyro lists in any order."""
_VALUES: Final = re.compile(r"Error parsing (\S+): .*?(?:\[('.*?')\]|: ('.*?')$)")
"""Sentence of tyro about values that are no numbers."""
_NO_VALUE: Final = re.compile(r"Missing value for argument '(.*)'\. Expected (\d+)")
_NO_OPTIONS: Final = re.compile(r"Missing from .*:\s*\n( +)\S")
"""Title of tyro over the options that must be given, which stand less far to the right than their help."""
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
    "imageio_ffmpeg": "video",
    "PIL": "video",
    "onnx": "onnx",
    "onnxruntime": "onnx",
    "minari": "data",
    "h5py": "data",
    "ray": "cluster",
    "viser": "design",
}
"""Optional libraries, and the extra of the package that installs each."""


class UsageError(PntGymError):
    """A command line that asks for something impossible or that does not exist."""


class Exit(SystemExit):
    """The end of a command with an exit code of its own; any other `SystemExit` comes from code of the user."""


def check_libraries(*names: str) -> None:
    """Make sure, before any work, that optional libraries are installed; none of them is imported.

    Raises:
        ModuleNotFoundError: one is not; `run` names the extra that brings it.
    """
    for name in names:
        if importlib.util.find_spec(name) is None:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def option(default: str, metavar: str | None = None, text: str | None = None) -> Any:
    """Help of an option whose default is None.

    Args:
        default: effect of the default.
        metavar: metavar of the value.
        text: help of more than one line, which tyro would break where the docstring of the option breaks; None for the
            docstring.
    """
    return tyro.conf.arg(metavar=metavar, help=text, help_behavior_hint=f"(default: {default})")


def read_settings(texts: Sequence[str]) -> dict[str, Any]:
    """Settings given as NAME=VALUE, where VALUE is a number, a list of numbers or a word.

    Raises:
        UsageError: a text has no name or no value, or a name is given twice.
    """
    settings: dict[str, Any] = {}
    check_once({"NAME=VALUE": [text.partition("=")[0] for text in texts]})
    for text in texts:
        name, _, value = text.partition("=")
        if not (name.isidentifier() and value):
            raise UsageError(f"{one_sentence(repr(text), 80)} is no NAME=VALUE, such as gain=0.1")
        try:
            settings[name] = json.loads(value)
        except ValueError:
            settings[name] = value
    return settings


def settings_of(*functions: Callable[..., Any]) -> list[str]:
    """Names of the settings that functions take: of their parameters with a default."""
    parameters = (part for function in functions for part in signature(function).parameters.values())
    return [*dict.fromkeys(part.name for part in parameters if part.default is not part.empty)]


def run(
    command: Callable[[Arguments], None],
    arguments: type[Arguments],
    name: str,
    command_line: Sequence[str] | None = None,
) -> None:
    """Parse a command line into `arguments` and run `command`.

    Exit codes: 0 after success; 2, with one sentence on stderr, after a user's mistake, a full disk or too little
    memory; 128 plus the signal's number if a signal of `signals.REASONS` ended the command; 70, with a traceback, after
    a fault of the program. A command may give 1 a meaning of its own, so no failure ends with 1.

    If the command writes data to standard output, its text for people goes to standard error.

    Args:
        command: function of the command.
        arguments: dataclass of the options.
        name: name of the module for `python -m`, or the words of the command line before `command_line`.
        command_line: options of the command line; None for those of this process.
    """
    # A redirected stream of another encoding must not turn a table into a traceback.
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="replace")
    try:
        parsed = _parse(arguments, f"python -m {module_name(name)}" if command_line is None else name, command_line)
        with warnings.catch_warnings():
            warnings.showwarning = lambda message, *_, **__: print(f"warning: {one_sentence(message)}", file=sys.stderr)
            options = vars(parsed)
            # Printed text goes to standard error if an option makes the command write to standard output.
            is_output = any(is_printed(value) for value in options.values() if isinstance(value, Path))
            printing = contextlib.redirect_stdout(sys.stderr) if is_output else contextlib.nullcontext()
            with handle_signals(interrupt), printing, user_code("a module or class of yours"):
                lists = {name: value for name, value in options.items() if isinstance(value, tuple)}
                check_once({name: value for name, value in lists.items() if all(isinstance(v, str) for v in value)})
                command(parsed)
    except (PntGymError, OSError, MemoryError) as error:
        print(f"error: {describe_error(error)}", file=sys.stderr)
        sys.exit(BAD_USAGE)
    except ModuleNotFoundError as error:
        library = (error.name or "").partition(".")[0]
        extra = EXTRAS.get(library)
        if extra is None:
            _end_with_traceback()
        print(f"error: this needs {library}: pip install 'pnt_gym[{extra}]'", file=sys.stderr)
        sys.exit(BAD_USAGE)
    except KeyboardInterrupt as error:
        number = error.number if isinstance(error, Interrupt) else signal.SIGINT
        with contextlib.suppress(OSError):  # the terminal may be closed
            print(REASONS[number], file=sys.stderr)
        sys.exit(128 + number)
    except Exception:
        _end_with_traceback()


def _end_with_traceback() -> NoReturn:
    """End the command after a fault of the program, with the traceback of the error at hand."""
    traceback.print_exc()
    sys.exit(DEFECT)


@contextlib.contextmanager
def user_code(subject: str) -> Generator[None, None, None]:
    """Context of code of the user: if the code ends the interpreter, as a script does, that is an error.

    Args:
        subject: name of the code, for the error.

    Raises:
        UsageError: the code ends the interpreter.
    """
    try:
        yield
    except (Exception, KeyboardInterrupt, GeneratorExit, Exit):
        raise
    except BaseException as end:
        kind = one_sentence(f"{type(end).__name__}({', '.join(map(repr, end.args))})", 80)
        raise UsageError(
            f"{subject} ended the interpreter with {kind}; lines that belong to a script must stand under "
            '`if __name__ == "__main__":`'
        ) from end


@contextlib.contextmanager
def about(subject: str) -> Generator[None, None, None]:
    """Context in which every mistake begins with a subject, such as an option.

    Raises:
        UsageError: the mistake.
    """
    try:
        yield
    except UsageError as error:
        raise UsageError(f"{subject}: {error}") from None


def check_known(kind: str, names: Iterable[object], known: Collection[object], further: str = "") -> None:
    """Make sure that names are known; the other arguments are those of `unknown_name`.

    Raises:
        UsageError: a name is unknown.
    """
    for name in names:
        if name not in known:
            raise UsageError(unknown_name(kind, name, known, further))


def check_once(options: Mapping[str, Iterable[Any]]) -> None:
    """Make sure that no option has a value twice.

    Args:
        options: values by the names of options.

    Raises:
        UsageError: an option has a value twice.
    """
    for option, values in options.items():
        for value, count in Counter(values).items():
            if count > 1:
                raise UsageError(f"{option}: {one_sentence(repr(value), 80)} is given {count} times; give it once")


def _parse(arguments: type[Arguments], program: str, command_line: Sequence[str] | None) -> Arguments:
    """Parsed options; an error that tyro prints in a box of several lines becomes one sentence."""
    output = io.StringIO()
    try:
        with contextlib.redirect_stderr(output):
            return tyro.cli(arguments, prog=program, args=command_line)
    except SystemExit as end:
        if not end.code:
            raise
    box = re.sub(r"\x1b\[[\d;]*m|[│╭╮╰╯─]|-{5,}", "", output.getvalue())
    problem = re.split(r"\n\s*\n", box.partition("\n")[2].strip())[0]
    problem = re.sub(r"'None',\s+|,\s+'None'|\{None\}\|", "", problem)  # options that were not given
    hint = re.search(r"Perhaps you meant:\s+(.*)", box)
    suggestion = f"; perhaps you meant {hint[1].strip()}" if hint else ""
    raise UsageError(f"{_sentence(problem, get_type_hints(arguments))}{suggestion}; see {program} --help")


def _sentence(problem: str, hints: Mapping[str, Any]) -> str:
    """What tyro says about a command line, in words of this package; `hints` are the types of the options."""
    line = " ".join(problem.split())
    if choice := _CHOICE.search(line):
        known = sorted(re.findall(r"'([^']*)'", choice[3]))
        return f"{choice[2]}: {unknown_name('value', choice[1], known)}"
    if values := _VALUES.search(line):
        given, kind = values[2] or values[3], _number_in_words(hints.get(values[1].strip("-").replace("-", "_")))
        if kind:
            subject = "each" if ", " in given else "it"
            return f"{values[1]} is {one_sentence(given, 80)}; {subject} must be {kind}"
    if no_value := _NO_VALUE.search(line):
        return f"{no_value[1]} needs {'a value' if no_value[2] == '1' else f'{no_value[2]} values'}"
    if no_options := _NO_OPTIONS.search(problem):
        needed = re.findall(rf"^{no_options[1]}(\S.*?)\s*$", problem, re.MULTILINE)
        return f"give {' and '.join(needed)}"
    return one_sentence(problem.rstrip(" .:").replace("Unrecognized options:", "unknown options:"), 200)


def _number_in_words(hint: Any) -> str:
    """The number that an option of a type takes, in words; nothing for a type without numbers."""
    types = [hint, *get_args(hint)]
    types += [part for kind in types for part in get_args(kind)]
    return "a number" if float in types else "a whole number" if int in types else ""


def describe_error(error: Exception) -> str:
    """Message of an error, one sentence or a list of problems, for user's mistakes, disk errors and lack of memory."""
    if isinstance(error, OSError):
        place = f" {one_sentence(repr(error.filename), 80)}" if error.filename is not None else ""
        return one_sentence(f"cannot read or write{place}: {error.strerror or error}")
    if isinstance(error, MemoryError):
        return one_sentence(f"not enough memory for so large a task: {error}".removesuffix(": "))
    return str(error) if isinstance(error, PntGymError) else one_sentence(error)


def at_least(options: Mapping[str, Any], **least: int) -> None:
    """Make sure that options are whole numbers, not below their least values; options that are None are skipped.

    Raises:
        UsageError: an option is no whole number, or lies below its least value.
    """
    for name, bound in least.items():
        value = options[name]
        is_whole = isinstance(value, Integral) and not isinstance(value, bool)
        if value is None or (is_whole and int(value) >= bound):
            continue
        kind = "" if is_whole else "a whole number, "
        raise UsageError(f"--{name.replace('_', '-')} is {value!r}; it must be {kind}at least {bound}")


def at_most(options: Mapping[str, Any], **most: int) -> None:
    """Make sure that options do not lie above their largest values; options that are None are skipped.

    Raises:
        UsageError: an option lies above its largest value.
    """
    for name, bound in most.items():
        if options[name] is not None and options[name] > bound:
            raise UsageError(f"--{name.replace('_', '-')} is {options[name]!r}; it must be at most {bound:,}")


def typed(kind: type[Arguments], options: Mapping[str, Any]) -> Arguments:
    """Options by name, as a caller in Python gives them, as the dataclass `kind`.

    Raises:
        UsageError: an option has another type.
    """
    from pydantic import TypeAdapter, ValidationError  # noqa: PLC0415 - help comes at once

    try:
        return TypeAdapter(kind).validate_python(options)
    except ValidationError as error:
        problem = error.errors()[0]
        name, message = str(problem["loc"][0]), problem["msg"].replace("tuple", "list")
        value = one_sentence(repr(options[name]), 80)
        raise UsageError(f"{name} is {value}: {message[0].lower()}{message[1:]}") from None


def check_effects(arguments: DataclassInstance, outputs: Mapping[str, str], positional: str = "") -> None:
    """Make sure that every option which was given has an effect.

    Args:
        arguments: the options of a command.
        outputs: by the name of an option, the name of that without which the option has no effect.
        positional: name of an argument that has no dashes.

    Raises:
        UsageError: an option was given without the other one.
    """
    usual = {field.name: field.default for field in fields(arguments)}
    for name, output in outputs.items():
        if getattr(arguments, name) != usual[name] and getattr(arguments, output) is None:
            other = output.upper() if output == positional else f"--{output}"
            raise UsageError(f"--{name} goes with {other}, and has no effect here")
