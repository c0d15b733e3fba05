"""The batched simulation behind the environments that grasp: a step is a grasp, or a throw."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, put_rows, replace_rows, take, take_rows
from pnt_gym.cells.base.action import clip_actions
from pnt_gym.cells.base.cell import Generators
from pnt_gym.cells.base.core import Core, Step
from pnt_gym.cells.base.request import NO_REQUEST, Request
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.hold import picked
from pnt_gym.cells.conveyor.objects.kernel import inside_outline
from pnt_gym.cells.grasp.action import MODE, NUMBERS, Wishes
from pnt_gym.cells.grasp.attempts import Attempts, Grasper, LastTry, tries_left
from pnt_gym.cells.grasp.config import CHANNELS, PIXELS, GraspConfig
from pnt_gym.cells.grasp.groups import GroupPicks
from pnt_gym.cells.grasp.images import PictureMaker
from pnt_gym.cells.grasp.observation import LAST, GraspSight, Recall, encode, space_of
from pnt_gym.cells.grasp.shifts import ShiftPicks

Observation = dict[str, NDArray[Any]]


@final
class GraspCore:
    """N cells; row i is environment i.

    The cells behind this core are those of the conveyor. A step in which a row's cup grasps and holds does not throw:
    the conveyor's core restores the row. In all other steps the row's pick ends by a throw, or without an object.

    Args:
        config: the level.
        count: number of cells N.
        threads: threads of the physics; results do not depend on their number.
    """

    action_mode = MODE
    shift_modes: tuple[str, ...] = ()

    def __init__(self, config: GraspConfig, count: int, threads: int = 1) -> None:
        self.config, self.count = config, count
        source = GroupPicks if config.grasp.objects > 1 else ShiftPicks if config.remembers else None
        self.cell = ConveyorCell(config, count, config.grasp.picks, threads, config.remembers, source)
        self.item_names, self.dwell, self.terminates = self.cell.item_names, self.cell.dwell, self.cell.terminates
        self.observation_space = space_of(config)
        numbers = len(NUMBERS) - (config.grasp.stages == 1)
        self.action_space = Box(-1.0, 1.0, (numbers,), np.float32)
        self.action_sizes: Mapping[str, int] = {MODE: numbers}
        self.throws = Core(self.cell, "release_point")
        """The core that throws, with the conveyor's actions."""
        self.correction = self.throws.correction
        """How the last two numbers of an action move the landing."""
        self.grasper = Grasper(config, self.cell.planner)
        """Grasps objects, and plans their throws."""
        self.pictures = PictureMaker(config, self.grasper.surfaces)
        """Draws the pictures; a benchmark replaces it by one that draws nothing."""
        self.picks: Context = self.cell.context
        """The coming picks with cups in the middles of the objects' outlines (N,), of groups the objects tried last."""
        self.attempts = Attempts.none(count)
        self._last = LastTry.of(count)
        self._images = np.empty((count, CHANNELS, PIXELS, PIXELS), np.uint8)
        self._begin(np.arange(count))

    @property
    def context(self) -> Context:
        """The coming picks (N,): with the cups in the pictures' middles, or that hold their objects."""
        return self.cell.context

    def reset(self, rows: Ints, generators: Generators, seeded: Bools | bool, request: Request = NO_REQUEST) -> None:
        """Begin new episodes in some rows, see `Core.reset`."""
        # Rows that keep a first throw have had its picture since the step that drew the throw.
        self._begin(self.throws.reset(rows, generators, seeded, request))
        self._last.put(rows, LastTry.of(len(rows)))

    def observe(self) -> Observation:
        """Pictures and vectors of the coming steps (N, ...)."""
        sight = GraspSight(self.cell.context, self.attempts, self.tries_left())
        last = {"last": LAST.encode(Recall(self.cell.context, self._last))} if self.config.remembers else {}
        return {"image": self._images.copy(), "vector": encode(sight), **last}

    def kinds(self) -> dict[str, NDArray[Any]]:
        """`kind`: item that the classifier sees in each object, index into `item_names` (N,).

        Kinds that are drawn are new to every classifier: it sees 0 in all of them.
        """
        kinds = self.throws.kinds()
        return {name: np.zeros_like(kind) for name, kind in kinds.items()} if self.config.drawn.kinds else kinds

    def hidden(self) -> dict[str, Floats]:
        """Values of the coming picks that no observation has, by name, (N,) each."""
        return self.throws.hidden()

    def step(self, actions: object, waiting: Bools | None = None) -> Step:
        """Grasp in the cells whose cups are free, and throw in the others.

        Args:
            actions: (N, A) within [-1, 1]; values outside are clipped.
            waiting: which cells only fill the batch (N,): the step leaves these cells unchanged, and their results mean
                nothing; None: no cell.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        wishes = Wishes.of(clip_actions(actions, self.count, self.action_space.shape[0], MODE), self.config)
        active = np.ones(self.count, dtype=np.bool_) if waiting is None else ~waiting
        ends, grasps, info = self._advance(wishes, active)
        attempts, thrown = self.attempts, ends & self.attempts.holds & ~wishes.rides
        if ends.any():
            result = self._throw(wishes, ends)
        else:
            zeros = np.zeros(self.count)
            result = Step(None, zeros, zeros > 0.0, {})
        self._last.put(np.flatnonzero(active), take(LastTry.after(grasps, attempts, thrown, result.info), active))
        self._begin(np.flatnonzero(ends))
        partial = {name: ends & result.partial.get(name, True) for name in result.info if name != "kind"}
        info |= {**result.info, **self.kinds()}
        return Step(self.observe(), np.where(ends, result.reward, 0.0), result.ended & ends, info, partial)

    def _advance(self, wishes: Wishes, active: Bools) -> tuple[Bools, Bools, dict[str, NDArray[Any]]]:
        """Grasp where actions ask for it; returns which picks end in this step (N,), which tried, and the info."""
        before, rules = self.attempts, self.config.grasp
        gives_up = wishes.rides & ((before.tries > 0) | (rules.skip and rules.stages > 1))
        grasps = active & ~gives_up & (~before.holds | (wishes.again & (self.tries_left() > 0)))
        self._grasp(np.flatnonzero(grasps), wishes.place)
        attempts = self.attempts
        # A pick ends without a grasp, or with a grasp that fails and leaves no try, or at once where a level has one
        # stage.
        ends = active & ~grasps | grasps & (~attempts.holds & (self.tries_left() <= 0) | (rules.stages == 1))
        info: dict[str, NDArray[Any]] = {
            "held": attempts.holds.copy(),
            "tries": attempts.tries.copy(),
            "place": attempts.place.copy(),
            "vacuum": attempts.vacuum.copy(),
            "leak": attempts.leak.copy(),
        }
        return ends, grasps, info

    def _grasp(self, rows: Ints, place: Floats) -> None:
        """Try to grasp the objects of some rows at places (N, 2) [m]."""
        if rows.size == 0:
            return
        again = rows[self.attempts.tries[rows] > 0]
        if again.size > 0:
            self.picks = self.picks_when_tried(again)
            self.cell.ride(again, self.config.grasp.retry)
        source, picks, asked = self.cell.source, take_rows(self.picks, rows, self.count), place[rows]
        if isinstance(source, GroupPicks):
            # A cup grasps the object in whose outline it lies deepest, or to whose outline it is nearest.
            groups = take(source.groups, rows)
            offset = groups.pick[..., :2] - groups.pick[:, :1, :2]
            members = range(offset.shape[1])
            inside = [inside_outline(take(groups.objects.rows, np.s_[:, k]), asked - offset[:, k]) for k in members]
            chosen = np.argmax(inside, axis=0)
            asked = asked - offset[np.arange(len(rows)), chosen]
            picks = self._ridden(take(source.groups, (rows, chosen)), picks.spent)
        before = take_rows(self.attempts, rows, self.count)
        self.picks = put_rows(self.picks, rows, picks, self.count)
        grasped, at, leak = self.grasper.grasp(picks, asked, before.tries)
        held = picked(grasped, self.config)
        after = before.then(held, at, place[rows] + (at - asked), grasped.objects.measured.seal, leak)
        self.attempts = put_rows(self.attempts, rows, after, self.count)
        over = np.flatnonzero(held | (self.tries_left()[rows] <= 0))
        coming = put_rows(picks, over, take_rows(grasped, over, len(rows)), len(rows))
        self.cell.context = put_rows(self.cell.context, rows, coming, self.count)

    def picks_when_tried(self, rows: Ints) -> Context:
        """The picks (N,) when the cups of some rows try: the belts of rows that try again move on, with their hands."""
        again = rows[self.attempts.tries[rows] > 0]
        if again.size == 0:
            return self.picks
        time = np.full(len(again), self.config.grasp.retry)
        return replace_rows(self.picks, again, self._ridden(take(self.picks, again), time))

    def _ridden(self, picks: Context, time: Floats) -> Context:
        """Picks that have ridden on with the belt for further times (K,) [s], which count as spent on tries.

        An object that would ride out of reach of its bin stays where it can be thrown from.
        """
        waited, pick = picks.replace(spent=picks.spent + time), picks.pick.copy()
        pick[:, 0] += self.config.belt.speed * time
        limits = self.config.robot.limits(picks.objects.percent)
        ridden = self.cell.planner.plan_at(waited, pick, limits.acceleration)
        stays = np.flatnonzero(~ridden.plan.feasible)
        return put_rows(ridden, stays, take(waited, stays), len(time))

    def tries_left(self) -> Ints:
        """Numbers of tries that are left (N,): of the level, and until the object leaves the window."""
        return tries_left(self.config, self.attempts.tries, self.picks)

    def _throw(self, wishes: Wishes, ends: Bools) -> Step:
        """End the picks of some rows (N,): objects that hang are thrown, but those that are to ride on."""
        rows, kept, waiting = np.flatnonzero(ends), self.cell.context, np.flatnonzero(~ends)
        throws, slowed = self.grasper.with_pace(take_rows(kept, rows, self.count), wishes.pace[rows])
        carries = ends & self.attempts.holds & ~wishes.rides
        context = put_rows(kept, rows, throws, self.count)
        # Hands that carry nothing get a draw with which no cup seals.
        hangs = np.where(carries, context.objects.pick_draw, -1.0)
        context = context.replace(objects=context.objects.replace(pick_draw=hangs))
        skipped = ends & (self.attempts.tries == 0)
        if skipped.any():  # the hand goes on without the dwell of a try
            context = context.replace(spent=context.spent - np.where(skipped, self.dwell, 0.0))
        self.cell.context = context
        pace = self.cell.context.throw_limits.acceleration / self.config.robot.acceleration
        if waiting.size == 0:
            result = self.throws.step(wishes.residual)
        else:
            with self.cell.hold_back(~ends):
                result = self.throws.step(wishes.residual, ~ends)
            self.cell.context = replace_rows(self.cell.context, waiting, take(kept, waiting))
        clipped = result.info["residual_clipped"].copy()
        clipped[rows] |= slowed
        return replace(result, info={**result.info, "residual_clipped": clipped, "pace": pace})

    def _begin(self, rows: Ints) -> None:
        """Begin the coming picks of some rows: no try yet, and a picture."""
        if rows.size == 0:
            return
        picks = take_rows(self.cell.context, rows, self.count)
        self.picks = put_rows(self.picks, rows, picks, self.count)
        self.attempts = put_rows(self.attempts, rows, Attempts.none(len(rows)), self.count)
        # The objects in sight (K, M), and their middles from the first's (K, M, 2) [m].
        objects, middles = take(self.picks.objects, rows[:, None]), np.zeros((len(rows), 1, 2))
        if isinstance(self.cell.source, GroupPicks):
            groups = take_rows(self.cell.source.groups, rows, self.count)
            objects, middles = groups.objects, groups.pick[..., :2] - groups.pick[:, :1, :2]
        self._images[rows] = self.pictures.draw(objects, middles)

    def view(self) -> ThrowView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return self.cell.view()
