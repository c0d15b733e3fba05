"""Models that others have trained: single files of stable-baselines3, and folders as RL-Zoo leaves them."""

import shutil
from collections import OrderedDict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from stable_baselines3 import A2C, DDPG, PPO, SAC, TD3
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from agents.controllers import Observation, make_controller
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector
from agents.learning import trained
from agents.learning.sb3 import load_policy
from tests.tools.commands import figures_of, output_of
from tests.tools.models import Space, model


@pytest.mark.parametrize("algorithm", [SAC, TD3, DDPG, PPO, A2C, "TQC"])
def test_the_algorithm_of_a_model_is_read_from_its_file(tmp_path: Path, algorithm: Any) -> None:
    if algorithm == "TQC":
        algorithm = pytest.importorskip("sb3_contrib").TQC
    saved = model(algorithm)
    saved.save(tmp_path / "model.zip")
    found = load_policy(tmp_path / "model.zip")
    assert issubclass(algorithm, type(found)) or isinstance(found, algorithm)  # TD3 for DDPG, BanditSAC for SAC
    seen = np.linspace(-1.0, 1.0, 8, dtype=np.float32).reshape(4, 2)
    for one, other in zip(*(m.predict(seen, deterministic=True)[0] for m in (saved, found)), strict=True):
        assert one == other


@pytest.fixture
def zoo(here: Path, tmp_path: Path) -> Path:
    """A folder as RL-Zoo leaves it, of a policy whose observations were normalised."""
    place = tmp_path / "logs" / "sac" / "Lob-v0_1"
    inner = place / "Lob-v0"
    inner.mkdir(parents=True)
    normalised = VecNormalize(DummyVecEnv([Space]), norm_reward=False)
    learner = model(SAC, normalised)
    learner.learn(60)
    learner.save(place / "Lob-v0")
    learner.save(place / "best_model")
    normalised.save(str(inner / "vecnormalize.pkl"))
    asked = {"algo": "sac", "env": "OneJointThrow-v0", "env_kwargs": {"level": "ideal"}, "gym_packages": ["pnt_gym"]}
    settings = {"gamma": 0.0, "normalize": "{'norm_obs': True}", "train_freq": (1, "step")}
    for name, told in (("args", asked), ("config", settings)):
        (inner / f"{name}.yml").write_text(yaml.dump(OrderedDict(told)))
    return place


def test_a_folder_of_rl_zoo_is_understood(zoo: Path) -> None:
    found = trained.find(zoo)
    assert found.task == {"env": "OneJointThrow-v0", "level": "ideal"}
    assert (found.model.name, found.statistics) == ("Lob-v0.zip", zoo / "Lob-v0" / "vecnormalize.pkl")
    env = make_vector("lob:Lob-v0", num_envs=4)
    seen = Observation(env.reset(seed=1)[0], np.zeros(4, dtype=np.int64))
    theirs = VecNormalize.load(str(found.statistics), DummyVecEnv([Space]))
    normal = load_policy(found.model).predict(theirs.normalize_obs(seen.features), deterministic=True)[0]
    np.testing.assert_array_equal(make_controller(str(zoo), env, trust=True).act(seen), normal)
    assert not np.allclose(make_controller(str(found.model), env, trust=True).act(seen), normal)
    shutil.copy(str(found.statistics), zoo)
    np.testing.assert_array_equal(make_controller(str(found.model), env, trust=True).act(seen), normal)


def test_a_folder_of_rl_zoo_on_the_command_line(zoo: Path, here: Path) -> None:
    options = "--env lob:Lob-v0 --level home --picks 4 --trust"
    assert figures_of(f"evaluate --controller {zoo} {options}", here)["picks"] == 4
    by_folder, by_model = (
        " ".join(output_of(f"evaluate --controller {place} {options}", here).split())
        for place in (zoo, zoo / "Lob-v0.zip")
    )
    assert "gets observations normalised by " in by_folder
    assert "gets raw observations: no vecnormalize.pkl lies beside Lob-v0.zip" in by_model
    assert trained.resolve(str(zoo), None, None, None) == ("OneJointThrow-v0", "ideal", None)


CODE = b"!!python/object/apply:os.system ['echo run > ran']\n"


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        ({"Lob-v0.zip": None, "best_model.zip": None}, r"holds neither Lob-v0\.zip nor best_model\.zip"),
        ({"Lob-v0/config.yml": b"env_wrapper: somebody.Wrapper\n"}, "was trained with env_wrapper"),
        ({"Lob-v0/args.yml": CODE}, "cannot be read as RL-Zoo writes it"),
        ({"Lob-v0.zip": b"PK of nothing"}, r"Lob-v0\.zip is truncated or not a model"),
        ({"Lob-v0/vecnormalize.pkl": b"nothing"}, "is damaged, or of other observations"),
    ],
)
def test_a_damaged_folder_of_rl_zoo_is_one_sentence(zoo: Path, damage: dict[str, bytes | None], said: str) -> None:
    """Files that are not there, or that hold something else."""
    for name, content in damage.items():
        if content is None:
            (zoo / name).unlink()
        else:
            (zoo / name).write_bytes(content)
    with pytest.raises(UsageError, match=said) as refused:
        make_controller(str(zoo), make_vector("lob:Lob-v0"), trust=True)
    assert "\n" not in str(refused.value)
    assert not Path("ran").exists()


def test_the_best_model_stands_in_for_a_run_cut_short(zoo: Path) -> None:
    (zoo / "Lob-v0.zip").unlink()
    assert trained.find(zoo).model.name == "best_model.zip"
