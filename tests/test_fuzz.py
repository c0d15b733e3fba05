"""Samples of `make fuzz` and `make soak`, and that both find what they look for."""

import json
import sys
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from benchmarks import fuzz, soak, soak_walls
from benchmarks.fuzz_cases.basis import Draws, Find, find_simplest
from benchmarks.fuzz_cases.cases import KINDS, SHARES, judge_cases
from benchmarks.fuzz_cases.formats import FORMATS
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.plant import ConveyorPlant
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.one_joint.pallets import Pallet
from pnt_gym.errors import ConfigError, PhysicsError
from tests.tools.commands import run_python
from tests.tools.nightly import with_nightly
from tests.tools.toy_cell import ToyVectorEnv

SAMPLE = {"level": 10, "action": 20, "calls": 8, "line": 7, "file": 15, "output": 1, "infos": 1, "hours": 1}
SAMPLE |= {**dict.fromkeys(FORMATS, 15), "resumed-folder": 6}  # a third of a second each
DAILY = {kind: (count + 3) // 4 for kind, count in SAMPLE.items()}
SAMPLES = [*DAILY.items(), *((kind, 4 * count) for kind, count in SAMPLE.items())]


@pytest.mark.parametrize(("kind", "count"), with_nightly(SAMPLES, DAILY.items()))
def test_no_case_of_a_sample_is_a_find(kind: str, count: int) -> None:
    assert judge_cases(kind, 0, count) is None


def test_bunches_hold_every_kind_by_its_share() -> None:
    chosen = list(fuzz.bunches(SHARES, 10_000, 3))
    assert {bunch.kind for bunch in chosen} == set(KINDS) == set(SHARES)
    assert sum(bunch.count for bunch in chosen) == pytest.approx(10_000, abs=len(KINDS))
    assert [bunch.number for bunch in chosen if bunch.kind == "hours"] == [3]
    assert len({(bunch.kind, bunch.number) for bunch in chosen}) == len(chosen)


def drawn(number: int, low: float) -> str | None:
    """What is said of cases of three numbers one of which may be too large."""

    def case(draws: Draws) -> None:
        numbers = [draws.integer(1000) for _ in range(3)]
        if max(numbers) > low:
            raise Find(str(numbers))

    return find_simplest(case, number, 100)


def test_a_find_is_shown_by_the_simplest_case() -> None:
    assert drawn(0, 1000) is None
    assert drawn(0, 500) == drawn(1, 500) == "[0, 0, 501]"


def raising(error: BaseException) -> Any:
    def call(*_: Any, **__: Any) -> Any:
        raise error

    return call


@pytest.mark.parametrize(("kind", "owner", "name", "broken", "said"), [
    ("action", Core, "step", raising(KeyError("x")), "KeyError"),
    # Environments are made once, and would notice themselves that what they see is no number.
    ("action", Core, "observe", lambda self: np.full((self.count, *self.observation_space.shape), np.nan), "no number"),
    ("level", Core, "step", raising(PhysicsError("MuJoCo warned")), "taken, then PhysicsError"),
    ("line", ToyVectorEnv, "step", raising(RuntimeError("x")), "RuntimeError"),
])  # fmt: skip
def test_what_must_not_be_is_found(
    monkeypatch: pytest.MonkeyPatch, kind: str, owner: type[Any], name: str, broken: Any, said: str
) -> None:
    assert judge_cases(kind, 1, 12) is None
    monkeypatch.setattr(owner, name, broken)
    assert said in (judge_cases(kind, 1, 40) or "")


CRASHES = """
import os, time
from benchmarks import fuzz

def judge(kind, number, count, before):
    before(), before()
    return {1: os.abort, 2: lambda: time.sleep(600), 3: lambda: "wrong"}.get(number, lambda: None)()

if __name__ == "__main__":
    for number in range(4):
        fuzz.PATIENCE = 5.0 if number == 2 else 60.0
        print(fuzz.find(fuzz.Bunch("x", number, 2), judge))
"""


def test_a_crash_and_a_hang_are_finds(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(CRASHES)
    done = run_python(tmp_path / "script.py", check=True)
    assert done.stdout.splitlines() == [
        "",
        "ends its process with -6 in case 2",
        "hangs for more than 5 s in case 2",
        "wrong",
    ]


def test_a_value_that_an_environment_replaces_may_be_anything() -> None:
    env = gym.make("OneJointSort-v0", level={"task": object()})
    assert env.spec is not None
    assert "<object object" in env.spec.to_json()


def test_the_first_throw_of_a_level_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    form, level = pnt_gym.envs.conveyor.PnTReleaseEnv, {"mismatch": 0.5}
    form(level=level)
    with monkeypatch.context() as patch:
        patch.setattr(ConveyorPlant, "fly", raising(PhysicsError("MuJoCo warned")))
        with pytest.raises(ConfigError, match="level 'custom' cannot be thrown in: MuJoCo warned"):
            form(level=level)
        form(level="waste")  # which ships
    monkeypatch.setattr("pnt_gym.cells.conveyor.cell.ConveyorCell.reward", lambda *_: {"landing": np.array([np.nan])})
    with pytest.raises(ConfigError, match="level 'custom' gives results that are not finite"):
        form(level=level)


SOAKED = [("PnTRelease-v0", "unseen"), ("OneJointSort-v0", "nominal"), ("GripperToss-v0", "belt")]
THROWN = {**soak.THROWN, "duration": 5.0}


@pytest.mark.parametrize(
    ("env_id", "level"), with_nightly([*SOAKED, ("PnTLine-v0", THROWN)], [SOAKED[0], ("PnTLine-v0", THROWN)])
)
def test_a_sample_of_the_soak(env_id: str, level: Any) -> None:
    assert soak.soak_round(env_id, level, 0) == []


def test_every_level_of_a_line_is_soaked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pnt_gym, "ENV_IDS", ("PnTLine-v0",))
    levels = [level["name"] for _, level in soak.pairs()]
    assert levels == [*LineConfig.level_names(), "skills3, thrown"]


def in_the_way(pallet: Pallet) -> np.ndarray:
    """Thin walls across the path of a part that arrives, before and behind its goal."""
    x, y, phi = pallet.pose
    return np.array([[x + side * np.cos(phi), y + side * np.sin(phi), 0.001, 0.2, phi] for side in (-0.05, 0.05)])


@pytest.mark.parametrize(("env_id", "level"), [*SOAKED, ("PnTLine-v0", THROWN)])
def test_an_object_that_goes_through_a_wall_is_found(monkeypatch: pytest.MonkeyPatch, env_id: str, level: Any) -> None:
    """Walls where there are none: across the way, or the bottom of a bin higher than it is."""
    panels, tray = soak_walls.bin_panels, soak_walls.tray_panels
    monkeypatch.setattr(soak_walls, "bin_panels", lambda *given: (panels(*given)[0], panels(*given)[1] + [0, 0, 0.1]))
    monkeypatch.setattr(soak_walls, "tray_panels", lambda *given: (tray(*given)[0], tray(*given)[1] + [0, 0, 0.1]))
    monkeypatch.setattr(Pallet, "walls", property(in_the_way))
    monkeypatch.setattr(soak, "ACTIONS", (0.0,))
    (said,) = soak.soak_round(env_id, level, 0)
    assert " went through " in said


def test_fast_centres_cross_and_flat_ones_dip() -> None:
    half, free = np.array([[0.1, 0.1, 0.005]]), np.ones((1, 4), dtype=bool)
    for heights, crossed in (((0.03, 0.01, -0.02, -0.03), [1]), ((0.01, 0.002, 0.001, 0.02), [])):
        offset = np.zeros((1, 4, 3))
        offset[0, :, 2] = heights
        assert np.flatnonzero(soak_walls.crossings(offset, half, free)).tolist() == crossed
        assert not soak_walls.crossings(np.add(offset, [0.2, 0, 0]), half, free).any()


@pytest.mark.parametrize(("below_edge", "crossed"), [(0.002, []), (0.008, [0])])
def test_centres_pass_over_an_edge_and_through_a_wall_below_its_edge(below_edge: float, crossed: list[int]) -> None:
    half, free = np.array([[0.1, 0.005, 0.1]]), np.ones((1, 2), dtype=bool)
    offset = np.array([[[0.0, -0.001, 0.1 - below_edge], [0.0, 0.001, 0.1 - below_edge]]])
    assert np.flatnonzero(soak_walls.crossings(offset, half, free)).tolist() == crossed


def test_a_soak_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(soak, "pairs", lambda: [("PnTRelease-v0", "ideal")])
    monkeypatch.setattr(soak, "soak_round", lambda *_: [])
    assert 10.0 < soak.memory() < 1e5
    monkeypatch.setattr(soak, "memory", lambda: 100.0)
    for throws, rounds in ((100, 2), (100, 2), (300, 5)):
        monkeypatch.setattr(
            sys, "argv", ["soak", "throws", "--throws", str(throws), "--state", str(tmp_path / "s.json")]
        )
        assert soak.main() == 0
        assert json.loads((tmp_path / "s.json").read_text())["rounds"] == rounds
    monkeypatch.setattr(soak, "soak_round", lambda *_: ["something"])
    monkeypatch.setattr(sys, "argv", ["soak", "throws", "--throws", "400", "--state", str(tmp_path / "s.json")])
    assert soak.main() == 1
