"""PPO in one file, on the vector form of any environment: numbers, masked choices, or pictures beside numbers.

    python examples/10_ppo.py PnTRelease-v0 --level waste --steps 60000 --save ppo.npz
    python examples/10_ppo.py PnTGrasp-v0 --steps 60000

The mean action begins at zero, which is the planner's own throw. What is saved needs NumPy alone.
"""

import argparse
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from gymnasium.spaces import Dict, Discrete
from torch import Tensor, nn

import pnt_gym

GAMMA = {"PnTLine-v0": 0.99, "PnTGrasp-v0": 1.0}  # elsewhere a throw pays at once
LAMBDA, CLIP, EPOCHS, BATCH, RATE, SPREAD = 0.95, 0.2, 8, 256, 1e-3, 0.25


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="PPO on an environment of pnt_gym")
    parser.add_argument("env", nargs="?", default="PnTRelease-v0", choices=pnt_gym.ENV_IDS)
    parser.add_argument("--level", help="name or file; the environment's default")
    parser.add_argument("--flight", action="store_true", help="learn from flights, without the robot: faster")
    parser.add_argument("--steps", type=int, default=60000, help="steps of all cells together")
    parser.add_argument("--cells", type=int, default=64)
    parser.add_argument("--rollout", type=int, default=16, help="steps of a cell between two updates")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--picks", type=int, default=64, help="throws to judge the policy by; 0 for none")
    parser.add_argument("--save", help="file for the numbers of the policy, .npz")
    return parser.parse_args()


def make(options: argparse.Namespace) -> Any:
    """The vector form; a level without a base stands on the environment's default."""
    level = {} if options.level is None else {"level": options.level}
    if options.flight:
        level = {"level": {**({"base": options.level} if options.level else {}), "fidelity": "flight"}}
    return gym.make_vec(options.env, num_envs=options.cells, **level)


def dense(inputs: int, outputs: int, scale: float = 1.0) -> nn.Linear:
    layer = nn.Linear(inputs, outputs)
    nn.init.orthogonal_(layer.weight, scale)
    nn.init.zeros_(layer.bias)
    return layer


class Agent(nn.Module):
    """Policy and value of one observation, each a network of two hidden layers; pictures go through convolutions."""

    def __init__(self, observations: Any, actions: Any) -> None:
        super().__init__()
        self.sees, self.chooses = isinstance(observations, Dict), isinstance(actions, Discrete)
        numbers = observations["vector"].shape[0] if self.sees else observations.shape[0]
        self.eye = nn.Sequential()
        if self.sees:
            planes = observations["image"].shape[0]
            layers = [
                nn.Conv2d(planes, 16, 5, 2),
                nn.ReLU(),
                nn.Conv2d(16, 32, 3, 2),
                nn.ReLU(),
                nn.Conv2d(32, 32, 3, 2),
            ]
            self.eye = nn.Sequential(*layers, nn.ReLU(), nn.Flatten(), nn.LazyLinear(64), nn.Tanh())
            self.eye(torch.zeros(1, *observations["image"].shape))  # which settles the size of the last layer
            numbers += 64
        outputs = int(actions.n) if self.chooses else actions.shape[0]
        hidden = [dense(numbers, 64, 2**0.5), nn.Tanh(), dense(64, 64, 2**0.5), nn.Tanh()]
        self.policy = nn.Sequential(*hidden, dense(64, outputs, 0.0))
        self.value = nn.Sequential(
            dense(numbers, 64, 2**0.5), nn.Tanh(), dense(64, 64, 2**0.5), nn.Tanh(), dense(64, 1)
        )
        self.spread = nn.Parameter(torch.full((outputs,), float(np.log(SPREAD))))

    def features(self, observation: dict[str, Tensor]) -> Tensor:
        if not self.sees:
            return observation["vector"]
        return torch.cat([observation["vector"], self.eye(observation["image"].float() / 255 - 0.5)], dim=1)

    def judge(self, observation: dict[str, Tensor], action: Tensor | None = None) -> tuple[Tensor, ...]:
        """Action, its log-probability, entropy, and value of observations (N, ...)."""
        features = self.features(observation)
        raw = self.policy(features)
        if self.chooses:
            chances: Any = torch.distributions.Categorical(logits=raw.masked_fill(~observation["mask"], -1e9))
        else:
            normal = torch.distributions.Normal(raw, self.spread.exp())
            chances = torch.distributions.Independent(normal, 1)
        action = chances.sample() if action is None else action
        return action, chances.log_prob(action), chances.entropy(), self.value(features)[:, 0]

    @torch.no_grad()
    def best(self, observation: dict[str, Tensor]) -> np.ndarray:
        """The mean action, or the likeliest choice."""
        raw = self.policy(self.features(observation))
        if self.chooses:
            return raw.masked_fill(~observation["mask"], -1e9).argmax(dim=1).numpy()
        return raw.clamp(-1, 1).numpy()


