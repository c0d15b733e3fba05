"""The look of all pictures: textures, shapes, finishes and light, which only pictures know.

A renderer draws with the textures and shapes of a model that holds nothing else, so the model of the physics stays as
it is: geoms get their finishes in the list of what is drawn. A geom's colour names its finish, see `palette`.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.base.solids import SOLIDS, TexturedSolid
from pnt_gym.cells.base.textures import SIDE, TEXTURES, Texture
from pnt_gym.engine import MjData, MjModel, MjSpec, mujoco
from pnt_gym.palette import BY_SHAPE, CLEAR, FINISHES, GLASS, ITEMS, PLAIN, SKY, STYLES, Finish, bin_colour

PERIODS: Final = {"belt": 0.40, "floor": 1.0, "board": 0.10, "wood": 0.5}
"""Sides of textures that are laid on in their true size [m]; other textures are stretched over a whole shape."""
AMBIENT: Final = 0.42
"""Light from everywhere, as a share of the brightest."""
SUN: Final = 0.50, 0.18
"""Strengths of the two lights that throw shadows: a lamp, and one of the places of a wide ceiling."""
COARSE: Final = 1024
"""Side of the map of shadows in each of many drawings [pixels]."""
HALL: Final = 24.0
"""Half of the drawn floor's side [m]."""
SLANT: Final = np.array([-0.34, 0.42, -1.0])
"""Direction of the lamp's light."""
SPREAD: Final = 0.16, 0.8
"""Half widths of both lights, as tangents: the lamp and the ceiling; shadows are soft in a picture of many samples."""
RIM: Final = 0.006
"""Half height of the opaque rim on the walls of clear bins [m]."""
_BOX, _CYLINDER, _ELLIPSOID, _SPHERE, _MESH, _PLANE = (
    int(getattr(mujoco.mjtGeom, f"mjGEOM_{name}").value)
    for name in ("BOX", "CYLINDER", "ELLIPSOID", "SPHERE", "MESH", "PLANE")
)
_GEOM: Final = int(mujoco.mjtObj.mjOBJ_GEOM.value)
_SHAPES: Final = {_BOX: "box", _CYLINDER: "cylinder", _ELLIPSOID: "ellipsoid", _SPHERE: "sphere"}
_LONG: Final = 5.0
"""A box longer than this, in its least half extents, keeps its sharp edges: stretched round ones would look bent."""
_MATERIALS: Final = tuple(TEXTURES)
_SOLIDS: Final = tuple(SOLIDS)


@cache
def _texture(name: str) -> Texture:
    return TEXTURES[name]()


@cache
def _solid(name: str) -> TexturedSolid:
    return SOLIDS[name]()


def style(name: str, shape: str) -> Finish:
    """Finish of an item, by the words of its name, else by its shape."""
    words = set(name.split("_")) | {name}
    found = [key for key in STYLES if key in words or key == name]
    return STYLES[max(found, key=lambda key: (key == name, len(key)))] if found else BY_SHAPE[shape]


def write_shape(geom: Any, kind: int, *shape: Any) -> None:
    """Make one of MuJoCo's abstract geoms a shape of no model, by type, extents, position, frame and colour."""
    mujoco.mjv_initGeom(geom, kind, *shape)
    geom.objid, geom.objtype = -1, int(mujoco.mjtObj.mjOBJ_UNKNOWN)  # MuJoCo leaves here what was there before


def add_shape(scene: Any, kind: int, *shape: Any) -> None:
    """Add a shape of no model to a scene, if there is room for it."""
    if scene.ngeom < scene.maxgeom:
        write_shape(scene.geoms[scene.ngeom], kind, *shape)
        scene.ngeom += 1


