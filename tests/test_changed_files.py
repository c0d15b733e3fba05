"""Files in which one thing was changed: samples of the fuzz, that it finds what it looks for, and what it has found."""

import contextlib
import io
import os
import shutil
import signal
import subprocess
import zipfile
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
import yaml

from benchmarks.fuzz_cases import changed
from benchmarks.fuzz_cases.basis import Draws, Find, find_simplest
from benchmarks.fuzz_cases.cases import judge_case
from benchmarks.fuzz_cases.changes import WRITERS, places_of
from benchmarks.fuzz_cases.changes import changed as change
from benchmarks.fuzz_cases.files import STRICT
from benchmarks.fuzz_cases.formats import FORMATS, Format, example
from pnt_gym.errors import PntGymError
from pnt_gym.reading import json_of, yaml_of
from tests.tools.commands import call_here
from tests.tools.nightly import with_nightly

PLACES = [(name, file) for name, form in FORMATS.items() for file in form.files]
Change = Callable[[Path], object]


@pytest.fixture
def copy_of(tmp_path: Path) -> Callable[[str], Path]:
    return lambda name: shutil.copytree(example(name), tmp_path / name)


@pytest.mark.parametrize(("name", "file"), PLACES)
def test_every_example_is_read(name: str, file: str, copy_of: Callable[[str], Path]) -> None:
    FORMATS[name].read(copy_of(name) / file)


@pytest.fixture
def patience() -> Iterator[None]:
    """Ends a test that waits for ever."""
    old = signal.signal(signal.SIGALRM, lambda *_: pytest.fail("it waits"))
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, old)


@pytest.mark.usefixtures("patience")
@pytest.mark.parametrize(("name", "file"), STRICT)
def test_no_reader_waits_for_somebody_who_writes(name: str, file: str, copy_of: Callable[[str], Path]) -> None:
    path = copy_of(name) / file
    path.unlink()
    os.mkfifo(path)
    with pytest.raises((PntGymError, gym.error.Error)):
        FORMATS[name].read(path)


@pytest.mark.parametrize("name", [name for name, form in FORMATS.items() if form.line])
def test_every_command_line_reads_its_example(name: str, copy_of: Callable[[str], Path]) -> None:
    module, *words = FORMATS[name].line.replace("FILE", FORMATS[name].files[-1]).split()
    done = call_here(module, *words, folder=copy_of(name))
    assert done.returncode == 0 or "--load" in words, done.stderr


def changes_of(change_once: Callable[[Draws], tuple[bytes, str]], count: int = 40) -> list[bytes]:
    """What a number of changes make of a file."""
    contents = list[bytes]()
    assert find_simplest(lambda draws: contents.append(change_once(draws)[0]), 0, count) is None
    return contents


@pytest.mark.parametrize(
    ("name", "file"), with_nightly(PLACES, {Path(file).suffix: (name, file) for name, file in PLACES}.values())
)
def test_a_change_changes_a_file(name: str, file: str) -> None:
    data = (example(name) / file).read_bytes()
    news = set(changes_of(partial(change, name=file, data=data)))
    assert len(news) > 15
    assert len(news - {data}) > 15


def test_a_change_of_a_document_is_one(tmp_path: Path) -> None:
    """Most changes of a document leave all but one of its values as they were."""
    path, near = tmp_path / "a.yaml", 0
    old = {"a": {"b": [1, 2.5, "x"], "c": None}, "d": 1.0, "e": {"f": 3}}
    for content in changes_of(lambda draws: WRITERS[".yaml"](draws, yaml.safe_dump(old).encode()), 100):
        path.write_bytes(content)
        try:
            new = yaml_of(path)
        except PntGymError:
            continue
        kept = sum(place in list(places_of(new)) for place in places_of(old))
        near += isinstance(new, dict) and kept >= len(list(places_of(old))) - 4
    assert near > 50


