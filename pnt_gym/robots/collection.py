"""The simulated robots as MJCF in the form of a model collection: robot, scene, licence and notes in a folder each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.engine import MjSpec, mujoco
from pnt_gym.robots.arm import ur10e
from pnt_gym.robots.gripper import model as gripper
from pnt_gym.robots.gripper import references
from pnt_gym.robots.gripper.geometry import PROTOTYPE
from pnt_gym.robots.joints import qpos_columns
from pnt_gym.robots.specification import set_options
from pnt_gym.robots.t3kr.model import add_t3kr

STEP: Final = 0.0004
"""Physics step of the models [s]."""
HOME: Final = (0.0, 0.0, -0.15)
"""Place of the T3KR's hand at home [m]."""
BELOW: Final = 0.25
"""Height of the hand at home above the floor of the scene [m]."""
SCENE: Final = """<mujoco model="{name} scene">
  <include file="{name}.xml"/>
  <visual>
    <headlight ambient="0.4 0.4 0.4" diffuse="0.5 0.5 0.5"/>
  </visual>
  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.9 0.93 0.96" rgb2="0.55 0.62 0.7" width="64" height="384"/>
    <texture name="tiles" type="2d" builtin="checker" rgb1="0.8 0.8 0.8" rgb2="0.7 0.7 0.7" width="64" height="64"/>
    <material name="tiles" texture="tiles" texrepeat="10 10"/>
  </asset>
  <worldbody>
    <light pos="0 -1 3" dir="0 0.3 -1"/>
    <geom name="floor" type="plane" size="2 2 0.1" pos="0 0 {floor:g}" material="tiles"/>
  </worldbody>
</mujoco>
"""
NOTES: Final = """# {title}

{about}

* `{name}.xml` is the robot, `scene.xml` the robot over a floor. All shapes are primitives, so there are no meshes.
* Start from the key `home`. It closes the loops of a robot that has some; other joint positions must close them, too.
* Each of the {motors} motors has three consecutive controls: angle [rad], velocity [rad/s] and torque on top [N m].
* MuJoCo {engine} or newer; written by pnt_gym {version}.
"""


@final
@dataclass(frozen=True)
class Model:
    """A robot as MJCF."""

    title: str
    about: str
    spec: MjSpec
    hand: float
    """Height of the hand at home [m]."""


def write_texts(licence: str, version: str) -> dict[str, str]:
    """Texts of all files of the collection by their paths within it, with the licence and the version of pnt_gym."""
    texts = dict[str, str]()
    for name, make in MODELS.items():
        model = make()
        words: dict[str, Any] = {"name": name, "title": model.title, "about": model.about, "floor": model.hand - BELOW}
        words |= {"motors": len(list(model.spec.actuators)), "engine": mujoco.__version__, "version": version}
        texts[f"{name}/{name}.xml"] = model.spec.to_xml()
        texts[f"{name}/scene.xml"] = SCENE.format(**words)
        texts[f"{name}/README.md"] = NOTES.format(**words)
        texts[f"{name}/LICENSE"] = licence
    return texts


def _t3kr() -> Model:
    """The T3KR of Hassan et al. 2022."""
    spec = mujoco.MjSpec()
    spec.modelname = "t3kr"
    set_options(spec, STEP)
    robot = add_t3kr(spec)
    model = spec.compile()
    pose, home = np.zeros(model.nq), robot.pose(np.array([HOME]))[0]
    pose[qpos_columns(model, robot)] = home
    angles = [float(pose[model.joint(name).qposadr[0]]) for name in robot.motor_joints]
    _add_home(spec, pose, np.array(angles))
    about = (
        "A parallel robot with four arms whose platform keeps level, of the class of the T3KR in Hassan et al. 2022. "
        "The paper publishes neither lengths nor masses: these belong to a mechanism that reaches an assumed workspace."
    )
    return Model("T3KR", about, spec, HOME[2])


def _gripper() -> Model:
    """The robot with a built-in gripper of Leveziel et al."""
    spec = mujoco.MjSpec()
    spec.modelname = "gripper"
    gripper.set_options(spec, STEP)
    robot = gripper.add_gripper(spec)
    model = spec.compile()
    pose = references.closed_pose(np.array([0.0, 0.0, PROTOTYPE.home_z, PROTOTYPE.home_theta]))
    columns = [int(model.joint(name).qposadr[0]) for name in robot.joints]
    home = np.zeros(model.nq)
    home[columns] = pose
    _add_home(spec, home, home[[int(model.joint(f"arm_{arm}").qposadr[0]) for arm in range(len(robot.actuators))]])
    about = (
        "A parallel robot with four degrees of freedom whose platform halves are a gripper, with the lengths of the "
        "prototype in Leveziel et al., A 4-DoF parallel robot with a built-in gripper for waste sorting. Masses are "
        "assumed."
    )
    return Model("4-DoF robot with a built-in gripper", about, spec, PROTOTYPE.home_z)


def _ur10e() -> Model:
    """A six-axis arm."""
    spec = mujoco.MjSpec()
    spec.modelname = "ur10e_class"
    set_options(spec, STEP)
    ur10e.add_ur10e(spec)
    _add_home(spec, np.array(ur10e.HOME), np.array(ur10e.HOME))
    about = (
        "A six-axis arm of the class of the Universal Robots UR10e: lengths, masses, centres of mass, ranges and "
        "torques as the maker publishes them. Inertias and gains are assumed."
    )
    data = spec.compile()
    place = mujoco.MjData(data)
    place.qpos[:] = ur10e.HOME
    mujoco.mj_kinematics(data, place)
    return Model("Six-axis arm", about, spec, float(place.site("tool").xpos[2]))


def _add_home(spec: MjSpec, pose: Floats, angles: Floats) -> None:
    """Add the key in which the loops are closed and the motors hold their angles (M,) [rad]."""
    controls = np.column_stack([angles, np.zeros((len(angles), 2))]).ravel()
    spec.add_key(name="home", qpos=pose, ctrl=controls)


MODELS: Final[Mapping[str, Callable[[], Model]]] = {"t3kr": _t3kr, "gripper": _gripper, "ur10e_class": _ur10e}
"""What makes each model, by its name."""
