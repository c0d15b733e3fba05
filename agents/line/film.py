"""A shift of a line seen from above: what rides the belt, who takes it, and where it flies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.cell import LineCell, Taken
from pnt_gym.cells.line.core import LineCore

from ..controllers.protocol import Controller, Observation
from ..drawings import COLOURS

WIDTH: Final = 1920
"""Of a frame, before it is made smaller [pixels]."""
LOW, HIGH = -0.72, 0.62
"""What is shown across the belt [m]."""
MARGIN: Final = 0.45
"""And beyond the first and the last window [m]."""
CORNERS: Final = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
BELT, GROUND, INK = (222, 222, 222), (250, 250, 250), (40, 40, 40)


@final
@dataclass(frozen=True)
class Act:
    """One cycle of a robot; x along the line [m], times since the begin of the shift [s]."""

    robot: int
    number: int
    """Of the object in the stream."""
    kind: int
    """What it is taken for."""
    sorted: bool
    picked: bool
    start: float
    lift: float
    release: float
    landing: float
    end: float
    begin: Floats
    """Where the hand comes from (2,)."""
    pick: Floats
    """Where it lifts the object (2,)."""
    target: Floats
    """Middle of the bin (2,)."""
    stop: Floats
    """Where the hand comes to stand (2,)."""

    def hand(self, time: float) -> Floats:
        """Where the hand is, straight from place to place (2,)."""
        if time < self.lift:
            return _between(self.begin, self.pick, self.start, self.lift, time)
        return _between(self.pick, self.stop, self.lift, self.end, time)

    def thing(self, time: float) -> Floats | None:
        """Where the object is that it has lifted (2,); None before and after."""
        if not self.picked or not self.lift <= time <= self.landing:
            return None
        if time <= self.release:
            return self.hand(time)
        return _between(self.hand(self.release), self.target, self.release, self.landing, time)


def _between(one: Floats, other: Floats, begin: float, end: float, time: float) -> Floats:
    share = np.clip((time - begin) / max(end - begin, 1e-9), 0.0, 1.0)
    return one + share * (other - one)


def acts(controller: Controller, env: Any, core: LineCore, seconds: float, seed: int) -> list[Act]:
    """What the robots of the first line do in the first seconds of a shift."""
    features, _ = env.reset(seed=seed)
    made: list[Act] = []
    while core.cell.state.clock[0] < seconds:
        action = controller.act(Observation(np.asarray(features), np.zeros(core.count, dtype=np.int64)))
        before = core.cell.state
        taken = core.cell.take(np.asarray(action, dtype=np.int64))
        features = core.observe()
        if taken.valid[0]:
            made.append(_act(core.cell, before, taken))
    return made


def _act(cell: LineCell, before: Any, taken: Taken) -> Act:
    robot, context, start = int(taken.robot[0]), taken.context, float(taken.start[0])
    base, choice = np.array([cell.config.places()[robot], 0.0]), before.choices
    at = int(np.flatnonzero(choice.real[0] & (choice.index[0] == taken.index[0]))[0])
    lift = start + float(choice.lift[0, at])
    release = lift + float(context.plan.time[0])
    return Act(
        robot=robot,
        number=int(taken.index[0]),
        kind=int(context.objects.seen[0]),
        sorted=bool(taken.made.sorted[0]),
        picked=bool(taken.made.picked[0]),
        start=start,
        lift=lift,
        release=release,
        landing=release + float(context.plan.flight_time[0]),
        end=float(taken.end[0]),
        begin=base + before.hand[0, robot, :2],
        pick=base + context.pick[0, :2],
        target=base + context.target[0, :2],
        stop=base + cell.state.hand[0, robot, :2],
    )


def frames(core: LineCore, made: list[Act], seconds: float, rate: float) -> Iterator[NDArray[np.uint8]]:
    """Frames (H, W, 3) of the first line's shift from its begin on."""
    for number in range(int(seconds * rate)):
        yield _frame(core, made, number / rate)


def _frame(core: LineCore, made: list[Act], time: float) -> NDArray[np.uint8]:
    places = core.config.places()
    low, high = core.config.cell.belt.pick_x
    left, right = places[0] + low - MARGIN, places[-1] + high + MARGIN
    scale = WIDTH / (right - left)
    image = Image.new("RGB", (WIDTH, int(scale * (HIGH - LOW))), GROUND)
    draw = ImageDraw.Draw(image)

    def spot(point: Any) -> tuple[float, float]:
        return (float(point[0]) - left) * scale, (HIGH - float(point[1])) * scale

    def box(middle: Any, half: Any, **how: Any) -> None:
        (x, y), (a, b) = spot(middle), (float(half[0]) * scale, float(half[1]) * scale)
        draw.rectangle((x - a, y - b, x + a, y + b), **how)

    _still(core, box)
    _riding(core, made, time, lambda corners, fill: draw.polygon([*map(spot, corners)], fill=fill))
    for act in made:
        where = act.thing(time)
        if where is not None:
            box(where, (0.045, 0.045), fill=COLOURS[act.kind % len(COLOURS)], outline=INK, width=2)
        if act.start <= time < act.end:
            (x, y), size = spot(act.hand(time)), 0.03 * scale
            draw.ellipse((x - size, y - size, x + size, y + size), outline=INK, width=5)
    return np.asarray(image)


def _still(core: LineCore, box: Any) -> None:
    """Belt, windows and bins, which have the colours of what they take."""
    belt, (low, high) = core.config.cell.belt, core.config.cell.belt.pick_x
    middle, half = (belt.y[0] + belt.y[1]) / 2, (belt.y[1] - belt.y[0]) / 2
    box((core.config.places().mean(), middle), (1e3, half), fill=BELT)
    for index, place in enumerate(core.config.places()):
        cell = core.config.cell_of(index)
        able = core.config.able()[index]
        box((place + (low + high) / 2, middle), ((high - low) / 2, half), outline=(150, 150, 150), width=4)
        for own, bin_ in enumerate(cell.bins.fixed):
            kinds = np.flatnonzero(cell.acceptance()[:, own] & able)
            colour = COLOURS[int(kinds[0]) % len(COLOURS)] if kinds.size else (205, 205, 205)
            box((place + bin_.x, bin_.y), np.array(bin_.size) / 2, outline=colour, width=8)


def _riding(core: LineCore, made: list[Act], time: float, outline: Any) -> None:
    """What is on the belt."""
    stream, speed = core.cell.stream, core.config.cell.belt.speed
    lifted = {act.number: act.lift for act in made if act.picked}
    x = stream.x[0] + speed * time
    for number in np.flatnonzero(np.abs(x - core.config.places().mean()) < 50.0):
        if lifted.get(int(number), np.inf) > time:
            kind, yaw = int(stream.objects.seen[0, number]), float(stream.objects.yaw[0, number])
            turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
            corners = stream.objects.size[0, number, :2] / 2 * CORNERS @ turn
            middle = np.array([x[number], stream.objects.lane_y[0, number]])
            outline([*map(tuple, middle + corners)], COLOURS[kind % len(COLOURS)])
