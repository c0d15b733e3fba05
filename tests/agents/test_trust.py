"""Files of strangers: whatever lies in them, nothing of it runs unless the user says `--trust`."""

import base64
import json
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, final
from zipfile import ZipFile

import cloudpickle
import numpy as np
import pytest
import yaml

from tests.tools.benchmark import toy_plan
from tests.tools.commands import answered, refused


@final
class Bomb:
    """What makes a file as soon as it is unpickled."""

    def __init__(self, canary: Path) -> None:
        self.canary = canary

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.canary,)


@pytest.fixture
def canary(tmp_path: Path) -> Path:
    return tmp_path / "canary"


def rewritten(file: Path, change: Callable[[str, bytes], bytes]) -> None:
    """A zip with its members changed."""
    with ZipFile(file) as old:
        members = {name: change(name, old.read(name)) for name in old.namelist()}
    with ZipFile(file, "w") as new:
        for name, data in members.items():
            new.writestr(name, data)


def poisoned(file: Path, canary: Path, *names: str) -> None:
    """A model with bombs in some members of its data; in all that stable-baselines3 unpickles if none is named."""
    bomb = {":type:": "x", ":serialized:": base64.b64encode(cloudpickle.dumps(Bomb(canary))).decode()}

    def change(name: str, data: bytes) -> bytes:
        if name != "data":
            return data
        told = json.loads(data)
        chosen = names or [key for key, value in told.items() if isinstance(value, dict)]
        return json.dumps({**told, **{key: {**told[key], **bomb} for key in chosen}}).encode()

    rewritten(file, change)


def commands(run: Path, kept: Path) -> list[tuple[Any, ...]]:
    """Every command that reads a run folder."""
    return [
        ("agents.evaluate", "--controller", run, "--picks", 4, "--num-envs", 4),
        ("agents.publish", run, "--picks", 4, "--to", kept, "--no-video"),
        ("agents.train", "--resume", run, "--steps", 20, "--eval-picks", 0),
    ]


def test_the_bomb_is_one(run: Path, canary: Path, tmp_path: Path) -> None:
    poisoned(run / "model.zip", canary, "lr_schedule")
    shutil.copy(run / "model.zip", tmp_path / "theirs.zip")
    door = ("--controller", tmp_path / "theirs.zip", "--env", "ToyThrow-v0", "--picks", 4, "--num-envs", 4)
    said = refused("agents.evaluate", *door)
    assert "runs whatever code its author put in; give --trust if you trust its source" in said
    assert not canary.exists()
    answered("agents.evaluate", *door, "--trust")
    assert canary.exists()


@pytest.mark.parametrize("names", [("lr_schedule",), ()], ids=["schedule", "all"])
def test_code_in_the_data_of_a_model_is_not_read(run: Path, canary: Path, tmp_path: Path, names: tuple[str]) -> None:
    for file in run.rglob("model.zip"):
        poisoned(file, canary, *names)
    for command in commands(run, tmp_path / "kept"):
        code, words = answered(*command)
        assert code == 0, words
    assert not canary.exists()


def pickled(file: Path, canary: Path) -> None:
    file.write_bytes(pickle.dumps(Bomb(canary)))


def bomb_for_weights(file: Path, canary: Path) -> None:
    rewritten(file, lambda name, old: pickle.dumps(Bomb(canary)) if name == "policy.pth" else old)


def bomb_for_spaces(file: Path, canary: Path) -> None:
    def change(name: str, data: bytes) -> bytes:
        bomb = {":serialized:": base64.b64encode(pickle.dumps(Bomb(canary))).decode()}
        return json.dumps({**json.loads(data), "observation_space": bomb}).encode() if name == "data" else data

    rewritten(file, change)


def policy_of_objects(file: Path, canary: Path) -> None:
    with np.load(file) as parts:
        known = {name: parts[name] for name in parts.files}
    np.savez(file, **{**known, "weight_0": np.array([Bomb(canary)], dtype=object)})


def code_in_yaml(file: Path, canary: Path) -> None:
    file.write_text(f"env: !!python/object/apply:os.system ['touch {canary}']\n")


ACTS, KEEPS, LEARNS = "agents.evaluate", "agents.publish", "agents.train"


