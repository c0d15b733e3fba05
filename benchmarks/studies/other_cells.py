"""What a cell that nobody measured costs, and how much of what practice in that very cell is worth adapting wins."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Any, Final, final

import numpy as np

from agents.controllers import load_state, make_controller
from agents.controllers.adaptive import without_feedback
from agents.controllers.protocol import Actions, Controller, Learner, Observation, SeparateControllers
from agents.ground.cli import UsageError
from agents.ground.environments import Env, core_of, make_vector, stream_seed
from agents.ground.places import at
from agents.judging.loop import practise, throw_held_out
from agents.judging.throws import Throws
from agents.results.study import Amount, Figures, Settings
from pnt_gym.arrays import Floats
from pnt_gym.cells.base.core import Core

ADAPTING: Final = "PnTAdapt-v0"
"""Environment in which all controllers are judged; in every shift the cell is another one."""
PRACTISING: Final = "PnTRelease-v0"
"""Environment of practice: without the landings of a camera, which tell a learner nothing in a cell that stays."""
ROWS: Final = 16
"""Cells side by side in practice."""


def shifts(settings: Settings, amount: Amount) -> Iterator[Figures]:
    """What controllers sort in the same shifts of drawn cells, from several throws of the shift on.

    Of each cell a row has the objects sorted, the seconds, the sum of the landing errors [m] and the number of
    landings; beside them the sorted objects and seconds of the `least` and the `most` controller in the same shifts.

    Args:
        settings: `level`, with a section `cells`; `block`, which tells apart draws of cells; `controllers` by label,
            each with the name of a `controller` and perhaps a file to `load`; `practised`, the names of learners by
            label, and their `practice` in throws; `least` and `most`, the labels between which shares are counted;
            `windows`, the throws of a shift that are over before the counting begins.
        amount: shifts, each in a cell of its own.
    """
    seed = stream_seed("evaluate", amount.seed, settings["block"])
    with closing(make_vector(ADAPTING, settings["level"], amount.throws, 1)) as env:
        core = core_of(env)
        controllers: dict[str, Controller] = {
            label: _controller(entry, env) for label, entry in settings["controllers"].items()
        }
        env.reset(seed=stream_seed("evaluate", seed))  # the cells that `throw_held_out` draws
        cells = drawn_cells(core)
        for label, name in settings["practised"].items():
            controllers[label] = Practised(settings["level"], name, cells, settings["practice"], amount.seed)
        judged = {
            label: _by_cell(throw_held_out(controller, env, amount.throws * core.cell.episode, seed), core)
            for label, controller in controllers.items()
        }
    for label, counted in judged.items():
        for window in settings["windows"]:
            cells_from, least, most = (
                part[window:].sum(axis=0) for part in (counted, judged[settings["least"]], judged[settings["most"]])
            )
            yield {
                "controller": label,
                "window": window,
                "cells": _numbers(cells_from),
                "least": _numbers(least[:, :2]),
                "most": _numbers(most[:, :2]),
            }


def _numbers(counted: Floats) -> list[list[float]]:
    """Numbers of cells for a file: four decimals, and none where a number is whole."""
    rows = np.round(counted, 4).tolist()
    return [[int(value) if value.is_integer() else value for value in row] for row in rows]


def _controller(entry: Settings, env: Env) -> Controller:
    """Controller of a plan, with its learned state where the plan names a file.

    Raises:
        UsageError: a file is given for a controller that learns nothing.
    """
    controller = make_controller(entry["controller"], env)
    if "load" in entry:
        if not isinstance(controller, Learner):
            raise UsageError(f"controller {controller.name!r} learns nothing that could be loaded")
        load_state(controller, at(entry["load"]))
    return controller


def drawn_cells(core: Core) -> list[dict[str, list[float]]]:
    """The section `cells` that fixes the numbers of each of the present cells."""
    cell, names = core.context.cell, core.config.cells.ranges
    values = {name: getattr(cell, name) for name in names}
    return [{name: [float(values[name][row])] * 2 for name in names} for row in range(core.count)]


@final
class Practised(Controller):
    """Learners that each practised in the cell of its row, with flights; they see nothing of the previous landing.

    Args:
        level: level of the cells.
        name: controller.
        cells: section `cells` of each row; cells that are alike are practised once.
        throws: throws of practice in each cell.
        seed: seed of the practice.
    """

    def __init__(self, level: Settings, name: str, cells: list[dict[str, list[float]]], throws: int, seed: int) -> None:
        self.name = name
        learners: dict[str, Controller] = {}
        for cell in cells:
            if str(cell) not in learners:
                learners[str(cell)] = _practised({**level, "fidelity": "flight", "cells": cell}, name, throws, seed)
        self._rows = SeparateControllers([learners[str(cell)] for cell in cells])

    def act(self, observation: Observation) -> Actions:
        """Action of each row's learner (N, A)."""
        return self._rows.act(without_feedback(observation))


def _practised(level: dict[str, Any], name: str, throws: int, seed: int) -> Controller:
    """A learner after practice in one cell."""
    with closing(make_vector(PRACTISING, level, ROWS, 1)) as env:
        controller = make_controller(name, env)
        controller.reset(seed)
        practise(controller, env, throws, seed)
    return controller


def _by_cell(throws: Throws, core: Core) -> Floats:
    """Whether sorted, seconds, landing error [m] or 0, whether that was measured, by throw and cell (T, C, 4)."""
    landed = np.isfinite(throws.landing_error)
    columns = throws.sorted, throws.cycle_time, np.nan_to_num(throws.landing_error), landed
    return np.stack([np.asarray(column, dtype=np.float64).reshape(-1, core.count) for column in columns], axis=2)
