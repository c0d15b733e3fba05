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
from benchmarks.fuzz_cases.cases import KINDS, SHARES, judge_case
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
SAMPLE |= dict.fromkeys(FORMATS, 15)
SAMPLES = [*SAMPLE.items(), *((kind, 4 * count) for kind, count in SAMPLE.items())]


@pytest.mark.parametrize(("kind", "count"), with_nightly(SAMPLES, SAMPLES[: len(SAMPLE)]))
def test_no_case_of_a_sample_is_a_find(kind: str, count: int) -> None:
    assert {n: said for n in range(count) if (said := judge_case(kind, n)) is not None} == {}


def test_a_case_is_known_by_its_number() -> None:
    chosen = list(fuzz.cases(0, 200))
    assert chosen[25:] == list(fuzz.cases(25, 175))
    assert len(set(chosen)) == 200
    assert {kind for kind, _ in chosen} == set(KINDS) == set(SHARES)


def raising(error: BaseException) -> Any:
    def call(*_: Any, **__: Any) -> Any:
        raise error

    return call


def test_what_must_not_be_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    numbers = range(12)
    # Environments are made once, and would notice themselves that what they see is no number.
    assert not any(judge_case("action", n) for n in numbers)
    with monkeypatch.context() as patch:
        patch.setattr(Core, "step", raising(KeyError("x")))
        assert any("KeyError" in (judge_case("action", n) or "") for n in numbers)
    with monkeypatch.context() as patch:
        patch.setattr(Core, "observe", lambda self: np.full((self.count, *self.observation_space.shape), np.nan))
        assert any("is no number" in (judge_case("action", n) or "") for n in numbers)
    with monkeypatch.context() as patch:
        patch.setattr(Core, "step", raising(PhysicsError("MuJoCo warned")))
        assert any("taken, then PhysicsError" in (judge_case("level", n) or "") for n in numbers)
    with monkeypatch.context() as patch:
        patch.setattr(ToyVectorEnv, "step", raising(RuntimeError("x")))
        assert any("RuntimeError" in (judge_case("line", n) or "") for n in range(30))


def test_a_crash_and_a_hang_are_finds(tmp_path: Path) -> None:
    code = "import os, sys, time; from benchmarks import fuzz\nfuzz.PATIENCE = 5.0\n"
    code += "def judge(kind, n):\n"
    code += "    {1: lambda: os.abort(), 3: lambda: time.sleep(60)}.get(n, lambda: None)()\n"
    code += "if __name__ == '__main__':\n    finds = fuzz.finds([('x', n) for n in range(5)], judge)\n"
    code += "    print(*[said.split(' ')[0] or 'well' for _, _, said in finds])"
    (tmp_path / "script.py").write_text(code)
    done = run_python(tmp_path / "script.py", check=True)
    assert done.stdout.split() == ["well", "ends", "well", "hangs", "well"]


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
