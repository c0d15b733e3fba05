"""Collect throws for offline learning as a Minari dataset: `python -m agents.dataset --controller random`."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Annotated

import tyro

from ..ground.cli import NUM_ENVS, at_least, option, run
from ..ground.cluster import pool
from ..ground.environments import make_single
from ..ground.places import MADE
from ..ground.tables import console, throws_bar
from ..judging.trials import open_trial
from .crew import Crew, EpisodeStore, Tally, collection_task

CONTROLLERS = (
    "The controller that throws: a name, the word expert, the folder of a training run, a class of your own, on a line "
    "a scorer's FILE.npz, or with --trust a stable-baselines3 model or an RL-Zoo folder."
)
CREW = ("controller", "expert", "seed", "trust", "practice", "noise")
"""Options that say who throws."""


@dataclass(frozen=True)
class Arguments:
    """Collect throws of a controller and write them as a Minari dataset, which replays bit for bit.

    The dataset states the mean return of random actions as score 0 and that of an expert as score 1. A dataset appears
    complete or not at all, and an interrupted collection goes on where it stopped. Nothing is downloaded, and data are
    sent only to the machines of --cluster.
    """

    controller: Annotated[
        str, tyro.conf.arg(metavar="NAME|expert|RUN_DIR|MODULE:CLASS|MODEL.zip", help=CONTROLLERS)
    ] = "random"
    expert: Annotated[
        str | None, option("the shipped policy, on a line guided_beam, elsewhere oracle", "NAME|RUN_DIR|...")
    ] = None
    """The controller whose mean return is the score 1, the expert; the shipped policy needs the extra rl."""
    trust: bool = False
    """Load a stable-baselines3 model or an RL-Zoo folder, whose code then runs; run folders hold no code."""
    env: Annotated[str | None, option("PnTRelease-v0, or that of the run folder", "ID|MODULE:ID")] = None
    """Environment id; MODULE:ID imports a module of yours first, which registers the id."""
    level: Annotated[str | None, option("waste; with --env that environment's own", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    action_mode: Annotated[str | None, option("the environment's own, or that of the run folder", "MODE")] = None
    """Meaning of an action: one of the environment's action modes."""
    noise: Annotated[tuple[float, ...], option("none", "SD ...")] = ()
    """Standard deviation of normal noise on the actions of --controller; of several, each chunk takes the next."""
    throws: int = 10_000
    """Throws to collect, or decisions on a line; the episode that contains the last throw is completed."""
    seed: int = 0
    """Seed of the collected throws; no training, practice or evaluation with any seed sees these throws."""
    name: Annotated[str | None, option("pnt_gym/ENVIRONMENT/LEVEL-CONTROLLER-v0", "NAMESPACE/NAME-vN")] = None
    """Name of the dataset."""
    root: Annotated[Path | None, option("MINARI_DATASETS_PATH, or ~/.minari/datasets", "DIR")] = None
    """The folder of all datasets."""
    practice: Annotated[int | None, option("120, or 0 for a controller that ships pre-trained", "N")] = None
    """Practice throws of a controller or an expert that learns, before the collection; refused where neither does."""
    score_throws: int = 1000
    """Throws, in whole episodes, from which the scores of random actions and of the expert are computed."""
    author: str = "anonymous"
    """Author of the dataset, in its metadata."""
    author_email: Annotated[str | None, option("none", "EMAIL")] = None
    """E-mail address of the author, in the metadata."""
    code_permalink: Annotated[str | None, option("none", "URL")] = None
    """Link to the version of the code that collected the dataset, in the metadata."""
    num_envs: int = NUM_ENVS
    """Cells simulated side by side; random actions depend on this number."""
    jobs: int = 2
    """Processes side by side, one thread each; results do not depend on this number."""
    cluster: Annotated[str | None, option("this machine alone", "HOST:PORT|auto")] = None
    """Collect on the machines of a Ray cluster instead of in --jobs processes here: the address of its head."""
    work: Annotated[Path | None, option("runs/dataset/NAME", "DIR")] = None
    """Folder of the collected throws until the dataset is written."""


def main(arguments: Arguments) -> None:
    """Collect the throws, write the dataset, and print its figures."""
    at_least(vars(arguments), throws=1, seed=0, practice=0, score_throws=1, num_envs=1, jobs=1)
    from . import offline  # noqa: PLC0415 - of an extra
    from .offline import facts_of  # noqa: PLC0415 - as above

    if arguments.name is not None:
        offline.check(arguments.name)
    home, names = offline.Home.of(arguments.root), (arguments.controller, arguments.env, arguments.level)
    env_id, level, mode = collection_task(*names, arguments.action_mode)
    with closing(open_trial(env_id, level, arguments.num_envs, action_mode=mode)) as trial:
        chosen = {name: getattr(arguments, name) for name in CREW}
        crew, config = Crew(trial, env_id, **chosen), trial.core.config
        name = arguments.name or offline.name(env_id, config.name, crew.label)
        home.check(name)
        whole = config.name if config.ships() else config.model_dump(mode="json")
        with closing(make_single(env_id, whole, mode)) as single, home.create(name):
            offline.check_recoverable(single)
            folder = arguments.work or MADE / "runs" / "dataset" / name
            make_pool = partial(pool, arguments.jobs, arguments.cluster)
            store = EpisodeStore(crew, folder, arguments.throws, arguments.score_throws, make_pool)
            scores, tally = store.scores(), Tally()
            authorship = {name: getattr(arguments, name) for name in ("author", "author_email", "code_permalink")}
            episodes = tally.count(store.episodes())
            first = next(episodes)
            facts = facts_of(crew, scores, offline.columns(first), authorship)
            with throws_bar() as bar:
                task = bar.add_task("packing", total=None, visible=False)
                offline.write(
                    name,
                    single,
                    chain([first], episodes),
                    facts,
                    lambda number, total: bar.update(task, completed=number, total=total, visible=True),
                )
    store.clear()
    console().print(tally.table(name, scores).terminal())
    console().print(f"it lies in {home.folder / name}", markup=False)


if __name__ == "__main__":
    run(main, Arguments, "agents.dataset")
