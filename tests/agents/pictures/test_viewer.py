"""`python -m agents.play --viewer`: the page is served, throws are shown, what differs between them is drawn beside."""

import re
import signal
import subprocess
import sys
import urllib.request
from itertools import islice
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from agents.controllers import make_controller
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import throw_batches
from agents.pictures.stage import Stage
from agents.pictures.viewer import Choice, Film, Shown, ViewerRequests, watch
from agents.play import Arguments, open_stage
from tests.tools.commands import INTERRUPTIBLE, call, environment


class Recorder:
    """Stands in for MuJoCo's viewer handle."""

    def __init__(self) -> None:
        self.model: Any = None
        self.data: Any = None
        self.models, self.shown = 0, list[Shown]()

    def set_model(self, model: Any) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self.models += 1

    def send_to_viewer(self, shown: Shown) -> None:
        self.shown.append(shown)

    def sync(self) -> None:
        mujoco.mj_forward(self.model, self.data)


@pytest.mark.parametrize(("env_id", "level"), [("PnTConveyor-v0", "waste"), ("GripperToss-v0", "nominal")])
def test_every_geom_of_a_throw_is_seen_once_and_where_it_is(env_id: str, level: str) -> None:
    env = make_vector(env_id, level, num_envs=1, threads=1)
    view, viewer = core_of(env).view(), Recorder()
    film = Film(viewer, view.camera)
    for _ in islice(throw_batches(make_controller("analytic", env), env, 9, 0), 4):
        for scene in view.scenes(4):
            film.show(scene, [])
            model, data, markers = scene
            beside = [shape.position for shape in viewer.shown[-1].shapes[len(markers) :]]
            for geom in np.flatnonzero(model.geom_rgba[:, 3] > 0.0):
                drawn = viewer.model.geom_rgba[geom, 3] > 0.0
                assert drawn != any(np.array_equal(place, data.geom_xpos[geom]) for place in beside)
                if drawn:
                    np.testing.assert_allclose(viewer.data.geom_xpos[geom], data.geom_xpos[geom], atol=1e-12)
                    np.testing.assert_array_equal(viewer.model.geom_size[geom], model.geom_size[geom])
    assert viewer.models <= 3  # a browser loads its page anew for each
    env.close()


def test_pause_and_speed_are_those_of_studio() -> None:
    from mujoco.studio import messages, sim  # noqa: PLC0415

    wishes = ViewerRequests(Choice("analytic", "waste"))
    wishes.on_step_control(messages.StepControlSnapshot(speed=25.0))
    assert wishes.speed == 0.25
    wishes.on_step_control(messages.StepControlSnapshot(pause_state=sim.PauseState.NORMAL_PAUSED))
    assert wishes.speed == 0.0


def test_a_page_is_served_until_it_is_stopped(tmp_path: Path) -> None:
    command = [sys.executable, "-u", "-c", INTERRUPTIBLE, "--viewer", "web", "--level", "waste"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=tmp_path, env=environment(), **pipes) as running:
        try:
            lines = iter(running.stdout.readline, "")
            address = next(found[0] for line in lines if (found := re.search(r"http://localhost:\d+/", line)))
            next(line for line in lines if "Model changed" in line)
            with urllib.request.urlopen(address, timeout=60) as page:
                assert b"<canvas" in page.read()
            running.send_signal(signal.SIGINT)
            _, told = running.communicate(timeout=60)
        finally:
            running.kill()
    assert "Traceback" not in told
    assert running.returncode == 130


def test_a_window_needs_a_display(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    done = call("agents.play", "--viewer", "native", folder=tmp_path)
    assert done.returncode == 2
    assert "--viewer web" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_choice_that_cannot_be_is_told_and_the_one_before_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    viewer = Recorder()

    class Launched:
        """Asks for a controller that does not exist, then for another level, then is closed."""

        def __init__(self, _: Any, plugins: list[Any]) -> None:
            self._wishes = plugins[-1]

        def __enter__(self) -> Any:
            return self

        def __exit__(self, *_: object) -> None: ...

        def __getattr__(self, name: str) -> Any:
            return getattr(viewer, name)

        def is_running(self) -> bool:
            asked = {5: Choice("nobody", "waste"), 10: Choice("analytic", "unseen")}.get(len(viewer.shown))
            if asked is not None:
                self._wishes.on_choice(asked)
            return len(viewer.shown) < 15

    monkeypatch.setattr("agents.pictures.viewer.launch_passive.launch", Launched)
    arguments = Arguments(env="PnTConveyor-v0", level="waste", viewer="web")
    made: list[Stage] = []

    def make(choice: Choice) -> Stage:
        made.append(open_stage(arguments, choice.controller, choice.level))
        return made[-1]

    watch(make, Choice("analytic", "waste"), "web")
    assert [stage.core.config.name for stage in made] == ["waste", "unseen"]
    assert "nobody" in viewer.shown[7].lines[-1]
    assert viewer.shown[-1].lines[-1] == ""
