"""What a cell may have that the model has not: how each such effect moves landings, and what gauges' readings say."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final, final

import numpy as np
from scipy.optimize import root_scalar
from scipy.stats import norm

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig

from .density import Density, Mode
from .hidden import residues
from .log import ThrowLog
from .model import ThrowModel

DRAUGHT, DRAG, DELAY, BLOW_OFF, PLACE = 0.2, 0.1, 0.001, 0.1, 0.005
"""Steps of differences: air [m/s], logarithm of the drag, delay [s], push [m/s], place on the belt [m]."""
FEWEST: Final = 2
"""Fewest landings of an item that is tested alone."""
TINY: Final = 1e-12
"""Least probability of a reading, so that one far from its item still has a score."""
FARTHEST: Final = 5.0
"""Bound of the logarithm of a factor of readings."""


@final
@dataclass(frozen=True)
class Effect:
    """An effect that the model leaves out."""

    test: str
    """Name of the test to which the effect belongs."""
    change: Floats
    """Change of the landings (N, 2, Q) [m] with each of Q sizes."""
    text: Callable[[Floats], str]
    """What the cell may have, at sizes (Q,)."""


def effects(density: Density, mode: Mode) -> list[Effect]:
    """All effects on landings, at the maximum of a posterior."""
    config, model = density.level(mode.z), density.model
    middle = model.landings(config)
    # Changes (N, 2, 2) with the scale and with the turn [rad] of the camera that measures them.
    x, y = (middle - np.nanmean(middle, axis=0)).T
    turned = np.stack([np.stack([x, -y], axis=1), np.stack([y, x], axis=1)], axis=1)
    wind = [model.landings(config, air) - middle for air in ((DRAUGHT, 0.0), (0.0, DRAUGHT))]
    found = [
        Effect("draught", np.stack(wind, axis=2) / DRAUGHT, lambda v: f"air that moves {np.hypot(*v):.2g} m/s"),
        Effect("bin_camera", turned, partial(_text, "bins")),
        Effect("belt_camera", _belt_camera(model, config, middle), partial(_text, "belt")),
        *_by_item(model, config, middle),
    ]
    if all(parameter.name != "blow_off" for parameter in density.parameters):
        blown = config.cup.model_copy(update={"blow_off": config.cup.blow_off + BLOW_OFF})
        push = (model.landings(config.model_copy(update={"cup": blown})) - middle)[:, :, None] / BLOW_OFF
        found.append(Effect("blow_off", push, lambda v: f"a cup that blows objects off {v[0]:+.2g} m/s faster"))
    return found


def _text(place: str, size: Floats) -> str:
    """What a camera may have, at its scale and turn [rad]."""
    turn = np.rad2deg(size[1])
    return f"a camera over the {place} that is scaled by {1.0 + size[0]:.3f} and turned by {turn:+.1f} degrees"


def _belt_camera(model: ThrowModel, config: ConveyorConfig, middle: Floats) -> Floats:
    """Changes of landings (N, 2, 2) [m] with scale and turn of the belt's camera, which sees across the belt."""
    bias = config.bias
    moved = [(bias.camera[0] + PLACE, bias.camera[1]), (bias.camera[0], bias.camera[1] + PLACE)]
    along, across = (
        (model.landings(config.model_copy(update={"bias": bias.model_copy(update={"camera": place})})) - middle) / PLACE
        for place in moved
    )
    lane = (model.log.pick[:, 1] - model.log.pick[:, 1].mean())[:, None]
    return np.stack([lane * across, -lane * along], axis=2)


def _by_item(model: ThrowModel, config: ConveyorConfig, middle: Floats) -> Iterator[Effect]:
    """Another drag and another delay of each item that landed often enough."""
    bias, m = config.bias, config.mismatch
    thicker = bias.model_copy(update={"drag": (1.0 + bias.drag) * np.exp(DRAG) - 1.0})
    later = bias.model_copy(update={"delay": bias.delay + DELAY / m})
    drag, delay = (model.landings(config.model_copy(update={"bias": part})) - middle for part in (thicker, later))
    kinds = model.log.kind[model.log.has_landing]
    for kind in np.unique(kinds):
        if (kinds == kind).sum() >= FEWEST:
            name, own = config.items[kind], (model.log.kind == kind)[:, None, None]
            yield Effect(
                "drag", np.where(own, drag[:, :, None] / DRAG, 0.0),
                lambda v, name=name: f"{name} of {np.exp(np.clip(v[0], -FARTHEST, FARTHEST)):.2g} times the drag, "
                "or of another mass or size than measured",
            )  # fmt: skip
            yield Effect(
                "delay", np.where(own, delay[:, :, None] / DELAY, 0.0),
                lambda v, name=name: f"{name} that comes free {abs(v[0]):.1f} ms "
                f"{'later' if v[0] > 0.0 else 'earlier'}, as with another seal or mass than measured",
            )  # fmt: skip


@final
@dataclass(frozen=True)
class Readings:
    """What a gauge read of the objects, against what the level's items have."""

    gauge: str
    chance: float
    """Probability of readings so far from the items' on average, if gauge and items are as in the level."""
    factor: float
    """Factor by which the readings differ."""


def readings(log: ThrowLog, config: ConveyorConfig) -> list[Readings]:
    """Of each gauge, whether its readings are those of the level's items; gauges of what never differs are left out.

    A reading's probability to be smaller is as likely any number from 0 to 1, so its normal score is normal, and so is
    the sum of scores.
    """
    results = list[Readings]()
    for gauge, (values, middle, width) in _expected(log, config).items():
        seen = np.isfinite(values)
        if not seen.any() or not width[seen].all():
            continue

        def total(shift: float, miss: Floats, width: Floats) -> float:
            lower = norm.cdf((miss - shift) / width).mean(axis=1)
            return float(norm.ppf(np.clip(lower, TINY, 1.0 - TINY)).sum())

        given = np.log(values[seen])[:, None] - middle[seen], width[seen, None]
        score = total(0.0, *given) / np.sqrt(seen.sum())
        factor = float(np.exp(root_scalar(total, args=given, bracket=(-FARTHEST, FARTHEST)).root))
        results.append(Readings(gauge, float(2.0 * norm.sf(abs(score))), factor))
    return results


def _expected(log: ThrowLog, config: ConveyorConfig) -> dict[str, tuple[Floats, Floats, Floats]]:
    """By gauge: readings (N,), equally likely middles of their logarithms (N, R), and deviations (N,)."""
    table, spread, noise, one = item_arrays(config.item_list()), config.spread, config.noise, np.ones(len(log))
    heavy = np.log(table.mass[log.kind])[:, None] + np.log1p(residues(config, table, log.kind))
    expected = {
        "mass": (log.mass, heavy, np.hypot(spread.mass, noise.mass) * one),
        "seal": (log.seal, np.log(table.seal_force[log.kind])[:, None], np.hypot(spread.seal, noise.seal) * one),
    }
    for axis, (name, blur) in enumerate({"length": noise.size, "width": noise.size, "height": 0.0}.items()):
        middle = table.size[log.kind, axis]
        width = np.sqrt(spread.size**2 + spread.size_axis**2 + (blur / middle) ** 2)
        expected[name] = log.size[:, axis], np.log(middle)[:, None], width
    return expected
