"""`python -m agents.play --viewer`: the page is served, throws are shown, what differs between them is drawn beside."""

import asyncio
import contextlib
import random
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from agents.controllers import make_controller
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import throw_batches
from agents.pictures.stage import Stage
from agents.pictures.viewer import Choice, Film, Shown, ViewerRequests, watch
from agents.play import Arguments, open_stage
from tests.tools.commands import INTERRUPTIBLE, call_here, environment
from tests.tools.nightly import with_nightly
from tests.tools.page import GREETING, STILL, listening, random_message, request, status


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


@dataclass(frozen=True)
class Page:
    """The page of a running `play --viewer web`."""

    running: subprocess.Popen[str]
    port: int

    @property
    def memory(self) -> int:
        """Memory of the process [kB]."""
        return int(re.findall(r"VmRSS:\s+(\d+)", Path(f"/proc/{self.running.pid}/status").read_text())[0])

    @property
    def hosted(self) -> str:
        return f"127.0.0.1:{self.port}"

    def socket(self, path: str, **settings: Any) -> connect:
        origin = f"http://{self.hosted}"
        return connect(f"ws://{self.hosted}{path}", origin=origin, max_size=None, ping_interval=None, **settings)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A page that is served, whoever visits it, until Ctrl-C ends it without a traceback."""
    command = [sys.executable, "-u", "-c", INTERRUPTIBLE, "--viewer", "web", "--level", "waste"]
    folder = tmp_path_factory.mktemp("page")
    with (folder / "told").open("w+") as told:
        pipes = {"stdout": subprocess.PIPE, "stderr": told, "text": True}
        with subprocess.Popen(command, cwd=folder, env=environment(), **pipes) as running:
            try:
                lines = iter(running.stdout.readline, "")
                port = next(
                    found[1] for line in lines if (found := re.search(r"page at http://localhost:(\d+)/", line))
                )
                next(line for line in lines if "Model changed" in line)
                threading.Thread(target=lambda: [None for _ in lines], daemon=True).start()
                yield Page(running, int(port))
                running.send_signal(signal.SIGINT)
                running.wait(timeout=60)
            finally:
                running.kill()
        assert "Traceback" not in (folder / "told").read_text()
        assert running.returncode == 130


async def _steers(page: Page) -> bool:
    """Whether the page's panels are drawn for a browser that takes control, and whether throws go on."""
    name = f"owner{time.monotonic_ns()}"
    async with page.socket(f"/state?sid={name}") as state, asyncio.timeout(60):
        await state.send("force_control")
        while await state.recv() != "grant":
            pass
        async with page.socket(f"/ui?sid={name}") as panels:
            await panels.send(GREETING)
            await panels.send(STILL)
            drawn = len(await panels.recv())
            while drawn < 10_000:
                drawn += len(await panels.recv())
        return len({await _payload(state) for _ in range(10)}) > 5


async def _payload(state: Any) -> bytes:
    """The next state of the simulation that a browser is shown."""
    while isinstance(message := await state.recv(), str):
        pass
    await state.send("state_ack")
    return message


def test_the_page_is_served_to_this_machine_alone(page: Page) -> None:
    assert listening(page.running.pid) == {"127.0.0.1"}
    with urllib.request.urlopen(f"http://{page.hosted}/", timeout=60) as answer:
        assert b"<canvas" in answer.read()
    assert asyncio.run(_steers(page))
    for path in ("/ui", "/state", "/drop"):
        assert status(page.port, request(f"{path}?sid=a", f"Host: {page.hosted}", "Origin: http://evil.example")) == 403
    assert status(page.port, request("/drop?sid=a", f"Host: {page.hosted}", f"Origin: http://{page.hosted}")) == 403


async def _watch_a_while(page: Page, name: str) -> bool:
    """Whether a browser is let in and shown something."""
    try:
        async with page.socket(f"/state?sid={name}", open_timeout=60) as state, asyncio.timeout(60):
            for _ in range(5):
                await _payload(state)
    except ConnectionClosed:
        return False
    return True


async def _crowd(page: Page) -> int:
    return sum(await asyncio.gather(*(_watch_a_while(page, f"guest{number}") for number in range(40))))


def test_forty_browsers_at_once_are_served_or_told_that_there_is_no_room(page: Page) -> None:
    assert asyncio.run(_crowd(page)) >= 9
    assert asyncio.run(_steers(page))


async def _throw(page: Page, path: str, messages: int) -> None:
    """Send random messages, and connect again where the page ends the connection."""
    draw, sent = random.Random(path), 0
    while sent < messages:
        with contextlib.suppress(ConnectionClosed, ConnectionError):
            async with page.socket(f"{path}?sid=thrower") as guest:
                if path == "/ui" and draw.random() < 0.8:
                    await guest.send(GREETING)
                until = sent + draw.randrange(1, 500)
                while sent < min(until, messages):
                    sent += 1
                    await guest.send(random_message(draw))
                await guest.ping()
        sent += 1


async def _throw_everywhere(page: Page, messages: int) -> None:
    await asyncio.gather(*(_throw(page, path, messages) for path in ("/ui", "/state")))


@pytest.mark.parametrize("messages", with_nightly([300, 10_000], [300]))
def test_random_messages_end_nothing_and_fill_no_memory(page: Page, messages: int) -> None:
    before = page.memory
    asyncio.run(_throw_everywhere(page, messages))
    assert page.running.poll() is None
    assert page.memory < before + 100_000
    assert asyncio.run(_steers(page))


def test_a_model_dropped_on_the_viewer_is_refused_and_the_throws_stay(tmp_path: Path) -> None:
    from mujoco.studio import launch_thread, messages, viewer_handle  # noqa: PLC0415

    dropped = tmp_path / "a.xml"
    dropped.write_text("<mujoco><worldbody><body><geom size='.1'/></body></worldbody></mujoco>")
    ours, requests = mujoco.MjModel.from_xml_string("<mujoco/>"), ViewerRequests(Choice("analytic", "waste"))
    screen, simulation = launch_thread.make_thread_endpoints()
    handle = viewer_handle.ViewerHandle(simulation, sim_plugins=[requests])
    handle.set_model(ours)
    for path in (str(dropped), ""):  # a drop, and the button that loads a model again
        screen.send_to_sim(messages.LoadModelEvent(path=path))
    handle.sync()
    assert handle.model is ours
    assert "loads no model" in requests.note


def test_a_window_needs_a_display(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    done = call_here("agents.play", "--viewer", "native", folder=tmp_path)
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
    arguments = Arguments(env="PnTConveyor-v0", level="waste", viewer="native")
    made: list[Stage] = []

    def make(choice: Choice) -> Stage:
        made.append(open_stage(arguments, choice.controller, choice.level))
        return made[-1]

    watch(make, Choice("analytic", "waste"), None)
    assert [stage.core.config.name for stage in made] == ["waste", "unseen"]
    assert "nobody" in viewer.shown[7].lines[-1]
    assert viewer.shown[-1].lines[-1] == ""
