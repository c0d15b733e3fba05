"""The thrower's config: levels, what the planner gets of it, and errors that people understand."""

import numpy as np
import pytest

from pnt_gym.cells.one_joint.config import GoalRegion, OneJointConfig
from pnt_gym.cells.one_joint.pallets import SORTING
from pnt_gym.cells.one_joint.tasks import Job
from pnt_gym.errors import ConfigError
from pnt_gym.planning.one_joint.parameters import Arm, Block

GOAL = {"name": "a", "x": 0.0, "y": 0.4, "phi_deg": 150.0, "dy": 0.0}


def test_the_defaults_are_the_planners_arm_and_block():
    config = OneJointConfig.load("nominal")
    assert config.arm.arm() == Arm()
    assert Block(**config.block.model_dump()) == Block()


def test_every_shipped_level_loads_for_every_task():
    assert {"ideal", "nominal", "late", "contact", "paper"} <= set(OneJointConfig.level_names())
    for name in OneJointConfig.level_names():
        assert OneJointConfig.load(name).name == name
        for task in ("sort", "assembly") if name != "paper" else ():
            assert OneJointConfig.load(name, task=task).task == task


def test_levels_differ_as_their_names_say():
    assert OneJointConfig.load("ideal").mismatch == 0.0
    assert OneJointConfig.load("nominal").mismatch == 1.0
    assert (OneJointConfig.load("nominal").errors.delay, OneJointConfig.load("late").errors.delay) == (0.005, 0.010)
    assert (OneJointConfig.load("nominal").release, OneJointConfig.load("contact").release) == ("ideal", "contact")
    (goal,) = OneJointConfig.load("paper").goals.fixed
    np.testing.assert_allclose(goal.state(), [0.0, 0.4, np.deg2rad(150.0), 0.0])


def test_a_changed_arm_reaches_the_planner():
    config = OneJointConfig.load("nominal", arm={"torque": 4.7, "angle_deg": [-60, 80]})
    arm = config.arm.arm()
    assert arm.torque == 4.7
    np.testing.assert_allclose(arm.angle, np.deg2rad([-60.0, 80.0]))


def test_a_changed_block_is_thrown():
    part = Job.of(OneJointConfig.load("nominal", block={"mass": 0.05, "half_length": 0.025})).parts[0]
    assert part.mass == pytest.approx(0.05, rel=1e-12)
    assert part.half_length == pytest.approx(0.025)
    assert part.inertia == pytest.approx(Block(mass=0.05, half_length=0.025).inertia, rel=1e-12)


def test_whole_turns_are_allowed():
    config = OneJointConfig.load("nominal", goals={"fixed": [GOAL | {"phi_deg": 510.0}]})
    assert config.goals.fixed[0].state()[2] == pytest.approx(np.deg2rad(510.0))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"arm": {"angle_deg": [90, -90]}}, "the range is empty"),
        ({"block": {"half_length": 0.5}}, "shorter than half the arm, 0.31 m"),
        ({"goals": {"fixed": [GOAL | {"y": -0.6}]}}, "y is -0.6 m; it lies below the pallets"),
        ({"goals": {"fixed": [GOAL | {"phi_deg": 1200.0}]}}, "phi_deg is 1200.0; the planner reaches -900 to 900 deg"),
        ({"goals": {"fixed": [GOAL, GOAL]}}, "must differ from one another"),
        ({"goals": {"fixed": [GOAL], "region": {}}}, "give one of them"),
        ({"goals": {"region": {"x": [0.2, -0.2]}}}, r"goals\.region\.x runs from 0\.2 to -0\.2"),
        ({"goals": {"region": {"y": [-0.9, 0.3]}}}, "goals.region: y is -0.9 m"),
        ({"task": "juggle"}, "task is 'juggle'"),
        ({"release": "slowly"}, "release is 'slowly'"),
        ({"errors": {"inertia": -0.299}, "mismatch": 3.0}, None),
    ],
)
def test_impossible_values_are_named_in_one_sentence(changes, message):
    if message is None:
        assert OneJointConfig.load("nominal", **changes).errors.inertia < 0.0
        return
    with pytest.raises(ConfigError, match=message) as caught:
        OneJointConfig.load("nominal", **changes)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("task", ["sort", "assembly"])
def test_pallets_bring_their_own_goals(task):
    with pytest.raises(ConfigError, match=f"task '{task}' throws at its own pallets"):
        Job.of(OneJointConfig.load("paper", task=task))


def test_jobs_hold_what_their_tasks_need():
    tasks = ("throw", "sort", "assembly")
    throw, sort, assembly = (Job.of(OneJointConfig.load("nominal", task=task)) for task in tasks)
    assert (len(throw.parts), len(throw.pallets), throw.region) == (1, 0, GoalRegion())
    assert (len(sort.parts), len(sort.pallets), sort.in_order) == (1, 3, False)
    assert sort.names == tuple(pallet.name for pallet in sort.pallets)
    assert (assembly.names, [t.part for t in assembly.targets], assembly.in_order) == (("aitch", "tee"), [0, 1], True)


def test_pockets_fit_the_block_of_the_config():
    assert Job.of(OneJointConfig.load("nominal", task="sort")).pallets == SORTING
    longer = Job.of(OneJointConfig.load("nominal", task="sort", block={"half_length": 0.035})).pallets
    assert longer[0].boxes[0][2] == pytest.approx(SORTING[0].boxes[0][2] + 0.005)
