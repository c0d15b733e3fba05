"""Trials by throws: a controller corrects single throws, and held-out throws are counted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, final

from gymnasium.spaces import Box

from pnt_gym.cells.grasp.action import MODE as GRASP

from ..controllers.adaptive import PRETRAINED, has_feedback
from ..controllers.protocol import Controller
from ..ground.cli import UsageError
from ..ground.environments import stream_seed
from ..ground.places import ADAPTIVE
from ..ground.versions import code_digest
from ..learning.hyperparameters import SEEING
from .loop import throw_batches, throw_held_out
from .record import Card
from .throw_record import CARD, ThrowRecord, depend, run_length
from .throws import Throws
from .trial import PRACTICE, Progress, Trial

ENDLESS: Final = 10**9
"""Number of throws of an endless trial."""
LOOKS: Final = 15
"""Throws that the oracle simulates for each executed throw."""


@final
class ThrowTrial(Trial):
    """Trials in cells where an action corrects one throw."""

    unit = "throws"
    options = Trial.options | {"picks_on", "floors", "also"}
    record = ThrowRecord

    def run(
        self,
        controller: Controller,
        count: int,
        seed: int,
        *,
        online: bool = False,
        progress: Progress | None = None,
    ) -> ThrowRecord:
        """Let a controller, without practice, throw `count` held-out objects."""
        throws = throw_held_out(controller, self.env, count, seed, online=online, progress=progress)
        return ThrowRecord(throws, self.core, {"online": online, "num_envs": self.env.num_envs})

    def count(self) -> int:
        """200 throws, or a whole episode of every row in cells where a throw informs the next one."""
        return self.env.num_envs * self.core.cell.episode if has_feedback(self.core) else self.usual

    def block(self, left: int) -> int:
        """A run of throws in every row; runs whose throws depend on one another are whole."""
        together = self.env.num_envs * run_length(self.core)
        return together if depend(self.core) else min(together, left)

    def peers(self, run_args: Mapping[str, Any]) -> dict[str, int]:
        """The planner, the base controller of the policy, and a virtual goal where actions correct a measured error.

        In a cell that grasps two rules of places instead of the planner and the goal.
        """
        if self.core.action_mode == GRASP:
            return {"centre": 0, "flattest": 0, run_args["over"]: 0}
        learning = {"virtual_goal": PRACTICE} if self.core.action_mode in self.core.shift_modes else {}
        return {"analytic": 0, **learning, run_args["over"]: 0}

    def check_training(self, run_args: Mapping[str, Any]) -> None:
        """Make sure that a training fits the observations.

        Raises:
            UsageError: the algorithm or the stack does not fit.
        """
        super().check_training(run_args)
        if isinstance(self.env.single_observation_space, Box):
            return
        if run_args["algo"] not in SEEING or run_args["stack"] > 1:
            raise UsageError(
                f"observations of {run_args['env']} hold pictures; algorithms there are {', '.join(SEEING)}, with a "
                "stack of 1"
            )

    def steps(self, controller: Controller, seed: int) -> Iterator[Throws]:
        """Throws of one cell, endlessly, one after the other."""
        return throw_batches(controller, self.env, ENDLESS, stream_seed("evaluate", seed))

    def check_count(self, count: int, num_envs: int, level: str) -> None:
        """Make sure that throws which depend on earlier throws are evaluated in whole episodes."""
        if not has_feedback(self.core):
            return
        together = num_envs * self.core.cell.episode
        if count % together > 0:
            raise UsageError(
                f"picks is {count}; with num_envs {num_envs} and shifts of {self.core.cell.episode} picks on level "
                f"{level!r} it must be a multiple of {together}"
            )

    @classmethod
    def card(cls) -> Card:
        """Card with landing error, success and pace of throws."""
        return CARD

    @classmethod
    def dependencies(cls, name: str, levels: Sequence[Any], options: Mapping[str, Any], throws: Sequence[int]) -> Any:
        """Digest of the shipped states of adaptive controllers, if the controller starts from such a state."""
        del levels, options
        return (
            code_digest(("*.npz",), root=ADAPTIVE) if max(throws) == 0 and name in (*PRETRAINED, "oracle_drift") else ""
        )

    @classmethod
    def effort(cls, name: str, config: Any, count: int, num_envs: int) -> int:
        """Number of throws; the oracle simulates each throw several times."""
        del config, num_envs
        return (LOOKS if name == "oracle" else 1) * count
