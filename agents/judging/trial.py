"""A trial: the one way to judge controllers in an environment.

The config of an environment's levels names its kind of trial: `trial = "throws"`, `"work_shifts"`, or `MODULE:CLASS`
for a subclass of `Trial` in a module of yours. Commands, benchmark and report ask the trial, and nothing else, what is
counted, who acts, and how that is told.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, ClassVar, Final

from pnt_gym.cells.base.config import LevelConfig

from ..controllers import make_controller
from ..controllers.own import controller_of, run_policy
from ..controllers.protocol import Controller, Learner
from ..ground.amounts import PICKS, PRACTICE
from ..ground.cli import UsageError
from ..ground.environments import Env, core_of
from ..ground.places import POLICY
from ..learning.algorithms import RESIDUAL
from ..learning.runs import RunFolder
from ..learning.windows import ThrowWindow, Window
from .card import Card, usual_card
from .loop import Progress, practise
from .record import Record

EXPERTS: Final[Mapping[str, str]] = dict.fromkeys(("PnTConveyor-v0", "PnTRelease-v0"), str(POLICY))
"""Policies that ship, by the environment in which each is the expert."""


class Trial(ABC):
    """Abstract: one kind of task, and how controllers are judged by it.

    A subclass needs `unit`, `record` and `run` alone. All else is as single throws need it.

    Args:
        env: the cells in which controllers act.
    """

    unit: ClassVar[str]
    """What is counted, in the plural, such as throws."""
    step: ClassVar[str] = "throw"
    """What a controller decides and learns from, in the singular."""
    option: ClassVar[str] = "picks"
    """Option of commands, and key of benchmark plans, that says how many units are counted."""
    usual: ClassVar[int] = PICKS
    """How many are counted unless others are asked for."""
    usual_card: ClassVar[int] = 1000
    """How many are counted for the card of a published policy."""
    usual_table: ClassVar[int] = 320
    """How many are counted for the table after a training."""
    options: ClassVar[frozenset[str]] = frozenset({"picks", "practice", "online", "load", "save"})
    """Options of commands and keys of benchmark plans that are of use, of those that some kinds have no use for."""
    record: ClassVar[type[Record]]
    """What `run` returns."""
    algorithms: ClassVar[tuple[str, ...]] = RESIDUAL
    """Those of `agents.train`, the usual one first."""
    checkpoint_every: ClassVar[int] = 2_000
    """Steps of a training between two checkpoints unless others are asked for."""
    window: ClassVar[type[Window]] = ThrowWindow
    """What a training tells while it runs."""
    reference: ClassVar[str | None] = None
    """Name of the controller over which gains are shown in tables, where one is."""

    def __init__(self, env: Env) -> None:
        self.env = env
        self.core: Any = core_of(env)

    @abstractmethod
    def run(
        self,
        controller: Controller,
        count: int,
        seed: int,
        *,
        online: bool = False,
        progress: Progress | None = None,
    ) -> Record:
        """Let a controller, as it is, do `count` held-out units.

        Args:
            controller: acts.
            count: number of units.
            seed: names the units; no training and no practice with any seed sees them.
            online: the controller goes on learning.
            progress: called with the number of units just done.
        """

    # What an environment is opened with

    @classmethod
    def simulated(cls, config: LevelConfig, throws: str) -> LevelConfig:
        """A level whose throws are simulated as `--throws` asks for.

        Raises:
            UsageError: levels of this kind of trial have no such choice.
        """
        del config, throws
        raise UsageError(f"--throws goes with work shifts; here {cls.unit} are judged, and always simulated")

    def close(self) -> None:
        """Close the environment; safe to call twice."""
        self.env.close()

    # Controllers

    def controller(self, policy: Any, *, trust: bool = False, **options: Any) -> Controller:
        """A controller that acts here, not yet reset.

        Args:
            policy: a name as `--controller` takes it; or a controller, its class, a model or a function.
            trust: run the code in an RL-Zoo folder or a model.zip.
            options: settings of a controller that is named.

        Raises:
            UsageError: no such controller, or one that cannot act here.
        """
        if isinstance(policy, str):
            return make_controller(policy, self.env, trust=trust, **options)
        return controller_of(policy, self.env)

    def correct_throws(self, release: str | None) -> None:
        """Let a controller of single throws correct the throws of this trial, where that is another one than acts."""
        del release

    def expert(self, env_id: str) -> str:
        """Name of the best controller known here."""
        return EXPERTS.get(env_id, "oracle")

    def count(self) -> int:
        """Units that are counted unless others are asked for."""
        return self.usual

    def practice(self, controller: Controller) -> int:
        """Steps from which a controller learns before it is judged, unless others are asked for."""
        return int(getattr(controller, "practice", PRACTICE)) if isinstance(controller, Learner) else 0

    def practise(
        self, controller: Controller, steps: int, seed: int, *, progress: Progress | None = None
    ) -> Controller:
        """Let a controller learn before it is judged.

        Args:
            controller: what learns; one that does not learn is returned as it is.
            steps: number of throws or decisions.
            seed: names them.
            progress: called with the number of steps just done.

        Returns:
            The controller, or where a search learns for it what the search has found.
        """
        practise(controller, self.env, steps, seed, progress=progress)
        return controller

    def peers(self, asked: Mapping[str, Any]) -> dict[str, int]:
        """Names of controllers with which the table after a training compares, and the steps of their practice."""
        return {"analytic": 0, asked["over"]: 0}

    # Pictures

    def steps(self, controller: Controller, seed: int) -> Iterator[Any]:
        """Endless: carry out steps one after the other, each of which can be shown by the view of the core.

        Raises:
            UsageError: this kind of trial shows no steps.
        """
        raise UsageError(f"{self.unit} of this environment cannot be shown")

    def filmed(self, steps: Iterator[Any], picks: int | None) -> Iterator[Any]:
        """The steps of a film: as many as asked for, or as are usual."""
        return islice(steps, 5 if picks is None else picks)

    def advance(self, steps: Iterator[Any], moment: float) -> None:
        """Carry out steps until a picture at a moment [s] can be drawn."""
        del moment
        next(steps)

    # Training

    def check_training(self, asked: Mapping[str, Any]) -> None:
        """Make sure that a training fits.

        Raises:
            UsageError: its algorithm does not.
        """
        if asked["algo"] not in self.algorithms:
            raise UsageError(
                f"algorithm {asked['algo']} does not learn from {self.step}s of {asked['env']}; algorithms there are "
                f"{', '.join(self.algorithms)}"
            )

    def hyperparameters(self, asked: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
        """Hyperparameters of a training with those that depend on the cell.

        Args:
            asked: arguments of the training.
            given: hyperparameters.
        """
        del asked
        return dict(given)

    def price(self, settings: Mapping[str, Any]) -> float:
        """How much more a second costs in training than in the reward of the environment [1/s]."""
        del settings
        return 0.0

    def policy(self, folder: RunFolder, checkpoint: Path | None, asked: Mapping[str, Any], name: str) -> Controller:
        """The newest policy of a training, or that of a checkpoint, as a controller called `name`."""
        return run_policy(folder.load_actor(checkpoint), asked, self.env, "the policy", name)

    @classmethod
    def card(cls) -> Card:
        """What cards say of published policies."""
        return usual_card(cls.record, cls.unit, cls.option)

    # Benchmark

    def check_count(self, count: int, num_envs: int, level: str) -> None:
        """Make sure that so many units of a level, counted in so many rows, are a fair number.

        Raises:
            UsageError: they are not.
        """
        del count, num_envs, level

    @classmethod
    def depends(cls, name: str, levels: Sequence[Any], options: Mapping[str, Any], throws: Sequence[int]) -> Any:
        """What figures of a controller depend on beside code, levels and its own files.

        Args:
            name: of the controller.
            levels: configs that it learns and acts on.
            options: settings that a benchmark's entry gives it.
            throws: steps that it learns from.
        """
        del name, levels, options, throws
        return {}

    @classmethod
    def learned(cls, name: str, levels: Sequence[Any], options: Mapping[str, Any]) -> list[tuple[str, str]]:
        """Setting and value of what a controller reads that was learned before, beside its own name."""
        del name, levels, options
        return []

    @classmethod
    def effort(cls, name: str, config: Any, count: int, num_envs: int) -> int:
        """About how many steps one evaluation simulates; a step that takes long counts several times.

        Args:
            name: of the controller.
            config: of the level.
            count: number of units.
            num_envs: rows side by side.
        """
        del name, config, num_envs
        return count
