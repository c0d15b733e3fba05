"""What can be learned from throws that somebody else made: imitation, regression of the landing, and offline RL."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Controller, Observation, Outcome
from agents.dataset import collection
from agents.dataset.crew import Crew
from agents.dataset.episodes import Episode
from agents.ground.cli import NUM_ENVS
from agents.ground.environments import Env, core_of
from agents.judging.trials import open_trial
from agents.learning.from_data import Function, Lesson, behaviour_cloning, iql, td3_bc
from agents.results.study import Amount, Figures, Settings

POLICIES: Final[dict[str, Callable[[Lesson, int], Function]]] = {
    "behaviour cloning": behaviour_cloning,
    "TD3+BC": td3_bc,
    "IQL": iql,
}
"""Learners of rewards and actions."""
REGRESSIONS: Final = {"ridge regression": "ridge", "MLP regression": "mlp"}
"""Controllers that learn from measured landings."""


def figures(settings: Settings, amount: Amount) -> Iterator[Figures]:
    """What each learner makes of one dataset, on held-out throws, beside the planner and the expert.

    Args:
        settings: `env`, `level`, `controller` and `noise` of the behaviour, as `agents.dataset` takes them, the number
            of `collected` throws, and the `seed` of dataset and learners.
        amount: held-out throws.
    """
    seed, names = settings["seed"], settings["learners"]
    with closing(open_trial(settings["env"], settings["level"], NUM_ENVS, 1)) as trial:
        crew = Crew(trial, settings["env"], settings["controller"], None, seed=seed, noise=settings["noise"])
        outcome = join_throws(collect(crew, settings["collected"]), trial.env)
        behaviour = float(np.linalg.norm(outcome.error, axis=1).mean())
        policies = {"analytic": "analytic", "expert": crew.chosen[0]}
        for name in names:
            controller: Any = policies.get(name) or learn(name, outcome, trial.env, seed)
            judged = trial.run(trial.controller(controller), amount.throws, amount.seed).report()
            worth = {key: judged[key] for key in ("landing_error_mean_m", "success_rate", "sorted_per_min")}
            yield {"learner": name, "throws": len(outcome.action), "behaviour_error_m": behaviour, **worth}


def learn(name: str, outcome: Outcome, env: Env, seed: int) -> Controller | Function:
    """The controller or policy that a learner makes of throws."""
    if name in REGRESSIONS:
        controller = make_controller(REGRESSIONS[name], env)
        controller.reset(seed)
        controller.learn(outcome)
        return controller
    return POLICIES[name](Lesson(outcome.observation.features, outcome.action, outcome.reward.astype(np.float32)), seed)


def collect(crew: Crew, throws: int) -> list[Episode]:
    """Episodes that `agents.dataset` writes, with the same bits."""
    with tempfile.TemporaryDirectory() as place:
        file, episodes = Path(place) / "chunk.npz", list[Episode]()
        for job in crew.throws().jobs("throws", throws):
            content = job.run(Path(place))
            assert isinstance(content, bytes)
            file.write_bytes(content)
            episodes += collection.unpack(file)
    return episodes


def join_throws(episodes: list[Episode], env: Env) -> Outcome:
    """Throws of all episodes whose objects were thrown.

    No action decides whether a pick fails or an object drops, so such throws teach nothing.
    """
    correction = core_of(env).correction
    assert correction is not None
    info = {name: np.concatenate([e.info[name][1:] for e in episodes]) for name in episodes[0].info}
    error = np.stack([info[name] for name in correction.error_keys], axis=1)
    thrown = (info["dropped"] == 0.0) & (info["residual_clipped"] == 0.0) & np.isfinite(error).all(axis=1)
    features, actions, rewards = (
        np.concatenate(parts)[thrown].astype(np.float32)
        for parts in zip(*((e.observations[:-1], e.actions, e.rewards) for e in episodes), strict=True)
    )
    outcome = Outcome(
        observation=Observation(features, np.zeros(len(features), dtype=np.int64)),
        action=actions,
        error=error[thrown],
        is_success=info["is_success"][thrown] == 1.0,
        cycle_time=info["cycle_time"][thrown],
        clipped=np.zeros(len(features), dtype=np.bool_),
        reward=rewards.astype(np.float64),
    )
    return outcome
