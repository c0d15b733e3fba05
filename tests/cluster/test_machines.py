"""A study on two machines: the same numbers, whatever dies or is interrupted."""

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import psutil
import pytest
import yaml

from agents.benchmark.run import Part, run_piece
from agents.ground import cluster
from agents.ground.cli import UsageError
from agents.ground.cluster import Needs, pool
from agents.ground.work import Job, do_missing
from agents.results.content import read_form
from agents.results.plan import Plan, pieces
from pnt_gym.errors import PntGymError
from tests.cluster.conftest import Machines, all_gone, lose_power, workers
from tests.tools.commands import complaints, environment
from tests.tools.lob import write_package

STUDY: dict[str, Any] = {
    "name": "study",
    "train_level": "waste",
    "levels": ["waste", "mild.yaml"],
    "picks": 32,
    "num_envs": 16,
    "seeds": [*range(6)],
    "entries": [{"label": "shift", "controller": "virtual_goal", "throws": [16, 32]}],
}
"""Twelve jobs of a second or two."""
MILD = {"base": "waste", "mismatch": 0.5}
TIMES = ("seconds", "learn_seconds")
"""What a job finds that no two runs have in common."""
OWN = """
import os
import pnt_gym
import theirs


def where(folder):
    home = [pnt_gym.__file__, theirs.__file__, os.getcwd()]
    return {"files": home, "threads": os.environ["OMP_NUM_THREADS"], "found": os.listdir(folder)}


def nothing(number, folder):
    return {"number": number}


def die(folder):
    os._exit(9)


def refuse(folder):
    raise pnt_gym.errors.PntGymError("there is no such throw")
"""


def timeless(found: Any) -> Any:
    if isinstance(found, dict):
        return {name: timeless(value) for name, value in found.items() if name not in TIMES}
    return [timeless(value) for value in found] if isinstance(found, list) else found


def fingerprint(found: Any) -> str:
    return hashlib.sha256(json.dumps(timeless(found), sort_keys=True).encode()).hexdigest()


def kept(folder: Path) -> dict[str, str]:
    """Fingerprints of what jobs have found, by the names of their files."""
    return {path.name: fingerprint(Part.read(path).results) for path in folder.glob("*.npz")}


@pytest.fixture
def study(here: Path) -> Path:
    (here / "plan.yaml").write_text(yaml.safe_dump(STUDY))
    (here / "mild.yaml").write_text(yaml.safe_dump(MILD))
    return here


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What the jobs of the study find one after the other in this process."""
    folder = tmp_path_factory.mktemp("serial")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("mild.yaml").write_text(yaml.safe_dump(MILD))
        planned = pieces(Plan.model_validate(STUDY))
        return {f"{p.name}-{p.key}.npz": fingerprint(run_piece(p, folder).results) for p in planned}


def begun(folder: Path, address: str) -> subprocess.Popen[str]:
    """The study as a user begins it, deaf to nothing."""
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from agents.benchmark.__main__ "
    code += "import Arguments, main, run; run(main, Arguments, 'agents.benchmark')"
    options = ["--config", "plan.yaml", "--out", "out.json", "--work", "kept", "--cluster", address]
    return subprocess.Popen(
        [sys.executable, "-c", code, *options],
        cwd=folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def at_work(process: subprocess.Popen[str], folder: Path, least: int, *machines: Any) -> None:
    """Wait until some jobs are done and every machine is at another one."""
    deadline = time.monotonic() + 120.0
    while time.monotonic() < deadline and process.poll() is None:
        if len(kept(folder / "kept")) >= least and all(map(workers, machines)):
            return
        time.sleep(0.05)
    raise AssertionError(f"it does not get on: {[*map(workers, machines)]}, {ended(process)}")


def places(machine: Any) -> list[str]:
    """Working folders of a machine's workers."""
    return [one.cwd() for one in workers(machine)]


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    said, stderr = process.communicate(timeout=180)
    complained = complaints(stderr)
    assert not complained.strip() or process.returncode != 0, complained
    return process.returncode, said + complained


@pytest.fixture(scope="module")
def first(machines: Machines) -> Any:
    """A machine that lives on."""
    return machines.join()


def test_work_of_a_machine_that_dies_is_done_by_another(
    machines: Machines, first: Any, study: Path, serial: dict[str, str]
) -> None:
    second = machines.join()
    process = begun(study, machines.address)
    at_work(process, study, 2, first, second)
    assert not {*places(first)} & {*places(second)}, "machines share a disk"
    before = len(kept(study / "kept"))
    victims = lose_power(second)
    code, said = ended(process)
    assert code == 0, said
    assert before < 12
    assert victims
    assert not any(one.is_running() and one.status() != psutil.STATUS_ZOMBIE for one in victims)
    found = kept(study / "kept")
    assert len(found) == 12
    assert found == serial
    assert len(re.findall(r"done: shift-\d+-seed\d \(\d+ s on \S+\)", said)) == 12
    assert all_gone(first)