def broken(error: BaseException | None, seconds: float = 0.0, count: int = 0) -> Format:
    """A form whose reader takes this time and this memory, as far as the judge of a case measures them."""

    def read(_: Path) -> None:
        changed.time.monotonic = lambda: seconds  # type: ignore[method-assign]
        changed._peak = lambda: count
        if error is not None:
            raise error

    return Format(lambda folder: (folder / "a.json").write_text('{"a": 1}'), read, ("a.json",))


class Simplest(Draws):
    """The simplest of all draws."""

    def __init__(self) -> None:
        pass

    def pick(self, choices: Iterable[Any]) -> Any:
        return next(iter(choices))

    def integer(self, low: int, end: int | None = None) -> int:
        return 0 if end is None else low


@pytest.fixture
def other_example() -> Iterator[None]:
    """Leaves no example of a form that a test puts in the place of another."""
    yield
    example.cache_clear()


@pytest.mark.usefixtures("other_example")
def test_what_must_not_be_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(changed, "time", type("Time", (), {"monotonic": staticmethod(lambda: 0.0)}))
    monkeypatch.setattr(changed, "MOST", 2**27)
    refused, hidden = PntGymError("a sentence"), PntGymError("a sentence")
    hidden.__cause__ = MemoryError()
    for form, said in (
        (broken(None), None), (broken(refused), None), (broken(KeyError("x")), "KeyError"),
        (broken(hidden), "more memory"), (broken(gym.error.Error("a\nb")), "is no sentence"),
        (broken(None, 61.0), "took 61 s"), (broken(None, 0.0, 2**28), "bytes"),
        (broken(MemoryError("x")), "MemoryError"),
    ):  # fmt: skip
        monkeypatch.setattr(changed.time, "monotonic", staticmethod(lambda: 0.0))
        monkeypatch.setattr(changed, "_peak", lambda: 0)
        monkeypatch.setitem(FORMATS, "level-file", form)
        example.cache_clear()
        with contextlib.nullcontext() if said is None else pytest.raises(Find, match=said):
            judge_case("level-file", Simplest())


