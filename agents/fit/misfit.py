"""Whether the model fits a log: score tests of what it leaves out, the gauges' readings, and the throws' scatter.

A score test asks whether the residuals lean the way that a left-out effect would push the landings. Under the model the
score g'r of whitened residuals r at the maximum has the covariance g'g - g'J S J'g, with the whitened slopes J of the
parameters and their posterior covariance S. Residuals are winsorised, so that single accidents raise no alarm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Self, final

import numpy as np
from scipy.stats import chi2, norm

from pnt_gym.arrays import Bools, Floats

from ..ground.cli import UsageError
from .density import Density, Mode
from .effects import Effect, effects, readings

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
ALIKE: Final = 6.0
"""Difference of -2 ln of the likelihoods below which two causes act alike: a ratio of 20."""
TESTS: Final = ("draught", "bin_camera", "belt_camera", "blow_off", "drag", "delay", "readings", "scatter")
"""Tests, among which the probability of an alarm is divided."""


@final
@dataclass(frozen=True)
class Finding:
    """Result of one test."""

    name: str
    chance: float
    """Probability of such a log where the model is right, corrected for the items and gauges that were tried."""
    text: str
    """What the cell may have that the model has not, with all causes that act alike on this log."""
    is_told: bool = True
    """Whether the text tells more than those of other tests; if not, causes that they name explain the alarm."""

    @property
    def alarms(self) -> bool:
        """Whether the test says that the model does not fit."""
        return self.chance < LEVEL / len(TESTS)


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


@final
@dataclass(frozen=True)
class Suspect:
    """An effect that the model leaves out, and what the residuals say of it."""

    effect: Effect
    column: Floats
    """Whitened and weighted change of the landings (2 L, Q)."""
    tried: int
    """Number of effects of the same test."""
    square: float
    """Score statistic, a chi-square variable with Q degrees of freedom where the model is right."""
    size: Floats
    """Sizes that fit best, to first order (Q,)."""

    @property
    def chance(self) -> float:
        """Probability of so large a score where the model is right, corrected for the effects that were tried."""
        return min(float(chi2.sf(self.square, len(self.size))) * self.tried, 1.0)

    @property
    def alarms(self) -> bool:
        """Whether so large a score speaks against the model."""
        return self.chance < LEVEL / len(TESTS)

    @property
    def evidence(self) -> float:
        """2 ln of the likelihood that the effect adds, less what free sizes and tries add by chance."""
        return self.square - 2.0 * len(self.size) - 2.0 * float(np.log(self.tried))

    @property
    def text(self) -> str:
        """What the cell may have."""
        return self.effect.text(self.size)


@final
@dataclass(frozen=True)
class Residuals:
    """Residuals at a maximum, and what is known of the free parameters there."""

    residual: Floats
    """Winsorised and weighted (2 L,)."""
    jacobian: Floats
    """Whitened and weighted changes per free parameter (2 L, P)."""
    covariance: Floats
    """Of the free parameters (P, P)."""

    @classmethod
    def of(cls, mode: Mode) -> Self:
        """The residuals of a mode."""
        size = np.sqrt((mode.residual**2).sum(axis=1))
        share = np.minimum(1.0, WINSOR / np.maximum(size, 1e-12)) * np.sqrt(mode.regular)
        return cls((mode.residual * share[:, None]).ravel(), mode.jacobian, mode.covariance)

    def suspect(self, effect: Effect, column: Floats, tried: int) -> Suspect:
        """What the residuals say of an effect."""
        explained, push = column.T @ self.jacobian, column.T @ self.residual
        weight = column.T @ column - explained @ self.covariance @ explained.T
        size = np.asarray(np.linalg.solve(weight + 1e-9 * np.eye(len(weight)), push), dtype=np.float64)
        return Suspect(effect, column, tried, float(push @ size), size)

    def given(self, column: Floats) -> Self:
        """The residuals where an effect with a whitened column (2 L, Q) is free, too."""
        jacobian, count = np.concatenate([self.jacobian, column], axis=1), self.jacobian.shape[1]
        information = jacobian.T @ jacobian
        information[:count, :count] = np.linalg.inv(self.covariance)
        covariance = np.linalg.inv(information + 1e-9 * np.eye(len(information)))
        # At the maximum the free parameters are at rest, so the new effect alone pushes.
        step = covariance[:, count:] @ (column.T @ self.residual)
        return replace(self, residual=self.residual - jacobian @ step, jacobian=jacobian, covariance=covariance)


def find(density: Density, mode: Mode) -> list[Finding]:
    """Results of all tests at the maximum of a posterior."""
    factor, chance = scatter(mode)
    found = effects(density, mode)
    columns = [_whiten(effect.change, mode, density.has_landing) for effect in found]
    findings = name_causes(found, columns, Residuals.of(mode))
    if (raised := _raised(density, mode)) is not None:
        findings["blow_off"] = raised
    findings["readings"] = _read(density)
    findings["scatter"] = Finding(
        "scatter", chance, f"throws scatter {np.sqrt(factor):.2f} times as far as the level says"
    )
    return [findings.get(name, Finding(name, 1.0, "")) for name in TESTS]


def _whiten(change: Floats, mode: Mode, landed: Bools) -> Floats:
    """Changes of landings (N, 2, Q) [m] as whitened and weighted columns (2 L, Q)."""
    white = np.einsum("nij,njq->niq", mode.scatter.root[landed], change[landed])
    return (white * np.sqrt(mode.regular)[:, None, None]).reshape(-1, change.shape[2])


def name_causes(found: Sequence[Effect], columns: Sequence[Floats], residuals: Residuals) -> dict[str, Finding]:
    """Results of the tests of effects, by name.

    The likeliest cause is named together with all that explain the landings about as well. A further one is named where
    it still alarms when those before it are free.
    """
    tests = [effect.test for effect in found]

    def suspects(given: Residuals) -> list[Suspect]:
        return [
            given.suspect(effect, column, tests.count(effect.test))
            for effect, column in zip(found, columns, strict=True)
        ]

    now = suspects(residuals)
    best = {
        test: min((s for s in now if s.effect.test == test), key=lambda s: s.chance) for test in dict.fromkeys(tests)
    }
    findings = {test: Finding(test, s.chance, f"landings lean as with {s.text}") for test, s in best.items()}
    silent, told = {test for test, finding in findings.items() if finding.alarms}, set[str]()
    while leaders := [s for s in now if s.effect.test in silent and s.alarms]:
        leader = max(leaders, key=lambda s: s.evidence)
        residuals = residuals.given(leader.column)
        then = suspects(residuals)
        # Alike is what explains the landings about as well, and nothing more beside the leader.
        alike = [
            before
            for before, after in zip(now, then, strict=True)
            if before.evidence > leader.evidence - ALIKE and before.chance < LEVEL and not after.alarms
        ]
        ranked = sorted((s for s in alike if s is not leader), key=lambda s: -s.evidence)
        texts = [leader.text, *(s.text for s in ranked)]
        ending = "; these act alike on this log" if len(texts) > 1 else ""
        name = leader.effect.test
        findings[name] = replace(findings[name], text=f"landings lean as with {', or with '.join(texts)}{ending}")
        told.add(name)
        silent -= {name, *(s.effect.test for s in alike)}
        now = then
    return {test: replace(finding, is_told=test in told) for test, finding in findings.items()}


def _raised(density: Density, mode: Mode) -> Finding | None:
    """Whether objects leave as if pushed upwards, which no blow-off does; None where the blow-off is not free."""
    for index, parameter in enumerate(density.parameters):
        if parameter.name == "blow_off":
            above = (mode.z[index] - parameter.score(parameter.least)) / np.sqrt(mode.covariance[index, index])
            speed = float(parameter.value(mode.z[index : index + 1])[0])
            text = f"objects leave as if the cup sucked them up at {max(-speed, 0.0):.2g} m/s"
            return Finding("blow_off", float(norm.cdf(above)), text)
    return None


def _read(density: Density) -> Finding:
    """Whether the gauges read of the objects what the level's items have; the gauge that is off most."""
    tried = readings(density.model.log, density.model.config)
    if not tried:
        return Finding("readings", 1.0, "")
    worst = min(tried, key=lambda gauge: gauge.chance)
    text = (
        f"the readings of {worst.gauge} are {worst.factor:.2g} times those of the level's items, as of scales that "
        "read wrong, or of objects that differ from the level's"
    )
    return Finding("readings", min(worst.chance * len(tried), 1.0), text)
