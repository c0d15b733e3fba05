"""A convolutional network that learns by trying where to grasp in a picture, and a small one how to throw.

    python examples/12_cnn_grasp.py --picks 30000 --save cnn_grasp.npz

The first network values places: of every second pixel it says what a grasp there is worth. It learns from the pixels
that were tried. The second one reads the gauge of what hangs under the cup, and says for each pace what the throw is
worth and where it lands. A pick is worth 1 if it is sorted, less what is usually sorted in its time. What is saved
needs NumPy alone.
"""

import argparse
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from torch import Tensor, nn

import pnt_gym

PIXEL, REACH, SIDE = 0.005, 0.10, 24  # m, m, and places along a picture
SHIFT = torch.tensor([0.20, 0.06])  # landing moved by a release of 1, along and across [m]
HOLDS, FAILED, LENGTH = 19, slice(23, 25), 0.05  # entries of the vector, and the scale of a place in it [m]
PACES = torch.linspace(-1.0, 1.0, 9)
CENTRES = PIXEL * (2 * torch.arange(SIDE) - 23.5)
PLACES = torch.stack(torch.meshgrid(-CENTRES, CENTRES, indexing="ij")[::-1], dim=-1).reshape(-1, 2)  # x, y [m]


class Places(nn.Module):
    """Values of the places of pictures; a place sees 17 x 17 pixels."""

    def __init__(self) -> None:
        super().__init__()
        layers = [nn.Conv2d(5, 16, 5, 2), nn.ReLU(), nn.Conv2d(16, 32, 3), nn.ReLU(), nn.Conv2d(32, 32, 3), nn.ReLU()]
        self.eye = nn.Sequential(*layers, nn.Conv2d(32, 32, 3))
        self.beside, self.last = nn.Linear(32, 32), nn.Linear(32, 1)

    def forward(self, images: Tensor, vectors: Tensor) -> Tensor:
        """Values (N, H, W) of pictures (N, 5, 2 H + 15, 2 W + 15)."""
        seen = self.eye(images.float() / 255 - 0.5).permute(0, 2, 3, 1)
        return self.last(torch.relu(seen + self.beside(vectors)[:, None, None]))[..., 0]


def padded(images: Tensor) -> Tensor:
    return nn.functional.pad(images, (8, 8, 8, 8))


class Grasper:
    """Both networks, and the choices that they make."""

    def __init__(self) -> None:
        self.places = Places()
        self.throws = nn.Sequential(nn.Linear(33, 64), nn.ReLU(), nn.Linear(64, 64), nn.ReLU(), nn.Linear(64, 3))

    def of_paces(self, vectors: Tensor) -> Tensor:
        """Worth of a throw at each pace, and its landing along and across without a correction (N, 9, 3)."""
        paces = PACES.expand(len(vectors), 9)[..., None]
        return self.throws(torch.cat([vectors[:, None].expand(-1, 9, -1), paces], dim=2))

    @torch.no_grad()
    def act(self, observation: dict[str, np.ndarray], explore: float = 0.0) -> tuple[np.ndarray, Tensor]:
        """Actions (N, 6), and the places that they choose (N,); a share of the choices is random."""
        images, vectors = (torch.as_tensor(np.array(observation[name])) for name in ("image", "vector"))
        count = len(vectors)
        values = self.places(padded(images), vectors).reshape(count, -1)
        is_object = images[:, 0, ::2, ::2].reshape(count, -1) > 8  # mm above the belt
        failed = vectors[:, FAILED] * LENGTH
        tried = (failed != 0).any(dim=1, keepdim=True)
        near = torch.cdist(failed, PLACES) < 0.015
        values = values.masked_fill(~is_object | (tried & near), -9.0)
        chance = torch.where(is_object, 1.0, 1e-6)
        place = torch.where(torch.rand(count) < explore, torch.multinomial(chance, 1)[:, 0], values.argmax(dim=1))
        worth = self.of_paces(vectors)
        best = torch.where(torch.rand(count) < explore, torch.randint(9, (count,)), worth[..., 0].argmax(dim=1))
        error = worth[torch.arange(count), best, 1:]
        actions = torch.zeros(count, 6)
        actions[:, :2] = (PLACES[place] / REACH).clamp(-1, 1)
        actions[:, 2] = 1.0 - vectors[:, HOLDS]  # grasp again, or throw what hangs there
        actions[:, 3], actions[:, 4:] = PACES[best], (-error / SHIFT).clamp(-1, 1)
        return actions.numpy(), place

    def state(self) -> dict[str, np.ndarray]:
        parts = {"places": self.places, "throws": self.throws}
        return {f"{name}.{key}": v.numpy() for name, net in parts.items() for key, v in net.state_dict().items()}


def fit(network: nn.Module, loss_of: Any, count: int, steps: int) -> None:
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)
    for _ in range(steps):
        loss = loss_of(torch.randint(count, (128,)))
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()