@pytest.mark.parametrize(
    ("name", "bomb", "refusing"),
    [
        ("policy.npz", pickled, {ACTS, KEEPS}),
        ("policy.npz", policy_of_objects, {ACTS, KEEPS}),
        ("model.zip", bomb_for_weights, {KEEPS, LEARNS}),
        ("model.zip", bomb_for_spaces, {KEEPS}),  # who learns has the spaces of the environment
        ("model.zip", pickled, {KEEPS, LEARNS}),
        ("args.yml", code_in_yaml, {ACTS, KEEPS, LEARNS}),
        ("config.yml", code_in_yaml, {KEEPS, LEARNS}),
    ],
)
def test_a_run_folder_with_code_in_it_is_damaged_for_those_who_read_it(
    run: Path, canary: Path, tmp_path: Path, name: str, bomb: Callable[[Path, Path], None], refusing: set[str]
) -> None:
    for file in run.rglob(name):
        bomb(file, canary)
    if ACTS in refusing:
        assert str(run) in refused("agents.play", "--controller", run, "--picture", tmp_path / "x.png")
    for command in commands(run, tmp_path / "kept"):
        if command[0] in refusing:
            assert str(run) in refused(*command)
        else:
            assert answered(*command)[0] == 0
    assert not canary.exists()


@pytest.mark.parametrize("name", ["random.json", "replay_buffer.npz"])
@pytest.mark.parametrize("kind", ["pickle", "objects"])
def test_memory_and_random_state_carry_no_code(run: Path, canary: Path, name: str, kind: str) -> None:
    file = run / "checkpoints" / "00000016" / name
    with file.open("wb") as out:
        if kind == "pickle":
            pickle.dump(Bomb(canary), out)
        else:
            objects = np.array([Bomb(canary)], dtype=object)
            np.savez(out, pos=objects, full=objects, observations=objects)
    assert "checkpoint 00000016 is truncated" in refused("agents.train", "--resume", run, "--steps", 20)
    assert not canary.exists()


def test_what_a_controller_saved_carries_no_code(tmp_path: Path, canary: Path) -> None:
    objects = np.array([Bomb(canary)], dtype=object)
    np.savez(tmp_path / "ridge.npz", controller=np.array("ridge"), gain=objects, weights=objects)
    (tmp_path / "pickle.npz").write_bytes(pickle.dumps(Bomb(canary)))
    for name in ("ridge.npz", "pickle.npz"):
        call = ("--env", "ToyThrow-v0", "--controller", "ridge", "--load", tmp_path / name)
        assert "holds no saved controller" in refused("agents.evaluate", *call)
    assert not canary.exists()


def test_statistics_of_an_rl_zoo_folder_need_trust(run: Path, canary: Path, tmp_path: Path) -> None:
    inner = tmp_path / "zoo" / "ToyThrow-v0"
    inner.mkdir(parents=True)
    shutil.copy(run / "model.zip", tmp_path / "zoo" / "ToyThrow-v0.zip")
    (inner / "args.yml").write_text("env: ToyThrow-v0\n")
    (inner / "config.yml").write_text("gamma: 0.0\n")
    (inner / "vecnormalize.pkl").write_bytes(pickle.dumps(Bomb(canary)))
    door = ("--controller", tmp_path / "zoo", "--picks", 4, "--num-envs", 4)
    assert "give --trust" in refused("agents.evaluate", *door)
    assert "give --trust" in refused("agents.play", *door[:2], "--picture", tmp_path / "x.png")
    assert "is not a run folder" in refused("agents.publish", tmp_path / "zoo", "--to", tmp_path)
    assert "is not a run folder" in refused("agents.train", "--resume", tmp_path / "zoo")
    assert not canary.exists()
    assert "is damaged, or of other observations" in refused("agents.evaluate", *door, "--trust")
    assert canary.exists()


@pytest.mark.parametrize("reference", ["subprocess:call", "subprocess:Popen", "os:system", "subprocess:run"])
def test_a_plan_calls_nothing_but_controllers(reference: str, tmp_path: Path, canary: Path) -> None:
    entry = {"label": "a", "controller": reference, "options": {"args": f"touch {canary}", "shell": True}}
    (tmp_path / "plan.yaml").write_text(yaml.safe_dump(toy_plan(entry)))
    command = ("--config", tmp_path / "plan.yaml", "--work", tmp_path / "work", "--out", tmp_path / "out.json")
    refused("agents.benchmark", *command, "--jobs", "1")
    assert not canary.exists()
