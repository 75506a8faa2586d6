"""Who may see the page: this machine, under its own address."""

from __future__ import annotations

import http.client
import socket
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from flexdyn.viewer.server import PageServer

SOCKETS = Path("/proc/net/tcp")
PAGE = "<!DOCTYPE html><title>caf\u00e9</title>"


@pytest.fixture
def port() -> Iterator[int]:
    """Of a server of the page."""
    server = PageServer(PAGE)
    yield urlsplit(server.url).port or 0
    server.close()


def ask(port: int, path: str = "/", host: str | None = None, method: str = "GET") -> tuple[int, bytes, dict[str, str]]:
    """Status, body and headers of a request under a host's name."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.request(method, path, headers={"Host": host or f"127.0.0.1:{port}"})
    answer = connection.getresponse()
    return answer.status, answer.read(), dict(answer.getheaders())


def test_the_page_is_served_whole(port: int) -> None:
    """With a content type, and a word to browsers not to keep it."""
    status, body, headers = ask(port)
    assert (status, body.decode()) == (200, PAGE)
    assert headers["Content-Type"] == "text/html; charset=utf-8"
    assert headers["Cache-Control"] == "no-store"
    assert ask(port, method="HEAD")[:2] == (200, b"")
    assert ask(port, host=f"localhost:{port}")[0] == 200


def test_it_listens_on_this_machine_alone(port: int) -> None:
    """Not on all addresses: one that only reaches such a server, 127.0.0.2 of the loopback network, is refused."""
    for address in ("127.0.0.2", "::1"):
        with pytest.raises(OSError, match=r"\w"):
            socket.create_connection((address, port), timeout=2)


@pytest.mark.skipif(not SOCKETS.exists(), reason="no list of sockets here (Linux has /proc/net/tcp)")
def test_the_listening_socket_is_bound_to_127_0_0_1(port: int) -> None:
    """As the kernel lists it: address and port in hexadecimal, state 0A for listening."""
    rows = [line.split() for path in (SOCKETS, SOCKETS.with_name("tcp6")) for line in path.read_text().splitlines()[1:]]
    bound = [row[1] for row in rows if row[3] == "0A" and row[1].endswith(f":{port:04X}")]
    assert bound == [f"0100007F:{port:04X}"]


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1.evil.example:{port}", "[::1]"]
)
def test_a_foreign_name_for_this_machine_is_refused(port: int, host: str) -> None:
    """A web page whose name was pointed here (DNS rebinding) reads nothing."""
    status, body, _ = ask(port, host=host.format(port=port))
    assert status == 403
    assert "caf" not in body.decode()


@pytest.mark.parametrize("path", ["/x", "/../etc/passwd", "/?a", "http://evil.example/"])
def test_there_is_nothing_else(port: int, path: str) -> None:
    """Only the page has an address."""
    assert ask(port, path)[0] == 404


def test_only_reading_is_answered(port: int) -> None:
    """Nothing can be sent to it."""
    assert ask(port, method="POST")[0] == 501


def test_a_closed_server_is_gone() -> None:
    """Its port answers no more; closing twice does no harm."""
    server = PageServer(PAGE)
    number = urlsplit(server.url).port or 0
    server.close()
    server.close()
    with pytest.raises(OSError, match=r"\w"):
        socket.create_connection(("127.0.0.1", number), timeout=2)
