"""Names that have left the package: who asks for one learns where it stands."""

import importlib

import pytest

from pnt_gym.errors import PntGymError

LEFT = [
    ("pnt_gym.planning.paths", "PlanePath"),
    ("pnt_gym.planning.paths", "LameCorner"),
    ("pnt_gym.planning.one_joint", "plan_throw"),
    ("pnt_gym.planning.one_joint", "random_goals"),
    ("pnt_gym.planning.one_joint", "next_virtual_goal"),
    ("pnt_gym.robots.gripper", "scan_workspace"),
    ("pnt_gym.robots.gripper", "joint_move"),
]


@pytest.mark.parametrize(("module", "name"), LEFT)
def test_a_name_that_has_moved_says_where_it_stands_and_stands_there(module, name):
    with pytest.raises(ImportError, match=rf"{module}.{name} is papers\.\S+\.{name} now") as error:
        exec(f"from {module} import {name}")
    assert isinstance(error.value, PntGymError)
    place = str(error.value).split(" is ")[1].split()[0].rpartition(".")[0]
    assert hasattr(importlib.import_module(place), name)


@pytest.mark.parametrize("module", sorted({module for module, _ in LEFT}))
def test_any_other_name_is_no_attribute(module):
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        _ = importlib.import_module(module).nothing
