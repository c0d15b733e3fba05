"""Files that a stranger may have made, and places to write to that are no plain files."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np

from benchmarks.fuzz_cases.basis import Draws, Find, Refused, refusable
from benchmarks.fuzz_cases.formats import FORMATS, example
from tests.tools.commands import call_here

STRICT: Final = tuple(
    (name, file)
    for name, form in FORMATS.items()
    for file in form.files
    if name != "zoo-folder" and file != "progress.csv"
)
"""Forms and files, without those whose keys or lines nobody minds."""
LARGEST: Final = 2**28
"""Bytes of arrays that no reader may unpack."""


def file_case(draws: Draws) -> str:
    """A file that no reader may take."""
    (name, file), kind = draws.pick(STRICT), draws.pick(FILES)
    with TemporaryDirectory() as place:
        folder = Path(place) / "here"
        shutil.copytree(example(name), folder)
        path = folder / file
        path.unlink()
        subject = f"{name}: {file} {kind}: {FILES[kind](draws, path)!r}"
        with contextlib.suppress(Refused), refusable(subject):
            FORMATS[name].read(path)
            raise Find(f"{subject}: taken")
    return subject


def _twice(draws: Draws, path: Path) -> str:
    """A key given twice, at any depth."""
    key, value = draws.pick(("name", "belt", "mismatch", "env", "a")), draws.pick(("1", "{x: 1}", "waste", "null"))
    lines = draws.pick(((f"{key}: {value}", f"{key}: {value}"), ("b:", f"  {key}: {value}", f"  {key}: 2")))
    text = "\n".join(lines)
    if path.suffix == ".json":
        text = f'{{"{key}": 1, "b": {{"{key}": 1, "{key}": 2}}}}'
    path.write_text(text)
    return text


def _path_name(draws: Draws, path: Path) -> str:
    """A name that is a path, or no line of text."""
    name = draws.pick(("a/b", "../x", "..", ".", "/etc/x", "a\\\\b", "a\\nb", "\\u202ea", "x" * 200))
    path.write_text(f'name: "{name}"\nlabel: "{name}"\nPnTRelease-v0: 1\n')
    return name


def _fifo(_: Draws, path: Path) -> str:
    os.mkfifo(path)
    return "FIFO"


def _link(draws: Draws, path: Path) -> str:
    target = draws.pick(("/dev/zero", "/dev/full", "/dev/tty", "/dev/random", "/", "/proc/self/mem", path.name))
    path.symlink_to(target)
    return target


def _sparse(draws: Draws, path: Path) -> str:
    """A file of which the disk holds nothing."""
    size = 2 ** draws.integer(33, 43)
    path.touch()
    os.truncate(path, size)
    return f"{size} bytes"


def _deep(draws: Draws, path: Path) -> str:
    bracket = draws.pick(("[", "{a: ", '{"a": ', "- ", "? "))
    path.write_text(bracket * 10_000)
    return f"{bracket} x 10000"


def _aliases(draws: Draws, path: Path) -> str:
    """Aliases of aliases, or of themselves."""
    if draws.chance(0.3):
        path.write_text("name: &a [*a]\nenv: {b: *a}")
        return "itself"
    levels = draws.integer(5, 12)
    lines = ["a0: &a0 [0]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, levels)]
    path.write_text("\n".join([*lines, f"bins: *a{levels - 1}", f"items: *a{levels - 1}"]))
    return f"{levels} levels"


def _zip(draws: Draws, path: Path) -> str:
    """An archive of zeros that is large when it is unpacked, or promises to be."""
    member = draws.pick(("weight_0.npy", "x.npy", "controller.npy", "../up.npy", "weight_0.pkl"))
    promise, size = draws.pick((0, 10**6, 10**12, -1)), 0 if draws.chance(0.5) else LARGEST
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as parts, parts.open(member, "w") as part:
        head = {"descr": "<f4", "fortran_order": False, "shape": (promise or size // 4,)}
        np.lib.format.write_array_header_1_0(part, head)
        for _ in range(size // 2**22):
            part.write(bytes(2**22))
    return f"{member} of {size} bytes, promises {promise}"


FILES: Final[dict[str, Callable[[Draws, Path], str]]] = {
    "twice": _twice,
    "named as a path": _path_name,
    "fifo": _fifo,
    "link": _link,
    "sparse": _sparse,
    "deep": _deep,
    "aliases": _aliases,
    "zip": _zip,
}


def output_case(draws: Draws) -> str:
    """An output of a command through links, to a device or to a pipe, which must stay links, device and pipe."""
    with TemporaryDirectory() as folder:
        place, content = PLACES[draws.pick(PLACES)](Path(folder))
        subject = f"evaluate --json {place}"
        before = os.lstat(place) if os.path.lexists(place) else None
        with content as written:
            command = ("--env", "ToyThrow-v0", "--controller", "analytic", "--picks", "4", "--num-envs", "4")
            process = call_here("agents.evaluate", *command, "--json", place, folder=Path(folder))
            if before is not None and stat.S_IFMT(os.lstat(place).st_mode) != stat.S_IFMT(before.st_mode):
                raise Find(f"{subject}: replaced")
        if process.returncode == 0 and b'"throws"' not in written():
            raise Find(f"{subject}: nothing is written")
        if process.returncode not in (0, 2) or "Traceback" in process.stderr:
            raise Find(f"{subject}: exit code {process.returncode}, {process.stderr[-200:]!r}")
    return subject


Place = tuple[Path, contextlib.AbstractContextManager[Callable[[], bytes]]]


def _links(folder: Path) -> Place:
    (folder / "disk").mkdir()
    (folder / "disk" / "old").write_text("old")
    (folder / "inner").symlink_to("disk/old")
    (folder / "link").symlink_to(folder / "inner")
    return folder / "link", contextlib.nullcontext((folder / "disk" / "old").read_bytes)


def _device(folder: Path) -> Place:
    (folder / "link").symlink_to("/dev/null")
    return folder / "link", contextlib.nullcontext(lambda: b'"throws"')


def _stream(folder: Path) -> Place:
    """An open file by its descriptor."""
    descriptor = os.open(folder / "open", os.O_WRONLY | os.O_CREAT)
    return Path(f"/dev/fd/{descriptor}"), _open(descriptor, (folder / "open").read_bytes)


@contextlib.contextmanager
def _open(descriptor: int, read: Callable[[], bytes]) -> Iterator[Callable[[], bytes]]:
    yield read
    os.close(descriptor)


PLACES: Final[dict[str, Callable[[Path], Place]]] = {"links": _links, "device": _device, "stream": _stream}
