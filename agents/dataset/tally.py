"""Returns and figures of the episodes of a dataset."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, final

import numpy as np
from rich.progress import Progress

from ..ground.metrics import mean_of_finite
from ..ground.tables import Grid, millimetres, percent
from .episodes import Episode

SHOWN: Final[Mapping[str, tuple[str, Callable[[float], str]]]] = {
    "is_success": ("success", percent),
    "sorted": ("sorted", percent),
    "landing_error": ("landing error, mean", millimetres),
    "shift_value_per_min": ("value a minute, mean", "{:.1f}".format),
    "shift_sorted_per_min": ("sorted a minute, mean", "{:.1f}".format),
}
"""Info values whose means the final table shows, where an environment has them: label and number format of each."""


@final
@dataclass(frozen=True)
class Scores:
    """Mean returns of an episode that define the scores 0 and 1."""

    lowest: float
    highest: float
    episodes: int
    """Number of episodes behind the means."""


@final
@dataclass
class Tally:
    """Returns, throws and figures of the episodes of a dataset, counted while the episodes are written."""

    returns: list[float] = field(default_factory=list)
    throws: int = 0
    figures: dict[str, list[float]] = field(default_factory=dict)
    """Values of throws and of whole episodes by the names in `SHOWN` that the environment has."""

    def count_episodes(self, episodes: Iterator[Episode]) -> Iterator[Episode]:
        """Yield the episodes unchanged, counting each."""
        for episode in episodes:
            self.returns.append(float(episode.rewards.sum()))
            self.throws += len(episode)
            columns = {**{name: values[1:] for name, values in episode.info.items()}, **episode.figures}
            for name in columns.keys() & SHOWN.keys():
                self.figures.setdefault(name, []).extend(np.ravel(columns[name]).tolist())
            yield episode

    def table(self, name: str, scores: Scores) -> Grid:
        """Table of the counted figures and of the mean score."""
        mean, span = float(np.mean(self.returns)), scores.highest - scores.lowest
        rows = [
            ("episodes", f"{len(self.returns)}"),
            ("throws", f"{self.throws}"),
            *(
                (label, show(mean_of_finite(self.figures[key])))
                for key, (label, show) in SHOWN.items()
                if key in self.figures
            ),
            ("return of an episode, mean", f"{mean:.3f}"),
            ("score: 0 is random, 1 the expert", f"{(mean - scores.lowest) / span:.3f}" if span else "-"),
        ]
        return Grid(name, ("figure", "value"), rows)


def packing_progress(bar: Progress) -> Callable[[int, int], None]:
    """Callback that shows the number of repacked episodes on a progress bar, from the first call on."""
    task = bar.add_task("packing", total=None, visible=False)
    return lambda number, total: bar.update(task, completed=number, total=total, visible=True)
