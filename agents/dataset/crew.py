"""The controllers of a dataset: the controller that throws, and the controllers of the scores 0 and 1."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Final, final

import numpy as np
from gymnasium.spaces import Box

from ..controllers.protocol import Controller, Learner
from ..ground import metrics, shipped
from ..ground.cli import UsageError, about
from ..ground.cluster import Needs
from ..ground.environments import Role
from ..ground.tables import Grid, millimetres, percent, throws_bar
from ..ground.work import Pool, keep_missing
from ..judging.trial import Trial
from ..learning import trained
from . import collection
from .collection import Collection, ControllerRecipe
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

    def count(self, episodes: Iterator[Episode]) -> Iterator[Episode]:
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
                (label, show(metrics.mean(self.figures[key])))
                for key, (label, show) in SHOWN.items()
                if key in self.figures
            ),
            ("return of an episode, mean", f"{mean:.3f}"),
            ("score: 0 is random, 1 the expert", f"{(mean - scores.lowest) / span:.3f}" if span else "-"),
        ]
        return Grid(name, ("figure", "value"), rows)


EXPERT: Final = "expert"
"""As `--controller`: the controller that `--expert` names."""
MOST_NOISE: Final = 10.0
"""Largest standard deviation of noise on actions; the span of an action is 2."""
CORE_ATTRIBUTES: Final = ("config", "cell", "item_names")
"""Attributes that the core of an environment must have for a dataset's metadata."""


def collection_task(
    controller: str, env: str | None, level: str | None, mode: str | None
) -> tuple[str, str | None, str | None]:
    """Environment id, level and action mode of a collection; level and mode are None for the defaults."""
    if env is None and not os.path.isdir(shipped.place(controller)):
        env, level = "PnTRelease-v0", "waste" if level is None else level
    return trained.resolve(controller, env, level, mode)


@final
class Crew:
    """The controllers of a dataset: `thrower` throws in it, random actions and the expert define the scores 0 and 1.

    Args:
        trial: trial of the cells in which the controllers throw.
        env_id: id of the environment.
        controller: name of the controller that throws for the dataset, or `EXPERT`.
        expert: name of the controller whose mean return is the score 1; None for the best controller known.
        seed: seed of the throws.
        trust: load policies that run code.
        practice: number of practice throws before; None for the usual number.
        noise: standard deviations of the noise on the actions of `thrower`, one chunk after the other in turn.

    Raises:
        UsageError: there is no such controller, the environment lacks one of `CORE_ATTRIBUTES`, or the noise is out of
            range or has no effect.
    """

    def __init__(
        self,
        trial: Trial,
        env_id: str,
        controller: str,
        expert: str | None,
        *,
        seed: int,
        trust: bool = False,
        practice: int | None = None,
        noise: Sequence[float] = (),
    ) -> None:
        # Make sure that noise can act on the actions of an environment.
        for deviation in noise:
            if not 0.0 <= deviation <= MOST_NOISE:
                raise UsageError(f"--noise is {deviation:g}; it must be from 0 to {MOST_NOISE:g}")
        if noise and not isinstance(trial.env.single_action_space, Box):
            raise UsageError(f"--noise has no effect: actions of environment {env_id!r} are choices, not numbers")
        missing = [part for part in CORE_ATTRIBUTES if not hasattr(trial.core, part)]
        if missing:
            raise UsageError(f"environment {env_id!r} cannot be collected: its core has no {' and no '.join(missing)}")
        self.trial, self.env_id, self.seed = trial, env_id, seed
        self._trust, self._practice = trust, practice
        self.noise = tuple(noise)
        expert = expert or trial.expert(env_id)
        chosen = expert if controller == EXPERT else controller
        self.chosen = (expert, chosen)
        self.lowest, self.thrower = (trial.controller(name, trust=trust) for name in ("random", chosen))
        with about("--expert"):
            self.highest = trial.controller(expert, trust=trust)
        if practice and not any(isinstance(controller, Learner) for controller in (self.thrower, self.highest)):
            names = sorted({self.thrower.name, self.highest.name})
            raise UsageError(
                f"--practice has no effect: {' and '.join(names)} learn{'s' if len(names) == 1 else ''} nothing that "
                "could be sent to the processes that collect, by `state` and `restore`"
            )
        self.label = (EXPERT if controller == EXPERT else self.thrower.name) + ("_noisy" if noise else "")
        """Part of the dataset's name."""
        self.expert, self.algorithm = _describe(self.highest, expert), _describe(self.thrower, chosen)

    def throws(self) -> Collection:
        """Collection of the dataset's throws."""
        return replace(self.collection(self.thrower, self.chosen[1], "dataset"), noise=self.noise)

    def collection(self, controller: Controller, policy_name: str, role: Role) -> Collection:
        """Collection of throws by one of the controllers, which first practises if it learns."""
        core, config = self.trial.core, self.trial.core.config
        state = None
        if isinstance(controller, Learner):
            controller.reset(self.seed)
            with throws_bar() as bar:
                practice = self.practice(controller)
                advance = partial(bar.advance, bar.add_task(f"practice of {controller.name}", total=practice))
                self.trial.practise(controller, practice, self.seed, progress=advance)
            state = controller.state()
        place = shipped.place(policy_name)
        is_trained = os.path.isdir(place) or place.suffix in (".zip", ".npz")
        files = trained.files(place) if is_trained else {}
        return Collection(
            env=self.env_id,
            level=config.name if config.ships() else config,
            mode=core.action_mode,
            num_envs=self.trial.env.num_envs,
            episode=getattr(core.cell, "episode", 1),
            recipe=ControllerRecipe(place.resolve().name if is_trained else policy_name, files, self._trust, state),
            role=role,
            seed=self.seed,
        )

    def practice(self, controller: Controller) -> int:
        """Number of practice throws of a controller; 0 for a controller that does not learn."""
        if not isinstance(controller, Learner):
            return 0
        return self.trial.practice(controller) if self._practice is None else self._practice


