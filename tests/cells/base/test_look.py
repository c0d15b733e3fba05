"""The look of pictures: what is drawn by numbers, the finish of a geom, and that the physics knows nothing of it."""

import mujoco
import numpy as np
import pytest

from pnt_gym.cells.base.catalogue import CATALOGUE
from pnt_gym.cells.base.items import SHAPES
from pnt_gym.cells.base.look import PERIODS, SceneLook, add_shape, style
from pnt_gym.cells.base.solids import SOLIDS
from pnt_gym.cells.base.textures import SIDE, TEXTURES
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.conveyor.view import camera
from pnt_gym.palette import BY_SHAPE, FINISHES, ITEMS, STYLES
from tests.tools.throws import make_core, same_bits

SMALL = (90, 160)


@pytest.mark.parametrize("name", TEXTURES)
def test_a_texture_is_drawn_the_same_again_and_is_not_plain(name):
    texture = TEXTURES[name]()
    assert texture.shape == (SIDE, SIDE, 3)
    assert texture.dtype == np.uint8
    assert same_bits(texture, TEXTURES[name]())
    assert texture.reshape(-1, 3).std(axis=0).max() > 1.0


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_fills_its_cube_and_its_normals_look_outwards(name):
    solid = SOLIDS[name]()
    assert np.abs(solid.vertices).max() <= 1.0 + 1e-9
    assert solid.texture.min() >= -1e-9
    assert solid.texture.max() <= 1.0 + 1e-9
    lengths = np.linalg.norm(solid.normals, axis=1)
    assert np.all((np.abs(lengths - 1.0) < 1e-6) | (lengths == 0.0))
    corners = solid.vertices[solid.faces]
    volume = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
    assert 0.0 < volume <= 8.0, "its triangles are turned inside out"
    if "crumpled" not in name:
        np.testing.assert_allclose(np.abs(solid.vertices[:, 2]).max(), 1.0)
        np.testing.assert_allclose(np.abs(solid.vertices[:, :2]).max(), 1.0)


def test_every_finish_names_what_there_is():
    for finish in (*FINISHES.values(), *STYLES.values(), *BY_SHAPE.values()):
        assert finish.texture in ("", *TEXTURES)
        assert finish.solid in ("", *SOLIDS)
    assert set(SHAPES) <= set(BY_SHAPE)
    assert set(PERIODS) <= set(TEXTURES)


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_item_of_the_catalogue_has_a_texture_or_its_own_colour(name):
    item = CATALOGUE[name]
    assert style(name, item.shape) in STYLES.values()


def test_the_longest_word_of_a_name_decides_and_an_unknown_name_has_its_shape():
    assert style("can_crushed", "box") == STYLES["crushed"]
    assert style("foil_tray", "box") == STYLES["foil_tray"]
    assert style("my_can", "cylinder") == STYLES["can"]
    assert style("candle", "cylinder") == BY_SHAPE["cylinder"]


@pytest.fixture(scope="module")
def core():
    core = make_core("nominal", 1, picks="belt", seed=2)
    core.cell.view()
    core.step(np.zeros((1, 2)))
    return core


def test_the_belts_texture_moves_with_the_belt_and_is_back_after_a_period(core):
    recording = core.cell.plant.recording
    model, data = recording.model, mujoco.MjData(recording.model)
    look = SceneLook(model, SMALL, core.item_names, 2.0)
    first = int(look.model.tex_adr[look.belt])
    speed, shown = core.config.belt.speed, []
    for way in (0.0, 0.25 * PERIODS["belt"], PERIODS["belt"]):
        data.time = way / speed
        assert look.move_belt(model, data)
        shown.append(look.model.tex_data[first : first + 3 * SIDE**2].reshape(SIDE, SIDE, 3).copy())
    still, quarter, round_ = shown
    assert same_bits(quarter, np.roll(still, SIDE // 4, axis=1))
    assert same_bits(round_, still)
    assert not same_bits(quarter, still)


def test_a_look_has_nothing_that_moves(core):
    look = SceneLook(core.cell.plant.recording.model, SMALL, core.item_names, 2.0)
    assert look.model.nv == 0
    assert look.model.nmesh == len(SOLIDS)
    assert core.cell.plant.recording.model.nmesh == core.cell.plant.recording.model.ntex - 1 == 0


def test_a_shape_of_no_model_forgets_what_stood_in_its_place():
    scene = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), 1)
    scene.geoms[0].objid, scene.geoms[0].objtype = 7, int(mujoco.mjtObj.mjOBJ_GEOM)
    shape = np.ones(3), np.zeros(3), np.eye(3).ravel(), np.ones(4, dtype=np.float32)
    for _ in range(2):  # there is room for one
        add_shape(scene, int(mujoco.mjtGeom.mjGEOM_BOX), *shape)
    assert scene.ngeom == 1
    assert (scene.geoms[0].objid, scene.geoms[0].objtype) == (-1, int(mujoco.mjtObj.mjOBJ_UNKNOWN))


@pytest.mark.usefixtures("opengl")
def test_a_picture_of_many_samples_is_smooth_and_changes_no_byte_of_the_physics(core):
    model = core.cell.plant.recording.model
    model.vis.quality.shadowsize, model.vis.quality.offsamples = 256, 0
    before = {name: np.copy(getattr(model, name)) for name in ("geom_rgba", "geom_size", "geom_matid", "mat_rgba")}
    view = ThrowView(core.cell, camera(), size=SMALL)
    rough = view.at(0.3)
    view._canvas.samples = 8
    fine = view.at(0.3)
    assert all(same_bits(values, getattr(model, name)) for name, values in before.items())
    steps = [np.abs(np.diff(frame.astype(float), axis=1)).max(axis=2) for frame in (rough, fine)]
    assert (steps[1] > 60).sum() < 0.8 * (steps[0] > 60).sum()
    assert abs(rough.mean() - fine.mean()) < 12.0
    assert same_bits(fine, view.at(0.3))
    view.close()


@pytest.mark.usefixtures("opengl")
def test_the_object_is_drawn_as_its_item(core):
    """The geom of the thrown object becomes the solid of its style, stretched to the geom's own size."""
    view = ThrowView(core.cell, camera(), size=SMALL)
    view.at(0.3)
    recording = core.cell.plant.recording
    geom = recording.model.geom("object").id
    kind = int(np.abs(ITEMS - recording.model.geom_rgba[geom]).sum(axis=1).argmin())
    scene = view._canvas._renderer.scene
    (drawn,) = [g for g in scene.geoms[: scene.ngeom] if g.objid == geom and g.objtype == int(mujoco.mjtObj.mjOBJ_GEOM)]
    shape = {int(mujoco.mjtGeom.mjGEOM_BOX): "box", int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder"}
    wanted = style(core.item_names[kind], shape.get(int(recording.model.geom_type[geom]), "ellipsoid"))
    assert drawn.type == int(mujoco.mjtGeom.mjGEOM_MESH)
    assert drawn.dataid == 2 * list(SOLIDS).index(wanted.solid)
    assert drawn.matid == list(TEXTURES).index(wanted.texture)
    size = np.linalg.norm(np.array(drawn.mat, dtype=float).reshape(3, 3), axis=0)
    own = recording.model.geom_size[geom].copy()
    if shape.get(int(recording.model.geom_type[geom])) == "cylinder":
        own = own[[0, 0, 1]]
    np.testing.assert_allclose(size, own, rtol=1e-4)
    view.close()
