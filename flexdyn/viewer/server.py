"""A server of one page, only for this machine."""

from __future__ import annotations

import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from socketserver import ThreadingTCPServer
from typing import Any

HOST = "127.0.0.1"


class PageServer:
    """Serves a page at http://127.0.0.1:PORT/ until closed, to this machine only.

    Args:
        page: its HTML.

    Attributes:
        url: of the page.
    """

    def __init__(self, page: str) -> None:
        self._server = _Server((HOST, 0), _handler(page.encode()))
        self.url = f"http://{HOST}:{self._server.server_address[1]}/"
        self._thread = threading.Thread(target=self._server.serve_forever, name="flexdyn viewer", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop; it may be called several times."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Server(ThreadingTCPServer):
    """The server; HTTPServer would ask a name server for the name of the address, TCPServer does not."""

    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore the error of a browser that closed the connection."""


def _handler(page: bytes) -> type[BaseHTTPRequestHandler]:
    """A handler of requests that answers with this page alone."""

    class Handler(BaseHTTPRequestHandler):
        """Sends the page, only to requests with the address of the server."""

        server_version, sys_version = "flexdyn", ""
        timeout = 30

        def do_GET(self) -> None:
            """Send the page at /, and nothing at other paths."""
            port = self.request.getsockname()[1]
            # A foreign page whose host name points to this machine sends that name: it must not read anything.
            if self.headers.get("Host") not in (f"{HOST}:{port}", f"localhost:{port}"):
                self.send_error(HTTPStatus.FORBIDDEN)
            elif self.path != "/":
                self.send_error(HTTPStatus.NOT_FOUND)
            else:
                self._answer()

        do_HEAD = do_GET

        def _answer(self) -> None:
            """Send the headers, and the page where it is asked for."""
            self.send_response(HTTPStatus.OK)
            for name, value in (
                ("Content-Type", "text/html; charset=utf-8"),
                ("Content-Length", str(len(page))),
                ("Cache-Control", "no-store"),
                ("X-Content-Type-Options", "nosniff"),
                ("X-Frame-Options", "DENY"),
                ("Referrer-Policy", "no-referrer"),
                ("Cross-Origin-Resource-Policy", "same-origin"),
            ):
                self.send_header(name, value)
            self.end_headers()
            if self.command == "GET":
                self.wfile.write(page)

        def log_message(self, format: str, *args: Any) -> None:
            """Write no log: a library prints nothing to the terminal."""

    return Handler
