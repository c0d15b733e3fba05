"""The log of throws, and the parameters of a fit."""

from __future__ import annotations

import numpy as np

from agents.fit.log import COLUMNS
from agents.fit.parameters import PARAMETERS

from .marks import table


def column_table(_: str) -> str:
    """A table of the columns of a log."""
    rows = [(f"`{name}`", c.unit, "yes" if c.required else "no", c.text) for name, c in COLUMNS.items()]
    return table(("column", "unit", "needed", "what it is"), rows)


def prior_table(_: str) -> str:
    """A table of the parameters and their priors."""
    rows = [
        (
            f"`{p.name}`",
            p.label,
            (f"x exp(+- {p.sd:g})" if p.is_log else f"+- {p.scale * p.sd:g} {p.unit}")
            + (f", at least {p.scale * p.least:g}" if np.isfinite(p.least) else ""),
        )
        for p in PARAMETERS
    ]
    return table(("parameter", "what it is", "standard deviation of the prior"), rows)
