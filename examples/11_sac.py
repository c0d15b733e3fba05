"""SAC in one file, on the vector form of an environment whose actions are numbers: each throw is kept and learned from.

    python examples/11_sac.py PnTConveyor-v0 --level waste --steps 10000 --save sac.npz

The mean action begins at zero, which is the planner's own throw. What is saved needs NumPy alone.
"""

import argparse
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from torch import Tensor, nn

import pnt_gym

ENVS = [env for env in pnt_gym.ENV_IDS if env not in ("PnTLine-v0", "PnTGrasp-v0")]  # which choose, and which see
RATE, BATCH, DRAG, WIDTH = 1e-3, 256, 0.005, 128
SPREAD = -1.5  # logarithm of the first spread of the actions


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="SAC on an environment of pnt_gym")
    parser.add_argument("env", nargs="?", default="PnTConveyor-v0", choices=ENVS)
    parser.add_argument("--level", help="name or file; the environment's default")
    parser.add_argument("--steps", type=int, default=10000, help="steps of all cells together")
    parser.add_argument("--cells", type=int, default=16)
    parser.add_argument("--start", type=int, default=256, help="steps before the first update")
    parser.add_argument("--gamma", type=float, default=0.0, help="discount; at the conveyor a throw pays at once")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--picks", type=int, default=64, help="throws to judge the policy by; 0 for none")
    parser.add_argument("--save", help="file for the numbers of the policy, .npz")
    return parser.parse_args()


def network(inputs: int, outputs: int) -> nn.Sequential:
    hidden = [nn.Linear(inputs, WIDTH), nn.ReLU(), nn.Linear(WIDTH, WIDTH), nn.ReLU()]
    return nn.Sequential(*hidden, nn.Linear(WIDTH, outputs))


