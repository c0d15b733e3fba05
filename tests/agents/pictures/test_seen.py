"""What the camera sees beside a throw: the object that is thrown, its map, and the place of the cup."""

from itertools import islice

import numpy as np
import pytest

from agents.pictures import places
from agents.pictures.places import examples
from agents.pictures.seen import CHOSEN, SeenView, colour_map
from agents.pictures.stage import Stage
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.observation import TABLE

LEVEL = GraspConfig.load({"base": "grasp", "fidelity": "flight"})


@pytest.mark.parametrize(("controller", "panels"), [("flattest", 3), ("local_mlp", 3), ("centre", 2), ("analytic", 2)])
def test_the_last_grasp_is_kept_with_its_picture_and_its_map(controller, panels):
    stage = Stage(controller, "PnTGrasp-v0", LEVEL, 3)
    try:
        inner, looks = stage.seen._controller.act, []
        stage.seen._controller.act = lambda observation: looks.append(observation) or inner(observation)
        next(stage.steps)
        grasp = stage.seen.grasp
        last = [look for look in looks if TABLE.decode(look.features[0])["holds"] < 0.5][-1]
        np.testing.assert_array_equal(grasp.image, last.image[0])
        pictures = grasp.panels(96)
        assert [picture.shape for picture in pictures] == [(96, 96, 3)] * panels
        x, y = grasp.place / 0.005 + 23.5, 23.5 - grasp.place / 0.005
        at = pictures[0][round(2 * y[1] + 1), round(2 * x[0] + 1)]
        np.testing.assert_array_equal(at, CHOSEN)
    finally:
        stage.close()


def test_panels_stand_at_the_right_of_the_frame():
    class Still:
        def last_throw(self, fps):
            return [np.full((120, 200, 3), 9, dtype=np.uint8)]

    stage = Stage("flattest", "PnTGrasp-v0", LEVEL, 3)
    try:
        list(islice(stage.steps, 1))
        (frame,) = SeenView(Still(), stage.seen).last_throw()
    finally:
        stage.close()
    assert frame.shape == (120, 240, 3)
    assert (frame[:, :200] == 9).all()
    np.testing.assert_array_equal(frame[40:80, 200:], stage.seen.grasp.panels(40)[1])


def test_a_map_is_black_beside_the_object_and_brightest_at_its_best_place():
    scores = np.full((48, 48), np.nan)
    scores[10:20, 10:30] = np.linspace(0.1, 0.9, 200).reshape(10, 20)
    colours = colour_map(scores)
    assert not colours[:10].any()
    assert tuple(colours[19, 29]) == (253, 231, 37)


def test_examples_show_a_place_that_a_rule_misses_and_a_network_finds():
    seen = examples()
    rows = dict(places.objects(seen))
    row = rows["the rule fails"]
    assert seen.worth("rule")[row] < 0.3
    assert seen.worth("network")[row] > 0.8
    assert len(rows) == 3
    assert len({int(seen.scenes.objects.kind[row]) for row in rows.values()}) == 3
