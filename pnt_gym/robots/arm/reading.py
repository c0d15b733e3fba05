"""A stranger's model file as numbers: nothing outside its folder is read, and nothing of it runs.

The file is taken apart before the engine sees it. Only elements that describe bodies, joints, shapes and motors are let
through; meshes are read here, from the folder of the file, and given to the engine from memory.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final, final
from xml.etree import ElementTree

from pnt_gym.engine import MjModel, mujoco, mute_warnings
from pnt_gym.errors import ConfigError, one_sentence
from pnt_gym.names import list_names
from pnt_gym.reading import ReadError, text_of
from pnt_gym.reading.files import bytes_of

MOST_TEXT: Final = 2**21
"""Bytes of a model file."""
MOST_PARTS: Final = 3000
"""Elements of a model file."""
DEEPEST: Final = 60
"""Elements within one another."""
MOST_MESH: Final = 2**24
"""Bytes of a mesh."""
MOST_MESHES: Final = 200
"""Meshes of a model."""
MESH_FORMS: Final = (".stl", ".obj", ".msh")
"""Forms of meshes that the engine reads."""
PARTS: Final = frozenset((
    "mujoco", "compiler", "default", "asset", "mesh", "worldbody", "body", "frame", "geom", "joint", "site", "inertial",
    "actuator", "motor", "position", "velocity", "intvelocity", "damper", "general",
    "robot", "link", "origin", "mass", "inertia", "collision", "geometry", "box", "cylinder", "sphere", "parent",
    "child", "axis", "limit", "dynamics",
))  # fmt: skip
"""Elements of an MJCF and of a URDF that are let through; each language refuses the other's itself."""
LEFT_OUT: Final = frozenset((
    "camera", "light", "sensor", "keyframe", "visual", "option", "size", "statistic", "contact", "material", "texture",
    "transmission", "gazebo", "safety_controller", "calibration",
))  # fmt: skip
"""Elements that say nothing of an arm's motion; they are left out with all that is in them."""
FOLDERS: Final = ("meshdir", "texturedir", "assetdir", "strippath")
"""Attributes of `compiler` that say where files are."""
COMPILER: Final = frozenset((
    "angle", "autolimits", "balanceinertia", "boundmass", "boundinertia", "coordinate", "discardvisual", "eulerseq",
    "fitaabb", "inertiafromgeom", "inertiagrouprange", "settotalmass", "alignfree", "saveinertial", "fusestatic",
))  # fmt: skip
"""Attributes of `compiler` that are let through, beside `FOLDERS`."""


@final
@dataclass(frozen=True)
class ModelFile:
    """A model file as the engine understands it."""

    model: MjModel
    speeds: dict[str, float]
    """Largest speeds of joints, by their names [rad/s, m/s]: those that a URDF states."""
    parts: dict[str, bytes]
    """Content of the file and of its meshes, by names."""


def read_model(path: str | Path) -> ModelFile:
    """Read an MJCF or URDF.

    Raises:
        ConfigError: the file or a mesh cannot be read, lies outside the folder, or is no model; or the file has parts
            that are no arm's.
    """
    place = Path(path)
    try:
        text = text_of(place, MOST_TEXT, "XML")
    except ReadError as error:
        raise ConfigError(f"cannot read model {str(path)!r}: {error}") from None
    try:
        return _compiled(text, place.parent)
    except ConfigError as error:
        raise ConfigError(f"model {place.name!r}: {error}") from None


def _compiled(text: str, folder: Path) -> ModelFile:
    if "<!" in text.replace("<!--", ""):
        raise ConfigError("it declares a document type or entities, which are not read")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ConfigError(f"it is not valid XML: {error}") from None
    if root.tag not in ("mujoco", "robot"):
        raise ConfigError(f"its root is <{one_sentence(root.tag, 40)}>; an MJCF has <mujoco>, a URDF <robot>")
    _check_size(root)
    _leave_out(root)
    if strange := sorted({str(part.tag) for part in root.iter()} - PARTS):
        raise ConfigError(
            f"it has {list_names([f'<{one_sentence(tag, 40)}>' for tag in strange])}; an arm is made of bodies, "
            "hinges, slides, shapes and motors in one file"
        )
    meshes = _take_meshes(root, folder)
    speeds = dict(_speeds(root))
    _set_compiler(root)
    model = _engine_model(ElementTree.tostring(root, encoding="unicode"), tuple(meshes.items()))
    return ModelFile(model, speeds, {"model": text.encode(), **meshes})


