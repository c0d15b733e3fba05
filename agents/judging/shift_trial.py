"""Trials by work shifts: a controller chooses the next object of each robot, and whole held-out shifts are counted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from itertools import takewhile
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.line.chances import format_table, required_table
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore

from ..controllers.between import PLANNER
from ..controllers.own import controller_of, import_controller
from ..controllers.protocol import Controller
from ..dispatchers import registry
from ..dispatchers.decisions import make_release, work_shifts
from ..dispatchers.registry import FIRST, GUIDED, SEARCHED
from ..dispatchers.rules import ScoreController, run_scores
from ..dispatchers.settings import PLANNERS, rate
from ..dispatchers.settings import settings as tuned_settings
from ..ground.cli import SHIFTS, UsageError
from ..ground.environments import Env, stream_seed
from ..ground.shipped import module_of
from ..learning.hyperparameters import MASKED, SCORING, algorithm_arguments
from ..learning.runs import RunFolder
from ..learning.windows import DecisionWindow
from ..policies.scorer import Scorer
from .loop import Progress
from .record import Card
from .shift_record import CARD, ShiftRecord
from .shifts import run_shifts
from .trial import Trial

SECONDS: Final = 12.0
"""Default length of a film: the first seconds of a shift."""
END: Final = 64
"""Shifts on which a search compares its final index with its first one, as in `agents.line tune`."""
SLOW: Final = 20
"""Number of a rule's decisions that take as long as one decision of a planner."""


