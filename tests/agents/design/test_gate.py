"""The gate of the page: who is let in to viser's server, without a browser."""

import importlib.util
import re
import urllib.request
from contextlib import closing
from urllib.error import HTTPError

import pytest
import viser
from viser import _messages
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from agents.design import __main__ as command
from agents.design import gate
from agents.design.gate import cookie_name, guarded, new_token
from agents.ground.cli import EXTRAS, UsageError
from agents.pictures.door import open_front
from tests.agents.design.conftest import served

TOKEN = "a-secret"


@pytest.fixture(scope="module")
def port():
    front = open_front("127.0.0.1")
    with closing(served(front, TOKEN)):
        yield front.getsockname()[1]


def get(port, path, **headers):
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", headers=headers)
    with urllib.request.urlopen(request, timeout=10) as answer:
        return answer


def is_let_in(port, path="/", origin=None, **headers):
    settings = {"subprotocols": [Subprotocol(f"viser-v{viser.__version__}")], "additional_headers": headers}
    try:
        with connect(f"ws://127.0.0.1:{port}{path}", origin=origin, open_timeout=10, **settings) as socket:
            socket.recv(timeout=10)
            return True
    except InvalidStatus as error:
        assert error.response.status_code == 403
        return False


def test_the_page_comes_with_its_token_and_sets_a_strict_cookie(port):
    answer = get(port, f"/?token={TOKEN}")
    assert answer.status == 200
    cookie = answer.headers["Set-Cookie"]
    assert cookie.startswith(f"{cookie_name(port)}={TOKEN};")
    assert "HttpOnly" in cookie and "SameSite=Strict" in cookie
    assert answer.headers["X-Frame-Options"] == "DENY"
    assert "connect-src 'self'" in answer.headers["Content-Security-Policy"]


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        ("/", {}),
        ("/?token=wrong", {}),
        (f"/?token={TOKEN}", {"Host": "evil.example"}),
        (f"/?token={TOKEN}", {"Origin": "https://evil.example"}),
        ("/", {"Cookie": "other=1; token=a-secret"}),
    ],
)
def test_a_request_without_the_token_or_from_elsewhere_is_refused(port, path, headers):
    with pytest.raises(HTTPError) as refused:
        get(port, path, **headers)
    assert refused.value.code == 403
    assert "Set-Cookie" not in refused.value.headers


def test_a_socket_needs_the_token_or_its_cookie(port):
    own = f"http://127.0.0.1:{port}"
    assert is_let_in(port, f"/?token={TOKEN}")
    assert is_let_in(port, f"/?token={TOKEN}", own)
    assert is_let_in(port, "/", own, Cookie=f"a=b; {cookie_name(port)}={TOKEN}")
    assert not is_let_in(port, "/", own)
    assert not is_let_in(port, "/?token=", own)
    assert not is_let_in(port, "/?token=a-secre", own)
    assert not is_let_in(port, "/", own, Cookie=f"{cookie_name(port + 1)}={TOKEN}")


@pytest.mark.parametrize("origin", ["https://evil.example", "http://127.0.0.1:1", "null"])
def test_a_foreign_page_is_refused_even_with_the_token(port, origin):
    assert not is_let_in(port, f"/?token={TOKEN}", origin)


def test_tokens_are_long_and_differ():
    tokens = {new_token() for _ in range(20)}
    assert len(tokens) == 20
    assert all(re.fullmatch(r"[\w-]{32,}", token) for token in tokens)


def test_websockets_serves_as_before_outside_of_the_context():
    before = gate.server.serve
    with open_front("127.0.0.1") as front, pytest.raises(UsageError, match="install viser"), guarded(front, TOKEN):
        assert gate.server.serve is not before
    assert gate.server.serve is before


def test_no_tunnel_to_another_host_can_be_asked_for():
    with closing(served(open_front("127.0.0.1"), TOKEN)) as page:
        assert _messages.ShareUrlRequest not in page.server._websock_server._incoming_handlers


def test_the_command_refuses_a_wrong_port_host_and_a_missing_extra(monkeypatch):
    with pytest.raises(UsageError, match="--port is 0; it must be from 1 to 65535"):
        command.main(command.Arguments(port=0))
    with pytest.raises(UsageError, match="--host is 'nowhere'"):
        command.main(command.Arguments(host="nowhere"))
    with open_front("127.0.0.1") as front, pytest.raises(UsageError, match="is in use"):
        command.main(command.Arguments(port=front.getsockname()[1]))
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ModuleNotFoundError) as missing:
        command.main(command.Arguments())
    assert EXTRAS[missing.value.name] == "design"
