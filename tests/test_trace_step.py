"""The trace of one step, which every environment has."""

import sys

import pytest

import pnt_gym
from benchmarks.trace_step import main, trace_step

CORES = {"Line": "LineCore.step", "Grasp": "GraspCore.step"}
"""Step of the core of an environment, by a part of its id; of the others it is that of `Core`."""


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_the_step_of_every_environment_is_traced(env_id):
    trace, info = trace_step(env_id)
    assert info.get("picked", env_id.startswith("OneJoint")), "a step whose pick failed throws nothing"
    assert "is_success" in info
    core = next((name for part, name in CORES.items() if part in env_id), "Core.step")
    assert [calls for (_, name), calls in trace.functions.items() if name.endswith(core)] == [1]
    assert 3 < trace.deepest <= len(trace.functions)


def test_a_throw_takes_a_short_way():
    trace, _ = trace_step("PnTConveyor-v0")
    assert len(trace.files) <= 47
    assert len(trace.functions) <= 230
    assert trace.deepest <= 15


def test_a_level_that_does_not_exist_is_one_sentence(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["trace_step", "--level", "nowhere"])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    assert "nowhere" in capsys.readouterr().err.splitlines()[-1]
