"""A filter that knows the physics: a posterior over the numbers of a cell, updated at each landing that was seen.

The numbers are those in which cells differ (`HiddenCell`) and that act on a flight, and an offset of the belt's camera.
Their priors are normal, with means of the ranges of a level and wider deviations. The lip's stiffness acts through the
phase of a swing, which repeats, so a few stiffnesses are hypotheses beside each other: each has an extended Kalman
filter of all other numbers, linear about its estimate, and a weight by how well it predicted the landings (Alspach and
Sorenson 1972, Gaussian sums). Predictions are flights of the model of `agents.fit`, from what an observation says.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records, join_columns, take
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.conveyor.config import LIP_GAP, ConveyorConfig
from pnt_gym.cells.conveyor.context import HiddenCell, HiddenDrift
from pnt_gym.cells.conveyor.observation import SHIFT_TABLE
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.planning.straight.plan import ReleaseBatch

from ..fit.log import ThrowLog
from ..fit.model import PLANNERS, ThrowModel
from ..ground.cli import UsageError
from .adaptive import begins_shift
from .filters import Filters, landing_offset
from .protocol import Actions, Controller, Observation, aimed_offsets, to_action

NUMBERS: Final = ("valve", "tau", "blow_off", "drag", "camera", "encoder")
"""Numbers of a cell that are estimated, beside the lip's stiffness; by their names in the section `cells`."""
LEAST: Final = np.array([0.0, 0.001, 0.0, 0.1, -0.1, -0.1])
"""Smallest values of these numbers in a flight, because a normal posterior knows no bounds."""
FLOWN: Final = 4
"""Numbers of `NUMBERS` whose effects are flown; the others act through the place of the grasp."""
PLACE: Final = 0.008
"""Standard deviation of the belt camera's offset along and across the belt, as on level `day` [m]."""
WIDER: Final = 1.5
"""Factor of the widths of the ranges: a cell may lie outside of them; on level `cells` a wider prior costs 0.2 mm."""
LIPS: Final = 3
"""Stiffnesses of the lip that are hypotheses."""
SCATTER: Final = (0.012, 0.004)
"""Standard deviations of landings along and across about those that the model predicts in a known cell: what seals,
masses, drag and jitter scatter beyond their gauges; measured on level `cells` [m]."""
TURNING: Final = 0.02
"""Share of the weights that is given to all hypotheses alike at each landing, as no model is quite true."""
ITERATIONS: Final = 2
"""Predictions of a landing in an update: in cells far from the prior, the prior's mean has other slopes."""
STEP, GRASP_STEP = 0.3, 0.005
"""Steps of the differences, in standard scores of a number, and of the place of the grasp [m]."""
TIMESTEP: Final = 0.001
"""Physics step of the level that the model doubles [s]."""


