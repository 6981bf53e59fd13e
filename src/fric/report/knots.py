"""Knots of the virgin curve, moved by hand: a page on this computer alone, and its requests.

The page has a random address, and is served to this computer alone. A request is one of three words; no request names a
file.
"""

import json
from collections.abc import Callable, Sequence
from functools import partial
from hmac import compare_digest
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from secrets import token_urlsafe
from threading import Event, Lock
from typing import Any

from fric.errors import FricError
from fric.report.page import environment
from fric.results.model import GMSResult
from fric.units import prefixed, si_unit

HOST = "127.0.0.1"
MOST_REQUEST = 16_384
"""Bytes of a request at most."""
MOST_KNOTS = 12

Fit = Callable[[Sequence[float]], "GMSResult"]
"""Returns the blocks of knots [m]."""


class KnotPage:
    """A page with the virgin curve, its knots, the blocks by eq. (6), and the residual of a replay.

    start: The knots to begin with, fitted.
    fit: Fits other knots.
    """

    def __init__(self, start: GMSResult, fit: Fit) -> None:
        self._fit, self._lock, self._done = fit, Lock(), Event()
        self.knots: list[float] = start.fit.blocks.displacement.tolist()
        self.token = token_urlsafe(24)
        self._page = _rendered(start).encode()
        self._server = ThreadingHTTPServer((HOST, 0), partial(_Handler, self))
        self._server.daemon_threads = True

    @property
    def port(self) -> int:
        """The port that it is served on."""
        return int(self._server.server_address[1])

    @property
    def address(self) -> str:
        """Where the page is: on this computer alone."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    def serve(self) -> list[float]:
        """Serve the page until knots are saved; return them [m]."""
        try:
            self._server.timeout = 0.2
            while not self._done.is_set():
                self._server.handle_request()
        finally:
            self._server.server_close()
        return self.knots

    def answer(self, word: str, asked: Any) -> dict[str, Any]:
        """Return the answer to a request: ``try`` fits knots, ``save`` takes them.

        Raises FricError: When the knots are none, or do not suit the curve.
        """
        knots = asked.get("knots") if isinstance(asked, dict) else None
        if not (
            isinstance(knots, list)
            and 0 < len(knots) <= MOST_KNOTS
            and all(isinstance(knot, int | float) and 0 < knot < 1e3 for knot in knots)
        ):
            raise FricError(f"that is no list of 1 to {MOST_KNOTS} displacements")
        with self._lock:
            found = _found(self._fit(sorted(float(knot) for knot in knots)))
        if word == "save":
            self.knots = sorted(float(knot) for knot in knots)
            self._done.set()
        return found


class _Handler(BaseHTTPRequestHandler):
    """Answers three requests, all behind the token: the page, ``try`` and ``save``."""

    server_version, sys_version = "fric", ""
    timeout = 10

    def __init__(self, page: KnotPage, *given: Any) -> None:
        self._page = page
        super().__init__(*given)

    def do_GET(self) -> None:
        """Send the page."""
        if self._word() == "":
            self._send(200, self._page._page, "text/html; charset=utf-8")
        else:
            self._send(404, b"", "text/plain")

    def do_POST(self) -> None:
        """Answer a request of the page."""
        word, size = self._word(), self.headers.get("Content-Length", "")
        known = word in {"try", "save"} and self.headers.get_content_type() == "application/json"
        if not (known and size.isascii() and size.isdigit() and int(size) <= MOST_REQUEST):
            self._send(404, b"", "text/plain")
            return
        try:
            found = self._page.answer(str(word), json.loads(self.rfile.read(int(size))))
        except (FricError, ValueError, RecursionError) as error:
            found = {"error": str(error)}
        self._send(200, json.dumps(found).encode(), "application/json")

    def _word(self) -> str | None:
        """Return the request behind the token; None where the token or the host is another."""
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


def _found(result: GMSResult) -> dict[str, Any]:
    """Return the content of the page about a fit: rows of blocks, and of records."""
    gms, fit = result.document["gms"], result.document["gms_fit"]
    ends = gms["alpha"].get("ci95"), gms["k"].get("ci95")
    return {
        "knots": result.fit.blocks.displacement.tolist(),
        "alpha": gms["alpha"]["value"],
        "k": gms["k"]["value"],
        "ci95": [list(pair) for pair in zip(*ends, strict=True)] if all(ends) else [],
        "records": [{"name": item["record"], "rmse": item["rmse"]["value"]} for item in fit["records"]],
        "rmse": fit["rmse"]["value"],
    }


def _rendered(start: GMSResult) -> str:
    curve, motion = start.fit.curve, start.fit.motion
    length, force, stiffness = (si_unit(name, motion) for name in ("position", "force", "stiffness"))
    units = {
        "length": prefixed(float(curve.displacement[-1]) / 10, length),
        "force": prefixed(float(curve.force.max()), force),
        "stiffness": prefixed(float(start.fit.blocks.k.max()), stiffness),
    }
    data = {
        "displacement": curve.displacement.tolist(),
        "force": curve.force.tolist(),
        "band": curve.band.tolist(),
        "units": {name: {"factor": factor, "unit": unit} for name, (factor, unit) in units.items()},
        "most": MOST_KNOTS,
        "found": _found(start),
    }
    return environment().get_template("knots.html.j2").render(axis=start.fit.axis, data=data)
