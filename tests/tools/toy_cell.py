"""A cell on paper: landing is a known function of the observation, so learning has a right answer."""

from types import SimpleNamespace
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv

from agents.controllers.protocol import Observation, Outcome
from pnt_gym.cells.base.action import Correction, mode_of
from pnt_gym.cells.base.features import CLIP
from pnt_gym.cells.conveyor.action import MODES, correction
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.observation import FEATURES

FEATURE_INDEX = {feature.name: i for i, feature in enumerate(FEATURES)}
SHIFT_NOISE = 0.002


class ToyCore:
    """Stands where the cell stands: config, what actions mean, and a preview of the coming throws."""

    action_sizes = {name: len(mode.numbers) for name, mode in MODES.items()}  # noqa: RUF012 - never changed
    shift_modes = tuple(name for name, mode in MODES.items() if mode.errors)
    dwell = 0.1
    cell = SimpleNamespace(episode=1, terminates=True)

    def __init__(self, config: ConveyorConfig, action_mode: Any = "release_point") -> None:
        mode_of(MODES, action_mode)
        self.config = config
        self.action_mode = action_mode
        self.item_names = config.items
        self.correction = correction(config, action_mode)
        self.features = np.zeros((0, len(FEATURES)), dtype=np.float32)

    def preview(self, actions: np.ndarray, *, jitter: bool = False) -> Any:
        along, across = toy_landing(self.features, actions, self.config)
        return SimpleNamespace(landing_along=along, landing_across=across)


def toy_bias(features: np.ndarray) -> np.ndarray:
    """Landing error (N, 2) of an uncorrected throw: linear and quadratic in what is seen."""
    speed, ratio = features[:, FEATURE_INDEX["release_speed"]], features[:, FEATURE_INDEX["ln_grip_ratio"]]
    grasp = features[:, FEATURE_INDEX["grasp_across"]]
    return np.stack([0.03 + 0.03 * ratio + 0.015 * speed * ratio, 0.008 * grasp], axis=-1)


def toy_landing(features: np.ndarray, actions: np.ndarray, config: ConveyorConfig) -> tuple[np.ndarray, np.ndarray]:
    shift = actions[:, :2] * np.array([config.action.along, config.action.across])
    landing = toy_bias(features.astype(np.float64)) + shift * [0.96, 1.0]
    return landing[:, 0], landing[:, 1]


def info_of(landing: np.ndarray, target: np.ndarray, kind: np.ndarray, cycle_time: float) -> dict[str, Any]:
    """What throws tell that land along and across (N, >= 2) of targets (N, 2), and touch nothing."""
    count, (along, across) = len(landing), landing[:, :2].T
    return {
        "landing_error": np.hypot(along, across),
        "landing_along": along,
        "landing_across": across,
        "cycle_time": np.full(count, cycle_time),
        **{name: np.zeros(count, dtype=bool) for name in ("recontact", "rim", "residual_clipped")},
        "item": kind,
        "target_x": target[:, 0],
        "target_y": target[:, 1],
    }


class ToyVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """One throw per step; episodes end every step (`steps` 1) or are truncated after `steps`."""

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP}  # noqa: RUF012 - Gymnasium's own form
    render_mode = None

    def __init__(
        self,
        num_envs: int = 4,
        level: Any = "waste",
        action_mode: str = "release_point",
        threads: int = 1,
        steps: int = 1,
    ) -> None:
        self.num_envs = num_envs
        self.core = ToyCore(ConveyorConfig.load(level), action_mode)
        self.steps = steps
        count = len(MODES[action_mode].numbers)
        self.single_observation_space = gym.spaces.Box(-CLIP, CLIP, (len(FEATURES),), np.float32)
        self.single_action_space = gym.spaces.Box(-1.0, 1.0, (count,), np.float32)
        self.observation_space = gym.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = gym.vector.utils.batch_space(self.single_action_space, num_envs)
        self._rows = [np.random.default_rng(i) for i in range(num_envs)]
        self._age = np.zeros(num_envs, dtype=int)

    def reset(self, *, seed: int | list[int] | None = None, options: Any = None) -> tuple[np.ndarray, dict[str, Any]]:
        if seed is not None:
            seeds = seed if isinstance(seed, list) else [seed + i for i in range(self.num_envs)]
            self._rows = [np.random.default_rng(s) for s in seeds]
        self._age[:] = 0
        self._draw()
        return self.core.features.copy(), {"kind": self._kind.copy()}

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        along, across = toy_landing(self.core.features, actions, self.core.config)
        noise = np.stack([r.standard_normal(2) for r in self._rows]) * SHIFT_NOISE
        along, across = along + noise[:, 0], across + noise[:, 1]
        error, kind = np.hypot(along, across), self._kind
        self._age += 1
        over = self._age >= self.steps
        target = self.core.features[:, 2:4].astype(float)
        self._draw()
        info = info_of(np.stack([along, across], axis=1), target, kind, 0.6)
        info |= {"is_success": error < 0.06, "kind": self._kind.copy()}
        none = np.zeros(self.num_envs, dtype=bool)
        if over.any():
            info["final_obs"] = self.core.features.copy()
            self._age[over] = 0
        terminated, truncated = (over, none) if self.steps == 1 else (none, over)
        return self.core.features.copy(), 1.0 - error / 0.25, terminated, truncated, info

    def _draw(self) -> None:
        normals = np.stack([r.standard_normal(len(FEATURES) + 1) for r in self._rows])
        self.core.features = np.clip(normals[:, :-1], -CLIP, CLIP).astype(np.float32)
        self._kind = (np.abs(normals[:, -1]) * 7).astype(np.int64) % len(self.core.config.items)


