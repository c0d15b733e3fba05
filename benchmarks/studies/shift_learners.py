"""Learners of shifts of grasps that practise for a study: with attention to earlier tries, recurrent, without memory.

The recurrent memory ships with no command, for the one with attention sorts more. It reads the objects of its shift one
after the other, and foretells what becomes of the next one; what it is about to say are features of the values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any, Final, NamedTuple, final

import numpy as np

from agents.controllers.protocol import State
from agents.controllers.shift_values import FILE
from agents.grasping.memory import DOUBT, MEMORIES, Event, MakesMemory, NoMemory, ShiftMemory
from agents.ground.fitting import fit_from, on_one_thread
from agents.ground.places import at
from agents.judging.evaluation import open_cells
from agents.judging.trials import of as trial_of
from agents.policies import networks
from agents.policies.networks import Gru, layers_from_torch
from agents.training.grasp_shifts import ENV, ROWS, practise_shifts, read_gauge
from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.grasp.config import GraspConfig

KINDS, SEEDS, SHIFTS = 1100, 5, 192
"""First seed of the drawn kinds from whose shifts the recurrent memory learns, number of seeds, shifts of each."""
UNITS, WIDTH = 48, 64
SAID: Final = MEMORIES - 1
"""Numbers in which the recurrent memory says what it knows; beside them stands the doubt of the cup's error."""
TAUGHT: Final = 4
"""Numbers that are foretold of an object: whether it is held, whether it hits, and where it lands (2)."""
LOOK_MIDDLE: Final = np.array([-25.0, -25.0, -30.0, 0.0, 0.0, 0.0, 5.0, 0.0])
LOOK_SCALE: Final = np.array([5.0, 5.0, 5.0, 2.0, 2.0, 2.0, 5.0, 5.0])
"""Middles and scales of looks, of all drawn kinds roughly."""
LANDING: Final = 0.05
"""Length that counts as 1 of where an object lands [m]."""
BATCH, STEPS, RATE, DECAY = 64, 1500, 3e-3, 0.02


def practised(memory: str, seed: int, picks: int) -> tuple[State, dict[str, Any]]:
    """State of a learner after its practice, and the options of the controller that loads the state.

    Args:
        memory: `attention`, `recurrent` or `none`.
        seed: seed of kinds, shifts, choices and fits.
        picks: picks of the practice.
    """
    makes = MEMORIES_BY_NAME[memory]()
    return practise_shifts(seed, makes, picks, read_gauge(at(FILE))).state(), {"memory": makes}


class Shift(NamedTuple):
    """The objects of a shift, one after the other."""

    looks: Floats
    """(K, 8)"""
    outcomes: Floats
    """(K, 11), see `_outcomes`."""


def _outcomes(events: Event) -> Floats:
    """What became of objects (K, 11), as numbers of the order of 1."""
    told = (events.tried, events.held, events.surprise, events.thrown, events.dropped, events.hit, events.landed)
    columns = [*(np.asarray(one, dtype=np.float64) for one in told), events.off / LANDING, events.direction]
    return np.clip(np.column_stack(columns), -4.0, 4.0)


def _scaled(looks: Floats) -> Floats:
    return np.clip((looks - LOOK_MIDDLE) / LOOK_SCALE, -5.0, 5.0)


@final
class Recording(ShiftMemory):
    """Keeps the shifts that are over.

    Args:
        shifts: the list to which they are added.
        more: arguments of `ShiftMemory`.
    """

    def __init__(self, shifts: list[Shift], *more: Any, **named: Any) -> None:
        self._shifts = shifts
        super().__init__(*more, **named)

    def begin(self, rows: Ints) -> None:
        """Keep the shifts of some rows, and forget them."""
        for row in map(int, rows):
            known = int(self._known[row])
            slots = np.arange(row * self._length, row * self._length + known)
            if known > 0:
                self._shifts.append(Shift(self._looks[row, :known].copy(), _outcomes(take(self._events, slots))))
        super().begin(rows)


def _work_shifts() -> list[Shift]:
    """Shifts of drawn kinds, worked by the learner that ships."""
    shifts = list[Shift]()
    for seed in range(KINDS, KINDS + SEEDS):
        level = GraspConfig.load({"base": "grasp_shift", "drawn": {"seed": seed}})
        with open_cells(ENV, {"level": level, "num_envs": ROWS, "threads": 1}) as cells:
            trial = trial_of(cells)
            controller = trial.controller("shift_values", memory=partial(Recording, shifts))
            controller.reset(0)
            trial.run(controller, SHIFTS * level.picks_per_shift, seed)
    return shifts


@final
class Recurrence(NamedTuple):
    """A recurrent network as arrays."""

    unit: Gru
    """Reads look and outcome of an object."""
    says: networks.Layers
    """From the unit's memory and a look to what is said."""

    def read(self, looks: Floats, outcomes: Floats, known: Floats) -> Floats:
        """Memories (K, H) after objects with looks (K, 8) and outcomes (K, 11)."""
        return self.unit(np.column_stack([_scaled(looks), outcomes]), known)

    def say(self, looks: Floats, known: Floats) -> Floats:
        """What memories (K, H) say of objects with looks (K, 8), as numbers (K, `SAID`)."""
        return np.tanh(networks.run(self.says, "SiLU", np.column_stack([known, _scaled(looks)])))