def test_a_study_that_was_interrupted_goes_on(
    machines: Machines, first: Any, study: Path, serial: dict[str, str]
) -> None:
    (study / "plan.yaml").write_text(yaml.safe_dump(STUDY | {"seeds": [0, 1, 2, 3]}))
    process = begun(study, machines.address)
    at_work(process, study, 3, first)
    os.killpg(process.pid, signal.SIGINT)
    code, said = ended(process)
    assert code == 130
    assert said.endswith("interrupted\n")
    assert all_gone(first)
    done = kept(study / "kept")
    assert 3 <= len(done) < 8
    assert done.items() <= serial.items()
    code, said = ended(begun(study, machines.address))
    assert code == 0
    assert said.count("done: ") == 8 - len(done)
    found = kept(study / "kept")
    assert len(found) == 8
    assert found.items() <= serial.items()


def test_workers_end_with_a_command_that_was_killed(machines: Machines, first: Any, study: Path) -> None:
    process = begun(study, machines.address)
    at_work(process, study, 1, first)
    process.kill()
    process.communicate(timeout=60)
    assert all_gone(first)


@pytest.fixture
def theirs(here: Path) -> Iterator[Any]:
    """A module of the user's in the working folder, which imports another one of theirs."""
    write_package(here)
    (here / "jobs.py").write_text(OWN)
    sys.modules.pop("theirs", None)
    import jobs  # noqa: PLC0415

    yield jobs
    for name in ("jobs", "theirs", "lob"):
        sys.modules.pop(name, None)


NEEDS = Needs(("jobs", "theirs"))


@pytest.mark.usefixtures("first")
def test_code_and_modules_are_those_that_were_sent(machines: Machines, theirs: Any, tmp_path: Path) -> None:
    (found,) = do_missing([Job("a", "k", theirs.where)], tmp_path / "kept", pool(1, machines.address, NEEDS))
    assert all("runtime_resources/working_dir_files" in place for place in found["files"])
    assert (found["threads"], found["found"]) == ("1", [])


@pytest.mark.usefixtures("first")
def test_a_cluster_costs_little_of_a_job(machines: Machines, theirs: Any, tmp_path: Path) -> None:
    jobs = [Job(str(n), "k", partial(theirs.nothing, n)) for n in range(300)]
    with pool(1, machines.address, NEEDS)(jobs, tmp_path) as done:
        moments = [time.perf_counter() for _ in done]
    each = (moments[-1] - moments[0]) / (len(moments) - 1)
    print(f"{1000 * each:.1f} ms a job, the first one included {moments[-1] - moments[0]:.1f} s")
    assert each < 0.02 * 10.0  # 2 % of a job of ten seconds


@pytest.mark.usefixtures("first")
def test_what_a_job_says_and_how_it_ends_is_told(
    machines: Machines, theirs: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hands = pool(1, machines.address, NEEDS)
    with pytest.raises(PntGymError, match=r"^there is no such throw$"):
        do_missing([Job("ill", "k", theirs.refuse)], tmp_path, hands)
    monkeypatch.setattr(cluster, "RETRIES", 1)
    with pytest.raises(UsageError, match="the cluster could not do a job; run the command again to go on"):
        do_missing([Job("dead", "k", theirs.die)], tmp_path, hands)
    with pytest.raises(UsageError, match="'local' cannot be sent to another machine"):
        do_missing([Job("local", "k", lambda _: {})], tmp_path, hands)
    assert not [*tmp_path.glob("*.json")]


@pytest.mark.usefixtures("first", "theirs")
def test_training_and_what_is_of_the_user_travel(machines: Machines, here: Path) -> None:
    entries = [
        {"label": "plain", "controller": "analytic"},
        {"label": "theirs", "controller": "theirs:Better", "options": {"gain": 0.5}},
        {"label": "goal", "controller": "virtual_goal", "throws": [16]},
        {"label": "sac", "controller": "sac", "throws": [110]},
    ]
    own = {"env": "lob:Lob-v0", "train_level": "home", "levels": ["home"], "seeds": [0], "entries": entries}
    (here / "plan.yaml").write_text(yaml.safe_dump(STUDY | own))
    found = []
    for options in (["--cluster", machines.address], ["--jobs", "1"]):
        where = [f"--work={options[0]}", f"--out=out{options[0]}.json"]
        command = [sys.executable, "-m", "agents.benchmark", "--config", "plan.yaml", *where, *options]
        done = subprocess.run(command, cwd=here, env=environment(), capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        found.append(fingerprint(read_form(here / f"out{options[0]}.json").data))
    assert found[0] == found[1]


def test_throws_of_all_machines_make_one_dataset(machines: Machines, first: Any, here: Path) -> None:
    """Random actions, and a controller that has practised; one machine dies, and the file has the same bytes."""
    second = machines.join()
    small = ["--throws", "800", "--score-throws", "16", "--practice", "16", "--expert", "virtual_goal"]
    for options, doomed in ((["--cluster", machines.address], second), (["--jobs", "2"], None)):
        places = ["--work", "kept", "--root", f"sets{options[0]}"]
        command = [sys.executable, "-m", "agents.dataset", *small, *places, *options]
        process = subprocess.Popen(
            command, cwd=here, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        if doomed is not None:
            at_work(process, here, 0, first, second)
            time.sleep(2.0)
            assert lose_power(doomed)
        code, said = ended(process)
        assert code == 0, said
        assert not (here / "kept").exists()
    bytes_of = [path.read_bytes() for path in sorted(here.glob("sets*/pnt_gym/release/*/data/main_data.hdf5"))]
    assert len(bytes_of) == 2
    assert bytes_of[0] == bytes_of[1]
