"""Throws for offline learning, as a Minari dataset: `python -m agents.dataset --controller random`."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, final

import numpy as np
import tyro
from rich.progress import Progress

from pnt_gym.cells.base.features import numbered

from .controllers.protocol import Controller, Learner
from .data.collection import Collection, Thrower, unpacked
from .data.episodes import Episode
from .ground.cli import UsageError, at_least, option, run
from .ground.environments import Env, Role, core_of, make_single, make_vector
from .ground.places import MADE, at
from .ground.tables import Grid, console, millimetres, percent, throws_bar
from .ground.versions import git_state, versions
from .jobs.cluster import Needs, pool
from .jobs.work import keep_missing
from .judging.evaluation import NUM_ENVS, practise, usual_practice
from .judging.makers import controller_for, expert_for
from .learning.trained import files_of, setting

if TYPE_CHECKING:
    from .data.offline import Facts

EXPERT: Final = "expert"
"""Stands for what `--expert` names."""
NEEDED: Final = ("pnt_gym", "mujoco", "gymnasium", "numpy", "scipy")
"""Packages on whose versions the bits of a throw depend."""
SAID: Final = ("config", "cell", "item_names")
"""What the core of an environment must have for a dataset to say what it is of."""
SHOWN: Final[Mapping[str, tuple[str, Callable[[float], str]]]] = {
    "is_success": ("success", percent),
    "sorted": ("sorted", percent),
    "landing_error": ("landing error, mean", millimetres),
    "shift_value_per_min": ("value a minute, mean", "{:.1f}".format),
    "shift_sorted_per_min": ("sorted a minute, mean", "{:.1f}".format),
}
"""What the last table shows the mean of, where the environment tells it: how it is called and written."""


@dataclass(frozen=True)
class Arguments:
    """Collect throws of a controller and write them as a Minari dataset, which replays bit for bit.

    Scores are given with it: 0 is what random actions are worth, 1 what an expert is. A dataset appears complete or not
    at all, and what was interrupted goes on where it was; nothing is fetched, or sent but to the machines of --cluster.
    """

    controller: Annotated[str, tyro.conf.arg(metavar="NAME|expert|RUN_DIR|MODULE:CLASS|MODEL.zip")] = "random"
    """Who throws: a controller's name, the expert, the folder of a training run, a class of your own, on a line a
    scorer's FILE.npz, or with --trust a model of others."""
    expert: Annotated[
        str | None, option("the policy that ships, on a line guided_beam, elsewhere oracle", "NAME|RUN_DIR|...")
    ] = None
    """Whose mean return is the score 1; the shipped policy needs the extra rl, any other controller will do."""
    trust: bool = False
    """Load a stable-baselines3 model or an RL-Zoo folder, which runs whatever code is in it. Run folders need no trust:
    they hold none."""
    env: Annotated[str | None, option("PnTRelease-v0, or that of the run folder", "ID|MODULE:ID")] = None
    """Environment id; with MODULE:ID one that a module of yours registers."""
    level: Annotated[str | None, option("waste, with --env that one's own", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    action_mode: Annotated[str | None, option("the environment's own, or that of the run folder", "MODE")] = None
    """What an action means: one of the environment's action modes."""
    throws: int = 10_000
    """Throws to collect, on a line decisions; the episode in which the last one falls is completed."""
    seed: int = 0
    """Names the throws; no training, practice or evaluation with any seed sees them."""
    name: Annotated[str | None, option("pnt_gym/ENVIRONMENT/LEVEL-CONTROLLER-v0", "NAMESPACE/NAME-vN")] = None
    """Of the dataset."""
    root: Annotated[Path | None, option("MINARI_DATASETS_PATH, or ~/.minari/datasets", "DIR")] = None
    """The folder of all datasets."""
    practice: Annotated[int | None, option("120, or 0 for one that ships knowing", "N")] = None
    """Throws before for a controller that learns; others throw none."""
    score_throws: int = 1000
    """Throws by which random actions and the expert are scored, in whole episodes."""
    author: str = "anonymous"
    """Who makes the dataset."""
    author_email: Annotated[str | None, option("none", "EMAIL")] = None
    """How to reach them."""
    code_permalink: Annotated[str | None, option("none", "URL")] = None
    """Where the code lies that collected it, at its version."""
    num_envs: int = NUM_ENVS
    """Cells simulated side by side; where actions are random, they depend on it."""
    jobs: int = 2
    """Processes side by side, one thread each; results do not depend on it."""
    cluster: Annotated[str | None, option("this machine alone", "HOST:PORT|auto")] = None
    """Let the machines of a Ray cluster throw, instead of --jobs processes here: the address of its head."""
    work: Annotated[Path | None, option("runs/dataset/NAME", "DIR")] = None
    """Folder of what has been thrown, until the dataset is there."""


def main(arguments: Arguments) -> None:
    """Collect, write, say what there is."""
    at_least(vars(arguments), throws=1, seed=0, practice=0, score_throws=1, num_envs=1, jobs=1)
    from .data import offline  # noqa: PLC0415 - of an extra

    if arguments.name is not None:
        offline.check_name(arguments.name)
    home, (env_id, level, mode) = offline.Home.of(arguments.root), task(arguments)
    with closing(make_vector(env_id, level, arguments.num_envs, action_mode=mode)) as env:
        crew = Crew(arguments, env, env_id)
        config = core_of(env).config
        name = arguments.name or offline.proper_name(env_id, config.name, crew.label)
        home.check_free(name)
        whole = config.name if config.ships() else config.model_dump(mode="json")
        with closing(make_single(env_id, whole, mode)) as single, home.made(name):
            offline.check_recoverable(single)
            thrown = Thrown(crew, arguments.work or MADE / "runs" / "dataset" / name)
            scores, tally = thrown.scores(), Tally()
            found = tally.counted(thrown.episodes())
            first = next(found)
            facts = facts_of(crew, scores, offline.columns(first))
            with throws_bar() as bar:
                offline.write(name, single, chain([first], found), facts, packing(bar))
    thrown.remove()
    console().print(tally.table(name, scores).terminal())
    console().print(f"it lies in {home.folder / name}", markup=False)


def task(arguments: Arguments) -> tuple[str, str | None, str | None]:
    """Environment id, level and action mode; the last two None for the environment's own."""
    env, level = arguments.env, arguments.level
    if env is None and not os.path.isdir(arguments.controller):
        env, level = "PnTRelease-v0", "waste" if level is None else level
    return setting(arguments.controller, env, level, arguments.action_mode)


@final
class Crew:
    """Who throws for a dataset, and between whose scores everybody's lie.

    Args:
        arguments: of the command.
        env: where they throw.
        env_id: what it is called.

    Raises:
        UsageError: no such controllers, or an environment that does not tell what a dataset says of it.
    """

    def __init__(self, arguments: Arguments, env: Env, env_id: str) -> None:
        missing = [part for part in SAID if not hasattr(core_of(env), part)]
        if missing:
            raise UsageError(f"environment {env_id!r} cannot be collected: its core has no {' and no '.join(missing)}")
        self.arguments, self.env, self.env_id = arguments, env, env_id
        expert = arguments.expert or expert_for(env_id, env)
        chosen = expert if arguments.controller == EXPERT else arguments.controller
        self.chosen = (expert, chosen)
        self.lowest, self.highest, self.thrower = (self._made(name) for name in ("random", expert, chosen))
        self.label = EXPERT if arguments.controller == EXPERT else self.thrower.name
        """In the name of the dataset."""
        self.expert, self.algorithm = _described(self.highest, expert), _described(self.thrower, chosen)

    def collection(self, controller: Controller, given: str, role: Role) -> Collection:
        """Throws of one of them, who practises before if it learns."""
        core, config = core_of(self.env), core_of(self.env).config
        return Collection(
            env=self.env_id,
            level=config.name if config.ships() else config,
            mode=core.action_mode,
            num_envs=self.env.num_envs,
            episode=getattr(core.cell, "episode", 1),
            thrower=self._thrower(controller, given),
            role=role,
            seed=self.arguments.seed,
        )

    def practice(self, controller: Controller) -> int:
        """Throws that one of them practises; who does not learn throws none."""
        if not isinstance(controller, Learner):
            return 0
        asked = self.arguments.practice
        return usual_practice(controller) if asked is None else asked

    def _thrower(self, controller: Controller, given: str) -> Thrower:
        arguments, state = self.arguments, None
        if isinstance(controller, Learner):
            controller.reset(arguments.seed)
            with throws_bar() as bar:
                practice = self.practice(controller)
                advance = partial(bar.advance, bar.add_task(f"practice of {controller.name}", total=practice))
                practise(controller, self.env, practice, arguments.seed, progress=advance)
            state = controller.state()
        place = at(given)
        is_trained = os.path.isdir(place) or given.endswith((".zip", ".npz"))
        files = files_of(place) if is_trained else {}
        return Thrower(Path(given).resolve().name if is_trained else given, files, arguments.trust, state)

    def _made(self, name: str) -> Controller:
        return controller_for(name, self.env, trust=self.arguments.trust)


@final
class Thrown:
    """What a crew has thrown, kept in a folder: what is there already is not thrown again."""

    def __init__(self, crew: Crew, folder: Path) -> None:
        arguments, self._folder = crew.arguments, folder
        planned = (
            ("random", crew.collection(crew.lowest, "random", "evaluate"), arguments.score_throws),
            ("expert", crew.collection(crew.highest, crew.chosen[0], "evaluate"), arguments.score_throws),
            ("throws", crew.collection(crew.thrower, crew.chosen[1], "dataset"), arguments.throws),
        )
        jobs = {name: collection.jobs(name, throws) for name, collection, throws in planned}
        modules = sorted({module for _, collection, _ in planned for module in collection.modules})
        models = [path for _, one, _ in planned for path in one.thrower.files if path.endswith(".zip")]
        hands = pool(arguments.jobs, arguments.cluster, Needs(tuple(modules), torch=bool(models)))
        files = iter(keep_missing([*chain(*jobs.values())], folder, hands, unit="throws"))
        self._files = {name: [next(files) for _ in some] for name, some in jobs.items()}
        self._throws = {name: throws for name, _, throws in planned}

    def episodes(self, name: str = "throws") -> Iterator[Episode]:
        """Episodes of the dataset, or by which random actions or the expert are scored, as many as were asked for."""
        done = 0
        for episode in chain.from_iterable(map(unpacked, self._files[name])):
            if done >= self._throws[name]:
                return
            done += len(episode)
            yield episode

    def scores(self) -> Scores:
        """What random actions and the expert are worth in the same episodes, which are in no dataset."""
        lowest, highest = (
            {episode.seed: float(episode.rewards.sum()) for episode in self.episodes(name)}
            for name in ("random", "expert")
        )
        common = [seed for seed in lowest if seed in highest]
        means = [float(np.mean([returns[seed] for seed in common])) for returns in (lowest, highest)]
        return Scores(*means, len(common))

    def remove(self) -> None:
        """Forget it, now that it stands in a dataset."""
        for file in chain.from_iterable(self._files.values()):
            file.unlink(missing_ok=True)
        with suppress(OSError):  # something else lies there
            self._folder.rmdir()


def _described(controller: Controller, given: str) -> str:
    """A controller by its name, and that of its folder, but not where that lies."""
    return f"{controller.name} of {Path(given).name}" if os.path.isdir(at(given)) else controller.name


@final
@dataclass(frozen=True)
class Scores:
    """Mean returns of an episode, by which others are measured."""

    lowest: float
    highest: float
    episodes: int
    """By which they were found."""


@final
@dataclass
class Tally:
    """What the episodes of a dataset are worth, counted while they pass."""

    returns: list[float] = field(default_factory=list)
    throws: int = 0
    told: dict[str, list[float]] = field(default_factory=dict)
    """Of throws and of whole episodes, by the names of `SHOWN`, as far as the environment tells."""

    def counted(self, found: Iterator[Episode]) -> Iterator[Episode]:
        """The same episodes."""
        for episode in found:
            self.returns.append(float(episode.rewards.sum()))
            self.throws += len(episode)
            known = {**{name: values[1:] for name, values in episode.told.items()}, **episode.figures}
            for name in known.keys() & SHOWN.keys():
                self.told.setdefault(name, []).extend(np.ravel(known[name]).tolist())
            yield episode

    def table(self, name: str, scores: Scores) -> Grid:
        """All that was counted."""
        mean, span = float(np.mean(self.returns)), scores.highest - scores.lowest
        rows = [
            ("episodes", f"{len(self.returns)}"),
            ("throws", f"{self.throws}"),
            *((label, show(_mean(self.told[key]))) for key, (label, show) in SHOWN.items() if key in self.told),
            ("return of an episode, mean", f"{mean:.3f}"),
            ("score: 0 is random, 1 the expert", f"{(mean - scores.lowest) / span:.3f}" if span else "-"),
        ]
        return Grid(name, ("figure", "value"), rows)


def _mean(values: Sequence[float]) -> float:
    """Of the values that are known; NaN where none is."""
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else np.nan


def packing(bar: Progress) -> Callable[[int, int], None]:
    """Shows how many of all episodes are packed, as soon as there are some."""
    shown = bar.add_task("packing", total=None, visible=False)
    return lambda done, total: bar.update(shown, completed=done, total=total, visible=True)


def facts_of(crew: Crew, scores: Scores, columns: Mapping[str, Sequence[str]]) -> Facts:
    """What the dataset tells of itself.

    Args:
        crew: who throws in it.
        scores: found with them.
        columns: of the arrays of `infos`.
    """
    from .data.offline import Facts  # noqa: PLC0415 - of an extra

    arguments, core = crew.arguments, core_of(crew.env)
    minari = {
        "algorithm_name": crew.algorithm,
        "author": arguments.author,
        "author_email": arguments.author_email,
        "code_permalink": arguments.code_permalink,
        "ref_min_score": scores.lowest,
        "ref_max_score": scores.highest,
        "num_episodes_average_score": scores.episodes,
        "description": description(crew, scores, columns),
        "requirements": [f"{name}=={versions()[name]}" for name in NEEDED],
    }
    ours = {
        "seed": arguments.seed,
        "num_envs": arguments.num_envs,
        "practice": crew.practice(crew.thrower),
        "expert": crew.expert,
        "items": list(core.item_names),
        "level": core.config.model_dump(mode="json"),
        "versions": versions(),
        "commit": (git_state() or "").partition("\n")[0] or None,
    }
    return Facts(minari, {"columns": columns, "pnt_gym": ours})


def description(crew: Crew, scores: Scores, columns: Mapping[str, Sequence[str]]) -> str:
    """The dataset in words."""
    core = core_of(crew.env)
    quantities = numbered(getattr(core.cell, "hidden", ()))
    hidden = "; ".join(f"{one.name} [{one.unit}], {one.meaning}" for one in quantities)
    parts = [
        f"Throws of {crew.env_id}, level {core.config.name}, action mode {core.action_mode}, by {crew.algorithm}.",
        "Reset the recovered environment with the seed of an episode and give it its actions: with the packages of "
        "`requirements`, observations and rewards are the same bit for bit.",
        "In `infos`, entry k + 1 is of throw k, and entry 0, of the reset, NaN or False; what a reset tells too is of "
        "the throw that follows: entry k belongs to observation k. `landing_error` is in metres.",
        f"Columns of `outcome`, as in the manual of the environment: {', '.join(columns['outcome'])}.",
        f"Columns of `hidden`, which no observation tells: {hidden}." if hidden else "",
        f"Score 0 is the mean return of random actions, score 1 that of {crew.expert}, on {scores.episodes} other "
        "episodes.",
    ]
    return " ".join(filter(None, parts))


if __name__ == "__main__":
    run(main, Arguments, "agents.dataset")
