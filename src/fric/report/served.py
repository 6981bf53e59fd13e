"""Pages that are served to this computer only, and their requests.

A page has a random address. A request is one of three words; no request names a file.
"""

import json
from abc import ABC, abstractmethod
from functools import partial
from hmac import compare_digest
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from secrets import token_urlsafe
from threading import Event, Lock
from typing import Any

from fric.errors import FricError

HOST = "127.0.0.1"


class LocalPage(ABC):
    """A page served to this computer only, with the requests ``try`` and ``save``.

    content: The page.
    most: Largest size of a request [bytes].
    """

    def __init__(self, content: bytes, most: int) -> None:
        self.content, self.most = content, most
        self.lock, self._done, self._saved = Lock(), Event(), None
        self.token = token_urlsafe(24)
        self._server = ThreadingHTTPServer((HOST, 0), partial(_Handler, self))
        self._server.daemon_threads = True

    @abstractmethod
    def answer(self, word: str, asked: Any) -> dict[str, Any]:
        """Return the answer to a request, ``try`` or ``save``; raise a `FricError` for any other."""

    @property
    def port(self) -> int:
        """The port of the server."""
        return int(self._server.server_address[1])

    @property
    def address(self) -> str:
        """Address of the page, for this computer only."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    def end(self, saved: Any) -> None:
        """Accept a result, and stop serving after pending requests are answered."""
        self._saved = saved
        self._done.set()

    def serve(self) -> Any:
        """Serve the page until a result is saved; return it."""
        try:
            self._server.timeout = 0.2
            while not self._done.is_set():
                self._server.handle_request()
        finally:
            self._server.server_close()
        return self._saved


class _Handler(BaseHTTPRequestHandler):
    """Answers three requests, all behind the token: the page, ``try`` and ``save``."""

    server_version, sys_version = "fric", ""
    timeout = 10

    def __init__(self, page: LocalPage, *given: Any) -> None:
        self._page = page
        super().__init__(*given)

    def do_GET(self) -> None:
        """Send the page."""
        if self._word() == "":
            self._send(200, self._page.content, "text/html; charset=utf-8")
        else:
            self._send(404, b"", "text/plain")

    def do_POST(self) -> None:
        """Answer a request of the page."""
        word, size = self._word(), self.headers.get("Content-Length", "")
        known = word in {"try", "save"} and self.headers.get_content_type() == "application/json"
        if not (known and size.isascii() and size.isdigit() and int(size) <= self._page.most):
            self._send(404, b"", "text/plain")
            return
        try:
            found = self._page.answer(str(word), json.loads(self.rfile.read(int(size))))
        except (FricError, ValueError, RecursionError) as error:
            found = {"error": str(error)}
        self._send(200, json.dumps(found).encode(), "application/json")

    def _word(self) -> str | None:
        """Return the request behind the token; None if the token or the host differs."""
        local = self.headers.get("Host", "") == f"{HOST}:{self._page.port}"  # else a name was bent to this computer
        head, token, word = self.path.split("/", 2) if self.path.count("/") > 1 else ("", "", "")
        right = compare_digest(token.encode(), self._page.token.encode())
        return word if local and right and head == "" else None

    def _send(self, status: int, content: bytes, kind: str) -> None:
        self.send_response(status)
        for name, value in {
            "Content-Type": kind, "Content-Length": str(len(content)), "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer", "X-Frame-Options": "DENY",
        }.items():  # fmt: skip
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *given: Any) -> None:
        """Write nothing to standard error."""
