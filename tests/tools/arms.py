"""Arms that are not part of the package: the SCARA of the guide, and a six-axis arm as URDF, with cells for them."""

import re
from pathlib import Path
from typing import Any, Final

import yaml

from agents.ground.places import SHIPPED

PAGE: Final = SHIPPED / "docs" / "extend.md"
SIX: Final = (
    # Name, place in the link before, axis, mass, centre of mass, length, torque, speed
    ("turn", "0 0 0.2", "0 0 1", 7.0, "0 0 0", 0.2, 330, 3.0),
    ("shoulder", "0 0 0", "0 1 0", 12.0, "0 0 0.3", 0.7, 330, 3.0),
    ("elbow", "0 0 0.7", "0 1 0", 4.0, "0 0 0.25", 0.65, 200, 4.0),
    ("bend", "0 0 0.65", "0 1 0", 2.0, "0 0 0.05", 0.1, 80, 6.0),
    ("roll", "0 0 0.1", "0 0 1", 1.5, "0 0 0.02", 0.1, 80, 6.0),
    ("tilt", "0 0 0.1", "1 0 0", 0.5, "0 0 0.02", 0.1, 80, 6.0),
)
"""A six-axis arm, upright where all joints are at 0."""


def scara(folder: Path, **changes: Any) -> Path:
    """Write the arm of the guide and its level to a folder, with changes of the section `robot`; the level's file."""
    text = PAGE.read_text(encoding="utf-8")
    for name in ("my_arm.xml", "my_arm.yaml"):
        block = re.search(rf'^```\w+ title="{name}"\n(.*?)^```$', text, re.M | re.S)
        assert block is not None, name
        (folder / name).write_text(block[1])
    return changed(folder / "my_arm.yaml", **changes)


def changed(level: Path, **changes: Any) -> Path:
    """Change keys of the section `robot` of a level's file; those of `model` one by one."""
    data = yaml.safe_load(level.read_text())
    model = changes.pop("model", {})
    data["robot"] = {**data["robot"], **changes, "model": {**data["robot"]["model"], **model}}
    level.write_text(yaml.safe_dump(data))
    return level


def urdf() -> str:
    """The six-axis arm as URDF, whose tool is a link without a joint of its own that moves."""
    parts = ['<robot name="six"><link name="base"/>']
    before = "base"
    for name, place, axis, mass, centre, length, torque, speed in SIX:
        across, slim = mass * length**2 / 12, mass * 0.05**2 / 2
        parts.append(
            f'<link name="{name}_link"><inertial><origin xyz="{centre}"/><mass value="{mass}"/><inertia ixx="{across}" '
            f'iyy="{across}" izz="{slim}" ixy="0" ixz="0" iyz="0"/></inertial>'
            f'<visual><geometry><cylinder radius="0.04" length="{length}"/></geometry></visual></link>'
            f'<joint name="{name}" type="revolute"><parent link="{before}"/><child link="{name}_link"/>'
            f'<origin xyz="{place}"/><axis xyz="{axis}"/><limit lower="-6.3" upper="6.3" effort="{torque}" '
            f'velocity="{speed}"/></joint>'
        )
        before = f"{name}_link"
    parts.append(
        f'<link name="flange"/><joint name="end" type="fixed"><parent link="{before}"/><child link="flange"/>'
        '<origin xyz="0 0 0.05"/></joint></robot>'
    )
    return "".join(parts)


def six_axis(folder: Path) -> Path:
    """Write the six-axis arm as URDF and a level for it to a folder; the level's file."""
    (folder / "six.urdf").write_text(urdf())
    data = {
        "name": "six",
        "base": "waste",
        "limits": {"percent": [100]},
        "belt": {"lane_y": [-0.40, -0.20]},
        "bins": {"rim": -1.0, "random": {"x": [-0.3, 0.3], "y": [0.06, 0.14], "item_clearance": 0.06}},
        "motion": {"reserve": 0.04, "follow_through": {"window": 0.03}},
        "robot": {
            "name": "six",
            "velocity": 0.9,
            "acceleration": 10.0,
            "jerk": 150.0,
            "reach": {"shape": "ellipse", "semi_x": 0.40, "semi_y": 0.24, "y": -0.18},
            "height": [-0.92, -0.40],
            "payload": 1.0,
            "model": {
                "file": "six.urdf", "tool": "flange", "base": [0.0, -1.0, -0.60],
                "home": [1.57, 0.3, 1.8, 1.04, 0.0, 0.0],
            },
        },
    }  # fmt: skip
    (folder / "six.yaml").write_text(yaml.safe_dump(data))
    return folder / "six.yaml"
