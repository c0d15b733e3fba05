"""Lines for tests: with tables that nobody had to make, decisions at random, and what became of everything by a ledger.

The ledger knows only what steps say they did; the cell's own books are compared with it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

from agents.controllers.protocol import Observation
from agents.dispatchers import decisions
from agents.dispatchers.registry import line_core
from agents.dispatchers.rules import IndexRule
from agents.ground.environments import make_vector
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.line.cell import Decisions, LineCell
from pnt_gym.cells.line.chances import Chances, format_table
from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.observation import MIN_RATE
from pnt_gym.cells.line.rows import Fate
from pnt_gym.cells.line.stream import Stream

PICKED = (0.8, 0.9, 0.6, 0.85)
"""How often cups seal on each item of the shipped lines, in the tables made here."""
EDGES = (0.7, 0.8, 0.9)
THREE_BINS = [
    {"name": "left", "x": -0.35, "y": 0.38, "size": [0.235, 0.235]},
    {"name": "right", "x": 0.35, "y": 0.38, "size": [0.235, 0.235], "accepts": ["can", "tray"]},
    {"name": "far", "x": 0.1, "y": 0.95, "size": [0.235, 0.235], "accepts": ["can"]},
]
"""Bins of a robot, of which a can may go into any."""
BOXES = st.lists(
    st.tuples(st.floats(0.0, 0.2), st.floats(-0.2, 0.2), st.floats(0.005, 0.15), st.floats(0.005, 0.15)),
    min_size=1,
    max_size=25,
)
"""Boxes in the order in which they come: the step from the one before, y, and half their sizes [m]."""


def chances(config: LineConfig, picked: tuple[float, ...] = PICKED) -> Chances:
    """A table that is told apart from any other: it falls with the distance, the speed, and from item to item."""
    percent = np.unique([percent for cell in config.cells() for percent in cell.limits.percent])
    items = np.arange(len(picked))[:, None, None]
    landed = 0.95 - 0.1 * items - 0.05 * np.arange(len(percent))[:, None] - 0.1 * np.arange(4)
    return Chances(percent, np.array(EDGES), np.array(picked), landed)


def with_table(level: dict[str, Any], folder: Path, picked: tuple[float, ...] = PICKED) -> dict[str, Any]:
    """The level with a table of its own in a folder."""
    config = LineConfig.load({**level, "throws": "flight"})
    place = folder / f"{config.digest()}-{'-'.join(map(str, picked))}.json"
    place.write_text(format_table(chances(config, picked), digest=config.digest()))
    return {**level, "chances": str(place)}


def vector_lines(level: Any, rows: int = 4) -> tuple[Any, LineCore]:
    """N lines in the vector form, and their core."""
    env = make_vector("PnTLine-v0", level, rows, 1)
    return env, line_core(env)


def observed(env: Any, steps: int, seed: int = 3) -> Iterator[tuple[Observation, dict[str, Any]]]:
    """Observations along shifts of the ATC rule, with the info of each."""
    rule, (features, info) = IndexRule("atc", "atc", patience=1.0), env.reset(seed=seed)
    for _ in range(steps):
        seen = decisions.observe(np.array(features, dtype=np.float32))
        yield seen, info
        features, *_, info = env.step(rule.act(seen))


def begun(level: Any, count: int = 1, seed: int = 0, threads: int = 1) -> LineCell:
    """N lines at the begin of their shifts; row i has its own generator of seed + i."""
    cell = LineCell(LineConfig.load(level), count, threads)
    cell.reset(np.arange(count), [np.random.default_rng(seed + i) for i in range(count)])
    return cell


def stream_with(stream: Stream, objects: Objects | None = None, **columns: Any) -> Stream:
    """The stream with other objects, values or luck."""
    known = {name: columns.get(name, stream.riders[name]) for name in ("x", "worth", "luck")}
    return Stream.of(stream.objects if objects is None else objects, **known)


def decided(cell: LineCell, random: np.random.Generator, invalid: float = 0.0) -> np.ndarray:
    """A choice for every line, any of those that there are, or now and then one that there is not (N,)."""
    real = cell.state.choices["real"]
    score = random.random(real.shape) + np.where(real, 1.0, 0.0)
    score = np.where((random.random(len(real)) < invalid)[:, None], -score, score)
    return score.argmax(axis=1)


def seen_values(core: LineCore) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the robots that decide next know, by name: of their lines (N,), and of each choice (N, CHOICES)."""
    state, choices, rows = core.cell.state, core.cell.state.choices, np.arange(core.cell.count)
    hand, until = state.arms["hand"][rows, state.robot], np.zeros((core.cell.count, MOST_ROBOTS))
    until[:, : state.arms["expected"].shape[1]] = np.maximum(state.arms["expected"] - state.clock[:, None], 0.0)
    line = {
        "gone": np.minimum(state.clock / core.config.duration, 1.0),
        **{f"turn_{robot}": state.robot == robot for robot in range(MOST_ROBOTS)},
        **{f"busy_{robot}": until[:, robot] for robot in range(MOST_ROBOTS)},
        "hand_x": hand[:, 0],
        "hand_y": hand[:, 1],
        "coming": _coming(core.cell),
        "possible": choices["real"].sum(axis=1),
    }
    plain = "real lift wait value chance percent crowd heirs reaches queue"
    return line, {
        **{name: choices[name] for name in plain.split()},
        "pick_x": choices["pick"][..., 0],
        "pick_y": choices["pick"][..., 1],
        "cycle": choices["lift"] + choices["throwing"],
        "slack": choices["leave"] - choices["lift"],
        "ln_rate": np.log(
            np.maximum(choices["value"] * choices["chance"] / (choices["lift"] + choices["throwing"]), MIN_RATE)
        ),
        "distance": np.hypot(choices["away"][..., 0], choices["away"][..., 1]),
        "stop_x": choices["stop"][..., 0],
        "stop_y": choices["stop"][..., 1],
    }


