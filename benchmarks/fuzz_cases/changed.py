"""Files in which one thing was changed: read as they are, or refused in a sentence, soon and without much memory."""

from __future__ import annotations

import contextlib
import io
import resource
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from benchmarks.fuzz_cases.basis import Draws, Find, Refused, refusable
from benchmarks.fuzz_cases.changes import changed
from benchmarks.fuzz_cases.formats import FORMATS, Format, example
from benchmarks.fuzz_cases.lines import complaint
from tests.tools.commands import call_here

LONGEST: Final = 60.0
"""Time that a file of some kilobytes may take to be read; the first one may compile functions [s]."""
MOST: Final = 2**30
"""Memory that it may take [bytes]."""
COMMANDS: Final = 0.02
"""Share of the cases that are read by a command line."""


def changed_case(name: str, draws: Draws) -> str:
    """One thing changed in a file of a form."""
    form = FORMATS[name]
    file = draws.pick(form.files)
    with TemporaryDirectory() as place:
        folder = Path(place) / "here"
        shutil.copytree(example(name), folder)
        content, said = changed(draws, file, (folder / file).read_bytes())
        (folder / file).write_bytes(content)
        subject = f"{name}: {file} with {said!r}"
        began, before = time.monotonic(), _peak()
        if form.line and draws.chance(COMMANDS):
            try_line(subject, form, folder, file)
        else:
            try_reader(subject, form, folder / file)
        if (taken := _peak() - before) > MOST:
            raise Find(f"{subject}: took {taken:,} bytes")
        if (seconds := time.monotonic() - began) > LONGEST:
            raise Find(f"{subject}: took {seconds:.0f} s")
    return subject


def try_reader(subject: str, form: Format, path: Path) -> None:
    """Read a file as commands do.

    Raises:
        Find: the file is neither read nor refused in a sentence.
    """
    with contextlib.suppress(Refused), refusable(subject), _silence():
        form.read(path)


def try_line(subject: str, form: Format, folder: Path, file: str) -> None:
    """Give a file to a command line.

    Raises:
        Find: the command ends otherwise than with 0, with a sentence and 2, or with a verdict.
    """
    module, *words = (file if word == "FILE" else word for word in form.line.split())
    done = call_here(module, *words, folder=folder)
    if done.returncode not in (0, 2) and form.verdict and form.verdict in done.stdout:
        return
    if (said := complaint(done)) is not None:
        raise Find(f"{subject}: {form.line}: {said}")


def _peak() -> int:
    """Most memory that this process ever had [bytes]."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        yield
