"""A drawing of why the moment of the release matters: landings of tosses over when their objects came free."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from agents.report.figures import COLOURS, subplots
from pnt_gym.cells.tray.config import TrayConfig
from pnt_gym.cells.tray.planner import TossPlanner
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.planning.ballistics import landing_point

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MILLI: Final = 1e3
RANGE: Final = (-0.012, 0.050)
"""Moments of the release that are drawn, after the planned one [s]."""


class Release(NamedTuple):
    """N throws."""

    item: Ints
    """Index into the config's things (N,)."""
    delay: Floats
    """When the object came free, after the planned moment (N,) [s]."""
    along: Floats
    """Landing from the target along the throw (N,) [m]."""
    success: Bools
    """Whether the object came to lie in its compartment (N,)."""


def release_figure(releases: Mapping[str, Release], config: TrayConfig) -> Figure:
    """Landing along the throw over the moment of the release, one panel for each of `releases`."""
    figure, axes = subplots(1, len(releases), (5.4 * len(releases), 4.2), sharex=True, sharey=True)
    times, landings = free_landings(config)
    for panel, (title, release) in zip(axes, releases.items(), strict=True):
        for k, thing in enumerate(config.things):
            panel.plot(MILLI * times, MILLI * landings[k], color="gray", linewidth=1)
            mine = release.item == k
            _dots(panel, release, mine, COLOURS[k], thing.name)
        for side in (-0.5, 0.5):
            panel.axhline(side * MILLI * config.tray.opening[0], color="black", linestyle="--", linewidth=1)
        brake = MILLI * config.motion.after
        panel.axvline(brake, color="gray", linestyle=":", linewidth=1)
        panel.text(brake + 0.5, 0.02, "robot brakes", fontsize=8, color="gray", transform=panel.get_xaxis_transform())
        panel.set_title(f"{title}: {100.0 * float(release.success.mean()):.0f} % succeed", fontsize=10)
        panel.set_xlabel("object comes free after the planned moment [ms]")
        panel.grid(alpha=0.3)
    axes[0].set_ylabel("landing from the target along the throw [mm]")
    axes[0].plot([], [], color="gray", linewidth=1, label="let go on the planned path, no air")
    axes[0].plot([], [], color="black", linestyle="--", linewidth=1, label="edges of the compartment")
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=4, loc="outside lower center")
    return figure


def _dots(panel: Axes, release: Release, mine: Bools, colour: str, name: str) -> None:
    for done, marker, label in ((True, "o", name), (False, "x", f"{name}, missed")):
        rows = mine & (release.success == done)
        if rows.any():
            x, y = MILLI * release.delay[rows], MILLI * release.along[rows]
            panel.scatter(x, y, s=14, marker=marker, color=colour, linewidths=1 if marker == "x" else 0, label=label)


def free_landings(config: TrayConfig) -> tuple[Floats, Floats]:
    """Moments of the release (M,) [s] and where objects land that leave the planned path then, along the throw (K, M).

    Without air and without a push of the claws; the pick is in the middle of where objects lie.
    """
    kinds = np.arange(len(config.things), dtype=np.int64)
    middle: Floats = np.array([config.table.pick_x, config.table.pick_y], dtype=np.float64).mean(axis=1)
    place = np.tile(middle, (kinds.size, 1))
    plans = TossPlanner(config).plan(kinds, place)
    step = config.timestep
    times = np.arange(RANGE[0] - step, RANGE[1] + step, step)
    position = plans.pose(plans.release_time[:, None] + times)[..., :3]
    velocity = np.asarray(np.gradient(position, step, axis=1), dtype=np.float64)
    position[..., 2] -= plans.hang[:, None]
    miss = landing_point(position, velocity, config.tray.rim) - plans.target[:, None]
    # At its ends a gradient is not central.
    return times[1:-1], (miss * plans.heading[:, None]).sum(axis=-1)[:, 1:-1]
