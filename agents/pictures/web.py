"""MuJoCo's web viewer behind a door: one address, no foreign page, no model of a stranger, and bounded guests."""

from __future__ import annotations

import asyncio
import math
import os
import socket
import threading
import zlib
from collections.abc import Sequence
from functools import partial
from types import FunctionType
from typing import Any, Final, final

from mujoco.studio import launch_thread, plugin, viewer_protocol, web_viewer
from mujoco.studio.web import web_server
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from ..ground.cli import UsageError
from . import door

GUESTS: Final = 64
"""Connections at once. MuJoCo's server lets in one browser that steers and at most 32 that watch."""
MESSAGE: Final = 2**16
"""Largest message of a browser [byte]; the page's own have less than 1 kB."""
UNREAD: Final = 2**26
"""Bytes for all guests that wait to be read, above which further requests wait. The page's largest file has 6.5 MB."""
PATIENCE: Final = 10.0
"""How long a guest may take over a request, a farewell, or the next piece of what it is sent [s]."""
UNKNOWN: Final = "this version of MuJoCo serves its page in a way that nothing guards; --viewer native opens a window"


@final
class Guest(ServerConnection):
    """Connection of a browser, which is closed if there are too many, or if the browser reads nothing.

    MuJoCo's server waits for each browser in turn: one that never reads would make all others wait.

    Args:
        guests: connections that are open.
        settings: settings of the connection.
    """

    def __init__(self, guests: set[Guest], *settings: Any, **named: Any) -> None:
        super().__init__(*settings, **named)
        self._guests = guests
        self._waiting: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take a connection up, or close it at once if there are too many."""
        super().connection_made(transport)
        self._guests.add(self)
        if len(self._guests) > GUESTS:
            self.transport.abort()
        self.loop.call_later(PATIENCE, self._end_without_request)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget a connection, and what it was sent: files of megabytes would wait for Python's collector."""
        self._guests.discard(self)
        if self.response is not None:
            self.response.body = b""
        super().connection_lost(exc)

    def pause_writing(self) -> None:
        """Wait for the browser to read."""
        super().pause_writing()
        self._wait(math.inf)

    def resume_writing(self) -> None:
        """Go on, as the browser has read."""
        super().resume_writing()
        if self._waiting is not None:
            self._waiting.cancel()

    async def recv(self, decode: bool | None = None) -> Any:
        """The next message of a browser, without the texts for the panels, which take none."""
        message = await super().recv(decode)
        while isinstance(message, str) and self.request is not None and self.request.path.startswith("/ui"):
            message = await super().recv(decode)
        return message

    def _end_without_request(self) -> None:
        if self.request is None:
            self.transport.abort()

    def _wait(self, unread: float) -> None:
        """Close the connection if the browser has read nothing since there were so many bytes to read."""
        left = self.transport.get_write_buffer_size()
        if self.paused and left >= unread:
            self.transport.abort()
        elif self.paused:
            self._waiting = self.loop.call_later(PATIENCE, self._wait, left)


@final
class Inner(socket.socket):
    """Socket between MuJoCo's server and its panels, both in this process: no other process is let in."""

    def accept(self) -> tuple[socket.socket, Any]:
        """Let in the panels.

        Raises:
            ConnectionAbortedError: the connection comes from another process.
        """
        connection, peer = super().accept()
        if not _is_of_this_process(peer, connection.getsockname()):
            connection.close()
            raise ConnectionAbortedError(f"{peer} is not of this process")
        return connection, peer


