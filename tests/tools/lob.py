"""A user's own package as text: a cell on paper in one file, registered with Gymnasium, and controllers beside it.

The object lands where the action sends it, 0.3 off to one side; a success is within 0.1. What a throw tells is the
least that a cell tells.
"""

from pathlib import Path
from textwrap import dedent

PACKAGE = """
from pathlib import Path

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from pydantic import BaseModel

from pnt_gym.cells.base.action import Correction


class Config(BaseModel):
    name: str = "home"


class View:
    def last_throw(self, rate):
        return [np.full((4, 6, 3), 200, np.uint8)]

    def at(self, moment, rate):
        return self.last_throw(rate)[0]

    def close(self):
        pass


class Core:
    action_mode, action_sizes, shift_modes = "aim", {"aim": 1}, ("aim",)
    item_names, dwell, terminates = ("ball",), 0.1, True
    observation_space = gym.spaces.Box(-5, 5, (2,), np.float32)
    action_space = gym.spaces.Box(-1, 1, (1,), np.float32)
    correction = Correction(
        errors=("error_x",),
        scale=np.array([1.0]),
        exploration=np.array([0.05]),
        tolerance=np.array([0.1]),
        buckets=lambda features, kind: [("ball", "target")] * len(kind),
    )

    def __init__(self, count, level):
        self.count, self.config = count, Config(name=level if level == "home" else Path(level).stem)
        self.seen = np.zeros((count, 2), np.float32)

    def draw(self, generators):
        self.seen = np.stack([g.standard_normal(2).clip(-5, 5) for g in generators]).astype(np.float32)

    def throw(self, actions):
        miss = 0.3 + np.asarray(actions, float)[:, 0] + 0.01 * self.seen[:, 0]
        return {
            "is_success": np.abs(miss) < 0.1,
            "landing_error": np.abs(miss),
            "error_x": miss,
            "cycle_time": np.full(self.count, 0.5),
            "residual_clipped": np.zeros(self.count, bool),
            "item": np.zeros(self.count, int),
            "kind": np.zeros(self.count, int),
        }

    def preview(self, actions, jitter=False):
        return type("Seen", (), self.throw(actions))

    def view(self):
        return View()


class Lob(gym.Env):
    def __init__(self, level="home"):
        self.core = Core(1, level)
        self.observation_space, self.action_space = Core.observation_space, Core.action_space

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.core.draw([self.np_random])
        return self.core.seen[0].copy(), {"kind": 0}

    def step(self, action):
        info = {name: value[0].item() for name, value in self.core.throw(np.asarray(action)[None]).items()}
        return self.core.seen[0].copy(), 1.0 - info["landing_error"], True, False, info


class Lobs(VectorEnv):
    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(self, num_envs=1, level="home"):
        self.num_envs, self.core = num_envs, Core(num_envs, level)
        self.single_observation_space, self.single_action_space = Core.observation_space, Core.action_space
        self.generators = [np.random.default_rng() for _ in range(num_envs)]

    def reset(self, *, seed=None, options=None):
        if seed is not None:
            seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else seed
            self.generators = [gym.utils.seeding.np_random(s)[0] for s in seeds]
        self.core.draw(self.generators)
        return self.core.seen, {"kind": np.zeros(self.num_envs, int)}

    def step(self, actions):
        info, last = self.core.throw(actions), self.core.seen
        self.core.draw(self.generators)
        over = np.ones(self.num_envs, bool)
        return self.core.seen, 1.0 - info["landing_error"], over, ~over, {**info, "final_obs": last, "_final_obs": over}


class Bare(gym.Env):
    observation_space, action_space = Core.observation_space, Core.action_space


gym.register("Lob-v0", entry_point=Lob, vector_entry_point=Lobs)
gym.register("LobAlone-v0", entry_point=Lob)
gym.register("LobBare-v0", entry_point=Bare)
gym.register("LobLost-v0", entry_point="lob:Nobody")
"""

CONTROLLERS = '''
import numpy as np

from agents.controllers import Controller


class Better(Controller):
    """Aims back by what the planner misses."""

    name = "better"

    def __init__(self, core, gain=1.0):
        self.size, self.gain = core.action_space.shape[0], gain

    def act(self, observation):
        return np.full((len(observation.kind), self.size), -0.3 * self.gain, dtype=np.float32)


class Plain:
    """Inherits nothing."""

    name = "plain"

    def reset(self, seed):
        self.ready = True

    def act(self, observation):
        return np.zeros((len(observation.kind), 1 if self.ready else 9))

    def learn(self, outcome):
        self.throws = getattr(self, "throws", 0) + len(outcome.cycle_time)


class Mute:
    name = "mute"

    def act(self, observation):
        return None


class Idle(Controller):
    name = "idle"


class Broken(Plain):
    def __init__(self):
        raise OSError("no such\\nmotor")


class Needy(Plain):
    def __init__(self, voltage):
        self.voltage = voltage


def policy(observations):
    return -0.3 - 0.01 * observations[:, :1]


number = 7
'''


def write_package(folder: Path) -> None:
    """The package `lob` and the module `theirs`, and `torn`, which fails when it is imported."""
    (folder / "lob").mkdir()
    (folder / "lob" / "__init__.py").write_text(dedent(PACKAGE))
    (folder / "theirs.py").write_text(dedent(CONTROLLERS))
    (folder / "torn.py").write_text("import no_such_module_anywhere\n")


def write_entry_point(folder: Path) -> None:
    """What installing `lob` with an entry point would leave."""
    info = folder / "lob-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lob\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[pnt_gym.envs]\nlob = lob\n")
