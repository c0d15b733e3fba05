"""What others bring: controllers, environments and policies of theirs, on the command line and from Python."""

import json
from pathlib import Path

import gymnasium as gym
import imageio.v3 as iio
import numpy as np
import pytest
import yaml
from gymnasium.vector import SyncVectorEnv
from stable_baselines3 import PPO, SAC

import pnt_gym
from agents import train
from agents.controllers import make_controller
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector
from agents.judging.evaluation import evaluate
from agents.judging.loop import practise, throw_held_out
from agents.judging.throw_record import summary
from agents.learning import trained
from agents.publish import __main__ as publish
from tests.tools.commands import answer, call, figures_of, output_of, refused
from tests.tools.lob import write_entry_point, write_package
from tests.tools.models import model


def test_a_controller_and_an_environment_of_a_users_module(folder: Path) -> None:
    arguments = ("--env", "lob:Lob-v0", "--controller", "theirs:Better", "--picks", "20", "--json", "o.json")
    found = answer(call("agents.evaluate", *arguments, folder=folder), folder / "o.json")
    assert (found["env"], found["controller"], found["level"]) == ("lob:Lob-v0", "theirs:Better", "home")
    assert (found["success_rate"], found["picks_per_min"], found["num_envs"]) == (1.0, 120.0, 16)
    assert found["bias_error_x"] == pytest.approx(0.0, abs=0.01)
    assert set(found["throws"][0]) >= {"item", "landing_error_m", "success", "cycle_time_s", "clipped", "error_x"}
    assert not [name for name in found if name.startswith("failed_")]


def test_a_model_of_stable_baselines(here: Path) -> None:
    model(SAC).save(here / "mine.zip")
    found = figures_of("evaluate --env lob:LobAlone-v0 --controller mine.zip --trust --picks 4", here)
    assert (found["controller"], len(found["throws"])) == ("mine.zip", 4)
    misfit = r"takes observations \(2,\) and gives actions \(1,\), but the environment has \(14,\) and \(4,\)"
    with pytest.raises(UsageError, match=misfit):
        make_controller(str(here / "mine.zip"), make_vector("OneJointThrow-v0", num_envs=1, threads=1), trust=True)


def test_a_function_gets_what_the_environment_gives() -> None:
    env = make_vector("PnTGrasp-v0", {"base": "grasp", "fidelity": "flight"}, num_envs=4, threads=1)
    first, seen = env.reset(seed=0)[0], []

    def mine(observation):
        seen.append(observation)
        return np.zeros((len(observation["vector"]), 6))

    assert evaluate(mine, env, picks=8)["controller"] == "mine"
    for name, space in env.single_observation_space.items():
        assert (seen[0][name].shape, seen[0][name].dtype) == (first[name].shape, space.dtype)
    assert set(seen[0]) == set(first)
    assert pnt_gym.compare(mine, "centre", "PnTGrasp-v0", budget=16, level={"base": "grasp", "fidelity": "flight"})[
        "pairs"
    ]


def test_training_in_an_environment_of_a_users_module(here: Path) -> None:
    start = "train --env lob:Lob-v0 --steps 32 --num-envs 8 --out run --eval-picks 8"
    assert "learned (sac)" in output_of(start, here)
    # What a run folder names is imported only if the user names it too.
    for attempt in (
        lambda: trained.resolve(str(here / "run"), None, None, None),
        lambda: train.main(train.Arguments(resume=here / "run", steps=40)),
        lambda: publish.main(publish.Arguments(here / "run", to=here / "kept")),
    ):
        with pytest.raises(UsageError, match="give --env lob:Lob-v0 to import it"):
            attempt()
    assert figures_of("evaluate --controller run --env lob:Lob-v0 --picks 8", here)["level"] == "env"
    output_of("train --resume run --env lob:Lob-v0 --steps 40 --eval-picks 0", here)


def test_a_picture_of_a_users_environment(here: Path) -> None:
    output_of("play --env lob:Lob-v0 --controller theirs:Better --picture lob.png", here)
    assert iio.imread(here / "lob.png").shape == (4, 6, 3)