def learn(grasper: Grasper, tries: list[Tensor], thrown: list[Tensor], lost: float, steps: int) -> None:
    """Fit both networks to all that happened; a grasp that holds is worth its best throw."""
    patches, vectors, held, following = tries
    seen, worth, errors = thrown

    def of_throws(rows: Tensor) -> Tensor:
        given, landed = grasper.throws(seen[rows]), errors[rows].isfinite()
        miss = (given[:, 1:] - errors[rows].nan_to_num()) * landed / 0.05  # dropped objects have no landing
        return (given[:, 0] - worth[rows]).square().mean() + nn.functional.huber_loss(miss, torch.zeros_like(miss))

    fit(grasper.throws, of_throws, len(worth), steps)
    with torch.no_grad():
        goal = torch.where(held, grasper.of_paces(following)[..., 0].amax(dim=1), torch.tensor(lost))

    def of_places(rows: Tensor) -> Tensor:
        turns, flips = int(torch.randint(4, ())), int(torch.randint(2, ()))  # a seal knows no direction
        seen = patches[rows].rot90(turns, (2, 3))
        seen = seen.flip(3) if flips else seen
        return (grasper.places(seen, vectors[rows])[:, 0, 0] - goal[rows]).square().mean()

    fit(grasper.places, of_places, len(goal), steps)


def train(options: argparse.Namespace) -> Grasper:
    """Pick, and fit both networks again whenever there are half as many picks more; at the end for longer."""
    torch.manual_seed(options.seed)
    env = gym.make_vec("PnTGrasp-v0", num_envs=options.cells, level={"base": "grasp", "fidelity": "flight"})
    grasper, rows, due = Grasper(), torch.arange(options.cells), options.picks // 20
    observation, explore = env.reset(seed=options.seed)[0], 1.0
    tries: list[tuple[Tensor, ...]] = []  # patches, vectors, whether the cup holds, and vectors then
    thrown: list[tuple[Tensor, ...]] = []  # vectors with paces, sorted or not, seconds, errors without a correction
    ended: list[np.ndarray] = []  # sorted or not and seconds of all picks
    while sum(map(len, ended)) < options.picks:
        actions, place = grasper.act(observation, explore)
        image, vector = (torch.as_tensor(np.array(observation[name])) for name in ("image", "vector"))
        observation, _, over, _, info = env.step(actions)
        following, over, done = torch.as_tensor(observation["vector"]), torch.as_tensor(over), torch.as_tensor(actions)
        windows = padded(image).unfold(2, 17, 2).unfold(3, 17, 2)  # (N, 5, 24, 24, 17, 17)
        patches = windows[rows, :, place // SIDE, place % SIDE]
        grasps, throws = vector[:, HOLDS] == 0, over & (vector[:, HOLDS] == 1)
        held = ~over & (following[:, HOLDS] == 1)
        tries.append(tuple(part[grasps] for part in (patches, vector, held, following)))
        if over.any():
            names = ("is_success", "cycle_time", "landing_along", "landing_across")
            told = torch.as_tensor(np.stack([info[name].astype(np.float32) for name in names], axis=1))
            ended.append(told[over, :2].numpy())
            errors = told[:, 2:] - SHIFT * done[:, 4:]
            paced = torch.cat([vector, done[:, 3:4]], dim=1)
            thrown.append(tuple(part[throws] for part in (paced, told[:, 0], told[:, 1], errors)))
        if sum(map(len, ended)) >= due:
            recent = np.concatenate(ended)[-due // 3 :]
            rate = float(recent[:, 0].sum() / recent[:, 1].sum())  # sorted a second
            seen, is_sorted, seconds, errors = map(torch.cat, zip(*thrown, strict=True))
            parts = [torch.cat(part) for part in zip(*tries, strict=True)]
            is_last, lost = due == options.picks, -rate * float(recent[:, 1].mean())
            learn(grasper, parts, [seen, is_sorted - rate * seconds, errors], lost, options.updates * (1 + 2 * is_last))
            print(f"after {due} picks: {60 * rate:.1f} sorted a minute", flush=True)
            explore = max(0.3 * (1 - due / options.picks), 0.1)
            due = min(3 * due // 2, options.picks) + is_last
    env.close()
    return grasper


def main() -> None:
    parser = argparse.ArgumentParser(description="learn to grasp from pictures")
    parser.add_argument("--picks", type=int, default=30000, help="picks to learn from")
    parser.add_argument("--updates", type=int, default=1200, help="steps of each network at each fit")
    parser.add_argument("--cells", type=int, default=64)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--judge", type=int, default=64, help="picks to judge by; 0 for none")
    parser.add_argument("--save", help="file for the numbers of the networks, .npz")
    options = parser.parse_args()
    torch.set_num_threads(1)
    grasper = train(options)
    if options.save:
        np.savez(options.save, **grasper.state())
    if options.judge:
        for policy in ("centre", "centroid", lambda observation: grasper.act(observation)[0]):
            figures = pnt_gym.evaluate(policy, "PnTGrasp-v0", picks=options.judge)
            print(f"{figures['controller']}: {figures['sorted_per_min']:.1f} sorted a minute", flush=True)


if __name__ == "__main__":
    main()
