"""The policies that ship, by names that hold in a checkout and in an installed package: `shipped:waste-sac`.

A policy that does not adapt holds for the cell in which it was trained, with that cell's vacuum, cup and calibration.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pnt_gym.names import unknown_name

from .cli import UsageError
from .places import POLICY, SHIPPED, at

LINE: Final = "PnTLine-v0"
"""Environment whose policies decide; all others correct throws."""
PREFIX: Final = "shipped:"
"""What the name of a shipped policy begins with."""


@dataclass(frozen=True)
class ShippedPolicy:
    """A policy that ships."""

    place: str
    """Run folder, or file of a scorer, below results/policies; or name of the level that is the prior of a filter."""
    env: str
    """Id of the environment in which it was trained."""
    purpose: str
    """What it does, and for which cell, for people."""
    controller: str = ""
    """The controller by name that acts, where the policy is no network."""


CORRECTING: Final[Mapping[str, ShippedPolicy]] = {
    "waste-sac": ShippedPolicy(POLICY.name, "PnTRelease-v0", "corrects throws of the cell of `waste` alone; SAC"),
    "cells": ShippedPolicy(
        "cells",
        "PnTAdapt-v0",
        "corrects throws of a cell that nobody measured: learns its numbers from the landings of each shift",
        "posterior",
    ),
    "day-recurrent_ppo": ShippedPolicy(
        "PnTAdapt-v0-day-recurrent_ppo-seed0",
        "PnTAdapt-v0",
        "corrects throws of a cell that drifts, over `static`; recurrent PPO, trained on `day`",
    ),
}
"""The shipped policies that correct throws by name, without `PREFIX`."""
DECIDING: Final[Mapping[str, ShippedPolicy]] = {
    "line/value": ShippedPolicy(
        "PnTLine-v0/value/residual_ppo", "PnTLine-v0", "decides who takes what next; residual PPO, trained on `value`"
    ),
    "line/skills3": ShippedPolicy(
        "PnTLine-v0/skills3/residual_ppo",
        "PnTLine-v0",
        "decides who takes what next; residual PPO, trained on `skills3`",
    ),
    "line/skills3_burst": ShippedPolicy(
        "PnTLine-v0/skills3_burst/residual_ppo",
        "PnTLine-v0",
        "decides who takes what next; residual PPO, trained on `skills3_burst`",
    ),
}
"""The shipped policies of lines by name, without `PREFIX`."""
POLICIES: Final = {**CORRECTING, **DECIDING}


def is_shipped(name: str) -> bool:
    """Whether a controller's name is the name of a shipped policy."""
    return name.startswith(PREFIX)


def names(policies: Mapping[str, ShippedPolicy]) -> list[str]:
    """Names of shipped policies as commands take them."""
    return [f"{PREFIX}{name}" for name in policies]


def place(name: str | Path) -> Path:
    """Folder or file of a policy: a shipped one by its name, or a path in the working folder or among shipped files.

    Raises:
        UsageError: no shipped policy has this name.
    """
    if not isinstance(name, str) or not is_shipped(name):
        return at(name) if str(name) else Path(name)
    short = name.removeprefix(PREFIX)
    if short not in POLICIES:
        raise UsageError(unknown_name("shipped policy", name, names(POLICIES)))
    policy = POLICIES[short]
    if policy.controller:
        from pnt_gym.cells.conveyor.config import ConveyorConfig  # noqa: PLC0415 - half a second to import

        return ConveyorConfig.file_of(policy.place)
    return SHIPPED / "results" / "policies" / policy.place


def module_of(name: str) -> str | None:
    """Module of the user in a name of the form MODULE:NAME; None for other names, those of shipped policies as well."""
    module, colon, _ = name.partition(":")
    return module if colon and not is_shipped(name) else None
