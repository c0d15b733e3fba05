"""Guests of the web viewer's page, welcome and not: requests and frames as bytes, and where a process listens."""

from __future__ import annotations

import os
import random
import re
import socket
import struct
from pathlib import Path

_HEADS = [struct.pack("<IB3x", 120, 0), struct.pack("<IB3x", 616, 2)]
"""Heads of the commands of the page to its panels: bytes of the whole command, and its kind."""
GREETING = _HEADS[0] + bytes(96) + struct.pack("<IIIBB2x", 18, 0, 0, 2, 0)
"""First command of MuJoCo's page to its panels: the version of the commands is 18, and a letter has two bytes."""
_NUMBERS = struct.pack("<HBBff4xQ24x32x", 0, 1, 0, 1.0, 60.0, 0)
STILL = _HEADS[1] + struct.pack("<2H2h2f512x", 1280, 640, 0, 0, 0.0, 0.0) + _NUMBERS
"""Mouse and keys at rest."""
WORDS = ("state_ack", "request_control", "leave_queue", "force_control", "max_spectators=9" + 30 * "9", "theme=", "\0")


def listening(pid: int) -> set[str]:
    """Addresses at which a process listens."""
    links = [os.readlink(path) for path in Path(f"/proc/{pid}/fd").iterdir() if path.is_symlink()]
    sockets = {found[1] for link in links if (found := re.fullmatch(r"socket:\[(\d+)\]", link))}
    rows = [row.split() for kind in ("tcp", "tcp6") for row in Path(f"/proc/{pid}/net/{kind}").read_text().splitlines()]
    return {_address(row[1]) for row in rows if row[3] == "0A" and row[9] in sockets}


def _address(place: str) -> str:
    """Address of a row of /proc/net/tcp: words of four bytes in the order of the machine."""
    packed = bytes.fromhex(place.partition(":")[0])
    words = b"".join(packed[begin : begin + 4][::-1] for begin in range(0, len(packed), 4))
    return socket.inet_ntop(socket.AF_INET if len(words) == 4 else socket.AF_INET6, words)


def request(path: str, *headers: str, upgrade: bool = True) -> bytes:
    """Request of a WebSocket, or of a file."""
    upgrading = ["Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13"] if upgrade else []
    lines = [f"GET {path} HTTP/1.1", *headers, *upgrading, f"Sec-WebSocket-Key: {'A' * 22}=="]
    return "\r\n".join([*lines, "", ""]).encode()


def visit(port: int, sent: bytes, *, narrow: bool = False) -> socket.socket:
    """Connection to the page that has sent something; a narrow one has hardly room for an answer."""
    guest = socket.socket()
    if narrow:
        guest.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    guest.settimeout(60.0)
    guest.connect(("127.0.0.1", port))
    guest.sendall(sent)
    return guest


def status(port: int, sent: bytes) -> int:
    """Status with which a request is answered."""
    with visit(port, sent) as guest:
        return int(guest.recv(12).split()[1])


def random_message(draw: random.Random) -> str | bytes:
    """A message that is no command, or looks like one at its beginning or but for some bytes."""
    noise = draw.randbytes(draw.choice([0, 3, 8, 112, 608, draw.randrange(3000)]))
    damaged = bytearray(STILL)
    for _ in range(draw.randrange(1, 9)):
        damaged[draw.randrange(len(damaged))] = draw.randrange(256)
    lengths = [struct.pack("<IB3x", draw.choice([0, 24, len(noise) + 8, 2**32 - 1]), kind) for kind in range(7)]
    heads = [*_HEADS, *lengths]
    return draw.choice([noise, draw.choice(heads) + noise, bytes(damaged), draw.choice(WORDS), noise.hex()])