def _coming(cell: LineCell) -> Any:
    """Objects that each deciding robot takes, from the camera to the end of its window (N,)."""
    state, stream, config = cell.state, cell.stream, cell.config
    x = stream.x + config.cell.belt.speed * state.clock[:, None]
    end = config.robot_x()[state.robot] + config.cell.belt.pick_x[1]
    in_sight = (x >= config.reach[0]) & (x <= np.minimum(config.reach[1], end)[:, None])
    takes = config.can_take()[state.robot[:, None], stream.objects.measured.kind]
    return (in_sight & takes & (state.accounts["since"] <= state.clock[:, None])).sum(axis=1)


@dataclass
class Ledger:
    """What became of every object of one line, by what steps said."""

    taken: dict[int, tuple[Fate, int, int]] = field(default_factory=dict)
    """Fate, robot and bin of those that a robot has lifted."""
    tries: dict[int, int] = field(default_factory=dict)
    value: float = 0.0

    def enter(self, taken: Decisions, row: int, duration: float) -> None:
        """One decision, of an object that nobody has taken before."""
        if not taken.valid[row]:
            assert not taken.results["picked"][row]
            return
        index = int(taken.index[row])
        assert index not in self.taken, f"object {index} is taken twice"
        self.tries[index] = self.tries.get(index, 0) + 1
        self.value += float(taken.value[row])
        if not taken.results["picked"][row]:
            return
        end, in_bin = Fate.HELD, -1
        if taken.end[row] <= duration:
            in_bin = int(taken.results["ended_in"][row])
            end = Fate.SORTED if taken.results["sorted"][row] else Fate.MISPLACED if in_bin >= 0 else Fate.FLOOR
        self.taken[index] = end, int(taken.robot[row]), in_bin

    def agrees(self, cell: LineCell, row: int) -> None:
        """Make sure that the cell's books say the same of every object of a line."""
        accounts = cell.state.accounts
        for index in range(accounts.shape[1]):
            fate, robot, in_bin = self.taken.get(index, (Fate.RIDES, -1, -1))
            assert (accounts["fate"][row, index], accounts["taker"][row, index], accounts["ended_in"][row, index]) == (
                fate,
                robot,
                in_bin,
            )
            assert accounts["attempts"][row, index] == self.tries.get(index, 0)
            assert np.isinf(accounts["since"][row, index]) == (index in self.taken)
