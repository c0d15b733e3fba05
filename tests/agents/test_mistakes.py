"""Wrong command lines and wrong files: one sentence that names what is wrong, exit code 2, and nothing left behind."""

import json
import shutil
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
import yaml

from agents.ground.cli import describe_error
from agents.ground.places import POLICY
from benchmarks.kill_trials.commands import LEARNER
from pnt_gym.errors import PhysicsError
from pnt_gym.reading import yaml_text
from tests.tools.commands import answered, output_of, refused
from tests.tools.toy_cell import ToyVectorEnv

START = ("--env", "ToyThrow-v0", "--steps", "8", "--num-envs", "4", "--eval-picks", "0", "--out", "run")
ANALYTIC = ("agents.evaluate", "--controller", "analytic")


YAML = {
    "date": ("bins: 2020-13-45", ""),
    "binary": (bytes(range(256)), "not UTF-8"),
    "twice": ("bins: 1\nbins: 2", "key 'bins' is given twice: line 2"),
    "list": ("[1, 2]", ""),
    "text": ("nothing", ""),
    "empty": ("", ""),
}


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run folder with a model; the policies that ship are without theirs."""
    place = tmp_path_factory.mktemp("trained")
    output_of("train --env PnTRelease-v0 --level waste --fidelity flight --steps 32 --eval-picks 0 --out run", place)
    return place / "run"


@pytest.mark.parametrize("name", YAML)
def test_yaml_that_is_none(desk: Path, name: str) -> None:
    text, said = YAML[name]
    (desk / "x.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
    shutil.copytree(POLICY, desk / "kept")
    shutil.copy(desk / "x.yaml", desk / "kept" / "args.yml")
    for command in (
        (*ANALYTIC, "--level", "x.yaml", "--picks", "1"),
        ("agents.train", *START, "--config", "x.yaml"),
        ("agents.benchmark", "--config", "x.yaml"),
        ("agents.evaluate", "--controller", "kept"),
    ):
        assert said in refused(*command)


HYPERPARAMETERS = [
    ({"batch_size": -1}, "hyperparameter batch_size is -1; it must be a whole number from 1"),
    ({"batch_size": True}, "hyperparameter batch_size is True"),
    ({"gamma": float("nan")}, "hyperparameter gamma is nan; it must be a number from 0 to 1"),
    ({"gamma": 1.5}, "hyperparameter gamma is 1.5"),
    ({"tau": "inf"}, "hyperparameter tau is 'inf'; it must be a number from 0 to 1"),
    ({"buffer_size": 0}, "hyperparameter buffer_size is 0; it must be a whole number from 1"),
    ({"buffer_size": 1e11}, "hyperparameter buffer_size is 100000000000.0"),
    ({"buffer_size": "1e11"}, "whole number from 1 to 1000000000; write 1e11 without quotes"),
    ({"gamma": "0.9"}, "hyperparameter gamma is '0.9'; it must be a number from 0 to 1; write 0.9 without quotes"),
    ({"policy_kwargs": {"net_arch": [10**5, 10**5]}}, "net_arch asks for 10,000,000,000 weights"),
    ({"policy_kwargs": {"net_arch": [-1]}}, "hyperparameter net_arch is [-1]; it must be a list of whole numbers"),
    ({"policy_kwargs": {"net_arch": {"pi": [0], "qf": [8]}}}, "hyperparameter net_arch is"),
    ({"policy_kwargs": {"net_arch": 5}}, "hyperparameter net_arch is 5"),
    ({"policy_kwargs": {"activation_fn": "nn.SiLU"}}, "do not fit sac"),
    ({"policy_kwargs": "dict(activation_fn=nn.functional)"}, "policy_kwargs is"),
    ({"policy_kwargs": {"log_std_init": float("nan")}}, "hyperparameter log_std_init is nan"),
    ({"policy_kwargs": 5}, "policy_kwargs is 5; it must be a mapping"),
    ({"gradient_steps": 0.5}, "hyperparameter gradient_steps is 0.5; it must be a whole number from -1"),
    ({"action_noise": "abc"}, "hyperparameter action_noise is 'abc'; it must be left out"),
    ({"learning_rate": "fast"}, "hyperparameter learning_rate is 'fast'"),
    ({"learning_rate": "lin_fast"}, "learning_rate is 'lin_fast'; it must be a number from 0 to 1, or lin_ and such"),
    ({"learning_rate": "lin_2"}, "hyperparameter learning_rate is 'lin_2'"),
    ({"gamma": "lin_0.9"}, "hyperparameter gamma is 'lin_0.9'; it must be a number from 0 to 1"),
    ({"ent_coef": float("inf")}, "hyperparameter ent_coef is inf"),
    ({"ent_coef": "some"}, "do not fit sac"),
    ({"use_sde": "yes please"}, "hyperparameter use_sde is 'yes please'; it must be true or false"),
    ({"policy": "NobodysPolicy"}, "do not fit sac"),
    ({"colour": "red"}, "do not fit sac: unknown hyperparameter 'colour'; known are "),
    ({"gama": 0.5}, "do not fit sac: unknown hyperparameter 'gama'; did you mean 'gamma'? known are "),
    ({5: 6}, "do not fit sac: unknown hyperparameter 5; known are "),
]


@pytest.mark.parametrize(("wrong", "said"), HYPERPARAMETERS, ids=str)
def test_wrong_hyperparameters_leave_no_folder(desk: Path, wrong: dict[Any, Any], said: str) -> None:
    (desk / "sac.yml").write_text(yaml_text({"default": {**LEARNER, **wrong}}))
    assert said in refused("agents.train", *START, "--config", "sac.yml")
    assert [path.name for path in desk.iterdir()] == ["sac.yml"]


def test_a_failed_start_does_not_block_the_next(desk: Path) -> None:
    (desk / "sac.yml").write_text(yaml.safe_dump({"default": LEARNER}))
    command = ("agents.train", *START, "--config", "sac.yml")
    for failure in (PhysicsError("MuJoCo warned"), MemoryError(), OSError(28, "No space left on device")):
        with patch.object(ToyVectorEnv, "step", side_effect=failure):
            assert describe_error(failure) in refused(*command)
        assert not (desk / "run").exists()
    assert answered(*command)[0] == 0
    # What was learned already is not thrown away.
    with patch.object(ToyVectorEnv, "step", side_effect=MemoryError):
        refused("agents.train", "--resume", "run", "--steps", "16")
    assert answered("agents.train", "--resume", "run", "--steps", "16", "--eval-picks", "0")[0] == 0


@pytest.mark.parametrize("share", [0.0, 0.001, 0.5, 0.9, 0.9999])
def test_a_torn_model(trained: Path, desk: Path, share: float) -> None:
    shutil.copytree(trained, desk / "kept")
    for name in ("model.zip", "policy.npz"):  # the second is torn while the first is torn already
        file = desk / "kept" / name
        file.write_bytes(file.read_bytes()[: int(share * file.stat().st_size)])
        assert f"{name} is truncated" in refused("agents.publish", "kept", "--to", ".")
    assert "policy.npz is truncated" in refused("agents.evaluate", "--controller", "kept", "--picks", "4")
    assert sorted(path.name for path in desk.iterdir()) == ["kept"]


def test_a_policy_that_is_not_its_models(trained: Path, desk: Path) -> None:
    shutil.copytree(trained, desk / "kept")
    file = desk / "kept" / "policy.npz"
    with np.load(file) as parts:
        found = {name: parts[name] for name in parts.files}
    np.savez(file, **{**found, "bias_1": np.nextafter(found["bias_1"], np.float32(1.0))})
    assert "policy.npz and model.zip are from different moments" in refused("agents.publish", "kept", "--to", ".")


def test_a_run_of_before_there_were_policies(trained: Path, desk: Path) -> None:
    shutil.copytree(trained, desk / "kept")
    (desk / "kept" / "policy.npz").unlink()
    said = "policy.npz is missing; before 0.2.0 none was written: its model.zip can be used with --trust"
    for command in (
        ("agents.evaluate", "--controller", "kept"),
        ("agents.play", "--controller", "kept", "--picture", "x.png"),
        ("agents.publish", "kept", "--to", "."),
    ):
        assert said in refused(*command)
    old = ("--controller", "kept/model.zip", "--trust", "--env", "PnTRelease-v0", "--level", "waste", "--picks", "16")
    assert answered("agents.evaluate", *old)[0] == 0
    (desk / "kept" / "model.zip").unlink()
    assert "policy.npz is missing\n" in refused("agents.evaluate", "--controller", "kept")


@pytest.mark.parametrize(
    ("name", "value"),
    [("algo", "ppo"), ("algo", [1]), ("algo", "dqn"), ("seed", "x"), ("env", 5), ("num_envs", None), ("level", [])],
)
def test_arguments_of_another_run(desk: Path, name: str, value: object) -> None:
    shutil.copytree(POLICY, desk / "kept")
    file = desk / "kept" / "args.yml"
    file.write_text(yaml.safe_dump({**yaml.safe_load(file.read_text()), name: value}))
    refused("agents.publish", "kept", "--to", ".", "--picks", "4")
    if value != "ppo":  # only the model tells
        refused("agents.evaluate", "--controller", "kept", "--picks", "4")


def test_a_level_whose_name_is_a_path_is_not_published(desk: Path) -> None:
    shutil.copytree(POLICY, desk / "kept")
    for text in ("name: ../../up\n", "name: 5\n", "[]\n"):
        (desk / "kept" / "env.yaml").write_text(text)
        assert "env.yaml has name" in refused("agents.publish", "kept", "--to", "to")
    assert not (desk / "to").exists()


STATES: list[tuple[str, dict[str, Any]]] = [
    ("ridge", {"weights": np.zeros((2, 3))}),
    ("ridge", {"gain": np.zeros(2), "centre": np.zeros((2, 9)), "weights": np.zeros((2, 3)), "offset": np.zeros(5)}),
    ("virtual_goal", {"buckets": np.array(["a"])}),
    ("virtual_goal", {"shift": np.zeros((1, 5)), "buckets": np.array(["a"]), "count": np.zeros(1)}),
    ("virtual_goal", {"shift": np.array("x"), "buckets": np.array(["a"]), "count": np.zeros(1)}),
    ("mlp", {"weight_0": np.zeros((2, 3))}),
    ("mlp", {"weight_0": np.zeros(3), "bias_0": np.zeros(3), "centre": np.zeros(2), "scale": np.zeros(1)}),
]


@pytest.mark.parametrize(
    ("name", "state"), STATES, ids=lambda value: value if isinstance(value, str) else "-".join(value)
)
def test_a_saved_controller_of_another_shape(desk: Path, name: str, state: dict[str, Any]) -> None:
    np.savez(desk / "x.npz", controller=np.array(name), **state)
    call = ("--env", "ToyThrow-v0", "--controller", name, "--load", "x.npz", "--picks", "4", "--num-envs", "4")
    refused("agents.evaluate", *call)


RESULTS: list[tuple[Any, str]] = [
    (
        {"plan": {}, "table": [], "comparisons": [], "results": []},
        "key 'versions' is missing\n- key 'seconds' is missing\n- key 'trial' is missing",
    ),
    ({"plan": 5, "table": 5, "comparisons": 5, "results": 5}, "plan is 5: input should be"),
    (
        {"study": "physics", "rows": [{"part": 5}], "throws": 10},
        "2 problems:\n- key 'version' is missing\n- key 'seed' is missing\n",
    ),
    ({"plan_release_us": "fast", "batch_plans_per_s": 5}, "of another form"),
    ({"envs": {"a": {}}, "cpus": 1}, "of another form"),
    ({"rows": [{}], "papers": ["p"], "figures": {}}, "key 'command' is missing"),
    ({"papers": ["p"], "rows": [], "figures": {"p": []}, "overview": {}}, "key 'grids' is missing"),
]
DRAWINGS = ["/etc/hostname", "../secret.svg", "a/b.svg", "x.png", "", "<script>.svg", "](x).svg"]
RECORD: dict[str, Any] = {
    "command": "", "versions": {}, "seconds": {}, "papers": ["p"], "titles": {"p": ""}, "data": {"p": {}},
    "overview": {"p": {"grids": {}, "notes": {}}}, "grids": {"p": []}, "rows": [],
}  # fmt: skip
RESULTS += [({**RECORD, "figures": {"p": [name]}}, "is no name of an .svg") for name in DRAWINGS]


@pytest.mark.parametrize(("data", "said"), RESULTS, ids=str)
def test_results_of_another_form(desk: Path, data: object, said: str) -> None:
    (desk / "reproduction.json").write_text(json.dumps(data))
    assert said in refused("agents.report", "--results", ".", "--readme", "none.md")
    assert [path.name for path in desk.iterdir()] == ["reproduction.json"]


@pytest.mark.parametrize("text", ["", "{", "nothing", "[" * 20_000, "1" * 5000, '{"a": NaN'], ids=lambda t: t[:8])
def test_results_that_are_no_json(desk: Path, text: str) -> None:
    (desk / "x.json").write_text(text)
    assert "not valid JSON" in refused("agents.report", "--results", ".")


def test_choices_are_those_that_one_can_type(desk: Path) -> None:
    del desk
    for command in (("agents.play", "--viewer", "webb"), (*ANALYTIC, "--picks", "few")):
        assert "None" not in refused(*command)
