"""The fit of one log: posterior, chances of seals, what is known in combination, and whether the model fits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import ItemTable, item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.drawing import release_delay

from ..ground.fitting import on_one_thread
from . import density, misfit
from .density import finite_numbers
from .log import ThrowLog
from .misfit import LEVEL, TESTS, Finding
from .parameters import Parameter, level_at, with_seals
from .posterior import Posterior, SealChance, posterior


class Combination(NamedTuple):
    """A figure that follows from several parameters.

    Attributes:
        name: name in files.
        label: name for people, with the formula.
        unit: unit of the figure.
        needs: names of the parameters.
        of: the figure of SI values by name.
    """

    name: str
    label: str
    unit: str
    needs: tuple[str, ...]
    of: Callable[[Mapping[str, Any]], Any]


def combinations(log: ThrowLog, config: ConveyorConfig) -> list[Combination]:
    """Camera and encoder together at the picks, and the delay of each item's release."""
    way = float(log.pick[:, 0].mean() - config.belt.camera_x)
    place = Combination(
        "camera_at_picks", f"camera along the belt + {way:.2f} m x encoder", "mm", ("camera_x", "encoder"),
        lambda values: 1e3 * (values["camera_x"] + way * values["encoder"]),
    )  # fmt: skip
    table = item_arrays(config.item_list())
    delays = [
        Combination(
            f"delay_{config.items[kind]}", f"delay of {config.items[kind]}", "ms", ("valve", "tau"),
            partial(_delay, table, int(kind), config),
        )
        for kind in np.unique(log.kind)
    ]  # fmt: skip
    return [place, *delays]


def _delay(table: ItemTable, kind: int, config: ConveyorConfig, values: Mapping[str, Any]) -> Floats:
    """Mean delay [ms] of an item's release at a valve's delay and a time constant."""
    seal, mass, zero, one = table.seal_force[kind], table.mass[kind], np.zeros(1), np.ones(1)
    decay = release_delay(seal * one, mass * one, zero, one, config.suction)[0]
    delay = values["valve"] + values["tau"] * decay + table.clings[kind]
    return 1e3 * config.mismatch * np.maximum(delay, 0.0)


ENDS: Final = (0.025, 0.975)
"""Ends of the intervals."""
TOLD: Final = 1.96
"""Standard deviations above 0 from which on a blow-off is told."""


@final
@dataclass(frozen=True)
class Estimate:
    """A figure with its 95 % interval, in the unit that people read."""

    label: str
    unit: str
    value: float
    low: float
    high: float
    deviation: float
    """Standard deviation of the posterior."""
    share: float
    """The same as a share of the prior's."""

    @property
    def text(self) -> str:
        """The figure with its interval."""
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.value:.3g} ({self.low:.3g}..{self.high:.3g}){unit}"


@final
@dataclass(frozen=True)
class Fitted:
    """A cell as one log tells of it."""

    log: ThrowLog
    config: ConveyorConfig
    """The level from which the fit began."""
    posterior: Posterior
    seals: list[SealChance]
    misfit: list[Finding]
    scatter: float
    """Scatter of the throws relative to that of the level."""

    @property
    def level(self) -> ConveyorConfig:
        """The level with the fitted values."""
        level = level_at(self.config, self.posterior.values)
        return with_seals(level, {seal.item: seal.mean for seal in self.seals})

    @property
    def blows(self) -> bool:
        """Whether the log tells of a blow-off: its estimate, free of the prior's end at 0, is that far above 0."""
        posterior, names = self.posterior, [parameter.name for parameter in self.posterior.parameters]
        if "blow_off" not in names:
            return False
        index, best = names.index("blow_off"), posterior.best
        width = np.sqrt(posterior.inflation * best.covariance[index, index])
        return bool(best.z[index] - posterior.least[index] > TOLD * width)

    @property
    def fits(self) -> bool:
        """Whether no test speaks against the model."""
        return not any(finding.alarms for finding in self.misfit)

    def estimates(self, samples: Floats) -> dict[str, Estimate]:
        """Each free parameter by its name, from samples of the posterior (S, P)."""
        estimates = {}
        for index, parameter in enumerate(self.posterior.parameters):
            scaled = parameter.scale * parameter.value(samples[:, index])
            low, high = np.quantile(scaled, ENDS)
            value = parameter.scale * self.posterior.values[parameter.name]
            share = float(samples[:, index].std())
            estimates[parameter.name] = Estimate(
                parameter.label, parameter.unit, value, float(low), float(high), float(scaled.std()), share
            )
        return estimates

    def combinations(self, samples: Floats) -> dict[str, Estimate]:
        """What is known of parameters together, by name, from samples of the posterior (S, P)."""
        parameters = self.posterior.parameters
        usual = np.random.default_rng(1).standard_normal(samples.shape)
        drawn, prior = (
            {p.name: p.value(scores[:, k]) for k, p in enumerate(parameters)} for scores in (samples, usual)
        )
        estimates = {}
        for part in combinations(self.log, self.config):
            if not set(part.needs) <= drawn.keys():
                continue
            figure, spread = part.of(drawn), float(np.std(part.of(prior)))
            if spread > 0.0:  # the delay of an item that never comes free late is always 0
                low, high = np.quantile(figure, ENDS)
                value, deviation = float(part.of(self.posterior.values)), float(figure.std())
                estimates[part.name] = Estimate(
                    part.label, part.unit, value, float(low), float(high), deviation, deviation / spread
                )
        return estimates


@on_one_thread
@finite_numbers()
def fit_log(log: ThrowLog, config: ConveyorConfig, parameters: Sequence[Parameter]) -> Fitted:
    """The fit of one log.

    Throws that scatter far more than the level says are fitted again with their scatter; a smaller excess widens the
    intervals.

    Args:
        log: the throws.
        config: the level, about whose values the priors lie.
        parameters: the free parameters.

    Raises:
        UsageError: log and level are of another kind of cell, or no finite numbers follow from them.
    """
    whole, seals = posterior(log, config, parameters)
    findings, scatter = misfit.find(whole.density, whole.best), 1.0
    factor, chance = misfit.scatter(whole.best)
    if chance < LEVEL / len(TESTS):
        whole, seals = posterior(log, config, parameters, factor)
        scatter, (factor, _) = factor, misfit.scatter(whole.best)
    whole = replace(whole, inflation=max(factor, 1.0))
    density.check(whole.best.z, whole.best.covariance, factor, [finding.chance for finding in findings])
    return Fitted(log, config, whole, seals, findings, float(np.sqrt(scatter * max(factor, 1.0))))
