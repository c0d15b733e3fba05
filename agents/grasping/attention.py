"""A network that foretells the gauge at places of a picture, with attention to the earlier tries of a shift.

The network corrects a label that is foretold from the picture alone. An earlier try counts for a place by
exp(-distance): of the objects' looks, and of numbers that the network makes of place and look, once for each head.
What the readings of these tries were beside what was foretold is among the inputs of the correction. The network learns
from many shifts of simulated tries, so that a shift itself needs no fit.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints, concatenate_records, take
from pnt_gym.cells.base.items import BOX, CYLINDER, ELLIPSOID
from pnt_gym.cells.grasp.config import GraspConfig

from ..ground.fitting import fit_from
from ..policies import networks
from ..policies.networks import Layers, layers_from_torch, sigmoid
from .features import SIGHTS, PlaceFeatures, place_features
from .foretelling import PART, Foretold, LabelTable, labels
from .memory import looks
from .scenes import Scenes

LOOKS: Final = 8
"""Numbers of a look, see `memory.looks`."""
INPUTS: Final = len(SIGHTS["local"]) + 1 + LOOKS
"""Numbers of a place: features of the picture, the label that is foretold from the picture, and the object's look."""
LABEL: Final = len(SIGHTS["local"])
"""Number of the foretold label among the inputs."""
HEADS, KEY, WIDTH = 4, 8, 64
"""Heads, numbers of a place by which a head compares, and width of the layers."""
NEARNESS: Final = -0.7
"""Logarithm of the weights of squared differences of looks, before learning."""
SHIFTS, OBJECTS = 8, 8
"""Shifts of a batch of learning, and objects of a shift whose labels are foretold."""
TRIES: Final = (0, 5, 15, 30, 60)
"""Numbers of earlier tries, one of which a batch has."""
LIKELY: Final = 0.75
"""Share of the earlier tries that are where a hold is likely; the others are at any of an object's places."""
RATE: Final = 3e-3
PLACES: Final = 24
"""Places of an object at which simulated tries are made for learning."""
TEMPERATURE: Final = 0.05
"""Of half of these places: each is chosen with a probability proportional to exp(foretold label / temperature)."""
KINDS: Final = 7
"""Kinds of a shift in learning; the k-th comes as often as one over k."""


def place_inputs(features: PlaceFeatures, label: Floats, look: Floats) -> Floats:
    """Inputs (T, D) of places, by labels that are foretold from the pictures (T,) and looks of the objects (N, 8)."""
    local = features.values[:, list(SIGHTS["local"])]
    return np.column_stack([local, label, look[features.picture]])


@final
class TryMemory:
    """Earlier tries of N rows, each of the shift in which it is.

    Args:
        count: number of rows N.
        most: largest number of tries in a shift.
    """

    def __init__(self, count: int, most: int) -> None:
        self._inputs, self._surprise = np.zeros((count, most, INPUTS)), np.zeros((count, most))
        self._known = np.zeros(count, dtype=np.int64)

    def begin(self, rows: Ints) -> None:
        """Forget the former shifts of some rows."""
        self._known[rows] = 0

    def add(self, row: int, inputs: Floats, surprise: float) -> None:
        """Keep a try at a place with inputs (D,), whose label was read by `surprise` above the foretold one."""
        slot = min(int(self._known[row]), self._surprise.shape[1] - 1)
        self._inputs[row, slot], self._surprise[row, slot] = inputs, surprise
        self._known[row] += 1

    def of_row(self, row: int) -> tuple[Floats, Floats]:
        """Inputs (C, D) and surprises (C,) of the tries of a row."""
        known = int(self._known[row])
        return self._inputs[row, :known], self._surprise[row, :known]