@pytest.mark.usefixtures("worker_here")
def test_a_benchmark_in_a_users_environment(here: Path) -> None:
    entries = [
        {"label": "analytic", "controller": "analytic"},
        {"label": "mine", "controller": "theirs:Better", "options": {"gain": 0.9}},
    ]
    plan = {"name": "own", "env": "lob:Lob-v0", "train_level": "home", "levels": ["home"], "entries": entries}
    more = {"picks": 16, "learned": [{"label": "mine"}], "references": [{"label": "analytic"}]}
    (here / "plan.yaml").write_text(yaml.safe_dump({**plan, **more}))
    output_of("benchmark --config plan.yaml --jobs 1 --out b.json", here)
    rows = {row["label"]: row for row in json.loads((here / "b.json").read_text())["table"]}
    assert (rows["analytic"]["success_rate"], rows["mine"]["success_rate"]) == (0.0, 1.0)
    assert rows["mine"]["landing_error_mean_m"] < 0.06 < rows["analytic"]["landing_error_mean_m"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--controller", "nowhere:Mine"), "module 'nowhere' cannot be imported: ModuleNotFoundError"),
        (("--controller", "torn:Mine"), "module 'torn' cannot be imported: ModuleNotFoundError: No module named 'no_"),
        (("--controller", "analytic", "--env", "lob:Nobody-v0"), "module 'lob': unknown environment 'Nobody-v0'"),
        (("--controller", "analytic", "--env", "lob:Lob-v0", "--action-mode", "x"), "takes no action mode but its own"),
    ],
)
def test_mistakes_on_the_command_line_are_one_sentence(here: Path, arguments: tuple[str, ...], said: str) -> None:
    assert said in refused("agents.evaluate", *arguments, "--picks", "4")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("theirs:Nobody", "module 'theirs': unknown class 'Nobody'; known are "),
        ("theirs:number", "module 'theirs': unknown class 'number'"),
        ("theirs:", "module 'theirs': unknown class ''"),
        (":Mine", "cannot be imported"),
        ("theirs:Mute", "controller 'theirs:Mute' has no reset and no learn"),
        ("theirs:Idle", "controller 'theirs:Idle' cannot be made: TypeError"),
        ("theirs:Broken", "controller 'theirs:Broken' cannot be made: OSError: no such motor"),
        ("theirs:Needy", "cannot be made: TypeError: .* 'voltage'"),
    ],
)
def test_a_controller_that_is_none_says_what_it_lacks(here: Path, name: str, said: str) -> None:
    with pytest.raises(UsageError, match=said) as caught:
        make_controller(name, make_vector("lob:Lob-v0"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("env_id", "said"),
    [
        ("nowhere:Lob-v0", "module 'nowhere' cannot be imported"),
        ("torn:Lob-v0", "module 'torn' cannot be imported"),
        ("lob:Lob", "module 'lob': unknown environment 'Lob'; known are Lob-v0, "),
        ("lob:LobBare-v0", "environment 'lob:LobBare-v0' has no core"),
        ("lob:LobLost-v0", "environment 'LobLost-v0' cannot be loaded: .*Nobody"),
        ("Lobbed-v0", "unknown environment 'Lobbed-v0'; known are PnT.*MODULE:ID"),
    ],
)
def test_an_environment_that_is_none_says_so(here: Path, env_id: str, said: str) -> None:
    with pytest.raises(UsageError, match=said):
        make_vector(env_id)


def test_an_installed_package_needs_no_prefix(tmp_path: Path) -> None:
    write_package(tmp_path)
    write_entry_point(tmp_path)
    arguments = ("--env", "Lob-v0", "--controller", "virtual_goal", "--picks", "8", "--json", "o.json")
    found = answer(call("agents.evaluate", *arguments, folder=tmp_path), tmp_path / "o.json")
    assert (found["env"], found["success_rate"], found["practice"]) == ("Lob-v0", 1.0, 120)


def test_rows_of_single_environments_are_those_of_the_vector_form(here: Path) -> None:
    whole, rows = (make_vector(f"lob:{name}-v0", num_envs=4) for name in ("Lob", "LobAlone"))
    assert isinstance(rows, SyncVectorEnv)
    one, other = (throw_held_out(make_controller("analytic", env), env, 12, 3) for env in (whole, rows))
    np.testing.assert_allclose(one.landing_error, other.landing_error)
    assert one.error.shape == other.error.shape == (12, 1)
    assert summary(one).keys() == summary(other).keys()
    learner = make_controller("virtual_goal", rows)
    practise(learner, rows, 40, 0)
    assert throw_held_out(learner, rows, 8, 0).is_success.all()
    with pytest.raises(UsageError, match="simulates all cells at once"):
        make_controller("oracle", rows)
    assert throw_held_out(make_controller("oracle", whole), whole, 8, 0).is_success.all()


def test_three_lines_of_python_say_what_the_command_line_says(here: Path) -> None:
    from_id = evaluate("theirs:Better", "lob:Lob-v0", 20)
    assert figures_of("evaluate --env lob:Lob-v0 --controller theirs:Better --picks 20", here) == from_id


def test_whatever_has_a_policy_can_be_judged(here: Path) -> None:
    import theirs  # noqa: PLC0415 - of the folder this test runs in

    env = make_vector("lob:Lob-v0", num_envs=4)
    perfect = evaluate(theirs.policy, env, 10)
    assert (perfect["controller"], perfect["env"], perfect["num_envs"]) == ("policy", "Lob-v0", 4)
    assert perfect["landing_error_mean_m"] < 1e-6
    assert evaluate(theirs.Better, env, 10)["controller"] == "better"
    plain = theirs.Plain()
    plain.reset(0)
    assert evaluate(plain, env, 10, practice=40)["practice"] == plain.throws == 40
    with pytest.raises(UsageError, match="--practice has no effect: controller 'policy' has no method `learn`"):
        evaluate(theirs.policy, env, 10, practice=40)
    with pytest.raises(UsageError, match="--online has no effect"):
        evaluate(theirs.policy, env, 10, online=True)
    assert evaluate(model(PPO), env, 10)["controller"] == "ppo"
    assert evaluate("ridge", env, 10, practice=40)["practice"] == 40
    for wrong in (None, 3, "nobody"):
        with pytest.raises(UsageError):
            evaluate(wrong, env, 10)
    with pytest.raises(UsageError, match="picks is 0"):
        evaluate(theirs.policy, env, 0)


def test_single_environments_keep_their_wrappers(here: Path) -> None:
    import theirs  # noqa: PLC0415 - as above

    def misread(observation: np.ndarray) -> np.ndarray:
        return observation + 10.0

    env = gym.make("lob:LobAlone-v0")
    seen = gym.wrappers.TransformObservation(env, misread, env.observation_space)
    assert evaluate(theirs.policy, env, 6)["env"] == "LobAlone-v0"
    assert evaluate(theirs.policy, seen, 6)["landing_error_mean_m"] == pytest.approx(0.1)
    with pytest.raises(UsageError, match="level cannot change an environment that is made already"):
        evaluate(theirs.policy, env, 6, level="home")
    with pytest.raises(UsageError, match="needs SAME_STEP autoreset"):
        evaluate(theirs.policy, SyncVectorEnv([lambda: env]), 6)
