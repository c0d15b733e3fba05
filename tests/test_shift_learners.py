"""The recurrent memory of shifts of grasps, which a study judges."""

import numpy as np
import pytest

from agents.grasping.memory import MEMORIES, Event, NoMemory, ShiftMemory
from benchmarks.studies.shift_learners import Recording, Recurrence, RecurrentMemory, Shift, learn

LENGTH = 8
LOOKS = np.array([[-25.0, -25.0, -30.0, 2.0, 0.0, 0.0, 5.0, 0.0], [-20.0, -25.0, -25.0, 0.0, 2.0, 0.0, 3.0, 1.0]])


def work(memory: ShiftMemory, holds: np.ndarray, random: np.random.Generator, objects: int = LENGTH) -> np.ndarray:
    """Kinds of the objects of a shift, which their looks tell; `holds` says which of the two kinds is held."""
    kinds = random.integers(2, size=objects)
    for kind in kinds:
        memory.add(np.array([0]), LOOKS[[kind]], Event.of(1, tried=np.array([True]), held=holds[[kind]]))
    return kinds


@pytest.fixture(scope="module")
def network() -> Recurrence:
    random, shifts = np.random.default_rng(0), list[Shift]()
    memory = Recording(shifts, 1, LENGTH, 0.01)
    for _ in range(300):
        work(memory, random.permutation([True, False]), random)
        memory.begin(np.array([0]))
    assert len(shifts) == 300
    assert shifts[0].looks.shape == (LENGTH, 8)
    return learn(shifts, 0, 300)


def test_what_earlier_objects_of_a_look_did_is_in_what_the_memory_says(network: Recurrence) -> None:
    memory, random = RecurrentMemory(network, 1, LENGTH, 0.01), np.random.default_rng(1)
    said, held, row = list[np.ndarray](), list[bool](), np.array([0])
    for _ in range(200):
        memory.begin(row)
        holds = random.permutation([True, False])
        work(memory, holds, random, 5)
        kind = random.integers(2)
        said.append(np.append(memory.known(row, LOOKS[[kind]])[0], 1.0))
        held.append(bool(holds[kind]))
    inputs, outputs = np.array(said), 2.0 * np.array(held) - 1.0
    weights = np.linalg.lstsq(inputs[:100], outputs[:100], rcond=None)[0]
    assert (np.sign(inputs[100:] @ weights) == outputs[100:]).mean() > 0.9


def test_a_new_shift_begins_with_what_an_empty_memory_says(network: Recurrence) -> None:
    memory, row = RecurrentMemory(network, 1, LENGTH, 0.01), np.array([0])
    before = memory.known(row, LOOKS[:1])
    work(memory, np.array([True, False]), np.random.default_rng(2))
    assert before.shape == (1, MEMORIES)
    assert np.abs(memory.known(row, LOOKS[:1]) - before).max() > 0.1
    memory.begin(row)
    np.testing.assert_array_equal(memory.known(row, LOOKS[:1]), before)


def test_without_a_memory_nothing_changes_what_is_known() -> None:
    memory, row = NoMemory(1, LENGTH, 0.01), np.array([0])
    work(memory, np.array([True, True]), np.random.default_rng(3))
    memory.watch(row, np.random.default_rng(4).random((1, *memory.first.shape)))
    np.testing.assert_array_equal(memory.known(row, LOOKS[:1]), np.zeros((1, MEMORIES)))
    np.testing.assert_allclose(memory.weights(row)[0], memory.first, rtol=1e-12)
    assert np.abs(memory.error(row)).max() < 1e-9