@final
class Posterior(Controller):
    """Knows the physics: estimates the cell's numbers from the shift's landings, and previews each throw with them.

    The controller needs no practice. It reads the catalogue and the planner of the level, and nothing hidden.

    Args:
        config: the cell, of which measured values and plans are used.
        correction: meaning of an action.
        prior: level whose section `cells` has the ranges of the numbers.

    Raises:
        UsageError: the level's planner throws otherwise, or a range of the prior is missing.
    """

    name = "posterior"

    def __init__(self, config: ConveyorConfig, correction: Correction, prior: str = "cells") -> None:
        if config.planner not in PLANNERS:
            raise UsageError(
                f"planner is {config.planner!r}; controller {self.name!r} knows the throws of "
                f"{' and '.join(PLANNERS)} alone"
            )
        if config.grip.safety is not None:
            raise UsageError(
                f"controller {self.name!r} knows throws that no grip slows; set grip.safety of the level to null"
            )
        ranges = ConveyorConfig.load(prior).cells.ranges
        if missing := {*NUMBERS, "stiffness"} - ranges.keys():
            raise UsageError(f"prior is {prior!r}, whose section `cells` has no range of {sorted(missing)[0]}")
        self._config = config.model_copy(update={"timestep": TIMESTEP, "fidelity": "flight"})
        self._planner, self._correction = PickPlanner(self._config), correction
        low, high = np.array([ranges[name] for name in NUMBERS]).T
        self._mean, self._sd = (low + high) / 2.0, WIDER * (high - low) / np.sqrt(12.0)
        softest, stiffest = np.log(ranges["stiffness"])
        place = WIDER * ((np.arange(LIPS) + 0.5) / LIPS - 0.5)
        self._stiffness: Floats = np.exp((softest + stiffest) / 2.0 + place * (stiffest - softest))
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget the shift."""
        self._last: ThrowModel | None = None
        self._filters = self._new_filters(0)

    def _new_filters(self, count: int) -> Filters:
        """Filters of standard scores in N rows: of `NUMBERS`, and of the camera's offset along and across the belt."""
        size = len(NUMBERS) + 2
        priors = np.tile(np.eye(size), (LIPS, 1, 1))
        beliefs = (1.0 / LIPS,) * LIPS
        noise = np.diag(np.square(SCATTER) + self._config.feedback.noise**2)
        return Filters((count,), priors, beliefs, turning=TURNING, noise=noise)

    def act(self, observation: Observation) -> Actions:
        """Actions (N, 2) whose predicted landings, averaged over the posterior's hypotheses, are the targets."""
        is_first, values = begins_shift(observation), SHIFT_TABLE.decode(observation.features)
        count = len(is_first)
        if self._last is None or len(self._last.log) != count:
            self._filters, is_first = self._new_filters(count), np.full(count, True)
        if self._last is not None and not is_first.all():
            self._learn(self._last, values, (values["last_seen"] > 0.5) & ~is_first)
        self._filters.begin(np.flatnonzero(is_first))
        model = ThrowModel(self._log(values, observation.kind), self._config, draws=0)
        self._last = model

        def errors(offset: Floats) -> Floats:
            """Errors (N, 2) [m] of throws with offsets (N, 2) [m], averaged over the hypotheses."""
            model.aim(offset)
            error = self._errors(model, self._filters.state, np.arange(count))
            return (self._filters.belief[..., None] * error).sum(axis=1)

        return to_action(aimed_offsets(errors, count, self._correction), self._correction)

    def _learn(self, model: ThrowModel, values: dict[str, Floats], seen: Bools) -> None:
        """Update the filters of the rows whose landing was seen."""
        rows = np.flatnonzero(seen)
        if rows.size == 0:
            return
        model.aim(np.stack([values["last_shift_along"], values["last_shift_across"]], axis=1))
        error = np.stack([values["last_along"], values["last_across"]], axis=1)[rows, None]

        def linear(scores: Floats) -> tuple[Floats, Floats]:
            """Slopes at scores, and the landings in a linear model with these slopes."""
            predicted, effect = self._slopes(model, scores, rows)
            return effect, error - predicted + landing_offset(effect, scores)

        effect, z = linear(self._filters.state[rows])
        for _ in range(ITERATIONS - 1):
            effect, z = linear(self._filters.updated(rows, effect, z)[0])
        self._filters.learn(rows, effect, z)

    def _slopes(self, model: ThrowModel, scores: Floats, rows: Ints) -> tuple[Floats, Floats]:
        """Predicted errors of throws (M, H, 2) [m] at scores (M, H, S), and their slopes by the scores (M, H, 2, S)."""
        size, flights = scores.shape[-1], 1 + FLOWN + 2
        varied = np.repeat(scores[:, :, None], flights, axis=2)
        place = np.zeros((flights, 2))
        for index in range(FLOWN):
            varied[:, :, 1 + index, index] += STEP
        place[1 + FLOWN :] = GRASP_STEP * np.eye(2)
        error = self._errors(model, varied, rows, place)
        change = (error[:, :, 1:] - error[:, :, :1]).swapaxes(-1, -2)
        slopes = np.zeros((*error.shape[:2], 2, size))
        slopes[..., :FLOWN] = change[..., :FLOWN] / STEP
        by_place = change[..., FLOWN:] / GRASP_STEP
        # Camera and encoder move the object along or across the belt, by the distance from where they are exact.
        pick, belt = model.log.pick[rows], self._config.belt
        across, along = pick[:, 1] - sum(belt.lane_y) / 2.0, pick[:, 0] - belt.camera_x
        slopes[..., FLOWN] = by_place[..., 1] * (self._sd[FLOWN] * across)[:, None, None]
        slopes[..., FLOWN + 1] = by_place[..., 0] * (self._sd[FLOWN + 1] * along)[:, None, None]
        slopes[..., FLOWN + 2 :] = by_place * PLACE
        return error[:, :, 0], slopes

    def _errors(self, model: ThrowModel, scores: Floats, rows: Ints, place: Floats | float = 0.0) -> Floats:
        """Predicted errors (M, H, ..., 2) [m] along and left of throws `rows` (M,) at scores (M, H, ..., S).

        `place` (..., 2) [m] is added to the offset of the camera.
        """
        shape = scores.shape[:-1]
        numbers = np.maximum(self._mean + self._sd * scores[..., : len(NUMBERS)], LEAST).reshape(-1, len(NUMBERS))
        camera = (PLACE * scores[..., len(NUMBERS) :] + place).reshape(-1, 2)
        fields = dict(zip(NUMBERS, numbers.T, strict=True))
        lip = np.broadcast_to(self._stiffness.reshape(-1, *(1,) * (len(shape) - 2)), shape).ravel()
        cells = HiddenCell.of(len(numbers), **fields, stiffness=lip, restitution=1.0)
        drift = HiddenDrift.of(len(numbers), camera=camera, encoder=fields["encoder"], scale=fields["camera"])
        row = np.repeat(rows, len(numbers) // len(rows))
        error = model.log.errors(model.landings_in(cells, drift, row), row)
        return np.nan_to_num(error).reshape(*shape, 2)

    def _log(self, values: dict[str, Floats], kind: Ints) -> ThrowLog:
        """What observations say of N coming throws as the planner would throw them; their results are open."""
        config, count = self._config, len(kind)
        pick = join_columns(values["pick_x"], values["pick_y"], config.belt.height + values["height"] + LIP_GAP)
        target = join_columns(values["target_x"], values["target_y"], config.bins.rim)
        heading = np.arctan2(*(target - pick).T[1::-1])
        cosine, sine = np.cos(heading), np.sin(heading)
        grasp = values["grasp_along"] * np.stack([cosine, sine]) + values["grasp_across"] * np.stack([-sine, cosine])
        plan, percent = self._nominal(values, pick, target)
        return ThrowLog(
            kind=kind, pick=pick, release=plan.position, velocity=plan.velocity, percent=percent,
            belt_speed=values["belt_speed"], target=target[:, :2],
            size=np.stack([values[name] for name in ("length", "width", "height")], axis=1),
            mass=np.exp(values["ln_mass"]), seal=np.exp(values["ln_seal"]), grasp=grasp.T,
            yaw=0.5 * np.arctan2(values["sin_2yaw"], values["cos_2yaw"]) + heading,
            sealed=np.ones(count), lost=np.zeros(count), landing=np.full((count, 2), np.nan),
        )  # fmt: skip

    def _nominal(self, values: dict[str, Floats], pick: Floats, target: Floats) -> tuple[ReleaseBatch, Floats]:
        """The planner's releases of N throws, and their speed settings: those whose plans are as observed."""
        ceiling, settings = pick[:, 2] + self._config.motion.ceiling, np.array(self._config.limits.percent)
        limits = [self._config.robot.limits(np.full(len(pick), setting)) for setting in settings]
        plans = [self._planner.mover.plan(pick, target, rows, ceiling) for rows in limits]
        misses = [np.hypot(p.speed - values["release_speed"], p.distance - values["release_distance"]) for p in plans]
        best = np.argmin(np.nan_to_num(misses, nan=np.inf), axis=0)
        return take(concatenate_records(plans), best * len(pick) + np.arange(len(pick))), settings[best]