@final
class Server(web_server.WebServer):
    """MuJoCo's web server, whose requests pass the door.

    Args:
        address: address at which the page is served.
        sockets: the page's socket and the panels'.
        model: model that the page shows first.
    """

    def __init__(self, address: str, sockets: tuple[socket.socket, socket.socket], model: bytes) -> None:
        super().__init__(*sockets, mjb_data=model)
        self._address = address
        self._guarded = threading.Event()

    def start(self) -> None:
        """Start MuJoCo's server in a thread, and make sure that its requests pass the door.

        MuJoCo's function takes no settings for its connections, but calls `serve` once, by its name in the module. The
        function runs here with another `serve`, and the module stays as it is.

        Raises:
            UsageError: this version of MuJoCo serves otherwise.
        """
        run = FunctionType(web_server._run_server.__code__, {**vars(web_server), "serve": self._serve})
        self._thread = threading.Thread(target=run, args=(self, self._stop_event), daemon=True)
        self._thread.start()
        if not self._guarded.wait(PATIENCE):
            self.stop()
            raise UsageError(UNKNOWN)

    def _serve(self, handler: Any, *, process_request: Any, process_response: Any, **settings: Any) -> Any:
        """Connections that pass the door, with bounds."""
        guests = set[Guest]()

        async def judge(connection: ServerConnection, request: Request) -> Response | None:
            hosts, origins = (request.headers.get_all(name) for name in ("Host", "Origin"))
            reason = door.refusal(self._address, request.path, hosts, origins)
            if reason:
                return connection.respond(403, f"{reason}\n")
            # Until it is read, or its reader is sent away.
            while sum(guest.transport.get_write_buffer_size() for guest in guests) > UNREAD:
                await asyncio.sleep(0.1)
            return process_request(connection, request)

        def complete(connection: ServerConnection, request: Request, response: Response) -> Response | None:
            response.headers["X-Frame-Options"] = "DENY"  # a page inside of a foreign page could be clicked unseen
            return process_response(connection, request, response)

        bounds = {"max_size": MESSAGE, "close_timeout": PATIENCE}
        self._guarded.set()
        asyncio.get_running_loop().set_exception_handler(_tell)
        return serve(
            handler,
            process_request=judge,
            process_response=complete,
            create_connection=partial(Guest, guests),  # pyright: ignore[reportArgumentType] - called, though declared as a class
            **{**settings, **bounds},
        )


@final
class Viewer(web_viewer.WebViewer):
    """MuJoCo's web viewer, which listens at one socket that it is given.

    Args:
        front: listening socket.
        settings: settings of the viewer.

    Raises:
        UsageError: this version of MuJoCo serves otherwise.
    """

    def __init__(self, front: socket.socket, *settings: Any, **named: Any) -> None:
        self._front = front
        super().__init__(*settings, **named)
        if not isinstance(self._web_server, Server):
            self.close()
            raise UsageError(UNKNOWN)

    def _start_server(self) -> None:
        """Start the server at the given socket; MuJoCo's own socket, at all addresses, never listens."""
        self._http_sock.close()
        self._http_sock = self._front
        self._host, self._http_port = self._front.getsockname()[:2]
        self._tcp_sock = Inner(fileno=self._tcp_sock.detach())
        model = self._serialize_model()
        self._model_crc32 = zlib.crc32(model)
        self._web_server = Server(self._host, (self._http_sock, self._tcp_sock), model)
        self._web_server.start()


def launch(front: socket.socket, config: viewer_protocol.ViewerConfig, *, plugins: Sequence[plugin.Plugin]) -> Any:
    """MuJoCo's web viewer in a thread, as a handle that is a context.

    Args:
        front: listening socket of the page.
        config: title of the page.
        plugins: plugins of the viewer and of the simulation.
    """
    drawing, simulating = plugin.split_plugins(plugins)

    def show(endpoint: Any) -> None:
        viewer_protocol.run_viewer_loop(Viewer(front, config, endpoint, plugins=drawing))

    return launch_thread.launch_thread(show, sim_plugins=simulating)


def _tell(loop: asyncio.AbstractEventLoop, event: dict[str, Any]) -> None:
    """Tell what went wrong in MuJoCo's server, but for browsers that have gone: its tasks meet each of these twice."""
    if not isinstance(event.get("exception"), ConnectionClosed | ConnectionError):
        loop.default_exception_handler(event)


def _is_of_this_process(peer: Any, here: Any) -> bool:
    """Whether this process holds the other end of a connection."""
    for name in os.listdir("/dev/fd"):
        try:
            end = socket.socket(fileno=int(name))
        except OSError:  # no socket
            continue
        try:
            if end.getsockname() == peer and end.getpeername() == here:
                return True
        except OSError:  # not connected
            continue
        finally:
            end.detach()
    return False
