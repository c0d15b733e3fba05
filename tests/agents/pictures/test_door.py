"""The door of the web viewer: which addresses, names, origins and paths it lets in."""

import re
import socket

import pytest

from agents.ground.cli import UsageError
from agents.pictures.door import PORTS, open_front, page_url, refusal
from tests.tools.commands import refused

OWN = "localhost:8080"
MACHINE = socket.gethostname()


@pytest.mark.parametrize(
    ("address", "host", "welcome"),
    [
        ("127.0.0.1", OWN, True),
        ("127.0.0.1", "LOCALHOST:9", True),  # through a tunnel, at a port of its own
        ("127.0.0.1", "127.0.0.1:8080", True),
        ("127.0.0.1", "127.0.0.1", True),
        ("::1", "[::1]:8080", True),
        ("127.0.0.1", "evil.example:8080", False),  # a name of a stranger that leads to this machine
        ("127.0.0.1", "localhost.evil.example", False),
        ("127.0.0.1", "evil.example@localhost", False),
        ("127.0.0.1", "192.0.2.1:8080", False),
        ("127.0.0.1", f"{MACHINE}.evil.example", False),
        ("127.0.0.1", "", False),
        ("192.0.2.1", "192.0.2.1:8080", True),
        ("192.0.2.1", f"{MACHINE}:8080", True),
        ("0.0.0.0", "192.0.2.1:8080", True),
        ("0.0.0.0", "evil.example:8080", False),
        ("::", "[2001:db8::1]:8080", True),
    ],
)
def test_the_page_is_served_under_names_of_its_own(address: str, host: str, *, welcome: bool) -> None:
    assert (refusal(address, "/", [host], []) == "") is welcome
    assert (refusal(address, "/ui?sid=a", [host], [f"http://{host}"]) == "") is welcome


@pytest.mark.parametrize("hosts", [[], [OWN, OWN], [OWN, "evil.example"]])
def test_a_request_names_one_host(hosts: list[str]) -> None:
    assert refusal("127.0.0.1", "/", hosts, []) != ""


@pytest.mark.parametrize("path", ["/", "/model", "/ui?sid=a", "/state?sid=a"])
@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "", "https://localhost:8080", "http://localhost:3000", "http://127.0.0.1:8080"],
)
def test_a_foreign_page_is_refused(path: str, origin: str) -> None:
    assert refusal("127.0.0.1", path, [OWN], []) == ""
    assert refusal("127.0.0.1", path, [OWN], [f"http://{OWN}"]) == ""
    assert "origin" in refusal("127.0.0.1", path, [OWN], [origin])
    assert "origin" in refusal("127.0.0.1", path, [OWN], [f"http://{OWN}", origin])


@pytest.mark.parametrize("path", ["/drop", "/drop?sid=a", "/\x1b[31m", "/ä", "/a b", "http://evil.example/", ""])
def test_models_and_other_paths_are_refused(path: str) -> None:
    assert refusal("127.0.0.1", path, [OWN], [f"http://{OWN}"]) != ""


def test_a_front_has_one_address_and_the_first_free_port() -> None:
    with open_front("127.0.0.1") as front, open_front("127.0.0.1") as other:
        assert front.getsockname()[0] == "127.0.0.1"
        assert front.getsockname()[1] in PORTS
        assert other.getsockname()[1] > front.getsockname()[1]
        assert re.fullmatch(r"http://localhost:\d+/", page_url(front))


@pytest.mark.parametrize(
    "address", ["localhost", "", "127.0.0.1:8080", "0", "256.0.0.1", "198.51.100.77", "2001:db8::1"]
)
def test_an_address_that_is_none_of_this_machine_is_refused_in_one_sentence(address: str) -> None:
    with pytest.raises(UsageError, match="--address") as complaint:
        open_front(address)
    assert repr(address) in str(complaint.value)


@pytest.mark.parametrize("viewer", ["--viewer native", "--video a.mp4"])
def test_an_address_goes_with_the_page(viewer: str) -> None:
    assert "--viewer web" in refused("agents.play", *viewer.split(), "--address", "0.0.0.0")
