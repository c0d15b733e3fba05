"""What another machine gets: all of the code, what it imports of the user's, and nothing else."""

import json
import os
from pathlib import Path

import pytest

from agents.ground import parcel
from agents.ground.cli import UsageError
from agents.ground.parcel import PARTS, identity, pack
from agents.ground.places import SHIPPED as ROOT
from tests.tools.commands import run_python

POLICY = "results/policies/PnTLine-v0/value/residual_ppo/policy.npz"
SAY = """
import json
from agents.ground.parcel import identity
from pnt_gym.planning.straight.kernel import choose_slopes
print(json.dumps([identity(["theirs"], True), len(choose_slopes.stats.cache_hits)]))
"""


@pytest.fixture
def sent(here: Path, tmp_path: Path) -> Path:
    """What is sent with modules of the user's."""
    pack(tmp_path, ["theirs", "lob", "lob.inner", "agents.policies.actor"])
    return tmp_path


def test_code_and_modules_are_there_and_nothing_else(sent: Path) -> None:
    assert {path.name for path in sent.iterdir()} == {*(part.partition("/")[0] for part in PARTS), "theirs.py", "lob"}
    assert [path.name for path in (sent / "results").iterdir()] == ["policies"]
    assert not [*sent.rglob("*.pyc*")]
    for part in ("pnt_gym/cells/base/items.yaml", "configs/cells/conveyor/waste.yaml", "agents/ground/work.py", POLICY):
        assert (sent / part).read_bytes() == (ROOT / part).read_bytes()
    texts = [path for path in sent.rglob("*") if path.is_file() and path.suffix not in (".nbi", ".nbc")]
    assert sum(path.stat().st_size for path in texts) < 12e6


@pytest.mark.nightly
@pytest.mark.usefixtures("here")
def test_it_computes_elsewhere_what_it_computes_here(tmp_path: Path) -> None:
    """In a process that knows no other place, on one core, with the machine code that was made here."""
    known = identity(["theirs"], True)
    pack(tmp_path, ["theirs"])
    told = {**os.environ, "PYTHONPATH": str(tmp_path), "OMP_NUM_THREADS": "1"}
    done = run_python("-W", "ignore", "-c", SAY, cwd=tmp_path, env=told)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [known, 1]


@pytest.mark.usefixtures("here")
def test_what_differs_is_told_by_name() -> None:
    found = identity(["theirs"], False)
    parcel.check(found, ["theirs"], False)
    for name, said in (
        ("code", "runs other code of pnt_gym than this machine"),
        ("numpy", f"has numpy {found['numpy']}, here it is another; a study needs the same everywhere"),
        ("module theirs", f"has module theirs {parcel.digest('theirs')[:12]}, here it is another"),
        ("arithmetic", "rounds otherwise than this machine"),
    ):
        with pytest.raises(UsageError, match=f"^node '.+' {said}"):
            parcel.check(found | {name: "another"}, ["theirs"], False)


def test_modules_that_cannot_travel(here: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (here / "bare").mkdir()
    with pytest.raises(UsageError, match="module 'bare' lies in no file"):
        pack(tmp_path, ["bare"])
    with pytest.raises(UsageError, match="module 'nowhere' cannot be imported"):
        pack(tmp_path / "two", ["nowhere"])
    monkeypatch.setattr(parcel, "_MOST", 10)
    with pytest.raises(UsageError, match="module 'lob' takes 0 MB; at most 0 MB are sent"):
        pack(tmp_path / "three", ["lob"])