@final
class ShiftTrial(Trial):
    """Trials on lines, where an action chooses the object that a robot takes next."""

    unit = "work shifts"
    step = "decision"
    option = "shifts"
    usual = usual_table = SHIFTS
    usual_card = 100
    options = frozenset({"shifts", "release", "throws", "picture", "video"})
    record = ShiftRecord
    algorithms = MASKED[::-1]
    checkpoint_every = 125_000
    window = DecisionWindow
    reference = "atc"

    def __init__(self, env: Env) -> None:
        super().__init__(env)
        self.core: LineCore
        self._settings: dict[str, str] = {}
        if env.num_envs > 1 and getattr(env.unwrapped, "core", None) is None:
            raise UsageError(
                f"this environment steps {env.num_envs} lines one by one, and a controller of a line sees all at once; "
                "use 1 line (--num-envs 1)"
            )

    def run(
        self,
        controller: Controller,
        count: int,
        seed: int,
        *,
        online: bool = False,
        progress: Progress | None = None,
    ) -> ShiftRecord:
        """Let a controller work `count` held-out shifts."""
        del online
        worked = run_shifts(controller, self.env, count, stream_seed("evaluate", seed), progress)
        return ShiftRecord(worked, self.core, {"level": self.core.config.name, **self._settings})

    @classmethod
    def with_throws(cls, config: LevelConfig, throws: str) -> LineConfig:
        """Copy of a level with throws by `table`, in `flight` or in `full`."""
        return LineConfig.load(config, throws=throws)

    def controller(self, policy: Any, *, trust: bool = False, **options: Any) -> Controller:
        """A controller of lines: a name, a scorer's file, a run folder, MODULE:CLASS, or what `controller_of` takes."""
        if not isinstance(policy, str):
            return controller_of(policy, self.env)
        if module_of(policy) is not None:
            return import_controller(policy, self.env, **options)
        return registry.make(policy, self.core, **options)

    def correct_throws(self, release: str | None) -> None:
        """Let a controller of PnTRelease-v0 correct the throws, where throws are simulated."""
        self._settings = {"release": release or PLANNER}
        if release is not None:
            self.core.use(make_release(release, self.core.config))

    def expert(self, env_id: str) -> str:
        """Name of the guided planner."""
        del env_id
        return GUIDED

    def practise(
        self, controller: Controller, steps: int, seed: int, *, progress: Progress | None = None
    ) -> Controller:
        """Search for an index if the controller is one, in whole generations of about `steps` decisions together."""
        del progress
        if controller.name != SEARCHED or steps == 0:
            return controller
        from ..dispatchers import search  # noqa: PLC0415 - as above
        from ..dispatchers.search import SEARCHED_SHIFTS, Bench  # noqa: PLC0415 - as above

        level = LineConfig.load(self.core.config, throws="table")
        first = stream_seed("practice", seed)
        bench = Bench(level, np.arange(first, first + END))
        generations = -(-steps // _count(level, SEARCHED_SHIFTS))
        tried = search.weights(bench, tuned_settings(level.name, "atc")["patience"], generations, seed)
        return ScoreController(SEARCHED, Scorer.linear(**search.best(tried).settings))

    def peers(self, run_args: Mapping[str, Any]) -> dict[str, int]:
        """Two rules: first in, first out, and the tuned ATC rule."""
        del run_args
        return {FIRST: 0, "atc": 0}

    def steps(self, controller: Controller, seed: int) -> Iterator[float]:
        """Carry out the decisions of one line's first shift; yields the time of the next decision in the shift [s].

        The shift is the same as that of row 0 of many lines.
        """
        for _ in work_shifts(controller.act, self.env, stream_seed("evaluate", seed), 1):
            yield float(self.core.cell.state.clock[0])

    def film_steps(self, steps: Iterator[float], picks: int | None) -> Iterator[float]:
        """The first `picks` decisions, or the decisions of the first 12 s."""
        return takewhile(lambda time: time < SECONDS, steps) if picks is None else super().film_steps(steps, picks)

    def advance(self, steps: Iterator[float], moment: float) -> None:
        """Carry out decisions until a moment of the shift [s]."""
        for time in steps:
            if time >= moment:
                return

    def check_training(self, run_args: Mapping[str, Any]) -> None:
        """Make sure that the algorithm chooses objects, and that no option for throws is given."""
        super().check_training(run_args)
        if (run_args["stack"], run_args["over"], run_args["fidelity"]) != (1, PLANNER, "full"):
            raise UsageError("--stack, --over and --fidelity go with throws, and not with work shifts")

    def hyperparameters(self, run_args: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
        """Hyperparameters completed by those of the line: patience and rate of value of the tuned ATC rule.

        `gamma` and `gae_lambda` are given per decision of one robot; per decision of R robots they are the R-th roots.
        """
        config, values = self.core.config, dict(settings)
        algorithm_arguments(values)
        robots = len(config.robots)
        values |= {key: round(values[key] ** (1.0 / robots), 6) for key in ("gamma", "gae_lambda") if key in values}
        if run_args["algo"] in SCORING:
            values.setdefault("patience", tuned_settings(config.name, "atc")["patience"])
        tuned = rate(config.name)
        values.setdefault("price_of_time", config.price_of_time if tuned is None else tuned)
        return values

    def price(self, settings: Mapping[str, Any]) -> float:
        """Price of time that a training subtracts beyond the price in the environment's reward [1/s]."""
        algorithm_arguments(settings)
        return float(settings.get("price_of_time", self.core.config.price_of_time)) - self.core.config.price_of_time

    def policy(self, folder: RunFolder, checkpoint: Path | None, run_args: Mapping[str, Any], name: str) -> Controller:
        """Newest policy of a training, or the policy of a checkpoint, as a controller."""
        del run_args, name
        return run_scores(folder.path, checkpoint)

    @classmethod
    def card(cls) -> Card:
        """Card with value per minute and recovery of shifts."""
        return CARD

    @classmethod
    def dependencies(
        cls, name: str, levels: Sequence[LineConfig], options: Mapping[str, Any], throws: Sequence[int]
    ) -> Any:
        """Tuned settings, and digests of the tables of throws."""
        del options, throws
        tuned: list[Any] = [tuned_settings(level.name, name, len(level.robots)) for level in levels]
        if name == SEARCHED:
            tuned += [tuned_settings(level.name, "atc") for level in levels]
        if name in cls.algorithms:
            tuned = [(tuned_settings(level.name, "atc"), rate(level.name)) for level in levels]
        return {
            "tuned": tuned,
            "tables": [sha256(format_table(required_table(level)).encode()).hexdigest() for level in levels],
        }

    @classmethod
    def artefact_settings(
        cls, name: str, levels: Sequence[LineConfig], options: Mapping[str, Any]
    ) -> list[tuple[str, str]]:
        """The guide of the guided planner on each level, and the user's files of tables of throws."""
        tables = [("chances", level.chances) for level in levels if isinstance(level.chances, str)]
        if name != GUIDED:
            return tables
        settings = [tuned_settings(level.name, name, len(level.robots)) for level in levels]
        return [
            *tables,
            *(("guide", str({**level_settings, **options}.get("guide", SEARCHED))) for level_settings in settings),
        ]

    @classmethod
    def effort(cls, name: str, config: LineConfig, count: int, num_envs: int) -> int:
        """Number of decisions in all rows until the last shift ends; a planner's decision counts `SLOW` times."""
        return _count(config, -(-count // num_envs) * num_envs) * (SLOW if name in PLANNERS else 1)


def _count(level: LineConfig, shifts: int) -> int:
    """Number of decisions in some shifts, about one per second and robot."""
    return int(level.duration) * len(level.robots) * shifts