@final
class EpisodeStore:
    """Collected throws of a crew's controllers, kept in a folder; kept throws are not collected again.

    Args:
        crew: the controllers.
        folder: folder of the collected throws.
        throws: number of throws of the dataset.
        score_throws: number of throws by which random actions and the expert are scored.
        make_pool: returns the pool that collects, for the needs of the jobs.
    """

    def __init__(
        self, crew: Crew, folder: Path, throws: int, score_throws: int, make_pool: Callable[[Needs], Pool]
    ) -> None:
        self._folder = folder
        plans = (
            ("random", crew.collection(crew.lowest, "random", "evaluate"), score_throws),
            ("expert", crew.collection(crew.highest, crew.chosen[0], "evaluate"), score_throws),
            ("throws", crew.throws(), throws),
        )
        jobs = {name: collection.jobs(name, throws) for name, collection, throws in plans}
        modules = sorted({module for _, collection, _ in plans for module in collection.modules})
        models = [path for _, one, _ in plans for path in one.recipe.files if path.endswith(".zip")]
        workers = make_pool(Needs(tuple(modules), torch=bool(models)))
        unit = f"{crew.trial.step}s"
        files = iter(keep_missing([*chain(*jobs.values())], folder, workers, unit=unit))
        self._files = {name: [next(files) for _ in chunks] for name, chunks in jobs.items()}
        self._throws = {name: throws for name, _, throws in plans}

    def episodes(self, name: str = "throws") -> Iterator[Episode]:
        """Episodes of the dataset, of random actions or of the expert, up to the number of throws asked for."""
        throws_done = 0
        for episode in chain.from_iterable(map(collection.unpack, self._files[name])):
            if throws_done >= self._throws[name]:
                return
            throws_done += len(episode)
            yield episode

    def scores(self) -> Scores:
        """Mean returns of random actions and of the expert over the same episodes, which are in no dataset."""
        lowest, highest = (
            {episode.seed: float(episode.rewards.sum()) for episode in self.episodes(name)}
            for name in ("random", "expert")
        )
        common = [seed for seed in lowest if seed in highest]
        means = [float(np.mean([returns[seed] for seed in common])) for returns in (lowest, highest)]
        return Scores(means[0], means[1], len(common))

    def clear(self) -> None:
        """Remove the collected throws from the folder, once they are in a dataset."""
        for file in chain.from_iterable(self._files.values()):
            file.unlink(missing_ok=True)
        with suppress(OSError):  # the folder holds other files
            self._folder.rmdir()


def _describe(controller: Controller, policy_name: str) -> str:
    """Description of a controller: its name and the name of its folder, without the folder's path."""
    place = shipped.place(policy_name)
    return f"{controller.name} of {place.name}" if os.path.isdir(place) else controller.name