POSE = Correction(
    errors=("error_x", "error_y", "error_phi", "error_dy"),
    scale=np.array([0.10, 0.10, 0.8, 0.5]),
    exploration=np.array([0.004, 0.004, 0.03, 0.04]),
    tolerance=np.array([0.005, 0.005, 0.035, 0.05]),
    buckets=lambda features, kind: [("block", f"pallet-{k}") for k in kind],
)
POSE_BIAS = np.array([0.031, -0.022, 0.25, -0.11])
"""Error of every uncorrected throw: x, y [m], phi [rad], dy [m/s]."""
POSE_NOISE = 0.02
"""Standard deviation of what no observation tells, in tolerances."""


class PoseCore:
    """A cell whose throws are judged by four numbers, each shifted by one number of the action."""

    config = SimpleNamespace(name="pose")
    action_mode = "virtual_goal"
    action_sizes = {"virtual_goal": 4}  # noqa: RUF012 - never changed
    shift_modes = ("virtual_goal",)
    item_names = ("block",)
    correction = POSE
    dwell = 0.0

    def preview(self, actions: np.ndarray, *, jitter: bool = False) -> Any:
        return SimpleNamespace(**dict(zip(POSE.errors, (POSE_BIAS + actions * POSE.scale).T, strict=True)))


class PoseVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """One throw per episode, three kinds of pallet, observations of no worth."""

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP}  # noqa: RUF012 - Gymnasium's own form
    render_mode = None

    def __init__(self, num_envs: int = 8) -> None:
        self.num_envs = num_envs
        self.core = PoseCore()
        self.single_observation_space = gym.spaces.Box(-CLIP, CLIP, (5,), np.float32)
        self.single_action_space = gym.spaces.Box(-1.0, 1.0, (4,), np.float32)
        self._random = np.random.default_rng(0)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[np.ndarray, dict[str, Any]]:
        self._random = np.random.default_rng(seed)
        return self._draw()

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        seen = self.core.preview(actions)
        noise = POSE_NOISE * self._random.standard_normal((self.num_envs, 4)) * POSE.tolerance
        error = np.stack([getattr(seen, name) for name in POSE.errors], axis=-1) + noise
        over = np.ones(self.num_envs, dtype=bool)
        none = ~over
        info = info_of(error, np.zeros((self.num_envs, 2)), np.zeros(self.num_envs, dtype=np.int64), 1.0)
        info |= dict(zip(POSE.errors, error.T, strict=True))
        info["is_success"] = (np.abs(error) <= POSE.tolerance).all(axis=1)
        features, kind = self._draw()
        return features, -info["landing_error"], over, none, {**info, **kind, "final_obs": features}

    def _draw(self) -> tuple[np.ndarray, dict[str, Any]]:
        kind = self._random.integers(3, size=self.num_envs)
        return self._random.standard_normal((self.num_envs, 5)).astype(np.float32), {"kind": kind}


def observation_of(features: np.ndarray, kind: np.ndarray | None = None) -> Observation:
    features = np.asarray(features, dtype=np.float32)
    return Observation(features, np.zeros(len(features), dtype=np.int64) if kind is None else kind)


def outcome_of(observation: Observation, action: np.ndarray, error: np.ndarray) -> Outcome:
    count = len(observation.kind)
    return Outcome(
        observation=observation,
        action=np.asarray(action, dtype=np.float32),
        error=error,
        is_success=np.ones(count, dtype=bool),
        cycle_time=np.ones(count),
        clipped=np.zeros(count, dtype=bool),
        reward=np.zeros(count),
    )


def register_toy() -> None:
    """Make `ToyThrow-v0` (one throw an episode) and `ToyShift-v0` (five throws) known to Gymnasium."""
    for env_id, steps in (("ToyThrow-v0", 1), ("ToyShift-v0", 5)):
        if env_id not in gym.registry:
            gym.register(env_id, vector_entry_point=ToyVectorEnv, kwargs={"steps": steps})