@final
class SceneLook:
    """Textures and shapes for pictures of one model, and how the model's geoms look.

    Args:
        model: model of the physics; other models of the same layout look the same.
        size: height and width of a picture [pixels].
        items: names of the items, in the order of their colours.
        reach: distance of a picture's middle [m]; what is 1.5 to 6 times as far away fades into the hall.
        is_mean: whether a picture is the mean of many drawings.
    """

    def __init__(
        self, model: MjModel, size: tuple[int, int], items: Sequence[str], reach: float, *, is_mean: bool = False
    ) -> None:
        self._items, self._own = items, int(model.nmesh)
        self.model = _look_model(model, size, reach)
        if is_mean:  # of many drawings, which are smooth together
            quality = self.model.vis.quality
            quality.offsamples, quality.shadowsize = 0, min(int(quality.shadowsize), COARSE)
        self._kinds = {_key(colour): kind for kind, colour in enumerate(ITEMS)}
        self._bins = {_key(bin_colour(kind)): kind for kind in range(len(ITEMS))}
        self._finishes = {_key(colour): finish for colour, finish in FINISHES.items()}

    def dress(self, scene: Any, model: MjModel, own: int) -> None:
        """Give every geom in a scene its finish, and clear bins their rims; the first `own` geoms are the model's."""
        rims: list[tuple[Any, ...]] = []
        for index in range(scene.ngeom):
            geom = scene.geoms[index]
            colour = model.geom_rgba[geom.objid] if index < own and geom.objtype == _GEOM else geom.rgba
            if geom.matid >= 0:  # of the model's own material, which this look does not know
                geom.matid = -1
                _polish(geom, PLAIN)
                continue
            if geom.type == _PLANE:
                geom.size[:], geom.castshadow = HALL, 0
            key = _key(colour)
            if key[3] < 1.0:
                geom.rgba[:3] = self._tint(key)
                if abs(key[3] - CLEAR) < 0.01 and geom.type == _BOX:
                    rims += _clear(geom)
                _polish(geom, GLASS)
                continue
            finish = self._finishes.get(key)
            if finish is None and key in self._kinds:
                kind, shape = self._kinds[key], _SHAPES.get(int(geom.type), "box")
                finish = style(self._items[kind] if kind < len(self._items) else "", shape)
            self._finish(geom, finish or PLAIN)
        for rim in rims:
            add_shape(scene, _BOX, *rim)

    def move_belt(self, model: MjModel, data: MjData) -> bool:
        """Shift the belt's texture to where the belt is by now; False if nothing moves."""
        moves = np.flatnonzero(np.abs(model.geom_surfacevel[:, :2]).max(axis=1) > 0.0)
        if moves.size == 0:
            return False
        way = model.geom_surfacevel[moves[0], :2] * float(data.time)
        x, y = np.rint(way / PERIODS["belt"] * SIDE).astype(int) % SIDE
        texture = _texture("belt")
        if abs(way[0]) < abs(way[1]):  # its seams run across the way
            texture = np.swapaxes(texture, 0, 1)
        _write_texture(self.model, "belt", np.roll(texture, (-y, x), axis=(0, 1)))
        return True

    def _tint(self, key: tuple[float, ...]) -> tuple[float, ...]:
        """Colour of what is clear: a bin for an item is like the item."""
        kind = self._bins.get(key)
        tint = style(self._items[kind], "box").tint if kind is not None and kind < len(self._items) else None
        return key[:3] if tint is None else tint

    @property
    def belt(self) -> int:
        """Index of the belt's texture."""
        return int(self.model.texture("belt").id)

    def _finish(self, geom: Any, finish: Finish) -> None:
        """Give a geom a finish: highlights, a texture, and another shape."""
        _polish(geom, finish)
        if finish.texture:
            geom.matid = _MATERIALS.index(finish.texture)
            geom.rgba[:3] = 1.0
        if finish.solid and int(geom.type) in _SHAPES:
            if int(geom.type) == _BOX and max(geom.size) > _LONG * sorted(geom.size)[1] and not finish.texture:
                return
            size = np.array(geom.size)
            if finish.solid == "block" and int(geom.type) != _BOX:
                return
            geom.mat[:] = np.asarray(geom.mat).reshape(3, 3) * size
            geom.type, geom.dataid, geom.texcoord = _MESH, 2 * (self._own + _SOLIDS.index(finish.solid)), 1


def light(scene: Any, sample: float, reach: float) -> None:
    """Set the lights of a scene: a lamp and a ceiling that throw shadows, and light from everywhere.

    Args:
        scene: a mujoco.MjvScene.
        sample: number of the sample in a picture of many, as a share of all; the lights of each are elsewhere.
        reach: distance from the middle of the picture within which shadows fall [m].
    """
    turn, ring = 2.0 * np.pi * 0.618 * 13.0 * sample, np.sqrt((sample * 7.0 + 0.5) % 1.0)
    disc = ring * np.array([np.cos(turn), np.sin(turn), 0.0])
    middle = np.asarray(scene.camera[0].pos) + np.asarray(scene.camera[0].forward) * reach
    scene.nlight = 3
    for number, (slant, strength) in enumerate(
        ((SLANT + SPREAD[0] * disc, SUN[0]), (np.array([0.0, 0.0, -1.0]) + SPREAD[1] * disc[[1, 0, 2]], SUN[1]))
    ):
        lamp, way = scene.lights[number], slant / np.linalg.norm(slant)
        lamp.type, lamp.castshadow, lamp.headlight = int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL.value), 1, 0
        lamp.pos[:], lamp.dir[:] = middle - 4.0 * way, way
        lamp.ambient[:], lamp.diffuse[:], lamp.specular[:] = 0.0, strength, strength
    fill = scene.lights[2]
    fill.type, fill.castshadow, fill.headlight = int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL.value), 0, 0
    fill.pos[:], fill.dir[:] = scene.camera[0].pos, scene.camera[0].forward
    fill.ambient[:], fill.diffuse[:], fill.specular[:] = AMBIENT, 0.10, 0.0


