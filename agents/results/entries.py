"""Entries of a benchmark: which controller is measured, and what it learns from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self, final

from pydantic import Field, model_validator

from pnt_gym.cells.base.config import FileName, Section
from pnt_gym.names import unknown_name

from ..controllers import NAMES
from ..controllers.adaptive import PRETRAINED
from ..controllers.between import BASES, MAX_STACK, PLANNER
from ..dispatchers.registry import NAMES as DECIDING
from ..dispatchers.registry import SEARCHED
from ..ground.cli import about, check_known, check_once
from ..ground.shipped import is_shipped, module_of
from ..learning.hyperparameters import MASKED, RESIDUAL, hyperparameters

Count = Annotated[int, Field(ge=0)]
Several = Annotated[int, Field(ge=2)]
TRAINED = (*RESIDUAL, *MASKED)
FITTED = (*TRAINED, "mlp", *PRETRAINED)
"""Controllers whose networks torch fits where they learn."""
LEARNERS = ("virtual_goal", "fitted_planner", "ridge", "mlp", *TRAINED)
LEARNED_BY: Final[Mapping[str, tuple[str, ...]]] = {"mlp": ("torch",), SEARCHED: ("cma",)}
"""Optional libraries by which a controller learns that is no training."""
EACH: Final = "each"
"""As `train_level`: the controller learns on each evaluation level separately."""


@final
class Entry(Section):
    """One line of the benchmark."""

    label: FileName
    controller: str = Field(
        description="A controller's name or MODULE:CLASS, or an algorithm of agents.train; of a line also a scorer's "
        ".npz file or the path of a run folder, from the working folder or from where what ships lies."
    )
    throws: tuple[Count, ...] = Field(
        (0,),
        min_length=1,
        description="Practice or training before the evaluation, of a line in decisions; training is rounded up to "
        "whole batches, the search for an index, which is what practice is to one, to whole generations.",
    )
    seeds: tuple[Count, ...] | None = Field(None, description="Of the learning; default: the plan's.")
    levels: tuple[str, ...] | None = Field(None, description="To be evaluated on; default: the plan's.")
    train_level: str | None = Field(None, description="To learn on; default: the plan's.")
    shifts: Several | None = Field(
        None, description="Of a line: work shifts, the first so many of the plan's; for controllers that are slow."
    )
    config: str | None = Field(
        None, description="Of an algorithm: file of its hyperparameters; default: configs/rl/ALGO.yml, which ships."
    )
    options: Mapping[str, Any] = Field({}, description="Settings of the controller.")
    action_mode: str | None = Field(None, description="Meaning of its actions; default: the environment's.")
    practice_envs: Several | None = Field(
        None, description="Cells that practise side by side, of a controller that is no algorithm; default: the plan's."
    )
    also: tuple[str, ...] = Field((), description="Controllers that take over what it learned, evaluated beside it.")
    online: bool = Field(False, description="It goes on learning in the evaluation, every cell for itself.")
    stack: int = Field(1, description="Of an algorithm: observations that its policy sees at once.")
    over: str = Field(PLANNER, description="Of an algorithm: the controller to whose action its policy's is added.")
    fidelity: Literal["full", "flight"] = Field(
        "full", description="Of an algorithm: what is simulated to learn from; it is judged in the level's own."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        with about(f"entry {self.label!r}"):
            check_once({name: getattr(self, name) or () for name in ("throws", "seeds", "levels", "also")})
        if self.controller in TRAINED and (self.also or self.online or self.practice_envs):
            raise ValueError(
                f"entry {self.label!r}: `also`, `online` and `practice_envs` cannot be used with {', '.join(TRAINED)}"
            )
        for name in self.also:
            if name not in NAMES:
                raise ValueError(f"entry {self.label!r}: also: {unknown_name('controller', name, NAMES)}")
        if module_of(self.controller) is None and not is_learned(self.controller):
            self._check_name()
        return self

    def _check_name(self) -> None:
        if self.controller not in (*NAMES, *DECIDING, *TRAINED):
            known = dict.fromkeys((*NAMES, *RESIDUAL, *DECIDING, *MASKED))
            further = ", MODULE:CLASS, of a line a scorer's .npz file, and a run folder"
            raise ValueError(unknown_name("controller", self.controller, known, further))
        if self.config is not None and self.controller not in TRAINED:
            raise ValueError(f"entry {self.label!r}: `config` can be used only with {', '.join(TRAINED)}")
        if self.controller not in RESIDUAL and (self.stack, self.over, self.fidelity) != (1, PLANNER, "full"):
            raise ValueError(
                f"entry {self.label!r}: `stack`, `over` and `fidelity` can be used only with {', '.join(RESIDUAL)}"
            )
        with about(f"entry {self.label!r}: over"):
            check_known("controller that needs no practice", [self.over], BASES)
        if not 1 <= self.stack <= MAX_STACK:
            raise ValueError(f"entry {self.label!r} has stack {self.stack}; it must be 1 to {MAX_STACK}")
        if self.controller in (*PRETRAINED, SEARCHED) or self.online:
            return
        if (self.controller in LEARNERS) != all(t > 0 for t in self.throws):
            valid = "a controller that learns needs numbers above 0"
            valid = valid if self.controller in LEARNERS else "a controller that does not learn needs none"
            raise ValueError(f"entry {self.label!r} of {self.controller!r} has throws {self.throws}; {valid}")


def is_learned(name: str) -> bool:
    """Whether an entry's controller name is a file of a trained policy: a scorer's file or the path of a run folder."""
    return is_shipped(name) or (module_of(name) is None and (name.endswith(".npz") or "/" in name))


def labels(entry: Entry) -> list[str]:
    """Labels of an entry's results: the entry's label, then those of the controllers in `also`."""
    followers = [name if entry.label == entry.controller else f"{name}_{entry.label}" for name in entry.also]
    return [entry.label, *followers]


def settings_of(entry: Entry, env_id: str) -> dict[str, Any]:
    """Hyperparameters of an entry that trains.

    Raises:
        UsageError: the file is missing or damaged, or has no hyperparameters for the environment.
    """
    file = None if entry.config is None else Path(entry.config)
    return {**hyperparameters(entry.controller, env_id, file), **entry.options}


@final
class Choice(Section):
    """One result of the benchmark: a label, and the number of throws that the controller learned from."""

    label: str
    throws: Count = 0
