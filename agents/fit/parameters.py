"""Hidden parameters of a cell: their priors, and the level that has given values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import one_sentence

from ..ground.cli import UsageError, about, check_known, check_once
from ..ground.levels import find

SOFTEST, STIFFEST = 0.05, 100.0
"""Bounds of the lip's stiffness in a level [N m/rad]."""

NARROWEST, WIDEST = 1e-6, 10.0
"""Bounds of a prior's standard deviation, as multiples of the usual one."""


@final
@dataclass(frozen=True)
class Parameter:
    """One hidden parameter with its normal prior.

    A value is mean + sd z, or mean exp(sd z) where the prior is of the logarithm, with z standard normal.
    """

    name: str
    label: str
    unit: str
    """Unit of the figure that people read."""
    scale: float
    """Figure that people read, per SI value."""
    read: Callable[[ConveyorConfig], float]
    """The level's own value."""
    sd: float
    """Standard deviation of the prior: of the SI value, or of its logarithm."""
    is_log: bool = False
    least: float = -np.inf
    """Least SI value that a cell may have; the prior is cut off there."""
    mean: float = np.nan

    def value(self, z: Floats) -> Floats:
        """SI values at standard scores S."""
        return self.mean * np.exp(self.sd * z) if self.is_log else self.mean + self.sd * z

    def score(self, value: float) -> float:
        """Standard score of an SI value."""
        return float(np.log(value / self.mean) if self.is_log else value - self.mean) / self.sd


PARAMETERS: Final = (
    Parameter("valve", "delay of the valve", "ms", 1e3, lambda c: c.suction.valve + c.bias.delay, 0.005),
    Parameter("tau", "decay of the vacuum", "ms", 1e3, lambda c: c.suction.tau, 0.4, is_log=True),
    Parameter("blow_off", "speed of the blow-off", "m/s", 1.0, lambda c: c.cup.blow_off, 0.15, least=0.0),
    Parameter("drag", "drag over the catalogue's", "x", 1.0, lambda c: 1.0 + c.bias.drag, 0.20, is_log=True),
    Parameter("camera_x", "belt camera along the belt", "mm", 1e3, lambda c: c.bias.camera[0], 0.008),
    Parameter("camera_y", "belt camera across the belt", "mm", 1e3, lambda c: c.bias.camera[1], 0.008),
    Parameter("encoder", "belt speed over the encoder's", "%", 1e2, lambda c: c.bias.encoder, 0.008),
    Parameter("stiffness", "stiffness of the lip", "N m/rad", 1.0, lambda c: c.cup.stiffness or 0.0, 0.7, is_log=True),
)
"""All parameters. Their priors are assumed. About the level `waste`, 95 % of the priors reach from 0 to 14 ms of valve,
from 4 to 20 ms of decay, from 0 to 0.3 m/s of blow-off and from a quarter to four times the stiffness, as cups differ;
the other widths are those of a data sheet's tolerance or of a tape measure's error."""


def read_level(level: str | Path) -> tuple[ConveyorConfig, bool]:
    """The cell of a conveyor's level, or of a line's, with flights alone; and whether the level is a line's."""
    text = str(level)
    is_file_or_line = bool(Path(text).suffix) or text not in ConveyorConfig.level_names()
    is_line = is_file_or_line and find(text)[1] is LineConfig
    config = LineConfig.load(level).cell if is_line else ConveyorConfig.load(level)
    return config.model_copy(update={"fidelity": "flight"}), is_line


