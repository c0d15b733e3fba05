"""A stranger's model: nothing outside its folder is read, nothing of it runs, and what is no arm is refused."""

import os
import struct
from pathlib import Path

import numpy as np
import pytest

from pnt_gym.errors import ConfigError
from pnt_gym.robots.arm.chain import chain_of
from pnt_gym.robots.arm.reading import read_model
from pnt_gym.robots.arm.settings import ArmSettings
from tests.tools.arms import urdf

ARM = (
    '<mujoco><compiler meshdir="{folder}"/>{asset}<worldbody><body name="a"><joint name="one"/>'
    '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{shape}{inside}</body></worldbody>'
    '<actuator><motor joint="one" ctrlrange="-5 5"/></actuator>{after}</mujoco>'
)
SETTINGS = ArmSettings(speed=(1.0,))


def written(folder: Path, asset="", shape="", inside="", after="", inner="") -> Path:
    text = ARM.format(asset=asset, shape=shape, inside=inside, after=after, folder=inner)
    (folder / "arm.xml").write_text(text)
    return folder / "arm.xml"


def tetrahedron() -> bytes:
    """A mesh as binary STL."""
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *corners[list(face)].ravel(), 0) for face in faces)
    return bytes(80) + struct.pack("<I", len(faces)) + body


def mesh(name: str) -> dict[str, str]:
    return {"asset": f'<asset><mesh name="m" file="{name}"/></asset>', "shape": '<geom type="mesh" mesh="m" mass="0"/>'}


def test_a_mesh_of_the_folder_is_read_from_memory(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "part.stl").write_bytes(tetrahedron())
    file = read_model(written(tmp_path, **mesh("part.stl"), inner="meshes"))
    assert file.parts["mesh_0.stl"] == tetrahedron()
    (shape,) = chain_of(file, SETTINGS).shapes
    assert shape.mesh is not None
    assert len(shape.mesh[1]) == 4


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("gone.stl", "cannot read mesh 'gone.stl': No such file"),
        ("../secret.stl", "mesh '../secret.stl' lies outside the folder of the model"),
        ("/etc/passwd", "mesh '/etc/passwd' is none of"),
        ("link.stl", "mesh 'link.stl' lies outside the folder"),
        ("file:///etc/hosts.stl", "cannot read mesh"),
        ("folder.stl", "cannot read mesh 'folder.stl'"),
    ],
)
def test_a_mesh_elsewhere_is_refused(tmp_path, name, said):
    inside = tmp_path / "model"
    inside.mkdir()
    (inside / "folder.stl").mkdir()
    (tmp_path / "secret.stl").write_bytes(tetrahedron())
    os.symlink(tmp_path / "secret.stl", inside / "link.stl")
    with pytest.raises(ConfigError) as refused:
        read_model(written(inside, **mesh(name)))
    assert said in str(refused.value) or (name.startswith("file:") and "outside the folder" in str(refused.value))
    assert "\n" not in str(refused.value)


