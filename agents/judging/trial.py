"""Trials: how controllers are evaluated in an environment.

The config of an environment's levels names its kind of trial: `trial = "throws"`, `"work_shifts"`, or `MODULE:CLASS`
for a subclass of `Trial` in a module of yours. Commands, benchmark and report ask only the trial which units are
counted, which controllers act, and how results are reported.
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
from ..controllers.protocol import Controller, learns
from ..ground.cli import PICKS, PRACTICE, UsageError
from ..ground.environments import Env, core_of
from ..ground.places import POLICY
from ..learning.hyperparameters import RESIDUAL
from ..learning.runs import RunFolder
from ..learning.windows import ThrowWindow, Window
from .loop import Progress, practise
from .record import Card, Record, usual_card

EXPERTS: Final[Mapping[str, str]] = {
    **dict.fromkeys(("PnTConveyor-v0", "PnTRelease-v0"), str(POLICY)),
    "PnTGrasp-v0": "oracle_grasp",
}
"""Folders of the shipped policies, or names of controllers, by the environment in which each is the expert."""


class Trial(ABC):
    """Abstract: how controllers are evaluated on one kind of task.

    A subclass needs `unit`, `record` and `run` alone; the defaults of all other methods fit single throws.

    Args:
        env: the cells in which controllers act.
    """

    unit: ClassVar[str]
    """Name of the counted unit, in the plural, such as throws."""
    step: ClassVar[str] = "throw"
    """Name of one step, from which a controller learns, in the singular."""
    option: ClassVar[str] = "picks"
    """Option of commands, and key of benchmark plans, with the number of units."""
    usual: ClassVar[int] = PICKS
    """Default number of units."""
    usual_card: ClassVar[int] = 1000
    """Default number of units for the card of a published policy."""
    usual_table: ClassVar[int] = 320
    """Default number of units for the table after a training."""
    options: ClassVar[frozenset[str]] = frozenset({"picks", "practice", "online", "load", "save"})
    """Options of commands and keys of benchmark plans that this kind of trial uses and other kinds may not use."""
    record: ClassVar[type[Record]]
    """Class of the records that `run` returns."""
    algorithms: ClassVar[tuple[str, ...]] = RESIDUAL
    """Algorithms of `agents.train` that can learn here, the default first."""
    checkpoint_every: ClassVar[int] = 2_000
    """Default number of training steps between two checkpoints."""
    window: ClassVar[type[Window]] = ThrowWindow
    """Figures that a training shows while it runs."""
    reference: ClassVar[str | None] = None
    """Name of the controller over which tables show gains; None for no gains."""

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
        """Let a controller, without practice, carry out `count` held-out units.

        Args:
            controller: acts.
            count: number of units.
            seed: seed of the units; no training and no practice with any seed sees these units.
            online: let the controller go on learning.
            progress: called with the number of units just done.
        """

    # Opening an environment

    @classmethod
    def with_throws(cls, config: LevelConfig, throws: str) -> LevelConfig:
        """Copy of a level whose throws are computed as `--throws` says.

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
        """A controller for this environment, not yet reset.

        Args:
            policy: a name as `--controller` takes it; or a controller, its class, a model or a function.
            trust: run the code in an RL-Zoo folder or a model.zip.
            options: settings of a controller given by name.

        Raises:
            UsageError: there is no such controller, or it cannot act here.
        """
        if isinstance(policy, str):
            return make_controller(policy, self.env, trust=trust, **options)
        return controller_of(policy, self.env)

    def correct_throws(self, release: str | None) -> None:
        """Let another controller correct the simulated throws, in trials whose own controller makes other decisions."""
        del release

    def expert(self, env_id: str) -> str:
        """Name of the best controller known for an environment."""
        return EXPERTS.get(env_id, "oracle")

    def count(self) -> int:
        """Default number of units in this environment."""
        return self.usual

    def block(self, left: int) -> int:
        """Number of units in the next block of a sequential comparison: one unit in every row.

        Args:
            left: number of units that may still be carried out.
        """
        return min(self.env.num_envs, left)

    def practice(self, controller: Controller) -> int:
        """Default number of practice steps of a controller; 0 for a controller that does not learn."""
        return int(getattr(controller, "practice", PRACTICE)) if learns(controller) else 0

    def practise(
        self, controller: Controller, steps: int, seed: int, *, progress: Progress | None = None
    ) -> Controller:
        """Let a controller practise before its evaluation.

        Args:
            controller: the controller; one that does not learn is returned unchanged.
            steps: number of throws or decisions.
            seed: seed of the steps.
            progress: called with the number of steps just done.

        Returns:
            The controller; where a search replaces practice, the best controller of the search.
        """
        practise(controller, self.env, steps, seed, progress=progress)
        return controller

    def peers(self, run_args: Mapping[str, Any]) -> dict[str, int]:
        """Controllers that the table after a training compares with the policy, and their practice steps, by name."""
        return {"analytic": 0, run_args["over"]: 0}

    # Pictures

    def steps(self, controller: Controller, seed: int) -> Iterator[Any]:
        """Carry out steps endlessly, one after the other; the core's view can show each step.

        Raises:
            UsageError: this kind of trial shows no steps.
        """
        raise UsageError(f"{self.unit} of this environment cannot be shown")

    def film_steps(self, steps: Iterator[Any], picks: int | None) -> Iterator[Any]:
        """Steps of a film: `picks` steps, or the default number for None."""
        return islice(steps, 5 if picks is None else picks)

    def advance(self, steps: Iterator[Any], moment: float) -> None:
        """Carry out steps until a picture at a moment [s] can be drawn."""
        del moment
        next(steps)

    # Training

    def check_training(self, run_args: Mapping[str, Any]) -> None:
        """Make sure that a training fits this kind of trial.

        Raises:
            UsageError: the algorithm does not fit.
        """
        if run_args["algo"] not in self.algorithms:
            raise UsageError(
                f"algorithm {run_args['algo']} does not learn from {self.step}s of {run_args['env']}; algorithms there "
                f"are {', '.join(self.algorithms)}"
            )

    def hyperparameters(self, run_args: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
        """Hyperparameters of a training, completed by those that depend on the cell.

        Args:
            run_args: arguments of the training.
            settings: hyperparameters.
        """
        del run_args
        return dict(settings)

    def price(self, settings: Mapping[str, Any]) -> float:
        """Price of time that a training subtracts beyond the price in the environment's reward [1/s]."""
        del settings
        return 0.0

    def policy(self, folder: RunFolder, checkpoint: Path | None, run_args: Mapping[str, Any], name: str) -> Controller:
        """Newest policy of a training, or the policy of a checkpoint, as a controller with a name."""
        return run_policy(folder.actor(checkpoint), run_args, self.env, "the policy", name)

    @classmethod
    def card(cls) -> Card:
        """Texts and figures of the cards of published policies."""
        return usual_card(cls.record, cls.unit, cls.option)

    # Benchmark

    def check_count(self, count: int, num_envs: int, level: str) -> None:
        """Make sure that `count` units of a level in `num_envs` rows give a fair evaluation.

        Raises:
            UsageError: the number of units is not fair.
        """
        del count, num_envs, level

    @classmethod
    def dependencies(cls, name: str, levels: Sequence[Any], options: Mapping[str, Any], throws: Sequence[int]) -> Any:
        """Dependencies of a controller's figures beside code, levels and its own files, as JSON values.

        Args:
            name: name of the controller.
            levels: configs of the levels for learning and evaluation.
            options: settings in the benchmark's entry.
            throws: numbers of learning steps.
        """
        del name, levels, options, throws
        return {}

    @classmethod
    def artefact_settings(cls, name: str, levels: Sequence[Any], options: Mapping[str, Any]) -> list[tuple[str, str]]:
        """Settings by which a controller reads further files, such as a guide, and their values."""
        del name, levels, options
        return []

    @classmethod
    def effort(cls, name: str, config: Any, count: int, num_envs: int) -> int:
        """Approximate number of steps of one evaluation; a slow step counts several times.

        Args:
            name: name of the controller.
            config: config of the level.
            count: number of units.
            num_envs: number of rows side by side.
        """
        del name, config, num_envs
        return count
