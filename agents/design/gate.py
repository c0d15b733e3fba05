"""The gate of the page: viser's server at one socket, behind the door of this machine's pages and a secret token."""

from __future__ import annotations

import contextlib
import hmac
import io
import re
import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable, Generator
from contextlib import contextmanager
from ipaddress import ip_address
from typing import Any, Final
from urllib.parse import parse_qs, urlsplit

import viser
from viser import _messages
from websockets.asyncio import server
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from pnt_gym.engine import has_display

from ..ground.cli import UsageError
from ..ground.tables import console
from ..pictures.door import LOOPBACK, page_url, refusal

TOKEN: Final = 24
"""Random bytes of a token."""
MESSAGE: Final = 2**21
"""Largest message of a browser [byte]: a level file's part, or a gesture."""
PATIENCE: Final = 10.0
"""Time for the server to start, and of a guest for its request [s]."""
UNKNOWN: Final = "this version of viser serves its page in a way that nothing guards; install viser 1.1"
WIDTH: Final = 360
"""Width of the panel [pixels]."""
BRAND: Final = (44, 92, 150)
"""Colour of buttons."""
HEADERS: Final = {
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
    # The page asks no other host for anything.
    "Content-Security-Policy": (
        "default-src 'self' data: blob:; script-src 'self' data: blob: 'unsafe-inline' 'unsafe-eval'; "
        "style-src 'self' data: blob: 'unsafe-inline'; connect-src 'self' data: blob:; frame-ancestors 'none'"
    ),
}
"""Headers of every answer."""
Judge = Callable[[ServerConnection, Request], Any]


def open_server(front: socket.socket, token: str, title: str) -> viser.ViserServer:
    """Viser's server at a listening socket, for browsers that bring the token; no tunnel leads to another host.

    Raises:
        UsageError: this version of viser serves otherwise.
    """
    # viser prints addresses without the token.
    with guarded(front, token), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(*front.getsockname()[:2], label=title, verbose=False)
    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server._incoming_handlers.pop(message)
    server.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=BRAND)
    server.gui.main_panel.dock_right()
    server.gui.main_panel.set_width(WIDTH)
    return server


def close_server(server: viser.ViserServer) -> None:
    """End viser's server, which prints that it ends."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def announce(front: socket.socket, token: str, what: str, opens_browser: bool) -> None:
    """Print where a browser finds the page, and open a browser where there is a display.

    Args:
        front: listening socket.
        token: secret of the page.
        what: what the page shows.
        opens_browser: whether to open a browser.
    """
    host = front.getsockname()[0]
    if not ip_address(host).is_loopback:
        console().print(f"warning: the page is served at {host}, beyond this machine, and nothing is encrypted")
    address = f"{page_url(front).replace('localhost', LOOPBACK)}?token={token}"
    print(f"{what} at {address}", flush=True)  # no line break within the address, which is copied
    if opens_browser and has_display():
        webbrowser.open(address)


def new_token() -> str:
    """A secret that nobody guesses."""
    return secrets.token_urlsafe(TOKEN)


def cookie_name(port: int) -> str:
    """Name of the cookie in which a browser keeps the token; cookies of one machine do not know ports."""
    return f"pnt_gym_design_{port}"


def has_token(request: Request, token: str, port: int) -> bool:
    """Whether a request brings the token, in its address or in its cookie."""
    given = parse_qs(urlsplit(request.path).query).get("token", [])
    name = re.escape(cookie_name(port))
    for cookie in request.headers.get_all("Cookie"):
        given += re.findall(rf"(?:^|;\s*){name}=([\w-]+)", cookie)
    return any(hmac.compare_digest(text.encode(), token.encode()) for text in given)


def judge(connection: ServerConnection, request: Request, address: str, token: str) -> Response | None:
    """The refusal of a request; None for a request that is let in.

    A foreign page's WebSocket has a foreign origin, a foreign name's page has a foreign host, and another user of this
    machine has no token.
    """
    hosts, origins = (request.headers.get_all(name) for name in ("Host", "Origin"))
    reason = refusal(address, request.path, hosts, origins)
    port = connection.local_address[1]
    if not reason and not has_token(request, token, port):
        reason = "the address of the page ends with its token; open the whole address that `pnt-gym design` printed"
    if not reason:
        return None
    response = connection.respond(403, f"{reason}\n")
    response.headers.update(HEADERS)
    return response


@contextmanager
def guarded(front: socket.socket, token: str) -> Generator[None, None, None]:
    """Context in which viser starts its server: at a given socket, and behind the gate.

    viser's function takes no settings for its connections, but calls `serve` of websockets once, by its place in the
    module. In this context the module has another `serve`.

    Raises:
        UsageError: this version of viser serves otherwise.
    """
    address, usual, called = front.getsockname()[0], server.serve, threading.Event()

    def serve(handler: Any, *_: Any, process_request: Judge, **settings: Any) -> Any:
        def check(connection: ServerConnection, request: Request) -> Any:
            answer = judge(connection, request, address, token)
            return process_request(connection, request) if answer is None else answer

        def complete(connection: ServerConnection, request: Request, response: Response) -> Response:
            if response.status_code < 400 and "Set-Cookie" not in response.headers:
                name = cookie_name(connection.local_address[1])
                response.headers["Set-Cookie"] = f"{name}={token}; HttpOnly; SameSite=Strict; Path=/"
            for header, value in HEADERS.items():
                if header not in response.headers:
                    response.headers[header] = value
            return response

        called.set()
        bounds = {"max_size": MESSAGE, "open_timeout": PATIENCE, "close_timeout": 0.2}
        gate = {"sock": front, "process_request": check, "process_response": complete}
        return usual(handler, **{**settings, **bounds, **gate})

    server.serve = serve  # pyright: ignore[reportAttributeAccessIssue] - for the time of the context
    try:
        yield
    finally:
        server.serve = usual
    if not called.is_set():
        raise UsageError(UNKNOWN)