def seen(observation: Any, info: dict[str, Any]) -> dict[str, Tensor]:
    """An observation as tensors, with the mask of what may be chosen."""
    parts = dict(observation) if isinstance(observation, dict) else {"vector": observation}
    if "action_mask" in info:
        parts["mask"] = info["action_mask"].astype(bool)
    return {name: torch.as_tensor(np.array(part)) for name, part in parts.items()}


def advantages(rewards: Tensor, values: Tensor, ends: Tensor, last: Tensor, gamma: float) -> Tensor:
    """Generalised advantages of rollouts (T, N)."""
    result, carried = torch.zeros_like(rewards), torch.zeros_like(last)
    for t in reversed(range(len(rewards))):
        goes_on = 1.0 - ends[t]
        error = rewards[t] + gamma * goes_on * last - values[t]
        carried = error + gamma * LAMBDA * goes_on * carried
        result[t], last = carried, values[t]
    return result


def update(agent: Agent, optimizer: torch.optim.Optimizer, data: dict[str, Any]) -> None:
    """Several epochs of clipped steps on one rollout."""
    count = len(data["action"])
    for _ in range(EPOCHS):
        for rows in torch.randperm(count).split(BATCH):
            observation = {name: part[rows] for name, part in data["observation"].items()}
            _, chance, entropy, value = agent.judge(observation, data["action"][rows])
            gain = data["gain"][rows]
            gain = (gain - gain.mean()) / (gain.std() + 1e-8)
            ratio = (chance - data["chance"][rows]).exp()
            surrogate = torch.minimum(ratio * gain, ratio.clamp(1 - CLIP, 1 + CLIP) * gain).mean()
            bonus = 0.01 * entropy.mean() if agent.chooses else 0.0  # a spread of throws needs none
            loss = 0.5 * (value - data["target"][rows]).square().mean() - surrogate - bonus
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimizer.step()


def train(options: argparse.Namespace) -> Agent:
    """Roll out, learn, and repeat; the rate falls to zero."""
    torch.manual_seed(options.seed)
    env = make(options)
    agent = Agent(env.single_observation_space, env.single_action_space)
    optimizer = torch.optim.Adam(agent.parameters(), lr=RATE)
    observation = seen(*env.reset(seed=options.seed))
    updates = max(options.steps // (options.cells * options.rollout), 1)
    for number in range(updates):
        optimizer.param_groups[0]["lr"] = RATE * (1 - number / updates)
        steps: list[tuple[Any, ...]] = []
        for _ in range(options.rollout):
            with torch.no_grad():
                action, chance, _, value = agent.judge(observation)
            following, reward, over, cut, info = env.step(action.numpy())
            end = torch.as_tensor((over | cut).astype(np.float32))  # the next observation is of a new episode
            steps.append((observation, action, chance, value, torch.as_tensor(reward.astype(np.float32)), end))
            observation = seen(following, info)
        with torch.no_grad():
            last = agent.judge(observation)[3]
        parts, action, chance, value, reward, end = zip(*steps, strict=True)
        values, rewards = torch.stack(value), torch.stack(reward)
        gain = advantages(rewards, values, torch.stack(end), last, GAMMA.get(options.env, 0.0))
        whole = {name: torch.cat([part[name] for part in parts]) for name in parts[0]}
        data = {"observation": whole, "action": torch.cat(action), "chance": torch.cat(chance)}
        update(agent, optimizer, {**data, "gain": gain.flatten(), "target": (gain + values).flatten()})
        if number % 10 == 0 or number == updates - 1:
            count = (number + 1) * options.cells * options.rollout
            print(f"after {count} steps: reward {rewards.mean():.3f} a step", flush=True)
    env.close()
    return agent


def main() -> None:
    options = arguments()
    torch.set_num_threads(1)
    agent = train(options)
    if options.save:
        np.savez(options.save, **{name: part.numpy() for name, part in agent.state_dict().items()})
    if options.picks and not agent.chooses:  # a line is judged in work shifts: `pnt-gym evaluate`
        level = {} if options.level is None else {"level": options.level}
        for policy in ("analytic" if not agent.sees else "centre", lambda o: agent.best(seen(o, {}))):
            figures = pnt_gym.evaluate(policy, options.env, picks=options.picks, **level)
            print(f"{figures['controller']}: {figures['sorted_per_min']:.1f} sorted a minute")


if __name__ == "__main__":
    main()
