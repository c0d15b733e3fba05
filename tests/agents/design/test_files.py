"""Files that the page makes: the report, the shared page; and solids of a line for its scene."""

import re
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from agents import play
from agents.design import changes, films, report, shapes, share, watch
from agents.design.answers import Judge
from agents.design.assumptions import assumptions
from agents.design.level_files import line_of_text
from agents.design.session import State, opened
from agents.ground.cli import UsageError
from agents.pictures.stage import Stage
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.scene import build_scene

LINE = opened(LineConfig.load("single", name="A & B <c>"))


@pytest.fixture(scope="module")
def state():
    answer = Judge().answer(LINE, False)
    # As settled as the page's: what a report says does not depend on it.
    return State(LINE, LINE, answer=replace(answer, is_settled=True), answered=0)


def test_a_report_has_the_drawing_the_figures_and_what_they_assume(state):
    text = report.html(state)
    assert "A &amp; B &lt;c&gt;" in text and "<c>" not in text
    assert f"{100.0 * state.answer.row['recovery']:.1f} %" in text
    assert "<svg" in text and "mujoco" in text
    for sentence in assumptions(LINE):
        assert sentence.split("'")[0] in text
    assert not re.search(r"(src|href)=.http", text)


def test_a_report_waits_for_settled_figures(state):
    with pytest.raises(UsageError, match="not settled yet"):
        report.html(replace(state, answer=replace(state.answer, is_settled=False)))
    with pytest.raises(UsageError, match="not settled yet"):
        report.html(replace(state, number=1))


def test_a_pdf_needs_a_browser(monkeypatch):
    monkeypatch.setattr(report, "browser", lambda: None)
    with pytest.raises(UsageError, match="not installed"):
        report.pdf("<p>text</p>")


def test_assumptions_follow_from_the_line():
    other = changes.choose_sheet(LINE, 0, "scara_700")
    assert not any("scara_700" in sentence for sentence in assumptions(LINE))
    assert any("scara_700" in sentence for sentence in assumptions(other))


def test_a_shared_file_holds_scene_figures_and_the_level(state):
    text = share.html("<html><body><p>scene</p></body></html>", state)
    assert '<iframe srcdoc="&lt;html&gt;&lt;body&gt;&lt;p&gt;scene' in text
    assert f"{100.0 * state.answer.row['recovery']:.1f} %" in text
    (level,) = re.findall("<pre>(.*?)</pre>", text, re.DOTALL)
    unescaped = level.replace("&lt;", "<").replace("&gt;", ">").replace("&#x27;", "'").replace("&amp;", "&")
    assert line_of_text(unescaped, "x") == LINE


def test_every_drawn_geom_is_a_solid_at_its_place():
    still, model = films.Still.of(LINE), build_scene(LINE).model
    drawn = (model.geom_rgba[:, 3] > 0.0) & (model.geom_group < 3) & (model.geom_type != 0)
    groups = [*still.fixed.values(), *still.moment[films.MOVING].values()]
    assert sum(len(group.position) for group in groups) == drawn.sum()
    assert all(np.allclose(np.linalg.norm(group.wxyz, axis=1), 1.0) for group in groups if len(group.wxyz))
    assert len(still.moment[films.OBJECTS]["box"].position) > 10  # slats of the belt, and trays


def test_a_film_moves_hands_and_objects_and_ends():
    frames = list(islice(films.play(LINE, 2.0), 100))
    assert len(frames) == 2 * films.RATE
    hands = np.array([frame[films.MOVING]["cylinder"].position for frame in frames])
    assert np.ptp(hands, axis=0).max() > 0.1


@pytest.mark.parametrize("shape", ["box", "ball", "cylinder"])
def test_meshes_are_closed_and_look_outwards(shape):
    vertices, faces = shapes.mesh(shape)
    assert np.allclose(np.abs(vertices).max(axis=0), 1.0, atol=0.02)
    corners = vertices[faces]
    # The volume by the divergence theorem, positive where all triangles look outwards.
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
    expected = {"box": 8.0, "ball": 4.0 / 3.0 * np.pi, "cylinder": 2.0 * np.pi}[shape]
    assert volume == pytest.approx(expected, rel=0.08)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = edges[~np.isclose(vertices[edges[:, 0]], vertices[edges[:, 1]]).all(axis=1)]
    one_way = {tuple(np.round([*vertices[a], *vertices[b]], 6)) for a, b in edges}
    assert all((*edge[3:], *edge[:3]) in one_way for edge in one_way)


def test_a_window_shows_no_line():
    with pytest.raises(UsageError, match="--viewer web shows a line"):
        play.main(play.Arguments(env="PnTLine-v0", controller="price", viewer="native"))


def test_a_line_at_work_is_served_behind_a_token(monkeypatch, capsys):
    shown = []
    monkeypatch.setattr(films, "RATE", 1000)  # nobody waits for true time
    monkeypatch.setattr(watch.BeltScene, "show", lambda self, moment: shown.append(moment))
    frames = films.frames
    monkeypatch.setattr(films, "frames", lambda stage: islice(frames(stage), 5))
    watch.show("127.0.0.1", "fifo", lambda: Stage("fifo", "PnTLine-v0", LINE, 0, throws="flight"))
    assert len(shown) == 6  # the line at rest first
    assert re.search(r"line at http://127\.0\.0\.1:\d+/\?token=[\w-]{32}", capsys.readouterr().out)