@lru_cache(maxsize=8)
def _engine_model(text: str, meshes: tuple[tuple[str, bytes], ...]) -> MjModel:
    """The engine's model, made once of the same text and meshes."""
    try:
        with mute_warnings():
            return mujoco.MjSpec.from_string(text, assets=dict(meshes)).compile()
    except (ValueError, KeyError) as error:
        raise ConfigError(f"the engine refuses it: {one_sentence(error, 200)}") from None


def _check_size(root: ElementTree.Element) -> None:
    """Make sure that neither this module nor the engine drowns in elements.

    Raises:
        ConfigError: there are too many, or they stand too deep in one another.
    """
    layer, count, depth = [root], 0, 0
    while layer:
        count, depth = count + len(layer), depth + 1
        if count > MOST_PARTS or depth > DEEPEST:
            raise ConfigError(f"it has more than {MOST_PARTS} elements, or more than {DEEPEST} within one another")
        layer = [part for element in layer for part in element]


def _leave_out(element: ElementTree.Element) -> None:
    """Remove what says nothing of an arm's motion, at any depth."""
    for part in list(element):
        # A material of a URDF's shape, too; a class of defaults may hold the others.
        if part.tag in LEFT_OUT:
            element.remove(part)
        else:
            _leave_out(part)
    for name in ("material", "texture"):
        element.attrib.pop(name, None)


def _take_meshes(root: ElementTree.Element, folder: Path) -> dict[str, bytes]:
    """Contents of the meshes by names that the elements have from now on."""
    compiler = root.find("compiler") if root.tag == "mujoco" else root.find("mujoco/compiler")
    given = {} if compiler is None else compiler.attrib
    inner = "" if root.tag == "robot" else given.get("meshdir", given.get("assetdir", ""))
    meshes = dict[str, bytes]()
    for part in root.iter():
        for key in [key for key in part.attrib if "file" in key.lower() or key == "content_type"]:
            if part.tag != "mesh" or key not in ("file", "filename"):
                raise ConfigError(f"<{part.tag}> reads a file by {key!r}; meshes alone are read")
            name = part.attrib[key]
            if len(meshes) == MOST_MESHES:
                raise ConfigError(f"it has more than {MOST_MESHES} meshes")
            kept = f"mesh_{len(meshes)}{Path(name).suffix.lower()}"
            meshes[kept] = _mesh(name, folder, inner)
            if part.tag == "mesh" and key == "file" and "name" not in part.attrib:
                part.set("name", Path(name).stem)  # by which shapes refer to it
            part.set(key, kept)
    return meshes


def _mesh(name: str, folder: Path, inner: str) -> bytes:
    """Content of a mesh within the folder."""
    said = one_sentence(repr(name), 100)
    relative = name.removeprefix("package://").removeprefix("file://")
    if Path(name).suffix.lower() not in MESH_FORMS:
        raise ConfigError(f"mesh {said} is none of {list_names(MESH_FORMS)}")
    home, place = folder.resolve(), (folder / inner / relative).resolve()
    if not place.is_relative_to(home):
        raise ConfigError(f"mesh {said} lies outside the folder of the model; put it there")
    try:
        return bytes_of(place, MOST_MESH)
    except ReadError as error:
        raise ConfigError(f"cannot read mesh {said}: {error}") from None


def _speeds(root: ElementTree.Element) -> Iterator[tuple[str, float]]:
    """Names of joints and their largest speeds in a URDF."""
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        value = None if limit is None else limit.get("velocity")
        if value is None:
            continue
        try:
            yield joint.get("name", ""), float(value)
        except ValueError:
            raise ConfigError(f"velocity {one_sentence(repr(value), 40)} of a joint is no number") from None


def _set_compiler(root: ElementTree.Element) -> None:
    """Let the engine look for no folder, and keep bodies without joints, of which one may be the tool."""
    if root.tag == "robot":
        holder = root.find("mujoco")
        holder = ElementTree.SubElement(root, "mujoco") if holder is None else holder
    else:
        holder = root
    compiler = holder.find("compiler")
    if compiler is None:
        compiler = ElementTree.Element("compiler")
        holder.insert(0, compiler)
    for name in FOLDERS:
        compiler.attrib.pop(name, None)
    if strange := sorted(set(compiler.attrib) - COMPILER):
        raise ConfigError(f"its <compiler> has {list_names(strange)}, which no arm needs")
    compiler.set("fusestatic", "false")