def _look_model(model: MjModel, size: tuple[int, int], reach: float) -> MjModel:
    """A model of nothing but the sky, the textures, the model's own meshes and all shapes."""
    spec = mujoco.MjSpec()
    spec.visual.global_.offheight, spec.visual.global_.offwidth = size
    spec.visual.quality.shadowsize = model.vis.quality.shadowsize
    spec.visual.quality.offsamples = model.vis.quality.offsamples
    spec.stat.extent, spec.stat.center = model.stat.extent, model.stat.center
    spec.visual.map.shadowclip = 1.0
    spec.visual.map.fogstart, spec.visual.map.fogend = np.array([1.5, 6.0]) * reach / model.stat.extent
    spec.visual.rgba.fog = (*SKY[0], 1.0)
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=list(SKY[0]), rgb2=list(SKY[1]), width=128, height=768,
    )  # fmt: skip
    for name in _MATERIALS:
        flat = mujoco.mjtBuiltin.mjBUILTIN_FLAT
        spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=flat, width=SIDE, height=SIDE)
        repeat = 1.0 / PERIODS[name] if name in PERIODS else 1.0
        material = spec.add_material(name=name, texrepeat=[2.0 * repeat] * 2 if name in PERIODS else [1.0, 1.0])
        material.texuniform = name in PERIODS
        material.textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB.value)] = name
    for _ in np.flatnonzero(model.geom_type == _PLANE):  # a drawn plane is one of the renderer's model
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[HALL, HALL, HALL / 8])
    solids = [*(_own_solid(model, mesh) for mesh in range(model.nmesh)), *map(_solid, _SOLIDS)]
    for number, solid in enumerate(solids):
        _add_mesh(spec, f"solid_{number}", solid)
    look: MjModel = spec.compile()
    for name in _MATERIALS:
        _write_texture(look, name, _texture(name))
    for number, solid in enumerate(solids):  # the compiler turns a mesh into its axes of inertia
        vertex, normal = int(look.mesh_vertadr[number]), int(look.mesh_normaladr[number])
        look.mesh_vert[vertex : vertex + len(solid.vertices)] = solid.vertices
        look.mesh_normal[normal : normal + len(solid.normals)] = solid.normals
    return look


def _add_mesh(spec: MjSpec, name: str, solid: TexturedSolid) -> None:
    mesh, faces = spec.add_mesh(name=name), solid.faces.ravel()
    mesh.uservert, mesh.usernormal = solid.vertices.ravel(), solid.normals.ravel()
    mesh.usertexcoord, mesh.userface = solid.texture.ravel(), faces
    mesh.userfacenormal = mesh.userfacetexcoord = faces
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, contype=0, conaffinity=0)


def _own_solid(model: MjModel, mesh: int) -> TexturedSolid:
    """A mesh of a model, with a normal for each corner of each triangle."""
    first, face = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    corners = model.mesh_face[face : face + int(model.mesh_facenum[mesh])].ravel() + first
    vertices = model.mesh_vert[corners].astype(np.float64)
    a, b, c = (vertices[k::3] for k in range(3))
    normals = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return TexturedSolid(vertices, normals, np.zeros((len(vertices), 2)), np.arange(len(vertices)).reshape(-1, 3))


def _clear(geom: Any) -> list[tuple[Any, ...]]:
    """Rims of a wall of a clear bin; a bin's bottom becomes opaque."""
    size, rgba = np.array(geom.size, dtype=np.float64), np.array(geom.rgba, dtype=np.float32)
    rgba[3] = 1.0
    if size[2] <= min(size[:2]):
        geom.rgba[3], geom.transparent = 1.0, 0
        return []
    frame = np.array(geom.mat, dtype=np.float64)
    middle = np.asarray(geom.pos) + frame.reshape(3, 3)[:, 2] * (size[2] - RIM)
    return [(np.array([size[0] + 0.001, size[1] + 0.001, RIM]), middle, frame.ravel(), rgba)]


def _polish(geom: Any, finish: Finish) -> None:
    geom.specular, geom.shininess, geom.emission, geom.reflectance = finish.specular, finish.shininess, finish.glow, 0.0


def _write_texture(model: MjModel, name: str, texture: NDArray[np.uint8]) -> None:
    first = int(model.tex_adr[model.texture(name).id])
    model.tex_data[first : first + texture.size] = texture.ravel()


def _key(colour: Any) -> tuple[float, ...]:
    return tuple(round(float(value), 3) for value in colour)
