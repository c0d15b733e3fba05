"""How a dataset is written and what it may be called."""

import pytest

from agents.dataset import offline
from agents.ground.cli import UsageError
from tests.tools.datasets import NAME


@pytest.mark.parametrize(
    ("env", "level", "label", "name"),
    [
        ("PnTRelease-v0", "waste", "random", NAME),
        ("OneJointThrow-v0", "nominal", "virtual_goal", "pnt_gym/one_joint_throw/nominal-virtual_goal-v0"),
        ("catapult:Catapult-v2", "my cell!", "é", "pnt_gym/catapult/my_cell-own-v0"),
    ],
)
def test_a_proper_name(env: str, level: str, label: str, name: str) -> None:
    assert offline.name(env, level, label) == name
    offline.check(name)


@pytest.mark.parametrize("name", ["", "a", "a-v", "../a-v0", "/a/b-v0", "a/b-v0/", "a b-v0", "a.b/c-v0", "x" * 300])
def test_no_name(name: str) -> None:
    with pytest.raises(UsageError, match="it must be NAMESPACE/NAME-vN"):
        offline.check(name)
