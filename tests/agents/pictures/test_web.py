"""The web viewer's server behind its door, without a simulation: requests, readers that do not read, torn frames."""

import logging
import socket
import time
from collections.abc import Iterator

import pytest

from agents.ground.cli import UsageError
from agents.pictures import door, web
from tests.tools.commands import run_python
from tests.tools.page import request, status, visit

MODEL = bytes(2**24)
"""More than the network between two processes holds."""
FRAMES = {
    "torn": b"\x82\xfe\x0f",
    "unmasked": b"\x82\x01a",
    "huge": b"\x82\xff" + (2**40).to_bytes(8) + b"abcd",
    "longer than a message may be": b"\x82\xff" + (2**17).to_bytes(8) + bytes(4),
    "of no kind": b"\xff\xff\xff\xff",
    "no text": b"\x81\x82\0\0\0\0\xff\xff",
    "rest of nothing": b"\x80\x80abcd",
    "long ping": b"\x89\xfe\x00\xff" + bytes(259),
    "empty": b"\x82\x80abcd",
}


@pytest.fixture
def places(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[int, int]]:
    """Ports of a server: the page's, and the panels'."""
    monkeypatch.setattr(web, "PATIENCE", 2.0)
    inner = web.Inner()
    inner.bind(("127.0.0.1", 0))
    inner.listen()
    with door.open_front("127.0.0.1") as front, inner:
        server = web.Server("127.0.0.1", (front, inner), MODEL)
        server.start()
        yield front.getsockname()[1], inner.getsockname()[1]
        server.stop()


def _length(guest: socket.socket, pause: float = 0.0) -> int:
    """Bytes that are read until the connection ends."""
    length = 0
    while piece := guest.recv(2**18):
        length += len(piece)
        time.sleep(pause)
    return length


@pytest.mark.parametrize(
    ("path", "headers", "upgrade", "expected"),
    [
        ("/state?sid=a", ("Host: localhost:{port}", "Origin: http://localhost:{port}"), True, 101),
        ("/ui?sid=a", ("Host: 127.0.0.1:{port}", "Origin: http://127.0.0.1:{port}"), True, 101),
        ("/state?sid=a", ("Host: localhost:{port}",), True, 101),
        ("/state?sid=a", ("Host: localhost:{port}", "Origin: http://evil.example"), True, 403),
        ("/ui?sid=a", ("Host: localhost:{port}", "Origin: null"), True, 403),
        ("/state?sid=a", ("Host: evil.example:{port}", "Origin: http://evil.example:{port}"), True, 403),
        ("/drop?sid=a", ("Host: localhost:{port}", "Origin: http://localhost:{port}"), True, 403),
        ("/", ("Host: localhost:{port}",), False, 200),
        ("/", ("Host: evil.example:{port}",), False, 403),
        ("/model", ("Host: localhost:{port}", "Origin: http://evil.example"), False, 403),
        ("/../web_server.py", ("Host: localhost:{port}",), False, 403),
        ("/", (), False, 403),
    ],
)
def test_a_request_passes_the_door(
    places: tuple[int, int], path: str, headers: tuple[str, ...], expected: int, *, upgrade: bool
) -> None:
    port, _ = places
    sent = request(path, *(header.format(port=port) for header in headers), upgrade=upgrade)
    assert status(port, sent) == expected


def test_no_other_page_shows_the_page_within_itself(places: tuple[int, int]) -> None:
    with visit(places[0], request("/", "Host: localhost", upgrade=False)) as guest:
        assert b"x-frame-options: deny" in guest.recv(2000).lower()


def test_panels_are_of_the_own_process(places: tuple[int, int]) -> None:
    _, inner = places
    with visit(inner, b"") as own:
        own.settimeout(0.5)
        with pytest.raises(TimeoutError):
            own.recv(1)
        code = f"import socket; print(socket.create_connection(('127.0.0.1', {inner}), 20).recv(1))"
        stranger = run_python("-c", code)
        assert stranger.stdout == "b''\n" or "ConnectionResetError" in stranger.stderr
        with pytest.raises(TimeoutError):  # the panels' connection goes on
            own.recv(1)


def test_who_reads_slowly_gets_all_and_who_reads_nothing_is_sent_away(places: tuple[int, int]) -> None:
    port, _ = places
    sent = request("/model", "Host: localhost", upgrade=False)
    with visit(port, sent, narrow=True) as idle, visit(port, sent) as slow:
        assert _length(slow, pause=0.05) > len(MODEL)
        time.sleep(2.0 * web.PATIENCE)
        assert _length(idle) < len(MODEL)


def test_guests_are_few_and_ask_for_something(places: tuple[int, int]) -> None:
    port, _ = places
    crowd = [visit(port, b"GET / HT") for _ in range(web.GUESTS)]
    with pytest.raises((IndexError, ConnectionError)):  # no answer
        status(port, request("/", "Host: localhost", upgrade=False))
    for guest in crowd:
        with guest:
            assert _length(guest) == 0
    assert status(port, request("/", "Host: localhost", upgrade=False)) == 200


@pytest.mark.parametrize("path", ["/state", "/ui"])
def test_frames_that_are_none_end_their_connection_alone(
    places: tuple[int, int], path: str, caplog: pytest.LogCaptureFixture
) -> None:
    port, _ = places
    sent = request(f"{path}?sid=a", "Host: localhost")
    with caplog.at_level(logging.WARNING):
        for frame in FRAMES.values():
            visit(port, sent + frame).close()
        assert status(port, sent) == 101
    assert not caplog.records


def test_a_server_that_would_pass_the_door_by_is_not_started(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web.web_server, "_run_server", lambda _server, stop: stop.wait())
    monkeypatch.setattr(web, "PATIENCE", 0.1)
    with door.open_front("127.0.0.1") as front, pytest.raises(UsageError, match="nothing guards"):
        web.Server("127.0.0.1", (front, socket.socket()), MODEL).start()