class Shown(NamedTuple):
    """Tries at M places of each of N objects, from which a network learns."""

    kind: Ints
    """Kinds of the objects (N,); only the same ones are of one kind."""
    inputs: NDArray[np.float32]
    """(N, M, D)"""
    label: NDArray[np.float32]
    """Labels that were read (N, M)."""

    @property
    def surprise(self) -> NDArray[np.float32]:
        """Labels that were read, less those foretold from the pictures (N, M)."""
        return self.label - self.inputs[:, :, LABEL]


def show_tries(level: GraspConfig, foretold: Foretold, count: int, seed: int) -> Shown:
    """Simulated tries at `PLACES` places of each of a number of objects, in a cell whose cup has no error.

    The first half of the places are at random, the others more likely where a high label is foretold. Objects with
    fewer than `PLACES` pixels are left out.
    """
    random, parts = np.random.default_rng([seed, 9]), list[Shown]()
    for scenes in Scenes.draw(level, count, seed).parts(PART):
        features = place_features(scenes.images, scenes.radius)
        label = foretold.predict(features.values)
        score = random.gumbel(size=(2, len(label)))
        score[1] += label / TEMPERATURE
        begin = np.searchsorted(features.picture, np.arange(features.pictures))
        large = np.bincount(features.picture, minlength=features.pictures) >= PLACES
        best = begin[large, None] + np.arange(PLACES // 2)
        rows = np.concatenate([features.ranked_rows(one)[best] for one in score], axis=1)
        inputs = place_inputs(features, label, _looks(scenes, features))[rows].astype(np.float32)
        places = np.zeros((features.pictures, PLACES, 2))
        places[large] = features.places()[rows]
        read = [labels(scenes.try_places(places[:, k]).vacuum, scenes.radius, scenes.surface) for k in range(PLACES)]
        parts.append(Shown(scenes.objects.kind[large], inputs, np.stack(read, axis=1)[large].astype(np.float32)))
    return concatenate_records(parts)


def _looks(scenes: Scenes, features: PlaceFeatures) -> Floats:
    """Looks of the objects of scenes (N, 8), as the camera measures them."""
    seen = scenes.objects.measured
    shapes = {"is_ellipsoid": ELLIPSOID, "is_cylinder": CYLINDER, "is_box": BOX}
    values = dict(zip(("length", "width", "height"), seen.size.T, strict=True))
    return looks({**values, **{name: (seen.shape == shape).astype(float) for name, shape in shapes.items()}}, features)


@final
class TryNetwork:
    """Foretells labels of the gauge from places and from earlier tries.

    Torch fits the network; NumPy computes it.
    """

    libraries: tuple[str, ...] = ("torch",)
    """Optional libraries by which it fits."""

    def __init__(self) -> None:
        self._layers: dict[str, Layers] = {}
        self._centre, self._scale = np.zeros(INPUTS), np.ones(INPUTS)
        self._nearness, self._prior = np.zeros((HEADS, LOOKS)), np.zeros(HEADS)
        self.table = LabelTable()
        """How labels are spread that the network foretells."""

    def predict(self, inputs: Floats, tried: Floats, surprise: Floats) -> Floats:
        """Labels (T,) at places of one object.

        Args:
            inputs: of the places (T, D).
            tried: inputs of earlier tries (C, D).
            surprise: labels of these tries, less those foretold from the pictures (C,).
        """
        places, keys = self._scaled(inputs), self._scaled(tried)
        apart = (inputs[0, -LOOKS:] - tried[:, -LOOKS:]) ** 2 @ self._nearness.T
        total, mean = np.zeros((len(inputs), HEADS)), np.zeros((len(inputs), HEADS))
        for head, (query, key) in enumerate(zip(self._keys(places), self._keys(keys), strict=True)):
            square = (query**2).sum(axis=1)[:, None] + (key**2).sum(axis=1) - 2.0 * query @ key.T
            weight = np.exp(-np.maximum(square, 0.0) - apart[:, head])
            total[:, head] = weight.sum(axis=1)
            mean[:, head] = weight @ surprise / (total[:, head] + self._prior[head])
        known = np.concatenate([places, mean, np.log1p(total)], axis=1)
        return sigmoid(networks.run(self._layers["head"], "SiLU", known)[:, 0])

    def _scaled(self, inputs: Any) -> Any:
        return np.clip((inputs - self._centre) / self._scale, -5.0, 5.0)

    def _keys(self, scaled: Floats) -> Floats:
        """Numbers by which heads compare places (H, T, K)."""
        return networks.run(self._layers["key"], "SiLU", scaled).reshape(-1, HEADS, KEY).transpose(1, 0, 2)

    def fit(self, shown: Shown, seed: int, steps: int) -> None:
        """Learn from tries, arranged as shifts in which each kind comes again; the kinds of a tenth serve the table."""
        import torch  # noqa: PLC0415 - a second to import, needed for fitting only

        flat = shown.inputs.reshape(-1, INPUTS)
        self._centre, self._scale = flat.mean(axis=0), flat.std(axis=0) + 1e-3
        held_out = shown.kind % 10 == 0
        learned, kept = take(shown, ~held_out), take(shown, held_out)
        random = np.random.default_rng([seed, 8])
        with fit_from(seed):
            model = _Model(torch)
            optimiser = torch.optim.AdamW(model.parameters, lr=RATE, weight_decay=0.01)
            schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
            arranged = _Arranged(torch, learned, self._scaled)
            for _ in range(steps):
                batch = arranged.batch(random)
                loss = torch.nn.functional.binary_cross_entropy_with_logits(model(batch), batch.label)
                optimiser.zero_grad()
                loss.backward()
                torch.nn.utils.clip_grad_norm_(model.parameters, 1.0)
                optimiser.step()
                schedule.step()
            self.restore({**self.state(), **model.arrays()})
            arranged = _Arranged(torch, kept, self._scaled)
            with torch.no_grad():
                batches = [arranged.batch(random) for _ in range(max(steps // 50, 10))]
                pairs = [(torch.sigmoid(model(b)).numpy().ravel(), b.label.numpy().ravel()) for b in batches]
        self.table = LabelTable.counted(*(np.concatenate(side).astype(float) for side in zip(*pairs, strict=True)))

    def state(self) -> dict[str, Any]:
        """Arrays by name."""
        units = {"centre": self._centre, "scale": self._scale, "nearness": self._nearness, "prior": self._prior}
        return {**_named(self._layers), **units, "table": self.table.share}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Load a fit."""
        for part in ("key", "head"):
            own = {n.removeprefix(f"{part}_"): a for n, a in state.items() if n.startswith(f"{part}_")}
            self._layers[part] = networks.layers(own)
        self._centre, self._scale, self._nearness, self._prior = (
            np.asarray(state[name], dtype=np.float64) for name in ("centre", "scale", "nearness", "prior")
        )
        self.table = LabelTable(np.asarray(state["table"], dtype=np.float64))


def _named(layers: Mapping[str, Layers]) -> dict[str, Any]:
    """Arrays of layers, by part and name."""
    return {f"{part}_{name}": array for part, own in layers.items() for name, array in networks.arrays(own).items()}


class _Batch(NamedTuple):
    """Shifts with objects and earlier tries; tensors."""

    places: Any
    """Scaled inputs (S, O, M, D)."""
    looks: Any
    """(S, O, 8)"""
    tried: Any
    """Scaled inputs of the tries (S, C, D)."""
    tried_looks: Any
    """(S, C, 8)"""
    surprise: Any
    """(S, C)"""
    counts: Any
    """1 where a try is of another object (S, O, C)."""
    label: Any
    """(S, O, M)"""


@final
class _Arranged:
    """Tries by the kinds of their objects, and shifts that are made of them."""

    def __init__(self, torch: Any, shown: Shown, scaled: Any) -> None:
        self._tensor, self._shown = torch.as_tensor, shown
        self._scaled = scaled(shown.inputs).astype(np.float32)
        self._of_kind = [np.flatnonzero(shown.kind == kind) for kind in np.unique(shown.kind)]
        self._often = 1.0 / np.arange(1, KINDS + 1)

    def batch(self, random: np.random.Generator) -> _Batch:
        """Shifts, each with the same number of earlier tries; most of these are where a hold is likely."""
        count, places = int(random.choice(TRIES)), self._scaled.shape[1]
        tried, own = (np.zeros((SHIFTS, size), dtype=np.int64) for size in (count, OBJECTS))
        for shift in range(SHIFTS):
            kinds = random.choice(len(self._of_kind), KINDS, replace=False)
            for objects in (tried, own):
                chosen = kinds[random.choice(KINDS, objects.shape[1], p=self._often / self._often.sum())]
                objects[shift] = [random.choice(self._of_kind[kind]) for kind in chosen]
        likely = random.random(tried.shape) < LIKELY
        slot = np.where(
            likely, random.integers(places // 2, places, tried.shape), random.integers(places, size=tried.shape)
        )
        arrays = (
            self._scaled[own], self._shown.inputs[own, 0, -LOOKS:], self._scaled[tried, slot],
            self._shown.inputs[tried, 0, -LOOKS:], self._shown.surprise[tried, slot],
            (own[:, :, None] != tried[:, None]).astype(np.float32), self._shown.label[own],
        )  # fmt: skip
        return _Batch(*map(self._tensor, arrays))


@final
class _Model:
    """The network in torch; its call gives logits (S, O, M) of the labels of a batch."""

    def __init__(self, torch: Any) -> None:
        self._torch, layer = torch, torch.nn.Linear
        self._key = [layer(INPUTS, WIDTH), layer(WIDTH, HEADS * KEY)]
        self._head = [layer(INPUTS + 2 * HEADS, WIDTH), layer(WIDTH, WIDTH), layer(WIDTH, 1)]
        self._nearness = torch.nn.Parameter(torch.full((HEADS, LOOKS), NEARNESS))
        self._prior = torch.nn.Parameter(torch.zeros(HEADS))

    @property
    def parameters(self) -> list[Any]:
        """All that is learned."""
        layers = [one for layer in (*self._key, *self._head) for one in layer.parameters()]
        return [*layers, self._nearness, self._prior]

    def __call__(self, batch: _Batch) -> Any:
        """Compute the logits."""
        torch = self._torch
        query, key = (self._run(self._key, x).unflatten(-1, (HEADS, KEY)) for x in (batch.places, batch.tried))
        square = (query**2).sum(-1)[:, :, :, None] + (key**2).sum(-1)[:, None, None]
        apart = ((batch.looks[:, :, None] - batch.tried_looks[:, None]) ** 2) @ torch.exp(self._nearness).T
        distance = square - 2.0 * torch.einsum("somhk,schk->somch", query, key) + apart[:, :, None]
        weight = torch.exp(-distance) * batch.counts[:, :, None, :, None]
        total = weight.sum(3)
        mean = (weight * batch.surprise[:, None, None, :, None]).sum(3) / (total + torch.exp(self._prior))
        return self._run(self._head, torch.cat([batch.places, mean, torch.log1p(total)], -1))[..., 0]

    def _run(self, layers: list[Any], value: Any) -> Any:
        for layer in layers[:-1]:
            value = self._torch.nn.functional.silu(layer(value))
        return layers[-1](value)

    def arrays(self) -> dict[str, Any]:
        """Arrays by name, as `TryNetwork.state` has them."""
        parts = {"key": self._key, "head": self._head}
        layers = {part: layers_from_torch([t for one in own for t in one.parameters()]) for part, own in parts.items()}
        nearness, prior = (logarithm.detach().exp().numpy() for logarithm in (self._nearness, self._prior))
        return {**_named(layers), "nearness": nearness, "prior": prior}
