"""The planner of picks: chooses a bin for an object, plans the throw, and checks that corrections stay feasible."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from typing import Final, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records, in_order, join_columns, recompute_rows, take
from pnt_gym.cells.base.cell import Purpose, draw_aside
from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor import scene_kernel
from pnt_gym.cells.conveyor.config import LIP_GAP, ConveyorConfig
from pnt_gym.cells.conveyor.context import Context, ThrowBins, apply_bias, belt_shift
from pnt_gym.cells.conveyor.cup.hold import LEAST_ACCELERATION, measured_hold
from pnt_gym.cells.conveyor.movers.choosing import AutoMover
from pnt_gym.cells.conveyor.movers.free_mover import FlyingMover, FreeMover
from pnt_gym.cells.conveyor.movers.placing import EllipseMover, HorizontalMover, PlaceMover, is_at_rest
from pnt_gym.cells.conveyor.movers.straight import Mover, StraightMover
from pnt_gym.cells.conveyor.movers.tracking import TrackingMover
from pnt_gym.cells.conveyor.objects.drawing import NORMALS, UNIFORMS, ObjectMaker, SideDraws
from pnt_gym.cells.conveyor.objects.fill import draw_fill, fixed_areas, mean_volumes
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.objects.rows import Uniforms
from pnt_gym.cells.conveyor.sections import Throwable
from pnt_gym.cells.conveyor.throwable import is_throwable
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows
from pnt_gym.planning.straight.plan import ReleaseBatch

BESIDE: Final = 0.02
"""Distance from a bin at which a carried object counts as in its way: walls and what swings under the cup [m]."""
ABOVE: Final = 0.02
"""Least height of a carried object above the rim of a bin below it [m]."""
TRIAL_THROWS: Final = 50
"""Number of trial throws at a bin before a warning that the bin is out of reach."""
KindDraws: TypeAlias = Callable[[Ints, Floats], Floats]
"""From rows (K,) and uniform draws (K, C) to the draws by which the kinds of the rows' objects are chosen (K, C)."""
KIND_DRAW: Final = [*Uniforms.fields].index("kind")
"""Column of the uniform draws by which an object's kind is chosen; the first column, before any field of several."""
_MOVERS: dict[str, Callable[[ConveyorConfig, EllipticWorkspace], Mover]] = {
    "straight": StraightMover,
    "straight_flying": FlyingMover,
    "free_direction": FreeMover,
    "horizontal": HorizontalMover,
    "pick_and_place": PlaceMover,
    "ellipse": EllipseMover,
    "auto": AutoMover,
}


