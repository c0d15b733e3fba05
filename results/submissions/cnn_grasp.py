"""The networks that `python examples/12_cnn_grasp.py --picks 30000 --save FILE` saves, with NumPy alone."""

from pathlib import Path

import numpy as np

PIXEL, REACH, SIDE = 0.005, 0.10, 24  # m, m, and places along a picture
SHIFT = np.array([0.20, 0.06])  # landing moved by a release of 1 [m]
CENTRES = PIXEL * (2 * np.arange(SIDE) - 23.5)
PLACES = np.stack(np.broadcast_arrays(CENTRES[None, :], -CENTRES[:, None]), axis=-1).reshape(-1, 2)  # x, y [m]
PACES = np.linspace(-1.0, 1.0, 9)


def convolution(planes, weight, bias, stride=1):
    """Maps (N, K, H, W) of windows in planes (N, C, h, w)."""
    size = weight.shape[-1]
    windows = np.lib.stride_tricks.sliding_window_view(planes, (size, size), axis=(2, 3))[:, :, ::stride, ::stride]
    return np.einsum("nchwij,kcij->nkhw", windows, weight, optimize=True) + bias[:, None, None]


class Sees:
    """A network that values the places of a picture, and one that values paces and says where a throw lands."""

    name = "cnn_grasp"

    def __init__(self):
        with np.load(Path(__file__).with_suffix(".npz"), allow_pickle=False) as file:
            self.numbers = {name: file[name].astype(float) for name in file.files}

    def reset(self, seed):
        """Nothing to forget."""

    def learn(self, outcome):
        """Nothing: it has learned before."""

    def layer(self, name):
        """Weight and bias."""
        return self.numbers[f"{name}.weight"], self.numbers[f"{name}.bias"]

    def dense(self, name, value):
        """What a full layer gives."""
        weight, bias = self.layer(name)
        return value @ weight.T + bias

    def values(self, images, vectors):
        """Values of places (N, 576)."""
        planes = np.pad(images, ((0, 0), (0, 0), (8, 8), (8, 8))) / 255.0 - 0.5
        for number, stride in ((0, 2), (2, 1), (4, 1)):
            planes = np.maximum(convolution(planes, *self.layer(f"places.eye.{number}"), stride), 0.0)
        seen = convolution(planes, *self.layer("places.eye.6")).transpose(0, 2, 3, 1)
        beside = self.dense("places.beside", vectors)[:, None, None]
        return self.dense("places.last", np.maximum(seen + beside, 0.0)).reshape(len(images), -1)

    def throws(self, vectors):
        """Worth of each pace, and landing along and across with it (N, 9, 3)."""
        value = np.stack([np.c_[vectors, np.full(len(vectors), pace)] for pace in PACES], axis=1)
        for number in (0, 2):
            value = np.maximum(self.dense(f"throws.{number}", value), 0.0)
        return self.dense("throws.4", value)

    def act(self, observation):
        """Actions (N, 6): place, whether to try again, pace and release."""
        vectors, images = observation.features.astype(float), observation.image
        rows = np.arange(len(vectors))
        failed = vectors[:, 23:25] * 0.05  # m
        near = np.linalg.norm(failed[:, None] - PLACES, axis=-1) < 0.015
        is_belt = images[:, 0, ::2, ::2].reshape(len(images), -1) <= 8  # mm
        avoided = is_belt | (near & (failed != 0).any(axis=1)[:, None])
        place = np.where(avoided, -9.0, self.values(images, vectors)).argmax(axis=1)
        worth = self.throws(vectors)
        best = worth[..., 0].argmax(axis=1)
        actions = np.zeros((len(vectors), 6))
        actions[:, :2] = PLACES[place] / REACH
        actions[:, 2] = 1.0 - vectors[:, 19]  # grasp again, or throw what hangs there
        actions[:, 3], actions[:, 4:] = PACES[best], -worth[rows, best, 1:] / SHIFT
        return np.clip(actions, -1.0, 1.0)
