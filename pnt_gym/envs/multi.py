"""A line as a game of several agents, one for each robot: PettingZoo's agent-environment cycle.

It needs PettingZoo (`pip install pnt_gym[multi]`), and nothing else of the suite does.
"""

from __future__ import annotations

from typing import Any, ClassVar, cast, final

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray
from pettingzoo import AECEnv  # pyright: ignore[reportMissingTypeStubs]

from pnt_gym.cells.base.config import Level, describes_a_cell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.rows import CHOICES
from pnt_gym.envs.base import seed_of
from pnt_gym.errors import ActionError, OrderError
from pnt_gym.names import check_keywords

Observation = NDArray[np.float32]


@final
class PnTLineAEC(AECEnv[str, Observation, int]):
    """`PnTLine-v0` with an agent for each robot; agents act in the order in which their robots become free.

    An observation is that of `PnTLine-v0`, as that robot sees the line, and `infos[agent]["action_mask"]` says which
    choices there are; a robot whose turn it is not has none. All agents get the same reward, that of the line:
    robots that leave to others what those do better are what the levels ask for. Agents are called `robot_0` and so on,
    upstream first. An agent's reward adds up from one of
    its turns to the next.

    Args:
        level: of the line.
        threads: of the physics; results do not depend on it.

    Raises:
        ConfigError: no such level, or one that describes no line that works.
    """

    metadata: ClassVar[dict[str, Any]] = {"name": "pnt_line_v0", "render_modes": [], "is_parallelizable": False}  # pyright: ignore[reportIncompatibleVariableOverride]

    @check_keywords
    def __init__(self, level: Level = "single", threads: int = 1) -> None:
        super().__init__()
        with describes_a_cell():
            self.core = LineCore(LineConfig.load(level), 1, threads)
        self.possible_agents = [f"robot_{index}" for index in range(len(self.core.config.robots))]
        self.observation_spaces = dict.fromkeys(self.possible_agents, self.core.observation_space)
        self.action_spaces = dict.fromkeys(self.possible_agents, cast("gym.Space[int]", self.core.action_space))
        self.agents: list[str] = []
        self.render_mode = None
        self._generator = np.random.default_rng()

    def observation_space(self, agent: str) -> gym.Space[Observation]:
        """What an agent sees."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> gym.Space[int]:
        """What an agent can do."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin a shift.

        Args:
            seed: of the stream, or None to go on with the generator as it is.
            options: not used.

        Raises:
            ConfigError: a seed that is no whole number.
        """
        number = seed_of(seed)
        if number is not None:
            self._generator = seeding.np_random(number)[0]
        self.core.reset(np.zeros(1, dtype=np.int64), [self._generator], seeded=number is not None)
        self.agents = self.possible_agents[:]
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.agent_selection = self._turn()
        self._tell({})

    def observe(self, agent: str) -> Observation:
        """What an agent sees now."""
        return self.core.observe_as(self.possible_agents.index(agent))[0]

    def step(self, action: int | None) -> None:
        """Let the agent whose turn it is act.

        Args:
            action: one of its choices; None for an agent whose shift is over.

        Raises:
            ActionError: no whole number from 0 to 15.
            OrderError: before the first reset.
        """
        if not self.possible_agents or not hasattr(self, "agent_selection"):
            raise OrderError("the environment was not reset; call reset before step")
        agent = self.agent_selection
        if self.truncations[agent]:
            self._was_dead_step(cast("int", action))
            return
        if action is None:
            raise ActionError(f"action is None; agent {agent!r} has to choose a whole number from 0 to {CHOICES - 1}")
        result = self.core.step(np.array([action]))
        self._cumulative_rewards[agent] = 0.0
        self.rewards = dict.fromkeys(self.agents, float(result.reward[0]))
        if result.ended[0]:
            self.truncations = dict.fromkeys(self.agents, True)
        self._accumulate_rewards()
        self.agent_selection = self._turn()
        self._tell({agent: {name: values[0] for name, values in result.info.items()}})

    def render(self) -> None:
        """A line has no pictures."""

    def close(self) -> None:
        """Nothing is open."""

    def _tell(self, done: dict[str, dict[str, Any]]) -> None:
        """Masks, and what became of what was done."""
        nothing, own = np.zeros(CHOICES, dtype=np.int8), self.core.masks()[0].astype(np.int8)
        self.infos: dict[str, dict[str, Any]] = {}
        for name in self.agents:
            mask = own if name == self.agent_selection else nothing
            self.infos[name] = {**done.get(name, {}), "action_mask": mask.copy()}

    def _turn(self) -> str:
        """Whose turn it is."""
        return self.possible_agents[int(self.core.cell.state.robot[0])]
