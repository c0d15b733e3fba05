"""Policies with a memory: what stands between them and the environment is the same in training and evaluation."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
import yaml
from gymnasium.wrappers import FrameStackObservation
from stable_baselines3.common.vec_env import VecEnv

from agents.benchmark.run import run_piece
from agents.controllers import GRASPING_NAMES, NAMES, Learner, Observation, between, make_controller
from agents.controllers.between import BASES, MemoryPolicy
from agents.controllers.own import run_policy
from agents.dataset.episodes import episodes
from agents.ground.cli import UsageError
from agents.ground.environments import core_of, make_vector
from agents.judging import trials
from agents.judging.evaluation import evaluate
from agents.judging.loop import throw_batches, throw_held_out
from agents.learning.hyperparameters import MAX_STACK
from agents.learning.runs import LATER, RunFolder
from agents.learning.sb3 import build, load_policy
from agents.learning.vec_env import SameStepVecEnv
from agents.pictures.stage import Stage
from agents.policies import weights
from agents.policies.actor import Actor
from agents.policies.networks import Dense, Lstm
from agents.results.compare import assemble
from agents.results.plan import Plan, pieces
from agents.train import Arguments, main
from agents.training import session
from benchmarks.kill_trials.commands import LEARNER
from pnt_gym.cells.conveyor.observation import SHIFT_TABLE
from tests.tools.nightly import with_nightly

LEVEL: dict[str, Any] = {"base": "day", "fidelity": "flight", "picks_per_shift": 5}
FEATURES = len(SHIFT_TABLE)
FULL = pytest.importorskip("sb3_contrib").RecurrentPPO
LSTM = {"policy": "MlpLstmPolicy", "n_steps": 5, "batch_size": 20, "n_epochs": 2, "gamma": 0.5}
SMALL = {**LSTM, "policy_kwargs": {"lstm_hidden_size": 8, "net_arch": [8], "log_std_init": -3.0}}
STACKED = {**LEARNER, "n_envs": 4, "buffer_size": 400, "learning_starts": 20, "batch_size": 16}


def cells(rows: int = 4) -> Any:
    return make_vector("PnTAdapt-v0", LEVEL, rows, 1)


def asked(stack: int = 1, over: str = "analytic", algo: str = "sac") -> dict[str, Any]:
    return {"algo": algo, "stack": stack, "over": over}


def an_actor(seen: int, memories: int = 0) -> Actor:
    """Weights of some size, so that actions are neither nothing nor at their bounds."""
    random = np.random.default_rng(4)

    def drawn(*shape: int) -> Any:
        return (random.standard_normal(shape) * shape[-1] ** -0.5).astype(np.float32)

    lstm = Lstm(drawn(4 * memories, seen), drawn(4 * memories, memories), drawn(4 * memories)) if memories else None
    low = -np.ones(2, dtype=np.float32)
    return Actor(
        (Dense(0.1 * drawn(2, memories or seen), drawn(2) * 0.1),), "Tanh", "squashed", np.inf, low, -low, lstm
    )


def test_a_stack_is_what_gymnasiums_own_wrapper_shows() -> None:
    single = FrameStackObservation(gym.make("PnTAdapt-v0", level=LEVEL), 3, padding_type="zero")
    actions = np.random.default_rng(1).uniform(-0.2, 0.2, (5, 1, 2)).astype(np.float32)
    with closing(between.wrap(cells(1), asked(stack=3))) as env:
        assert env.single_observation_space.shape == (3 * FEATURES,)
        assert env.observation_space.contains(env.reset(seed=9)[0])
        seen, _ = env.reset(seed=9)
        theirs, _ = single.reset(seed=9)
        assert not theirs[:2].any()
        for step, action in enumerate(actions):
            np.testing.assert_array_equal(seen, theirs.reshape(1, -1))
            seen, _, _, over, info = env.step(action)
            theirs, _, _, ended, _ = single.step(action[0])
            assert (bool(over[0]), bool(ended)) == (step == 4, step == 4)
        np.testing.assert_array_equal(info["final_obs"][0], theirs.reshape(-1))
        assert not seen[:, : 2 * FEATURES].any(), "nothing of the shift before is seen in the next one"
        assert seen[:, 2 * FEATURES :].any()


def test_zero_over_a_controller_is_that_controller() -> None:
    with closing(cells()) as plain, closing(between.wrap(cells(), asked(over="kalman"))) as env:
        kalman = make_controller("kalman", plain)
        kalman.reset(0)
        own = [part.info["landing_along"] for part in throw_batches(kalman, plain, 40, 3)]
        env.reset(seed=3)
        zero = np.zeros((4, 2), dtype=np.float32)
        steps = [env.step(zero)[4] for _ in range(10)]
        final = [np.where(info.get("_final_info", False), info.get("final_info", info)["landing_along"],
                          info["landing_along"]) for info in steps]  # fmt: skip
        known = np.isfinite(own)
        np.testing.assert_array_equal(np.array(own)[known], np.array(final)[known])
        analytic = make_controller("analytic", plain)
        other = [part.info["landing_along"] for part in throw_batches(analytic, plain, 40, 3)]
        assert np.nanmax(np.abs(np.array(own) - other)) > 0.01


@pytest.mark.parametrize(("stack", "over", "memories"), [(4, "analytic", 0), (1, "ema", 6), (3, "static", 6)])
def test_a_policy_is_evaluated_as_it_was_trained(stack: int, over: str, memories: int) -> None:
    """The same actions for the same objects, over two shifts and a bit."""
    actor, algo = an_actor(stack * FEATURES, memories), "recurrent_ppo" if memories else "sac"
    with closing(cells()) as plain, closing(between.wrap(cells(), asked(stack, over, algo))) as env:
        policy = run_policy(actor, asked(stack, over, algo), plain, "it")
        given: list[Any] = []
        act = policy.act
        policy.act = lambda observation: given.append(act(observation)) or given[-1]  # type: ignore[method-assign]
        rewards = np.concatenate([part.reward for part in throw_batches(policy, plain, 48, 7)])
        seen, _ = env.reset(seed=7)
        memory, trained = actor.initial_memory(4), []
        for step in range(12):
            memory = actor.initial_memory(4) if step % 5 == 0 else memory
            action, memory = actor.act_with_memory(seen, memory)
            seen, reward, *_ = env.step(action)
            trained.append(reward)
    np.testing.assert_array_equal(rewards, np.concatenate(trained))
    assert np.ptp(np.array(given), axis=(0, 1)).min() > 0.01


def test_rows_remember_for_themselves() -> None:
    """Each acts as if it were alone, wherever in its shift another one is."""
    actor, env = an_actor(2 * FEATURES, 5), cells(1)
    random = np.random.default_rng(2)
    seen = random.uniform(-1.0, 1.0, (6, 3, FEATURES)).astype(np.float32)
    seen[..., -1] = 0.5
    seen[0, :, -1] = seen[2, 1, -1] = seen[4, 2, -1] = 0.0
    together, *alone = (run_policy(actor, asked(2, algo="recurrent_ppo"), env, "it") for _ in range(4))
    for step in seen:
        kind = np.zeros(3, dtype=np.int64)
        whole = together.act(Observation(step, kind))
        apart = [one.act(Observation(step[k : k + 1], kind[:1])) for k, one in enumerate(alone)]
        np.testing.assert_array_equal(whole, np.concatenate(apart))
    env.close()


def test_what_has_been_seen_is_forgotten_with_the_shift_and_on_reset() -> None:
    with closing(cells()) as env:
        policy = run_policy(an_actor(3 * FEATURES, 5), asked(3, "ema", "recurrent_ppo"), env, "it")
        policy.reset(0)
        first = throw_held_out(policy, env, 40, 1).info["landing_along"]
        np.testing.assert_array_equal(throw_held_out(policy, env, 40, 1).info["landing_along"], first)
        throw_held_out(policy, env, 12, 2)  # ends within a shift
        policy.reset(0)
        np.testing.assert_array_equal(throw_held_out(policy, env, 40, 1).info["landing_along"], first)


def test_controllers_under_a_policy_are_those_that_need_no_practice() -> None:
    with closing(cells(1)) as env:
        made = {name: make_controller(name, env) for name in NAMES if name not in GRASPING_NAMES}
        grasping = {*GRASPING_NAMES} - {"oracle_grasp", "true_surface"}
        eager = {name for name, one in made.items() if isinstance(one, Learner) and trials.of(env).practice(one)}
    assert set(BASES) == ({*made} - eager - {"random", "oracle", "oracle_drift"}) | grasping


@pytest.mark.parametrize(
    ("stack", "over", "said"),
    [
        (1, "oracle", "over: unknown controller that needs no practice 'oracle'"),
        (1, "runs/my", "over: unknown controller that needs no practice 'runs/my'"),
        (0, "static", f"stack is 0; a policy sees from 1 to {MAX_STACK} observations at once"),
    ],
)
def test_what_cannot_stand_between_is_refused(stack: int, over: str, said: str) -> None:
    with closing(cells(1)) as env, pytest.raises(UsageError, match=said):
        between.make(env, stack, over)


def test_a_policy_with_a_memory_does_not_act_elsewhere() -> None:
    size = make_vector("PnTConveyor-v0", None, 1, 1).single_observation_space.shape[0]
    with closing(make_vector("PnTConveyor-v0", None, 1, 1)) as env:
        with pytest.raises(UsageError, match="it needs observations that mark the beginning of a shift"):
            run_policy(an_actor(size, 4), asked(algo="recurrent_ppo"), env, "it")
        with pytest.raises(UsageError, match=r"takes observations \(136,\) .* but the environment has \(104,\)"):
            run_policy(an_actor(4 * FEATURES), asked(4), env, "it")


def test_wrappers_and_learners_of_others_go_with_the_single_form() -> None:
    env = gym.wrappers.FlattenObservation(FrameStackObservation(gym.make("PnTAdapt-v0", level=LEVEL), 4))
    settings = {name: value for name, value in SMALL.items() if name != "policy"}
    assert FULL("MlpLstmPolicy", env, device="cpu", **settings).learn(10).num_timesteps == 10
    env.close()


def trained(folder: Path) -> Any:
    """A model of RecurrentPPO that acts with some force."""
    env: VecEnv = SameStepVecEnv(cells())
    model = build("recurrent_ppo", env, SMALL, 0)
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter.add_(torch.randn_like(parameter), alpha=0.3)
    model.save(folder / "model.zip")
    return model


def test_a_recurrent_model_of_others_remembers_too(tmp_path: Path) -> None:
    model = trained(tmp_path)
    found = load_policy(tmp_path / "model.zip")
    assert type(found) is FULL
    with closing(cells()) as env:
        for policy in (model, str(tmp_path / "model.zip")):
            figures = evaluate(policy, env, 20, trust=True)
            expected = throw_held_out(
                MemoryPolicy(weights.actor(model), "it", between.make(env, 1, "analytic")), env, 20, 0
            )
            errors = [throw["landing_error_m"] for throw in figures["throws"]]
            np.testing.assert_array_equal(np.array(errors, dtype=float), expected.landing_error)


@pytest.fixture
def recipe(tmp_path: Path) -> Arguments:
    (tmp_path / "small.yml").write_text(yaml.safe_dump({"default": SMALL}))
    (tmp_path / "stacked.yml").write_text(yaml.safe_dump({"default": STACKED}))
    (tmp_path / "level.yaml").write_text(yaml.safe_dump({"name": "brief", **LEVEL}))
    recurrent = {"algo": "recurrent_ppo", "over": "static", "config": tmp_path / "small.yml"}
    few = {"steps": 80, "num_envs": 4, "checkpoint_every": 40, "eval_picks": 0, "threads": 1}
    return Arguments(env="PnTAdapt-v0", level=str(tmp_path / "level.yaml"), out=tmp_path / "run", **recurrent, **few)


@pytest.mark.parametrize("kind", with_nightly(("recurrent", "stacked"), ["recurrent"]))
def test_a_resumed_run_with_a_memory_is_bit_for_bit_the_uninterrupted_one(
    recipe: Arguments, tmp_path: Path, kind: str
) -> None:
    if kind == "stacked":
        recipe = replace(recipe, algo="sac", stack=3, over="ema", config=tmp_path / "stacked.yml")
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    main(replace(recipe, out=whole))
    main(replace(recipe, out=halves, steps=40))
    assert [one.name for one in RunFolder(halves).checkpoints][-1] != "00000080"
    main(Arguments(resume=halves, steps=80, eval_picks=0, threads=2))
    names = {one.name for one in RunFolder(whole).checkpoints} & {one.name for one in RunFolder(halves).checkpoints}
    assert names >= {"00000000", "00000040", "00000080"}
    one, other = (dict(RunFolder(folder).load().policy.named_parameters()) for folder in (whole, halves))
    assert all(torch.equal(one[name], other[name]) for name in one)
    assert (whole / "policy.npz").read_bytes() == (halves / "policy.npz").read_bytes()


def test_a_run_says_what_stands_between_and_older_ones_need_not(recipe: Arguments, tmp_path: Path) -> None:
    main(replace(recipe, steps=20, stack=2, eval_picks=8))
    run = tmp_path / "run"
    told = RunFolder(run).arguments
    assert (told["stack"], told["over"]) == (2, "static")
    assert RunFolder(run).actor().sizes == (2 * FEATURES, 2)
    assert [row["controller"] for row in yaml.safe_load((run / "evaluation.json").read_text())] == [
        "analytic", "virtual_goal", "static", "learned (recurrent_ppo)",
    ]  # fmt: skip
    old = {name: value for name, value in told.items() if name not in LATER}
    RunFolder(run).write(old)
    found = RunFolder(run).arguments
    assert (found["stack"], found["over"], found["fidelity"]) == (1, "analytic", "full")


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("over", "os:system", "over: unknown controller that needs no practice 'os:system'"),
        ("stack", 10**9, "stack 1000000000; it must be from 1 to 100"),
        ("stack", -1, "stack -1; it must be from 1 to 100"),
        ("stack", 2, "takes observations"),
        ("num_envs", 2**31, "num_envs 2147483648; it must be from 1 to 100,000"),
        ("stack", "8", "args.yml has stack '8'"),
        ("over", 3, "args.yml has over 3"),
    ],
)
def test_a_run_folder_that_says_otherwise_is_refused(
    recipe: Arguments, tmp_path: Path, name: str, value: Any, said: str
) -> None:
    main(replace(recipe, steps=20))
    run = tmp_path / "run"
    RunFolder(run).write({**RunFolder(run).arguments, name: value})
    with closing(cells(1)) as env, pytest.raises(UsageError, match=said):
        make_controller(str(run), env)


def test_a_run_with_a_memory_is_evaluated_and_watched(recipe: Arguments, tmp_path: Path) -> None:
    main(replace(recipe, steps=40))
    run = tmp_path / "run"
    figures = evaluate(str(run), "PnTAdapt-v0", 40, level=LEVEL)
    own = evaluate("static", "PnTAdapt-v0", 40, level=LEVEL)
    assert abs(figures["landing_error_mean_m"] - own["landing_error_mean_m"]) < 0.005, "static's throws, or near them"
    with closing(Stage(str(run), None, None, 0)) as stage:
        assert len([next(stage.steps) for _ in range(7)]) == 7


def test_who_ships_knowing_does_not_practise_before_it_is_watched() -> None:
    with closing(Stage("ema", "PnTAdapt-v0", None, 0)) as stage, closing(make_vector("PnTAdapt-v0", None, 1, 1)) as env:
        ema = make_controller("ema", env)
        ema.reset(0)
        own = throw_held_out(ema, env, 4, 0).info["landing_along"]
        np.testing.assert_array_equal([next(stage.steps).info["landing_along"][0] for _ in range(4)], own)


@pytest.mark.nightly
def test_the_benchmark_trains_policies_with_a_memory_and_goes_on_with_them(tmp_path: Path) -> None:
    (tmp_path / "level.yaml").write_text(yaml.safe_dump({"name": "brief", **LEVEL}))
    memory = {"throws": [20, 40], "over": "ema", "seeds": [0]}
    entries = [
        {"label": "ema", "controller": "ema"},
        {"label": "recurrent", "controller": "recurrent_ppo", "options": {**SMALL, "n_envs": 4}, **memory},
        {"label": "stacked", "controller": "sac", "options": STACKED, "stack": 3, **memory},
    ]
    other = {"name": "still", "base": "waste", "picks_per_shift": LEVEL["picks_per_shift"]}
    (tmp_path / "other.yaml").write_text(yaml.safe_dump(other))
    level, still = str(tmp_path / "level.yaml"), str(tmp_path / "other.yaml")
    plan = Plan.model_validate(
        {"name": "x", "env": "PnTAdapt-v0", "train_level": level, "levels": [level, still], "picks": 20,
         "num_envs": 4, "entries": entries}
    )  # fmt: skip
    work = {piece.entry.label: piece for piece in pieces(plan)}
    assert len({piece.key for piece in work.values()}) == 3
    found = {label: run_piece(piece, tmp_path).results for label, piece in work.items()}
    assert [(one["throws"], one["level"]) for one in found["stacked"]] == [
        (20, level), (20, still), (40, level), (40, still),
    ]  # fmt: skip
    rows = assemble(plan, [*found["ema"], *found["stacked"]])["table"]
    assert [(row["label"], row["shifts"], len(row["landing_error_by_pick_m"])) for row in rows[:3]] == [
        ("ema", 4, 5), ("ema", 4, 5), ("stacked", 4, 5),
    ]  # fmt: skip
    with closing(cells()) as env:
        run = tmp_path / f"{work['recurrent'].name}-{work['recurrent'].key}-run"
        again = throw_held_out(make_controller(str(run), env), env, 20, 0)
    told = next(one for one in found["recurrent"] if (one["throws"], one["level"]) == (40, level))
    errors = [np.nan if value is None else value for value in told["columns"]["along_m"]]
    np.testing.assert_allclose(errors, again.info["landing_along"], atol=6e-6)
    assert run_piece(work["recurrent"], tmp_path).results[3]["columns"] == found["recurrent"][3]["columns"]


def test_the_benchmark_learns_from_flights_and_judges_in_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "level.yaml").write_text(yaml.safe_dump({"name": "brief", **LEVEL, "fidelity": "full"}))
    level, given, learn = str(tmp_path / "level.yaml"), {}, session.learn

    def spied(model: Any, env: Any, *rest: Any, quick: Any, **more: Any) -> None:
        given.update({"judged": core_of(env.env).config.fidelity, "learned": core_of(quick).config.fidelity})
        given["seen"] = env.observation_space.shape == quick.single_observation_space.shape
        learn(model, env, *rest, quick=quick, **more)

    monkeypatch.setattr(session, "learn", spied)
    entry = {"label": "stacked", "controller": "sac", "options": STACKED, "stack": 3, "over": "ema", "throws": [20]}
    plans = [
        Plan.model_validate({"name": "x", "env": "PnTAdapt-v0", "train_level": level, "levels": [level], "picks": 20,
                             "num_envs": 2, "seeds": [0], "entries": [{**entry, **more}]})
        for more in ({"fidelity": "flight"}, {})
    ]  # fmt: skip
    (piece,), (full,) = (pieces(plan) for plan in plans)
    assert piece.key != full.key
    assert len(run_piece(piece, tmp_path).results) == 1
    assert given == {"judged": "full", "learned": "flight", "seen": True}
    assert RunFolder(tmp_path / f"{piece.name}-{piece.key}-run").arguments["num_envs"] == 4


def test_throws_of_a_policy_with_a_memory_make_a_dataset(recipe: Arguments, tmp_path: Path) -> None:
    """Of whole episodes, whichever rows they were thrown in."""
    main(replace(recipe, steps=20, stack=2))
    found = []
    for rows in (2, 3):
        with closing(cells(rows)) as env:
            controller = make_controller(str(tmp_path / "run"), env)
            found.append([one.actions for one in episodes(controller, env, 30, iter(range(2**31, 2**31 + 99)))])
    assert len(found[0]) == 6
    np.testing.assert_array_equal(np.array(found[0]), np.array(found[1]))