@pytest.mark.parametrize(("code", "words", "said"), [
    (0, "", None), (2, "error: a sentence", None), (2, "", "exit code 2"), (1, "error: a sentence", "exit code 1"),
    (70, "Traceback", "exit code 70"), (0, "Traceback", "exit code 0"),
])  # fmt: skip
def test_a_command_that_ends_otherwise_is_found(
    code: int, words: str, said: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done = subprocess.CompletedProcess([""], code, "", words)
    monkeypatch.setattr(changed, "call_here", lambda *_, **__: done)
    form = Format(lambda _: None, lambda _: None, ("a.csv",), "agents.fit FILE --level waste")
    with contextlib.nullcontext() if said is None else pytest.raises(Find, match=said):
        changed.try_line("a case", form, tmp_path, "a.csv")


def document(file: str, *place: Any, value: Any) -> tuple[str, Change]:
    """A file whose value at a place is another."""

    def write(path: Path) -> None:
        data = json_of(path) if path.suffix == ".json" else yaml_of(path)
        part = data
        for key in place[:-1]:
            part = part[key]
        part[place[-1]] = value
        path.write_text(yaml.safe_dump(data))

    return file, write


def arrays(file: str, name: str, turn: Callable[[Any], Any]) -> tuple[str, Change]:
    """An archive one array of which is another."""

    def write(path: Path) -> None:
        with np.load(path) as old:
            np.savez(path, **{**old, name: turn(old[name])})

    return file, write


def spoil_tensors(name: str, path: Path) -> None:
    """Write a model with weights that are no numbers, or with an optimiser's moments of another shape."""
    with zipfile.ZipFile(path) as old:
        parts = {name: old.read(name) for name in old.namelist()}
    tensors = torch.load(io.BytesIO(parts[name]), weights_only=True)
    if "state" in tensors:
        tensors["state"][0]["exp_avg"] = torch.zeros(3, 3)
    else:
        next(iter(tensors.values()))[...] = float("nan")
    content = io.BytesIO()
    torch.save(tensors, content)
    with zipfile.ZipFile(path, "w") as new:
        for part, data in {**parts, name: content.getvalue()}.items():
            new.writestr(part, data)


def spoiled(array: Any) -> Any:
    return np.full_like(array, np.nan)


POINT, RULES = "checkpoints/00000008", "runs/line_rules.yaml"
SETTINGS = ("PnTRelease-v0", "policy_kwargs")
MEMORY, MODEL = f"{POINT}/replay_buffer.npz", f"{POINT}/model.zip"
FORM = "it is of another form"


def complex_of(array: Any) -> Any:
    return array.astype("c16")


REFUSED: dict[str, list[tuple[tuple[str, Change], str]]] = {
    "resumed-folder": [
        (document("args.yml", "num_envs", value=2**31), "num_envs 2147483648; it must be from 1 to 100,000"),
        (arrays(MEMORY, "observations", spoiled), "truncated, or of another version"),
        ((MODEL, partial(spoil_tensors, "policy.pth")), "is truncated or not a model"),
        ((MODEL, partial(spoil_tensors, "critic.optimizer.pth")), "is truncated or not a model"),
    ],
    "run-folder": [
        (document("args.yml", "seed", value=-1), "seed -1; it must be from 0 to"),
        (document("args.yml", "algo", value="x" * 1000), "args.yml has algo 'xxx"),
    ],
    "chances-file": [(document("table.json", "percent", value=[]), "is not a table from")],
    "level-file": [
        (document("belt.yaml", "robot", "claws", "length", value=10**40), "'length' has the number 1000"),
        (document("belt.yaml", "robot", "dimensions", "r", value=10**400), "'r' has the number 1000"),
        (document("belt.yaml", "robot", "servo", "stall_torque", value=float("nan")), "has the number nan"),
    ],
    "settings-file": [(document("ppo.yml", *SETTINGS, value={"net_arch": True}), "net_arch is True")],
    "rules-file": [
        (document(RULES, "mine", "atc", "patience", value=5e-324), "patience is 5e-324"),
        (document(RULES, "mine", "price", "share", value="x"), "share is 'x'"),
        (document(RULES, "mine", "atc", "speed", value=1), "no settings patience, speed"),
        (document(RULES, "mine", value=[]), "is not a file of settings by level"),
        (document(RULES, "mine", "rate", value="x"), "is not a file of settings by level"),
    ],
    "state-file": [
        (arrays("virtual_goal.npz", "shift", lambda a: np.resize(a, (*a.shape, 7))), "no state of 'virtual_goal'"),
        (arrays("virtual_goal.npz", "shift", complex_of), "'shift' is complex128"),
        (arrays("ridge.npz", "weights", spoiled), "that are not finite"),
    ],
    "network-file": [
        (arrays("local_mlp.npz", "centre", lambda a: a[:0]), "holds no networks that choose"),
        (arrays("local_mlp.npz", "scale", lambda a: 0.0 * a), "holds no networks that choose"),
    ],
    "dataset-chunk": [
        (arrays("chunk.npz", "lengths", complex_of), "lengths are complex128"),
        (arrays("chunk.npz", "lengths", lambda a: a + 1), FORM),
        (arrays("chunk.npz", "actions", lambda a: a.astype("U9")), FORM),
        (arrays("chunk.npz", "figures", lambda a: np.array(["["] * len(a))), "it is not valid JSON"),
    ],
}
CASES = [(name, number) for name, cases in REFUSED.items() for number in range(len(cases))]


@pytest.mark.parametrize(("name", "number"), CASES)
def test_what_was_found_is_refused_in_a_sentence(name: str, number: int, copy_of: Callable[[str], Path]) -> None:
    (file, write), said = REFUSED[name][number]
    path = copy_of(name) / file
    write(path)
    with pytest.raises(PntGymError) as caught:
        FORMATS[name].read(path)
    assert said in str(caught.value)


def test_a_number_of_throws_that_no_run_has_is_left_out(copy_of: Callable[[str], Path]) -> None:
    path = copy_of("resumed-folder") / "progress.csv"
    path.write_text(f"{path.read_text()}{'9' * 5000},1,1,1,1\n")
    FORMATS["resumed-folder"].read(path)
    assert "9" * 5000 not in path.read_text()