@final
class PickPlanner:
    """Chooses a bin for an object and plans its throw.

    A throw is accepted if it stays inside the workspace for its target and for the target moved by the mover's reserve
    along the throw. So every residual within that range has a feasible plan.
    """

    def __init__(self, config: ConveyorConfig) -> None:
        self.config = config
        self.workspace = config.robot.workspace
        self.mover: Mover = self._mover(config.planner)
        self._put_mover = self._mover("ellipse") if config.planner == "auto" else None
        fixed = config.bins.fixed
        self._centres = np.array([(b.x, b.y) for b in fixed]).reshape(-1, 2)
        self._openings = np.array([b.size for b in fixed]).reshape(-1, 2)
        self.areas = fixed_areas(config)
        """Areas of the fixed bins' openings (B,) [m2]."""
        self.accepts = config.acceptance()
        """Whether fixed bins (columns) accept items (rows)."""
        self._is_biased = config.bias.applies
        self._has_throw_rule = config.throwable != Throwable()
        self._table = item_arrays(config.item_list())
        self._maker = ObjectMaker(config, self._table)
        self._volumes = mean_volumes(config, self._table)
        spread, uniform, normal = config.spread, np.random.Generator.random, np.random.Generator.standard_normal
        side_effects = (
            (config.pick.fails, Purpose.PICK, "pick", uniform),
            (config.classifier.confusion, Purpose.CLASS, "seen", uniform),
            (config.bins.emptied, Purpose.FILL, "fill", uniform),
            (
                any((spread.restitution, spread.friction, spread.blow_off, spread.residue)),
                Purpose.SPREAD,
                "spread",
                normal,
            ),
            (config.robot.accuracy, Purpose.HAND, "hand", normal),
        )
        self._side_draws = [effect[1:] for effect in side_effects if effect[0]]
        """Purposes for which the level draws aside, fields of `SideDraws` for these draws, and how they are drawn."""

    def draw(
        self, generators: list[np.random.Generator], rows: Ints, count: int, kinds: KindDraws | None = None
    ) -> Objects:
        """Draw `count` new objects from the generators of some rows, shape (len(rows), count).

        Args:
            generators: the generators of all rows.
            rows: the rows (K,).
            count: objects of each row C.
            kinds: changes the draws of the objects' kinds; None for kinds as in the level.
        """
        normals, uniforms = np.empty((len(rows), count, NORMALS)), np.empty((len(rows), count, UNIFORMS))
        side_draws = SideDraws.none(self.config, len(rows), count)
        for place, row in enumerate(rows):
            generator = generators[int(row)]
            fills = [
                (purpose, partial(draw, out=getattr(side_draws, column)[place]))
                for purpose, column, draw in self._side_draws
            ]
            draw_aside(generator, *fills)
            generator.standard_normal(out=normals[place])
            generator.random(out=uniforms[place])
        if kinds is not None:
            uniforms[..., KIND_DRAW] = kinds(rows, uniforms[..., KIND_DRAW])
        return self._maker.make(normals, uniforms, side_draws)

    def draw_picks(
        self, generators: list[np.random.Generator], rows: Ints, kinds: KindDraws | None = None
    ) -> tuple[Objects, Floats]:
        """Draw an object from the generator of each row, and its pick point anywhere in the window (N, 3) [m]."""
        objects = take(self.draw(generators, rows, 1, kinds), np.s_[:, 0])
        low, high = self.config.lift_x
        return objects, self.pick_point(objects, low + (high - low) * objects.draws.place[:, 0])

    def pick_point(self, objects: Objects, x: Floats) -> Floats:
        """The planner's points (N, 3) [m] of objects at belt coordinate x (N,) [m].

        The point is the cup tip on the object, lowered by the known depth of the centre of mass.
        """
        height = self.height(objects.size, objects.known_depth)
        return join_columns(x, objects.draws.lane_y, height)

    def height(self, size: Floats, depth: Floats) -> Floats:
        """Heights of the planner's points at picks of objects, S [m].

        Args:
            size: extents of the objects, S + (3,) [m].
            depth: known depth of the centre of mass below the cup, S [m].
        """
        return self.config.belt.height + size[..., 2] + LIP_GAP - depth

    def mark_feasible(self, context: Context, release: ReleaseBatch) -> ReleaseBatch:
        """The releases, with `feasible` true only where the robot can execute them."""
        return release.replace(feasible=self.mover.is_feasible(context.pick, release, context.throw_limits))

    def clears_bins(self, context: Context, release: ReleaseBatch) -> Bools:
        """Which straight throws lead the object over the rims of all bins, until the hand has stopped (N,).

        A bin is taken as the circle around its opening, which errs on the safe side. The hand rises evenly on its way.
        """
        motion = self.mover.throw(context.pick, release, context.throw_limits, context.ceiling)
        centre, opening = context.target[:, None, :2], context.opening[:, None]
        if self.config.bins.random is None:
            centre, opening = self._centres[None], self._openings[None]
        rise, width = self.config.bins.rim - self.config.belt.height, context.objects.measured.size.max(axis=-1)
        way = motion.stop - context.pick
        length = np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)[:, None]
        gap = centre - context.pick[:, None, :2]
        # In top view: bins' middles along and beside the way, and where the way enters their circles.
        along = (gap * (way[:, :2] / length)[:, None]).sum(axis=-1)
        beside_squared = (gap**2).sum(axis=-1) - along**2
        radius = np.hypot(opening[..., 0], opening[..., 1]) / 2.0 + width[:, None] / 2.0 + BESIDE
        entry = np.maximum(along - np.sqrt(np.maximum(radius**2 - beside_squared, 0.0)), 0.0)
        meets = (beside_squared < radius**2) & (along > 0.0) & (entry < length)
        is_low = way[:, 2:] * entry / length < rise + ABOVE
        return ~(meets & is_low).any(axis=1)

    def plan(self, objects: Objects, pick: Floats) -> tuple[Context, Bools]:
        """Contexts for objects at their picks, and which throws are accepted (N,).

        Bins are tried in the order of the object's draws; rows without an accepted throw hold the last attempt.
        """
        draw, r = objects.draws.bin, self.config.bins.random
        if r is None:
            # Accepting fixed bins in turn, starting at a random one; they repeat.
            choices = self.accepts[objects.measured.kind]
            count = choices.sum(axis=1)
            start = np.minimum((draw[:, 0, 0] * count).astype(np.int64), count - 1)
            chosen_rank = (start[:, None] + np.arange(choices.shape[1], dtype=np.int64)) % count[:, None]
            rank = np.cumsum(choices, axis=1) - 1
            bins = self._fixed_bins(np.argmax(choices[:, None] & (rank[:, None] == chosen_rank[:, :, None]), axis=2))
        else:
            inputs = in_order(draw, objects.measured.size, np.array([r.x, r.y, r.side]))
            target, opening = scene_kernel.draw_bins(*inputs, r.item_clearance, self.config.bins.rim)
            bins = ThrowBins(target, opening, np.zeros(draw.shape[:-1], dtype=np.int64))
        return self._plan_throws(objects, pick, bins)

    def plan_into(self, objects: Objects, pick: Floats, bins: Ints) -> tuple[Context, Bools]:
        """Contexts as `plan`, for given fixed bins (N,)."""
        return self._plan_throws(objects, *in_order(pick), self._fixed_bins(bins[:, None]))

    def _plan_throws(self, objects: Objects, pick: Floats, bins: ThrowBins) -> tuple[Context, Bools]:
        """Contexts as `plan`, for bins in the order in which to try them."""
        ceiling = pick[:, 2] + self.config.motion.ceiling
        throw_limits, can_hold = self.grip_limits(objects, pick)
        choice = None
        if not self._has_throw_rule:
            choice = self.mover.choose_targets(pick, bins.target, throw_limits, ceiling, pick, can_hold)
        attempt = np.zeros(len(pick), dtype=np.int64) if choice is None else choice.attempt
        tried = take(bins, (np.arange(len(pick)), attempt))
        plan = self.mover.plan(pick, tried.target, throw_limits, ceiling) if choice is None else choice.plan
        context = Context.new(
            objects, pick, tried, self._depth(objects, tried.opening), throw_limits=throw_limits, plan=plan,
            ceiling=ceiling, belt=self.config.belt,
        )  # fmt: skip
        context = apply_bias(context, self.config) if self._is_biased else context
        return (context, choice.good) if choice else self._try_bins(context, bins, can_hold)

    def _try_bins(self, context: Context, bins: ThrowBins, can_hold: Bools) -> tuple[Context, Bools]:
        """Contexts as `plan`, from contexts with the first bins: one bin after the other, for all objects together."""
        first, accepted = self._accept(context)
        good = can_hold & accepted
        attempts, last, count = [first], np.arange(len(good)), len(good)
        for attempt in range(1, bins.bin.shape[1]):
            rows = (~good).nonzero()[0]
            if rows.size == 0:
                break
            again, others = take(first, rows), take(bins, (rows, attempt))
            plan = self.mover.plan(again.pick, others.target, again.throw_limits, again.ceiling)
            depth = self._depth(again.objects, others.opening)
            tried, accepted = self._accept(again.replace(**others._asdict(), depth=depth, plan=plan))
            good[rows] = accepted & can_hold[rows]
            attempts.append(tried)
            last[rows], count = np.arange(count, count + len(rows)), count + len(rows)
        return first if len(attempts) == 1 else take(concatenate_records(attempts), last), good

    def _accept(self, context: Context) -> tuple[Context, Bools]:
        """The picks, some of them with plans to put the object down, and which plans are accepted (N,)."""
        context, allowed = self._apply_throw_rule(context)
        # Displacements along the throws by which targets may move.
        reserve, shift = self.mover.reserve(context.plan), None
        if reserve.any():
            shift = np.zeros_like(context.target)
            shift[:, :2] = reserve[:, None] * context.direction
        return context, allowed & self.mover.accepts(context, shift)

    def replan(self, context: Context, goal: Floats, is_swapped: bool = False) -> ReleaseBatch:
        """New plans to goals (N, 3) [m], thrown or put down as the nominal plans, or the other way if `is_swapped`."""
        arguments = context.pick, goal, context.throw_limits, context.ceiling
        plans = self.mover.plan(*arguments)
        if self._put_mover is None:
            return plans
        return recompute_rows(plans, is_at_rest(context.plan) ^ is_swapped, self._put_mover.plan, *arguments)

    def plan_at(self, context: Context, pick: Floats, acceleration: Floats) -> Context:
        """The picks at other points (N, 3) [m], with throws of bounded acceleration (N,) [m/s2].

        The robot can carry out the throws whose plan is `feasible`.
        """
        limits, _ = self.grip_limits(context.objects, pick)
        limits = limits._replace(acceleration=np.minimum(limits.acceleration, acceleration))
        ceiling = pick[:, 2] + self.config.motion.ceiling
        moved = context.replace(
            pick=pick,
            throw_limits=limits,
            ceiling=ceiling,
            plan=self.mover.plan(pick, context.target, limits, ceiling),
            belt_shift=belt_shift(context.objects, pick, self.config.belt),
        )
        moved, _ = self._apply_throw_rule(moved)
        return moved.replace(plan=self.mark_feasible(moved, moved.plan))

    def grip_limits(self, objects: Objects, pick: Floats) -> tuple[LimitRows, Bools]:
        """Limits at which measured objects stay under the cup, and which objects the cup can hold (N,)."""
        safety, limits = self.config.grip.safety, self.config.robot.limits(objects.percent)
        if safety is None:
            return limits, np.ones(len(objects.measured.kind), dtype=np.bool_)
        required = self._table.safety[objects.measured.kind] if safety == "surface" else safety
        largest = measured_hold(objects, belt_shift(objects, pick, self.config.belt)).acceleration(required)
        slow = np.minimum(limits.acceleration, np.maximum(largest, LEAST_ACCELERATION))
        return limits._replace(acceleration=slow), largest >= LEAST_ACCELERATION

    def warn_of_reach(self) -> None:
        """Warn of fixed bins that no throw reaches: they stay empty, and other bins get their items."""
        objects, pick = self.draw_picks([np.random.default_rng(0)], np.zeros(TRIAL_THROWS, dtype=np.int64))
        limits, ceiling = self.config.robot.limits(objects.percent), pick[:, 2] + self.config.motion.ceiling
        for fixed in self.config.bins.fixed:
            target = np.tile([fixed.x, fixed.y, self.config.bins.rim], (TRIAL_THROWS, 1))
            if not self.mover.is_feasible(pick, self.mover.plan(pick, target, limits, ceiling), limits).any():
                warnings.warn(
                    f"level {self.config.name!r}: bin {fixed.name!r} at x {fixed.x} m, y {fixed.y} m stays empty: none "
                    f"of {TRIAL_THROWS} trial throws reaches it; move it closer to the robot",
                    stacklevel=2,
                )

    def _depth(self, objects: Objects, opening: Floats) -> Floats:
        """Free depths (N, B) [m] from the objects' draws: of all fixed bins, or of a drawn bin with opening (N, 2)."""
        emptied = self.config.bins.emptied
        if emptied is None:
            return np.full(objects.fill.shape, self.config.bins.depth)
        area = self.areas if self.config.bins.fixed else opening[:, :1] * opening[:, 1:]
        return draw_fill(objects.fill, emptied, self._volumes).depth(area, self.config)

    def _mover(self, name: str) -> Mover:
        mover = _MOVERS[name]
        if self.config.belt.tracking:
            return TrackingMover(self.config, self.workspace, mover)
        return mover(self.config, self.workspace)

    def _apply_throw_rule(self, context: Context) -> tuple[Context, Bools]:
        """The picks with plans to put down objects that the rule does not throw, and which picks are accepted (N,)."""
        every = np.full(len(context.pick), True)
        is_thrown = is_throwable(context, self.config.throwable, self._table) if self._has_throw_rule else every
        if self._put_mover is None:
            return context, is_thrown
        arguments = context.pick, context.target, context.throw_limits, context.ceiling
        return context.replace(plan=recompute_rows(context.plan, ~is_thrown, self._put_mover.plan, *arguments)), every

    def _fixed_bins(self, index: Ints) -> ThrowBins:
        """Fixed bins by their indices (N, T)."""
        target = np.full((*index.shape, 3), self.config.bins.rim)
        target[..., :2] = self._centres[index]
        return ThrowBins(target, self._openings[index], index)