@final
class RecurrentMemory(ShiftMemory):
    """Remembers a shift by a recurrent network, and the error of the cup as the memory with attention does.

    Args:
        network: the network.
        count: number of rows N.
        length: picks of a shift.
        spread: standard deviation of the cup's error before anything is known of it, per axis [m].
    """

    attends = False

    def __init__(self, network: Recurrence, count: int, length: int, spread: float) -> None:
        super().__init__(count, length, spread)
        self._network, self._units = network, np.zeros((count, UNITS))

    def begin(self, rows: Ints) -> None:
        """Forget the former shifts of some rows."""
        super().begin(rows)
        self._units[rows] = 0.0

    def add(self, rows: Ints, looks: Floats, events: Event) -> None:
        """Read objects (K,) of some rows."""
        super().add(rows, looks, events)
        self._units[rows] = self._network.read(looks, _outcomes(events), self._units[rows])

    def known(self, rows: Ints, looks: Floats) -> Floats:
        """What is known of objects of looks (K, 8) in some rows, as features (K, `MEMORIES`)."""
        return np.column_stack([self._network.say(looks, self._units[rows]), self.doubt(rows) / DOUBT])


@cache
def recurrence() -> MakesMemory:
    """What makes memories by a recurrent network that has learned from worked shifts."""
    return partial(RecurrentMemory, learn(_work_shifts(), 0, STEPS))


@on_one_thread
def learn(shifts: Sequence[Shift], seed: int, steps: int) -> Recurrence:
    """A recurrent network that has learned to foretell what becomes of the next object.

    Cross entropies of being held, of objects that were tried, and of hitting, of those that were thrown, and half the
    Huber loss of the landing, of those that were seen to land.
    """
    import torch  # noqa: PLC0415 - a second to import, needed for fitting only

    looks, outcomes, is_there = map(torch.as_tensor, _side_by_side(shifts))
    random = np.random.default_rng([seed, 11])
    with fit_from(seed):
        layer, silu = torch.nn.Linear, torch.nn.SiLU()
        unit = torch.nn.GRUCell(looks.shape[-1] + outcomes.shape[-1], UNITS)
        says = torch.nn.Sequential(layer(UNITS + looks.shape[-1], WIDTH), silu, layer(WIDTH, SAID), torch.nn.Tanh())
        foretells = layer(SAID, TAUGHT)
        model = torch.nn.ModuleList([unit, says, foretells])
        optimiser = torch.optim.AdamW(model.parameters(), lr=RATE, weight_decay=DECAY)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
        for _ in range(steps):
            rows = random.integers(len(shifts), size=BATCH)
            known, total = torch.zeros(BATCH, UNITS), torch.zeros(())
            for k in range(looks.shape[1]):
                look, outcome = looks[rows, k], outcomes[rows, k]
                foretold = foretells(says(torch.cat([known, look], -1)))
                total = total + (_loss(torch, foretold, outcome) * is_there[rows, k]).sum()
                known = unit(torch.cat([look, outcome], -1), known)
            optimiser.zero_grad()
            (total / is_there[rows].sum()).backward()
            torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
            optimiser.step()
            schedule.step()
    return Recurrence(Gru.from_torch(unit, np.float64), layers_from_torch(says.parameters(), np.float64))


def _side_by_side(shifts: Sequence[Shift]) -> tuple[Any, Any, Any]:
    """Scaled looks (S, K, 8), outcomes (S, K, 11), and 1 where the shift has an object (S, K)."""
    longest = max(len(shift.looks) for shift in shifts)
    looks, outcomes = (np.zeros((len(shifts), longest, one.shape[1]), dtype=np.float32) for one in shifts[0])
    is_there = np.zeros((len(shifts), longest), dtype=np.float32)
    for k, shift in enumerate(shifts):
        count = len(shift.looks)
        looks[k, :count], outcomes[k, :count], is_there[k, :count] = _scaled(shift.looks), shift.outcomes, 1.0
    return looks, outcomes, is_there


def _loss(torch: Any, foretold: Any, outcome: Any) -> Any:
    """Losses (B,) of what was foretold (B, 4) of objects with outcomes (B, 11), see `_outcomes`."""
    functions = torch.nn.functional
    held, hit = (
        functions.binary_cross_entropy_with_logits(foretold[:, k], outcome[:, column], reduction="none")
        for k, column in enumerate((1, 5))
    )
    landing = functions.huber_loss(foretold[:, 2:], outcome[:, 7:9], reduction="none").sum(-1)
    return held * outcome[:, 0] + hit * outcome[:, 3] + 0.5 * landing * outcome[:, 6]


MEMORIES_BY_NAME: Final[dict[str, Callable[[], MakesMemory]]] = {
    "attention": lambda: ShiftMemory,
    "recurrent": recurrence,
    "none": lambda: NoMemory,
}
"""What makes memories, by the names that studies give."""
