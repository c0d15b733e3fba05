"""What the figures of a design rest on: the assumptions that apply to it, a sentence each."""

from __future__ import annotations

from collections.abc import Iterator

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.names import list_names

from ..ground.levels import assumed_text


def assumptions(line: LineConfig) -> Iterator[str]:
    """The assumptions behind a design's figures; `docs/honest.md` says how each of them moves a figure."""
    cell = line.cell
    strange = [*dict.fromkeys(sheet.name for sheet in line.sheets() if not sheet.has_model)]
    if strange:
        yield (
            f"Of {list_names(strange)} the data sheet alone is known: joints, torques and tracking errors are left "
            "out, so rates are too high, above all for arms."
        )
    if cell.mismatch == 0.0:
        yield "The level's mismatch is 0: nothing goes wrong that the planner does not know. Real figures are lower."
    if cell.pick.fails:
        yield "The chance that a cup seals is assumed for each kind of object, and rates move with it."
    else:
        yield "Every cup seals: rates are too high."
    yield "Drag, friction, restitution, delays and spreads are assumed where no source gives them."
    if not cell.classifier.confusion:
        yield "The camera classifies every object without error: figures are too high by the mistakes of a real one."
    if cell.bins.emptied is None:
        yield "Each throw meets an empty bin: nothing bounces off a filling, and emptying takes no time."
    yield (
        "Carried objects pass over the objects on the belt, no object leans or lies on another, and a lost object does "
        "not come back to the belt: on a dense or fast belt rates are too high."
    )
    if not any(sheet.energy is not None for sheet in line.sheets() if not sheet.has_model):
        yield "Energy is the mechanical work of the motors, without heat, gears, recuperation and vacuum pump."
    if not line.cost.applies:
        yield "The level names no costs and no proceeds, so there is no money an hour."
    yield (
        "Nothing drifts, wears or clogs, apart from the standstill of a robot."
        if line.down
        else "Nothing drifts, wears, clogs or stands still."
    )
    yield from (f"Of an item of the level's own: {sentence}." for sentence in assumed_text(line).splitlines())