class Actor(nn.Module):
    """Squashed normal actions."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.net = network(inputs, 2 * outputs)
        nn.init.zeros_(self.net[4].weight)
        nn.init.zeros_(self.net[4].bias)

    def sample(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        """Actions (N, A) and their log-probabilities (N,)."""
        mean, spread = self.net(observations).chunk(2, dim=1)
        normal = torch.distributions.Normal(mean, (spread + SPREAD).clamp(-5, 1).exp())
        raw = normal.rsample()
        action = raw.tanh()
        chance = normal.log_prob(raw) - torch.log(1 - action.square() + 1e-6)  # of a squashed number
        return action, chance.sum(dim=1)

    @torch.no_grad()
    def best(self, observations: Tensor) -> np.ndarray:
        return self.net(observations).chunk(2, dim=1)[0].tanh().numpy()


class Memory:
    """The steps that were taken, in the order of their coming."""

    def __init__(self, size: int, inputs: int, outputs: int) -> None:
        self.parts = [torch.zeros(size, width) for width in (inputs, outputs, 1, inputs, 1)]
        self.count = 0

    def keep(self, *steps: Tensor) -> None:
        """Observations, actions, rewards, next observations, and whether the episode ended, a row each."""
        end = self.count + len(steps[0])
        for part, rows in zip(self.parts, steps, strict=True):
            part[self.count : end] = rows.reshape(len(rows), -1)
        self.count = end

    def draw(self) -> list[Tensor]:
        rows = torch.randint(self.count, (BATCH,))
        return [part[rows] for part in self.parts]


class Learner:
    """Actor, two judges of actions, slow copies of these, and the price of certainty."""

    def __init__(self, inputs: int, outputs: int, gamma: float) -> None:
        self.actor, self.gamma, self.target = Actor(inputs, outputs), gamma, -float(outputs)
        self.judges, self.slow = ([network(inputs + outputs, 1) for _ in range(2)] for _ in range(2))
        for judge, slow in zip(self.judges, self.slow, strict=True):
            slow.load_state_dict(judge.state_dict())
        self.price = torch.tensor(-3.0, requires_grad=True)  # logarithm
        numbers = [number for judge in self.judges for number in judge.parameters()]
        self.for_judges = torch.optim.Adam(numbers, lr=RATE)
        self.for_actor = torch.optim.Adam(self.actor.parameters(), lr=RATE)
        self.for_price = torch.optim.Adam([self.price], lr=RATE)

    @staticmethod
    def worth(judges: list[nn.Sequential], observations: Tensor, actions: Tensor) -> list[Tensor]:
        return [judge(torch.cat([observations, actions], dim=1))[:, 0] for judge in judges]

    def update(self, memory: Memory) -> None:
        """One step of each network."""
        observations, actions, rewards, following, ends = memory.draw()
        price = self.price.exp().detach()
        with torch.no_grad():
            goal = rewards[:, 0]
            if self.gamma:
                action, chance = self.actor.sample(following)
                later = torch.minimum(*self.worth(self.slow, following, action)) - price * chance
                goal = goal + self.gamma * (1 - ends[:, 0]) * later
        loss: Any = sum((worth - goal).square().mean() for worth in self.worth(self.judges, observations, actions))
        self.descend(self.for_judges, loss)
        action, chance = self.actor.sample(observations)
        worth = torch.minimum(*self.worth(self.judges, observations, action))
        self.descend(self.for_actor, (price * chance - worth).mean())
        self.descend(self.for_price, -(self.price.exp() * (chance.detach() + self.target)).mean())
        with torch.no_grad():
            for judge, slow in zip(self.judges, self.slow, strict=True):
                for number, follower in zip(judge.parameters(), slow.parameters(), strict=True):
                    follower.lerp_(number, DRAG)

    @staticmethod
    def descend(optimizer: torch.optim.Optimizer, loss: Tensor) -> None:
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()


def train(options: argparse.Namespace) -> Actor:
    """A step of every cell, then as many updates as cells; the vector form begins episodes anew by itself."""
    torch.manual_seed(options.seed)
    level = {} if options.level is None else {"level": options.level}
    env = gym.make_vec(options.env, num_envs=options.cells, **level)
    inputs, outputs = env.single_observation_space.shape[0], env.single_action_space.shape[0]
    learner, memory = Learner(inputs, outputs, options.gamma), Memory(options.steps + options.cells, inputs, outputs)
    observation, total, rounds = env.reset(seed=options.seed)[0], 0.0, max(options.steps // options.cells, 1)
    for number in range(rounds):
        with torch.no_grad():
            action = learner.actor.sample(torch.as_tensor(observation))[0]
        following, reward, over, cut, info = env.step(action.numpy())
        last = following.copy()  # what was seen at the end of an episode, and not the begin of the next one
        for row in np.flatnonzero(over | cut):
            last[row] = info["final_obs"][row]
        # Failed picks and dropped objects tell nothing of their actions.
        rows = info.get("picked", np.ones(len(over), bool)) & ~info.get("dropped", np.zeros(len(over), bool))
        steps = observation[rows], action.numpy()[rows], reward[rows], last[rows], over[rows]
        memory.keep(*(torch.as_tensor(np.asarray(part, dtype=np.float32)) for part in steps))
        observation, total = following, 0.98 * total + 0.02 * float(reward.mean())
        if memory.count >= options.start:
            for _ in range(options.cells):
                learner.update(memory)
        if number % 64 == 63 or number == rounds - 1:
            mean = total / (1 - 0.98 ** (number + 1))
            print(f"after {(number + 1) * options.cells} steps: reward {mean:.3f} a step", flush=True)
    env.close()
    return learner.actor


def main() -> None:
    options = arguments()
    torch.set_num_threads(1)
    actor = train(options)
    if options.save:
        np.savez(options.save, **{name: part.numpy() for name, part in actor.state_dict().items()})
    if options.picks:
        level = {} if options.level is None else {"level": options.level}
        for policy in ("analytic", lambda observations: actor.best(torch.as_tensor(observations))):
            figures = pnt_gym.evaluate(policy, options.env, picks=options.picks, **level)
            error = 1000 * figures["landing_error_mean_m"]
            print(f"{figures['controller']}: {figures['success_rate']:.0%} succeed, {error:.0f} mm from the target")


if __name__ == "__main__":
    main()
