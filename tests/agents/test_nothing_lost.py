"""Killed, doubled, or without room: nothing is lost, nothing is half, and one sentence says what to do."""

import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import yaml

from agents.ground.files import lock_folder, sweep, write_text
from agents.ground.places import SHIPPED
from agents.learning.runs import RunFolder
from benchmarks.kill_trials.commands import LEARNER, small_reproduction
from benchmarks.kill_trials.trials import state
from tests.tools.benchmark import toy_plan
from tests.tools.commands import answered, call_here, environment, refused, run_python
from tests.tools.datasets import SMALL as SMALL_DATASET

pytestmark = pytest.mark.usefixtures("here")
SMALL = ("--env", "ToyThrow-v0", "--num-envs", "4", "--checkpoint-every", "8", "--config", "sac.yml", "--out", "run")
RESUME = ("agents.train", "--resume", "run", "--eval-picks", "4")


@pytest.fixture
def here(desk: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MINARI_DATASETS_PATH", "sets")
    (desk / "sac.yml").write_text(yaml.safe_dump({"default": LEARNER}))
    return desk


@pytest.mark.nightly
def test_a_sample_of_kills() -> None:
    """`make kill` kills at every operation; here at some, and twice at random."""
    options = ("--toy", "--every", "23", "--chances", "1", "--only", "train", "report", "Throw-v0-1")
    done = run_python("benchmarks/kill.py", *options, cwd=SHIPPED)
    assert done.returncode == 0, done.stdout + done.stderr
    lost, _, _, kills, *_ = done.stdout.splitlines()[-1].split()
    assert int(lost) == 0
    assert int(kills) >= 10


def test_a_second_command_in_a_folder_is_refused(run: Path, here: Path) -> None:
    (here / "results").mkdir()
    small_reproduction(here / "results")
    (here / "plan.yaml").write_text(yaml.safe_dump(toy_plan()))
    (here / "work").mkdir()
    commands: dict[str, tuple[str, ...]] = {
        "run": (*RESUME, "--steps", "24"),
        "work": ("agents.benchmark", "--config", "plan.yaml", "--work", "work", "--out", "out.json"),
        "results": ("agents.report", "--results", "results", "--readme", "none.md"),
    }
    before = state(here)
    for folder, command in commands.items():
        with lock_folder(here / folder):
            assert f"another command is at work in '{folder}'" in refused(*command)
    with lock_folder(here / "work"):
        command = ("agents.reproduce", "choe", "--only", "length", "--work", "work", "--jobs", "1")
        assert "another command is at work in 'work'" in refused(*command)
    assert state(here) == before
    assert answered(*commands["results"])[0] == 0


def test_a_lock_ends_with_its_process(here: Path) -> None:
    code = "import os\nfrom agents.ground.files import Path, lock_folder\n"
    code += "with lock_folder(Path()): os.kill(os.getpid(), 9)"
    assert run_python("-c", code, timeout=60).returncode == -9
    with lock_folder(here):
        pass


def dead() -> int:
    """The number of a process that is no more."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_what_a_killed_command_left_is_swept_and_what_others_write_is_not(here: Path) -> None:
    (here / f".out.json.{dead()}.tmp").write_text("half")
    (here / f".run.{dead()}.tmp" / "checkpoints").mkdir(parents=True)
    (here / f".out.json.{os.getppid()}.tmp").write_text("still at it")
    (here / ".mine.tmp").write_text("a user's own")
    write_text(here / "out.json", "whole\n")
    kept = [f".out.json.{os.getppid()}.tmp", ".mine.tmp", "out.json", "sac.yml"]
    assert sorted(path.name for path in here.iterdir()) == sorted(kept)
    sweep(here / "nowhere")


def test_a_resume_mends_what_a_kill_kept_from_being_done(run: Path) -> None:
    whole = state(run)
    first, last = (run / "checkpoints" / name for name in ("00000008", "00000016"))
    for name in ("model.zip", "policy.npz"):
        shutil.copy(first / name, run / name)
    (run / "replay_buffer.npz").unlink()
    shutil.copy(last / "replay_buffer.npz", first / "replay_buffer.npz")
    (run / "checkpoints" / f".00000016.{dead()}.tmp").mkdir()
    (run / "evaluation.json").unlink()
    assert answered(*RESUME) == (0, "")
    assert state(run) == whole
    for name in ("model.zip", "policy.npz"):
        assert (run / name).read_bytes() == (last / name).read_bytes()
    assert "has done 16 throws of 16; give a larger --steps" in refused(*RESUME)


def test_a_table_of_fewer_throws_is_not_taken_for_that_of_more(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def killed(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("agents.judging.throw_trial.throw_held_out", killed)
        assert answered(*RESUME, "--steps", "24")[0] != 0
    assert RunFolder(run).load().num_timesteps == 24
    assert not (run / "evaluation.json").exists()
    assert answered(*RESUME)[0] == 0
    assert (run / "evaluation.json").exists()


@contextmanager
def room_for(size: int) -> Iterator[None]:
    """No file may grow beyond a size [bytes]: what a full disk does, for this process only."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("size", [0, 100, 3000, 8000, 20_000])
def test_a_disk_that_is_full_costs_no_more_than_the_leg(run: Path, here: Path, size: int) -> None:
    whole = state(here)
    commands = [
        ("agents.train", *SMALL[:-1], "new", "--steps", "8", "--eval-picks", "0"),
        ("agents.evaluate", "--env", "ToyThrow-v0", "--controller", "analytic", "--picks", "400", "--json", "out.json"),
    ]
    for command in commands:
        with room_for(size):
            code, said = answered(*command)
        assert code in (0, 2), said
        assert code == 0 or ("File too large" in said and said.count("\n") == 1), said
        for name in ("new", "out.json"):
            if code == 2:
                assert not (here / name).exists()
            elif (here / name).is_dir():
                shutil.rmtree(here / name)
            else:
                (here / name).unlink(missing_ok=True)
    with room_for(size):
        code, said = answered(*RESUME, "--steps", "24")
    assert code == 0 or "File too large" in said
    kept = state(here)
    assert all(kept[name] == whole[name] for name in whole if "/checkpoints/0" in name and "buffer" not in name)
    assert answered(*RESUME, "--steps", "24")[0] in (0, 2)
    assert RunFolder(run).load().num_timesteps == 24


LEARNS = ("torch", "stable_baselines3", "sb3_contrib")
OURS = (
    *(f"agents.learning.{name}" for name in ("progress", "sb3", "vec_env")), "agents.policies.weights",
    "agents.dataset.offline",
)  # fmt: skip
"""What of ours imports them, or what writes a dataset."""
MISSING = [
    ("torch", "rl", ("agents.train", *SMALL[:-1], "new")),
    ("torch", "rl", ("agents.evaluate", "--controller", "run/model.zip", "--env", "ToyThrow-v0", "--trust")),
    ("torch", "rl", ("agents.publish", "run", "--to", "new")),
    ("onnx", "onnx", ("agents.publish", "run", "--to", "new", "--levels", "waste")),
    ("stable_baselines3", "rl", ("agents.train", *SMALL[:-1], "new")),
    ("sb3_contrib", "rl", ("agents.train", *SMALL[:-1], "new", "--algo", "tqc")),
    ("minari", "data", SMALL_DATASET),
    ("h5py", "data", SMALL_DATASET),
    ("PIL", "video", SMALL_DATASET),
    ("ray", "cluster", (*SMALL_DATASET, "--throws", "4", "--cluster", "auto")),
    ("torch", "rl", ("agents.evaluate", "--controller", "mlp", "--env", "ToyThrow-v0")),
]


LINE = ("--env", "PnTLine-v0", "--level", "skills3", "--controller", "fifo", "--shifts", "1", "--num-envs", "1")
AT_ONCE = [
    ("matplotlib", "report", ("agents.evaluate", *LINE, "--picture", "new/who.svg")),
    ("imageio", "video", ("agents.evaluate", *LINE, "--video", "new/x.mp4")),
    ("imageio_ffmpeg", "video", ("agents.play", "--env", "PnTRelease-v0", "--video", "new/x.mp4")),
    ("PIL", "video", ("agents.play", "--env", "PnTRelease-v0", "--picture", "new/x.png")),
    ("matplotlib", "report", ("agents.line plan", "--level", "skills3", "--picture", "new/plans.svg")),
    ("cma", "rl", ("agents.line tune", "--level", "skills3", "--what", "atc", "index", "--out", "new/rules.yaml")),
    ("jinja2", "report", ("agents.report", "--results", "results", "--readme", "none.md")),
    ("matplotlib", "report", ("agents.publish", "run", "--to", "new", "--levels", "waste")),
    ("onnxruntime", "onnx", ("agents.publish", "run", "--to", "new", "--levels", "waste")),
    ("imageio", "video", ("agents.publish", "run", "--to", "new", "--levels", "waste", "--no-onnx")),
    ("matplotlib", "report", ("agents.reproduce", "choe", "--only", "length", "--work", "new")),
    ("torch", "rl", ("agents.benchmark", "--config", "plan.yaml", "--work", "new")),
]


def forget(monkeypatch: pytest.MonkeyPatch, *libraries: str) -> None:
    """Let libraries, and our modules that import them, be imported anew in this test alone.

    A package knows its modules, too: without its old attribute, later tests would meet two copies of a class.
    """
    for name in [n for n in sys.modules if n.partition(".")[0] in libraries or n in OURS]:
        package, _, module = name.rpartition(".")
        if name in OURS and hasattr(sys.modules.get(package), module):
            monkeypatch.delattr(sys.modules[package], module)
        monkeypatch.delitem(sys.modules, name)


@pytest.mark.parametrize(("library", "extra", "command"), AT_ONCE)
def test_what_is_missing_at_the_end_is_named_before_the_work(
    run: Path, here: Path, monkeypatch: pytest.MonkeyPatch, library: str, extra: str, command: tuple[str, ...]
) -> None:
    (here / "results").mkdir()
    small_reproduction(here / "results")
    (here / "plan.yaml").write_text(yaml.safe_dump(toy_plan({"label": "m", "controller": "mlp", "throws": [8]})))
    before = sorted(here.rglob("*"))
    monkeypatch.setitem(sys.modules, library, None)
    done = call_here(*command, folder=here)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"error: this needs {library}: pip install 'pnt_gym[{extra}]'\n"
    assert sorted(here.rglob("*")) == before


@pytest.mark.parametrize(("library", "extra", "command"), MISSING)
def test_a_library_that_is_not_there_is_named_with_what_brings_it(
    run: Path, here: Path, monkeypatch: pytest.MonkeyPatch, library: str, extra: str, command: tuple[str, ...]
) -> None:
    (here / "results").mkdir()
    small_reproduction(here / "results")
    forget(monkeypatch, library)
    monkeypatch.setitem(sys.modules, library, None)
    said = refused(*command)
    assert f"needs {library}" in said
    assert f"pip install 'pnt_gym[{extra}]'" in said
    assert not (here / "new").exists() or not list((here / "new").iterdir())


def test_a_trained_policy_throws_without_the_libraries_that_trained_it(
    run: Path, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = ("agents.evaluate", "--controller", "run", "--picks", "8", "--num-envs", "4", "--json")
    assert answered(*command, "with.json") == (0, "")
    forget(monkeypatch, *LEARNS)
    for name in LEARNS:
        monkeypatch.setitem(sys.modules, name, None)
    assert answered(*command, "without.json") == (0, "")
    assert (here / "without.json").read_bytes() == (here / "with.json").read_bytes()


def test_paths_with_spaces_and_umlauts_without_a_home_in_an_ascii_world(tmp_path: Path) -> None:
    place = tmp_path / "Müll sortieren, größer"
    place.mkdir()
    (place / "mein Förderband.yaml").write_text("mismatch: 0.5\nname: Förderband\n", encoding="utf-8")
    bare = {k: v for k, v in environment().items() if k not in ("HOME", "LANG", "LC_CTYPE", "PYTHONIOENCODING")}
    command = ["--env", "PnTRelease-v0", "--level", "mein Förderband.yaml", "--controller", "analytic", "--picks", "4"]
    command += ["--num-envs", "4", "--json", "Übersicht 1.json"]
    ascii_world = {**bare, "LC_ALL": "C", "PYTHONUTF8": "0"}
    done = run_python("-m", "agents.evaluate", *command, cwd=place, env=ascii_world, text=False)
    assert done.returncode == 0, done.stderr
    assert b"Traceback" not in done.stderr
    assert (place / "Übersicht 1.json").is_file()
