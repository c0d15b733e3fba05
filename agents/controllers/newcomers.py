"""Corrections of item kinds that a policy has not learned, estimated from few throws."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.conveyor.observation import TABLE

from .filters import Filters, landing_offset
from .trackers import delay_effect

PRIOR: Final = (0.008, 0.008, 0.003)
"""Standard deviations of a kind's landing error: delay of the release [s]; offset along and across the throw for any
other reason, such as the depth of the centre of mass or drag [m]."""
LIKE_OTHERS: Final = 0.35
"""Factor on `PRIOR` for a kind that behaves like the known kinds."""
SHARE: Final = 0.2
"""Prior probability that a kind behaves like the known kinds."""


@final
class UnseenKinds:
    """Landing errors of unseen kinds, for every kind in every row; zero for known kinds.

    Args:
        is_known: whether the policy has learned each kind (K,).
    """

    def __init__(self, is_known: Bools) -> None:
        self._is_known = is_known
        self._begin(0)

    def is_unseen(self, kind: Ints) -> Bools:
        """Whether objects (N,) are of an unseen kind."""
        return ~self._is_known[kind]

    def learn(self, kind: Ints, throws: Floats, z: Floats, rows: Bools) -> None:
        """Update by throws (N, D) of kinds (N,) with landing errors z (N, 2) [m], in the rows that are selected."""
        self._match_rows(len(kind))
        selected = np.flatnonzero(rows & self.is_unseen(kind))
        self._filters.learn((selected, kind[selected]), _kind_effects(throws[selected]), z[selected])

    def effect(self, kind: Ints, throws: Floats) -> Floats:
        """Expected landing errors of throws (N, D) of kinds (N,): (N, 2) [m]."""
        self._match_rows(len(kind))
        return landing_offset(_kind_effects(throws), self._filters.estimate((np.arange(len(kind)), kind)))

    def _match_rows(self, count: int) -> None:
        """Restart where the number of rows has changed."""
        if len(self._filters.state) != count:
            self._begin(count)

    def _begin(self, count: int) -> None:
        variances = np.square(PRIOR)
        priors = np.stack([np.diag(LIKE_OTHERS**2 * variances), np.diag(variances)])
        self._filters = Filters((count, len(self._is_known)), priors, (SHARE, 1.0 - SHARE))


def _kind_effects(throws: Floats) -> Floats:
    """Effects of a release 1 s later, and 1 m further along and across, on landings (N, 2, 3)."""
    effects_array = np.zeros((len(throws), 2, 3))
    effects_array[:, 0, 0], effects_array[:, 0, 1], effects_array[:, 1, 2] = (
        delay_effect(TABLE.decode(throws)),
        1.0,
        1.0,
    )
    return effects_array
