"""The planner that knows what a log of its throws tells: it fits the cell's numbers, and releases by the fitted model.

A cell's numbers are those of `agents.fit`: the valve's delay, the vacuum's decay, the drag over the catalogue's, the
offsets of camera and encoder, and the lip's stiffness. The log is of the planner's own throws without exploration:
objects and bins differ enough. So a log costs nothing beside the work, and objects are sorted meanwhile.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, concatenate_records, take
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.errors import one_sentence

from ..fit.fitted import fit_log
from ..fit.log import ThrowLog
from ..fit.model import PLANNERS, ThrowModel
from ..fit.parameters import level_at, priors
from ..ground.cli import UsageError
from .protocol import Actions, Learner, Observation, Outcome, State, aimed_offsets, to_action

GUESS: Final[Mapping[str, float]] = {
    "valve": 0.008, "tau": 0.010, "blow_off": 0.0, "drag": 1.0, "camera_x": 0.0, "camera_y": 0.0,
    "encoder": 0.0, "stiffness": 1.0,
}  # fmt: skip
"""Numbers of a cell before its first throw, SI units: the middle of what valves (2 to 14 ms) and cups (5 to 20 ms; 0.3
to 3 N m/rad) have, the catalogue's drag, no offsets and no blown air. The level's own numbers, which are the truth of a
simulated cell, are not read."""
GROWTH: Final = 2
"""Growth of the log by which the fit is renewed, from the first landing on."""
MOST: Final = 120
"""Latest landings to which it fits; on `waste` more bring it no nearer to the targets."""
FARTHEST: Final = 10.0
"""Largest standard score of a number in a saved state."""


@final
class FittedPlanner(Learner):
    """Plans each throw with the cell's numbers, which it fits to the landings of its own throws.

    Before the first fit it plans with numbers of a data sheet. Each release is moved until the landing that the model
    of the fit predicts, at what the gauges read of the object, is the target. It knows the catalogue of the level, as
    the fit does.

    Args:
        core: the cells, of which the planner reads measured values and plans alone.
        correction: meaning of an action.

    Raises:
        UsageError: the cells throw with another planner, or nothing hidden acts on their throws.
    """

    name = "fitted_planner"

    def __init__(self, core: Core, correction: Correction) -> None:
        if not (isinstance(getattr(core, "cell", None), ConveyorCell) and core.config.planner in PLANNERS):
            raise UsageError(
                f"controller {self.name!r} knows a conveyor's throws by the planner {' or '.join(PLANNERS)} alone"
            )
        self._core, self._correction = core, correction
        known = {name: value for name, value in GUESS.items() if name != "stiffness" or core.config.swings}
        self._begin = level_at(core.config.model_copy(update={"fidelity": "flight"}), known)
        self._parameters = priors(self._begin)
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget log and fit; `seed` is not used."""
        self._logs: list[ThrowLog] = []
        self._landings = self._fitted_at = 0
        self._adopt({parameter.name: parameter.mean for parameter in self._parameters})

    def end_practice(self) -> None:
        """Fit to all throws."""
        if self._landings > self._fitted_at:
            self._fit()

    def act(self, observation: Observation) -> Actions:
        """Actions whose predicted landings are the targets (N, 2), in practice too.

        Raises:
            UsageError: the observation is not of all cells.
        """
        core, correction, count = self._core, self._correction, len(observation.kind)
        if count != core.count:
            raise UsageError(f"controller {self.name!r} plans the throws of all {core.count} cells at once")
        model = ThrowModel(ThrowLog.of(core.context, core.context.plan), self._level, draws=0)

        def errors(offset: Floats) -> Floats:
            """Errors (N, 2) [m] along and left of throws with offsets (N, 2) [m]; 0 of one that lands nowhere."""
            model.move(core.plan(to_action(offset, correction))[0])
            landing = model.quick_landings([self._level])[0]
            return np.nan_to_num(np.stack(core.context.to_throw_frame(landing - model.log.target), axis=1))

        action = to_action(aimed_offsets(errors, count, correction), correction)
        self._known = ThrowLog.of(core.context, core.plan(action)[0])
        return action

    def learn(self, outcome: Outcome) -> None:
        """Add the landings to the log; renew the fit when the log has grown."""
        known = take(self._known, slice(len(outcome.cycle_time)))
        rows = np.flatnonzero(np.hypot(*outcome.error.T) <= self._begin.feedback.view)  # an error may be NaN
        sure = np.ones(len(known))
        log = replace(known, landing=known.landings(outcome.error), sealed=sure, lost=0.0 * sure)
        self._logs.append(take(log, rows))
        self._landings += len(rows)
        if self._landings >= max(GROWTH * self._fitted_at, 1):
            self._fit()

    def state(self) -> State:
        """The cell's numbers by the names of the fit, SI units."""
        return {name: np.array(value) for name, value in self._values.items()}

    def restore(self, state: State) -> None:
        """Load a cell's numbers; the log behind them is not part of the state.

        Raises:
            UsageError: a number is missing, or no cell has it.
        """
        values: dict[str, float] = {}
        for parameter in self._parameters:
            name, ends = parameter.name, parameter.value(np.array([-FARTHEST, FARTHEST]))
            value = np.asarray(state.get(name, np.nan), dtype=np.float64)
            if value.shape != () or not ends[0] <= value <= ends[1]:
                raise UsageError(
                    f"the saved state of {self.name!r} has {name} {one_sentence(value, 40)}; it must be a number from "
                    f"{ends[0]:.3g} to {ends[1]:.3g}"
                )
            values[name] = float(value)
        self._adopt(values)

    def _fit(self) -> None:
        log = take(concatenate_records(self._logs), slice(-MOST, None))
        self._adopt(fit_log(log, self._begin, self._parameters).posterior.values)
        self._fitted_at = self._landings

    def _adopt(self, values: Mapping[str, float]) -> None:
        self._values, self._level = dict(values), level_at(self._begin, values)
