"""Door of the web viewer: the address at which the page is served, and the requests that are let in."""

from __future__ import annotations

import errno
import os
import re
import socket
from collections.abc import Sequence
from ipaddress import ip_address
from typing import Final

from ..ground.cli import UsageError

LOOPBACK: Final = "127.0.0.1"
"""Address that only this machine reaches."""
PORTS: Final = range(8080, 8100)
"""Ports of the page: the first free one is taken."""
TARGET: Final = re.compile(r"/[!-~]*")
"""What may be asked for: no character of it, which MuJoCo's server may print, steers a terminal."""
HOST: Final = re.compile(r"(\[[\da-f:.]+\]|[\w.-]+)(:\d{1,5})?", re.ASCII | re.IGNORECASE)
DROP: Final = "/drop"
"""Where MuJoCo's page sends models that were dropped on it."""


def open_front(address: str, ports: Sequence[int] = PORTS, option: str = "--address") -> socket.socket:
    """Listening socket at an address of this machine, at the first free port.

    Args:
        address: the address.
        ports: ports in the order in which they are tried.
        option: option that gives the address, for the error.

    Raises:
        UsageError: this machine has no such address, or no port of the address is free.
    """
    try:
        family = {4: socket.AF_INET, 6: socket.AF_INET6}[ip_address(address).version]
    except ValueError:
        raise UsageError(
            f"{option} is {address!r}; it must be an IP address of this machine, such as {LOOPBACK}"
        ) from None
    for port in ports:
        try:
            return socket.create_server((address, port), family=family, backlog=socket.SOMAXCONN)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                reason = os.strerror(error.errno or errno.EINVAL)
                raise UsageError(f"{option} is {address!r}, where no page can be served: {reason}") from None
    if len(ports) == 1:
        raise UsageError(f"port {ports[0]} of {address} is in use; give another one, or leave the port out")
    raise UsageError(f"{option} is {address!r}, whose ports {ports[0]} to {ports[-1]} are all in use")


def page_url(front: socket.socket) -> str:
    """Where a browser of this machine finds the page."""
    address, port = front.getsockname()[:2]
    name = "localhost" if address == LOOPBACK or ip_address(address).is_unspecified else address
    return f"http://[{name}]:{port}/" if ":" in name else f"http://{name}:{port}/"


def refusal(address: str, target: str, hosts: Sequence[str], origins: Sequence[str]) -> str:
    """Why a request is not let in; empty for a request that is.

    A request without an origin comes from no foreign page, for browsers name the origin of every such WebSocket and of
    every answer that a foreign page could read.

    Args:
        address: address at which the page is served.
        target: path and query of the request.
        hosts: values of the header `Host`.
        origins: values of the header `Origin`.
    """
    if not TARGET.fullmatch(target):
        return "the page has no such path"
    if target.partition("?")[0] == DROP:
        return "the page shows throws alone, and loads no model"
    if len(hosts) != 1 or not _is_own(address, hosts[0]):
        return "the page is served under its own address alone: a foreign name may be a trap"
    if any(origin != f"http://{hosts[0]}" for origin in origins):
        return "the page answers itself alone, and no page of another origin"
    return ""


def _is_own(address: str, host: str) -> bool:
    """Whether a header `Host` names this machine; a stranger's name may lead here, and its page would be let in."""
    found = HOST.fullmatch(host)
    if found is None:
        return False
    name = found[1].strip("[]").lower()
    if name in ("localhost", address):
        return True
    return not ip_address(address).is_loopback and (
        _is_address(name) or name in (socket.gethostname().lower(), socket.getfqdn().lower())
    )


def _is_address(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True