def test_the_engine_reads_no_file_by_itself(tmp_path, monkeypatch):
    """A mesh that lies in the working folder under the name that the engine is given is not read either."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mesh_0.stl").write_bytes(b"not a mesh")
    (tmp_path / "part.stl").write_bytes(tetrahedron())
    assert read_model(written(tmp_path, **mesh("part.stl"))).parts["mesh_0.stl"] == tetrahedron()


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"after": '<extension><plugin plugin="mujoco.sdf.torus"/></extension>'}, "<extension>"),
        ({"asset": '<include file="other.xml"/>'}, "it has '<include>'"),
        ({"asset": '<asset><model name="m" file="other.xml"/></asset>'}, "it has '<model>'"),
        ({"asset": '<asset><hfield name="h" file="h.png" size="1 1 1 1"/></asset>'}, "it has '<hfield>'"),
        ({"inside": '<composite type="cable" count="3 1 1"/>'}, "<composite>"),
        ({"inside": '<body><freejoint/><geom size="0.1"/></body>'}, "<freejoint>"),
        ({"inside": '<body name="b"><joint type="free"/></body>'}, "the engine refuses it"),
        ({"inside": '<body name="b"><joint type="ball"/><geom size="0.1"/></body>'}, "body 'b' has a ball joint"),
        ({"inside": '<body><joint name="s" stiffness="3"/><geom size="0.1"/></body>'}, "joint 's' has a spring"),
        ({"after": '<equality><joint joint1="one"/></equality>'}, "<equality>"),
        ({"after": '<tendon><fixed><joint joint="one" coef="1"/></fixed></tendon>'}, "'<fixed>' and '<tendon>'"),
        ({"after": '<option><flag energy="enable"/></option><custom/>'}, "<custom>"),
        ({"inside": '<body><joint name="two"/><geom size="0.1"/></body>'}, "joint 'two' has no actuator"),
        ({"inside": '<geom size="-1"/>'}, "the engine refuses it"),
        ({"after": "<!DOCTYPE mujoco>"}, "it declares a document type or entities"),
        ({"after": "<open>"}, "it is not valid XML"),
        ({"inside": "<body>" * 5000 + "</body>" * 5000}, "it has more than 3000 elements, or more than 60"),
    ],
)
def test_what_is_no_arm_is_refused_in_a_sentence(tmp_path, parts, said):
    with pytest.raises(ConfigError) as refused:
        chain_of(read_model(written(tmp_path, **parts)), ArmSettings(speed=(1.0, 1.0)))
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<html/>", "its root is <html>"),
        ('<mujoco><worldbody><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>', "<freejoint>"),
        ('<mujoco><worldbody><body name="b"><joint type="free"/><geom size="0.1"/></body></worldbody></mujoco>',
         "body 'b' has a free joint"),
        ("<mujoco/>", "it has 0 joints"),
        ('<mujoco><compiler plugin="x"/></mujoco>', "its <compiler> has 'plugin'"),
        ("\x00", "it is not valid XML"),
        (urdf().replace('velocity="3.0"', 'velocity="fast"'), "velocity 'fast' of a joint is no number"),
        (urdf().replace('velocity="3.0"', ""), "the largest speed of joint 'turn' and 'shoulder' is missing"),
        (urdf().replace('effort="80"', ""), "joint 'bend', 'roll' and 'tilt' has no actuator"),
    ],
)  # fmt: skip
def test_a_file_without_an_arm_is_refused_in_a_sentence(tmp_path, text, said):
    (tmp_path / "arm.xml").write_text(text)
    with pytest.raises(ConfigError) as refused:
        chain_of(read_model(tmp_path / "arm.xml"), ArmSettings())
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("value", ["nan", "inf", "-1", "1e308", "1e400", "x"])
@pytest.mark.parametrize("place", ['mass="1"', 'diaginertia="1', 'pos="0'])
def test_a_number_of_no_arm_is_refused_or_kept(tmp_path, place, value):
    """Never an error of another kind, and never a number that is not finite."""
    name = place.partition('"')[0]
    text = written(tmp_path).read_text().replace(place, f'{name}"{value}' + ('"' if place.endswith('"') else ""))
    (tmp_path / "arm.xml").write_text(text)
    try:
        chain = chain_of(read_model(tmp_path / "arm.xml"), SETTINGS)
    except ConfigError as refused:
        assert "\n" not in str(refused)
    else:
        assert all(np.isfinite(chain.links[name]).all() for name in chain.links.dtype.names)


def test_settings_that_do_not_fit_the_arm_are_refused(tmp_path):
    file = read_model(written(tmp_path))
    with pytest.raises(ConfigError, match=r"robot\.model\.speed has 2 values, and the arm has 1 joints"):
        chain_of(file, ArmSettings(speed=(1.0, 1.0)))
    with pytest.raises(ConfigError, match="unknown tool 'cup'"):
        chain_of(file, ArmSettings(speed=(1.0,), tool="cup"))
    with pytest.raises(ConfigError, match=r"cannot read model '.*gone\.xml': No such file"):
        read_model(tmp_path / "gone.xml")
    assert chain_of(file, ArmSettings(speed=(1.0,), torque=(7.0,))).limits.torque == [7.0]
    assert chain_of(file, SETTINGS).limits.torque == [5.0]