def priors(
    config: ConveyorConfig,
    free: Sequence[str] | None = None,
    spreads: Mapping[str, Any] | None = None,
    free_motion: bool = False,
) -> tuple[Parameter, ...]:
    """Parameters of a level with priors about the level's own values.

    Args:
        config: the level.
        free: names of the parameters that are not known; None for all that the level has.
        spreads: standard deviations of priors by name, in SI units; of the logarithm for tau, drag and stiffness.
        free_motion: whether hands move otherwise than the planner's; no log of them tells the stiffness.

    Raises:
        UsageError: a parameter is unknown or absent, a spread is not in its range, or nothing is free.
    """
    spreads, names = {} if spreads is None else spreads, [parameter.name for parameter in PARAMETERS]
    if not isinstance(spreads, Mapping):
        raise UsageError(
            f"prior is {one_sentence(repr(spreads), 80)}; it must be a mapping from names to standard deviations"
        )
    chosen = names if free is None else free
    if isinstance(chosen, str) or not isinstance(chosen, Sequence):
        raise UsageError(
            f"free is {one_sentence(repr(free), 80)}; it must be a list of names, such as ['valve', 'tau']"
        )
    for option, given in {"free": chosen, "prior": [*spreads]}.items():
        with about(option):
            check_known("parameter", given, names)
        check_once({option: given})
    for parameter in PARAMETERS:
        sd, low, high = spreads.get(parameter.name, parameter.sd), NARROWEST * parameter.sd, WIDEST * parameter.sd
        if isinstance(sd, bool) or not isinstance(sd, int | float) or not low <= sd <= high:
            valid = f"a standard deviation from {low:g} to {high:g}, {'of the logarithm' if parameter.is_log else 'SI'}"
            raise UsageError(f"the prior of {parameter.name} is {one_sentence(repr(sd), 80)}; it must be {valid}")
    if config.mismatch == 0.0:
        raise UsageError(f"level {config.name!r} has mismatch 0: nothing hidden acts on its throws; set it to 1")
    swings = config.swings and not free_motion
    present = [p for p in PARAMETERS if p.name in chosen and (p.name != "stiffness" or swings)]
    if not present:
        raise UsageError("no parameter is free; give at least one that the level has")
    for parameter in present:
        if parameter.is_log and not parameter.read(config) > 0.0:
            raise UsageError(f"{parameter.name} is 0 in level {config.name!r}; a free one must be above 0")
    return tuple(replace(p, mean=p.read(config), sd=float(spreads.get(p.name, p.sd))) for p in present)


def level_at(config: ConveyorConfig, values: Mapping[str, float]) -> ConveyorConfig:
    """The level with values of some parameters, by name, in SI units; what a valve lacks below zero is in `bias.delay`.

    The values are not checked, so that a search may leave the ranges of a level for a while.
    """
    bias, suction, cup = config.bias, config.suction, config.cup
    if "valve" in values:
        suction = suction.model_copy(update={"valve": max(values["valve"], 0.0)})
        bias = bias.model_copy(update={"delay": min(values["valve"], 0.0)})
    if "tau" in values:
        suction = suction.model_copy(update={"tau": values["tau"]})
    if "blow_off" in values:
        cup = cup.model_copy(update={"blow_off": values["blow_off"]})
    if "stiffness" in values:
        cup = cup.model_copy(update={"stiffness": float(np.clip(values["stiffness"], SOFTEST, STIFFEST))})
    camera = values.get("camera_x", bias.camera[0]), values.get("camera_y", bias.camera[1])
    encoder, drag = values.get("encoder", bias.encoder), values.get("drag", 1.0 + bias.drag) - 1.0
    bias = bias.model_copy(update={"camera": camera, "encoder": encoder, "drag": drag})
    return config.model_copy(update={"bias": bias, "suction": suction, "cup": cup})


def with_seals(config: ConveyorConfig, chances: Mapping[str, float]) -> ConveyorConfig:
    """The level with chances that cups seal, by item."""
    items = config.item_definitions()
    changed = {name: items[name].model_copy(update={"pick_chance": chance}) for name, chance in chances.items()}
    kept = {item.name: item for item in config.extra_items}
    return config.model_copy(update={"extra_items": (*{**kept, **changed}.values(),)})


def values_at(parameters: Sequence[Parameter], z: Floats) -> dict[str, float]:
    """SI values by name at one vector of standard scores (P,)."""
    return {parameter.name: float(parameter.value(z[index])) for index, parameter in enumerate(parameters)}
