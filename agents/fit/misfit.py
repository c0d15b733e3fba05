"""Whether the model fits a log: score tests against what the model leaves out, and the scatter of the throws.

A score test asks whether the residuals lean the way that a left-out effect would push the landings. Under the model the
score g'r of whitened residuals r at the maximum has the covariance g'g - g'J S J'g, with the whitened slopes J of the
parameters and their posterior covariance S. Residuals are winsorised, so that single accidents raise no alarm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from scipy.stats import chi2, norm

from pnt_gym.arrays import Bools, Floats

from ..ground.cli import UsageError
from .density import Density, Mode

LEVEL: Final = 0.05
"""Probability of any alarm where the model is right."""
WINSOR: Final = 2.8
"""Mahalanobis distance to which farther residuals are brought."""
_CUT: Final = WINSOR**2
_SHARE: Final = float(np.exp(-_CUT / 2.0))
EXPECTED: Final = 2.0 * (1.0 - _SHARE)
"""Mean of min(d2, WINSOR^2) of a chi-square variable d2 with two degrees of freedom."""
DEVIATION: Final = float(np.sqrt(2.0 * (4.0 - _SHARE * (2.0 * _CUT + 4.0)) - EXPECTED**2))
"""Its standard deviation."""
FEWEST: Final = 2
"""Fewest landings of an item that is tested alone."""
DRAUGHT, DRAG, DELAY = 0.2, 0.1, 0.001
"""Steps of differences: air [m/s], logarithm of the drag, delay [s]."""

DRAUGHT_TEXT: Final = (
    "landings lean as in a draught, for instance "
    "(those of a camera over the bins that is turned or scaled look the same)"
)


@final
@dataclass(frozen=True)
class Finding:
    """Result of one test."""

    name: str
    chance: float
    """Probability of such residuals where the model is right, corrected for the items that were tried."""
    text: str
    """What the cell may have that the model has not, as an example: other causes may act alike."""

    @property
    def alarms(self) -> bool:
        """Whether the test says that the model does not fit."""
        return self.chance < LEVEL / len(TESTS)


TESTS: Final = ("draught", "drag", "delay", "scatter")
"""Tests, among which the probability of an alarm is divided."""


def scatter(mode: Mode) -> tuple[float, float]:
    """Factor by which the throws' covariance is larger than assumed, and the probability of so large a scatter.

    Raises:
        UsageError: every landing is astray.
    """
    square = (mode.residual**2).sum(axis=1)[mode.regular > 0.5]
    if not square.size:
        raise UsageError(
            "no landing lies where this level lets its throw land; check the log's lengths and frame, and bins, belt "
            "and items of the level"
        )
    used = len(mode.z) - np.trace(mode.covariance)
    expected = EXPECTED * max(1.0 - used / max(2.0 * len(square), 1.0), 0.1)

    def excess(factor: float) -> float:
        return float(np.minimum(square / factor, _CUT).mean()) - expected

    # The mean falls with the factor, so bisection on its logarithm finds the factor.
    low, high = np.log(1e-2), np.log(1e2)
    for _ in range(40):
        middle = (low + high) / 2.0
        low, high = (middle, high) if excess(np.exp(middle)) > 0.0 else (low, middle)
    chance = norm.sf(excess(1.0) / (DEVIATION / np.sqrt(len(square))))
    return float(np.exp(low)), float(chance)


def find(density: Density, mode: Mode) -> list[Finding]:
    """Results of all tests at the maximum of a posterior."""
    factor, chance = scatter(mode)
    config, model = density.level(mode.z), density.model
    middle = model.landings(config)
    wind = [(model.landings(config, air) - middle) / DRAUGHT for air in ((DRAUGHT, 0.0), (0.0, DRAUGHT))]
    bias, m = config.bias, config.mismatch
    thicker = bias.model_copy(update={"drag": (1.0 + bias.drag) * np.exp(DRAG) - 1.0})
    later = bias.model_copy(update={"delay": bias.delay + DELAY / m})
    drag, delay = (model.landings(config.model_copy(update={"bias": part})) - middle for part in (thicker, later))
    air = _whiten(np.stack(wind, axis=2), mode, density.has_landing)
    weight, push = _score(air, mode)
    draught = float(chi2.sf(push @ np.linalg.solve(weight, push), 2))
    return [
        Finding("draught", draught, DRAUGHT_TEXT),
        _by_item(density, mode, drag, "drag", "{item} lands as with another drag, for instance"),
        _by_item(density, mode, delay, "delay", "{item} lands as if it came free later or earlier, for instance"),
        Finding("scatter", chance, f"throws scatter {np.sqrt(factor):.2f} times as far as the level says"),
    ]


def _whiten(change: Floats, mode: Mode, landed: Bools) -> Floats:
    """Changes of landings (N, 2, Q) [m] as whitened and weighted columns (2 L, Q)."""
    white = np.einsum("nij,njq->niq", mode.scatter.root[landed], change[landed])
    return (white * np.sqrt(mode.regular)[:, None, None]).reshape(-1, change.shape[2])


def _score(columns: Floats, mode: Mode) -> tuple[Floats, Floats]:
    """Covariance (Q, Q) and score (Q,) of left-out effects with whitened columns (2 L, Q)."""
    size = np.sqrt((mode.residual**2).sum(axis=1))
    residual = mode.residual * (np.minimum(1.0, WINSOR / np.maximum(size, 1e-12)) * np.sqrt(mode.regular))[:, None]
    explained = columns.T @ mode.jacobian
    return columns.T @ columns - explained @ mode.covariance @ explained.T, columns.T @ residual.ravel()


def _by_item(density: Density, mode: Mode, change: Floats, name: str, text: str) -> Finding:
    """Test of an effect (N, 2) [m] that one item has alone; the item that leans most."""
    kind, items = density.model.log.kind, density.model.config.items
    column = _whiten(change[:, :, None], mode, density.has_landing)[:, 0]
    owner = np.repeat(kind[density.has_landing], 2)
    tried = [k for k in np.unique(owner) if (owner == k).sum() >= 2 * FEWEST]
    if not tried:
        return Finding(name, 1.0, text.format(item="an item"))
    chances: list[float] = []
    for k in tried:
        weight, push = _score(np.where(owner == k, column, 0.0)[:, None], mode)
        chances.append(float(chi2.sf(push[0] ** 2 / max(weight[0, 0], 1e-9), 1)))
    least = int(np.argmin(chances))
    return Finding(name, min(chances[least] * len(tried), 1.0), text.format(item=items[tried[least]]))
