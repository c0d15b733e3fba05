"""Motions over the ellipse of Choe et al. 2023, N at a time, planned quickly enough for every pick.

`papers.choe.planning.timing` finds the quickest motion along any path, but one path at a time and with CasADi. Here
each arc gets a speed law of a few phases, as pieces of constant jerk, which takes some percent longer.
"""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.limits import Limits
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.paths import arc_kernel
from pnt_gym.planning.paths.rows import Arc

PIECES = 78
"""Pieces of constant jerk in an arc, as in `arc_kernel`."""


def arc_segments(way: Floats, top: Floats, limits: Limits) -> Segments:
    """Return motions from rest to rest along upper halves of ellipses that run vertically at both ends.

    The pieces meet the ellipse at all borders but the second and the last but one. Between the borders the pieces stay
    within some micrometres of the ellipse, within half a millimetre on long and flat ellipses at slow speeds. The
    motions keep all limits.

    Args:
        way: from the start to the end of each arc (N, 3) [m].
        top: height of each arc's highest point above its start (N,) [m].
        limits: largest speed, acceleration and jerk.

    Raises:
        PlanningError: an arc has no width, or its top is not above both ends.
    """
    run = np.sqrt(way[:, 0] ** 2 + way[:, 1] ** 2)
    room = np.minimum(top, top - way[:, 2])
    if not ((run > 0.0) & (room > 0.0)).all():
        row = int(np.argmin((run > 0.0) & (room > 0.0)))
        raise PlanningError(
            f"an arc needs a width and a top above both its ends, both above 0 m, got {run[row]} and {room[row]} m"
        )
    half_chord = np.sqrt(top * (top - way[:, 2]))
    motion = limits.arrays(len(way))._asdict()
    arcs = Arc.zeros(len(way), width=run / 2.0, rise=way[:, 2] / 2.0, chord=half_chord, **motion)
    steps, accelerations = np.empty((len(way), PIECES)), np.empty((len(way), 2, PIECES + 1))
    arc_kernel.arc_segments(arcs, steps, accelerations)
    jerks = np.diff(accelerations, axis=2) / np.where(steps > 0.0, steps, 1.0)[:, None]
    heading = way[:, None, :2] / run[:, None, None]
    return Segments(steps, np.concatenate([jerks[:, 0, :, None] * heading, jerks[:, 1, :, None]], axis=2))
