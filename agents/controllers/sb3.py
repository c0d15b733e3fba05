"""A policy trained with stable-baselines3, loaded from its run folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from agents.controllers.protocol import Actions, Observation, Outcome

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm


@final
class Sb3:
    """The mean action of a trained policy.

    Args:
        model: the loaded algorithm.
        name: name in tables.
    """

    def __init__(self, model: BaseAlgorithm, name: str) -> None:
        self.name = name
        self._model = model

    @classmethod
    def load(cls, run: Path, observations: int, actions: int) -> Sb3:
        """The policy of a run folder.

        Raises:
            UsageError: the folder is missing, damaged, or its policy does not fit the environment.
        """
        from agents import runs  # noqa: PLC0415 - torch takes a second to import
        from agents.cli import UsageError  # noqa: PLC0415

        model = runs.load_model(run)
        shapes = (model.observation_space.shape, model.action_space.shape)
        if shapes != ((observations,), (actions,)):
            raise UsageError(
                f"the policy of run {str(run)!r} takes observations {shapes[0]} and gives actions "
                f"{shapes[1]}, but the environment has {(observations,)} and {(actions,)}"
            )
        return cls(model, runs.read_arguments(run)["algo"])

    def reset(self, seed: int) -> None:
        """A trained policy keeps what it learned."""

    def act(self, observation: Observation) -> Actions:
        """Mean actions (N, A)."""
        action, _ = self._model.predict(observation.features, deterministic=True)
        return np.asarray(action, dtype=np.float32)

    def learn(self, outcome: Outcome) -> None:
        """Learns no more."""
