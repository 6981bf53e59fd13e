"""Pages that are served to this computer only: to state the columns of foreign logs, and to move knots, by hand.

A page has a random address. A request is one of three words; no request names a file.
"""

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from hmac import compare_digest
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from secrets import token_urlsafe
from threading import Event, Lock
from typing import Any

import numpy as np

from fric.arrays import Real
from fric.columns import KINDS
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_text
from fric.errors import FricError
from fric.io.channels import plan
from fric.io.propose import Guess, Guessed, mapping_text
from fric.io.questions import sampling_period
from fric.io.roles import AxisColumns, Role, in_memory
from fric.log import Log
from fric.records.inspection import inspect
from fric.report.view import environment
from fric.results.identify import GMSResult
from fric.units import Motion, in_units_of, prefixed, readable, rotates, si_unit

HOST = "127.0.0.1"
MOST_KNOT_REQUEST = 16_384  # Largest size of a request of the page of knots [bytes]
MOST_KNOTS = 12  # Knots at most in it
Fit = Callable[[Sequence[float]], "GMSResult"]  # Returns the blocks of knots [m]
MOST_REQUEST = 262_144  # Largest size of a request of the page of columns [bytes]
MOST_WORD = 60  # Largest length of a name or a unit [characters]
SKETCH = 160  # Points of the sketch of a column
TAKEN = ("time", "position", "velocity", "force", "input", "reference", "load_position")  # What a column can be


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
        if self._word() == "":
            self._send(200, self._page.content, "text/html; charset=utf-8")
        else:
            self._send(404, b"", "text/plain")

    def do_POST(self) -> None:
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


class ColumnsPage(LocalPage):
    """A page with the columns of files as sketches, their roles, units and rate, and the resulting records.

    guess: The guess about the files.
    """

    def __init__(self, guess: Guessed) -> None:
        tables = {guess.table.path: in_memory(guess.table) for guess in guess.found}
        self._found = [replace(part, table=tables[part.table.path]) for part in guess.found if not part.joined]
        if not self._found:
            raise FricError("no file has columns to state")
        super().__init__(_rendered(self._found).encode(), MOST_REQUEST)

    def answer(self, word: str, asked: Any) -> dict[str, Any]:
        """Return the stated mapping and the resulting records; ``save`` accepts it."""
        axes = asked.get("axes") if isinstance(asked, dict) else None
        if not isinstance(axes, list) or len(axes) != len(self._found):
            raise FricError("that is not a list of axes")
        pairs = list(zip(self._found, axes, strict=True))
        stated = [_stated(guess, axis) for guess, axis in pairs if isinstance(axis, dict) and axis.get("taken")]
        if not stated:
            raise FricError("no axis is taken", hint="Tick at least one.")
        text = mapping_text(stated, assume=True)
        document = read_text(text, MappingDocument)
        found = {"mapping": text, "axes": [_followed(guess, document) for guess in stated]}
        if word == "save":
            self.end(Guessed(tuple(stated)))
        return found


def _word(value: Any, what: str) -> str:
    if not isinstance(value, str) or len(value) > MOST_WORD or not value.isprintable():
        raise FricError(f"that is no {what}")
    return value.strip()


def _stated(guess: Guess, asked: Mapping[str, Any]) -> Guess:
    """Return a guess with the statements of the page about its axis."""
    roles: dict[str, Role] = {}
    for row in asked["roles"] if isinstance(asked.get("roles"), list) else []:
        channel, column = (row.get("channel"), row.get("column")) if isinstance(row, dict) else (None, None)
        if channel not in TAKEN or type(column) is not int or not 0 <= column < len(guess.table.columns):
            raise FricError("a column has no valid channel")
        name = guess.table.columns[column].name
        if not (unit := _word(row.get("unit", ""), "unit")):
            hint = "Give the unit, or the size of a step: 0.0879 deg."
            raise FricError(f"'{name}' ({channel}) has no unit", hint=hint)
        turn = known.turn if (known := guess.axis.roles.get(channel)) and known.column == column else 0.0
        roles[channel] = Role(channel, column, unit, 1.0, 1.0, "as stated", -1 if row.get("turned") else 1, turn=turn)
    if "time" not in roles:
        if (period := sampling_period(rate := _word(asked.get("rate", ""), "rate"))) is None:
            what = f"'{rate}' is not a sampling rate" if rate else "no column is marked as time"
            raise FricError(what, hint="Mark its column, or give a rate, as in 1 kHz.")
        roles["time"] = Role("time", None, f"{period:.9g} s", 1.0, 1.0, "as stated")
    motion: Motion = "rotary" if asked.get("motion") == "rotary" else "linear"
    if "force" in roles:
        motion = in_units_of(motion, roles["force"].unit)
    name = _word(asked.get("name", ""), "name") or guess.axis.name
    if not {"position", "velocity"} & roles.keys():
        raise FricError(f"axis {name} has neither position nor velocity", hint="State one, or leave the axis out.")
    ordered = {channel: roles[channel] for channel in TAKEN if channel in roles}
    return replace(guess, axis=AxisColumns(name, motion, 1.0, ordered), named=True, kind="")


def _followed(guess: Guess, document: MappingDocument) -> dict[str, Any]:
    """Return the result of a mapping on the first rows of a file: channels in SI, and their inspection."""
    mapping = document.of(guess.table.path, [column.name for column in guess.table.columns], guess.axis.name)
    try:
        chosen = plan(guess.table, mapping, None, guess.axis.motion, {})
        blocks = list(guess.table.read(chosen.wanted))
        columns = [np.concatenate(values) for values in zip(*(block.columns for block in blocks), strict=True)]
        channels = chosen.unwrapped(chosen.convert(columns, np.arange(len(columns[0]))), {})
        given: dict[str, Any] = dict(channels)
        log = Log(axis=guess.axis.name, motion=guess.axis.motion, name=guess.table.path.stem, **given)
        shown = inspect(log)
        uses = [f"{use.purpose}: {'good' if use.good else 'no'}, {use.why}" for use in shown.uses]
        kind = str(shown.kind)
    except FricError as error:
        return {"axis": guess.axis.name, "lines": [], "problem": " ".join([error.what, error.hint])}
    rate = 1.0 / float(np.median(np.diff(log.time)))
    lines = [f"{readable(float(np.ptp(log.time)), 's')} at {readable(rate, 'Hz')}"]
    lines += [f"{name} from {readable(float(values.min()), log.unit(name))} to "
              f"{readable(float(values.max()), log.unit(name))}"
              for name, values in channels.items() if name != "time"]  # fmt: skip
    return {"axis": guess.axis.name, "lines": [*lines, f"looks like {kind}", *uses], "problem": ""}


def _rendered(found: list[Guess]) -> str:
    sketched: dict[Any, list[dict[str, Any]]] = {}
    for guess in found:
        if guess.table.path not in sketched:
            sketched[guess.table.path] = [_sketch(guess, n) for n in range(len(guess.table.columns))]
    files = list(sketched)
    axes = [
        {
            "name": guess.axis.name,
            "motion": "rotary" if rotates(guess.axis.motion) else "linear",
            "file": files.index(guess.table.path),
            "rate": role.unit if (role := guess.axis.roles.get("time")) and role.column is None else "",
            "roles": [
                {"channel": role.channel, "column": role.column, "unit": role.unit, "turned": role.sign < 0,
                 "why": role.why, "sure": min(role.likelihood, role.unit_likelihood)}
                for role in guess.axis.roles.values() if role.column is not None and role.channel in TAKEN
            ],
        }
        for guess in found
    ]  # fmt: skip
    members = {path: [file.name for g in found if g.table.path == path for file in g.files] for path in files}
    names = {path: sorted(set(members[path])) for path in files}
    listed = [{"names": names[path][:8], "count": len(names[path]), "columns": sketched[path]} for path in files]
    data = {"axes": axes, "files": listed, "channels": TAKEN, "kinds": KINDS}
    return environment().get_template("columns.html.j2").render(data=data)


def _sketch(guess: Guess, n: int) -> dict[str, Any]:
    """Return a column with its limits, and its first rows as extremes of pieces, in thousandths of its range."""
    blocks = [block.columns[0] for block in guess.table.read([n])]
    values: Real = np.concatenate(blocks) if blocks else np.empty(0)
    values, column = values[np.isfinite(values)], guess.table.columns[n]
    if not len(values):
        return {"name": column.name, "unit": column.unit or "", "low": "", "high": "", "points": []}
    low, high = float(values.min()), float(values.max())
    pieces = np.array_split(values, min(SKETCH // 2, len(values)))
    ends = np.concatenate([piece[np.sort([piece.argmin(), piece.argmax()])] for piece in pieces])
    return {"name": column.name, "unit": column.unit or "", "low": f"{low:.5g}", "high": f"{high:.5g}",
            "points": np.round(1000.0 * (ends - low) / ((high - low) or 1.0)).astype(int).tolist()}  # fmt: skip


class KnotPage(LocalPage):
    """A page with the virgin curve, its knots, the blocks by eq. (6), and the residual of a replay.

    start: The knots to begin with, fitted.
    fit: Fits other knots.
    """

    def __init__(self, start: GMSResult, fit: Fit) -> None:
        super().__init__(_knots_page(start).encode(), MOST_KNOT_REQUEST)
        self._fit = fit

    def answer(self, word: str, asked: Any) -> dict[str, Any]:
        """Return the answer to a request: ``try`` fits knots [m], ``save`` accepts them."""
        knots = asked.get("knots") if isinstance(asked, dict) else None
        if not (
            isinstance(knots, list) and 0 < len(knots) <= MOST_KNOTS
            and all(isinstance(knot, int | float) and 0 < knot < 1e3 for knot in knots)
        ):  # fmt: skip
            raise FricError(f"that is not a list of 1 to {MOST_KNOTS} displacements")
        ordered = sorted(float(knot) for knot in knots)
        with self.lock:
            found = _found(self._fit(ordered))
        if word == "save":
            self.end(ordered)
        return found


def _found(result: GMSResult) -> dict[str, Any]:
    """Return the content of the page about a fit: rows of blocks, and of records."""
    gms, fit = result.document["gms"], result.document["gms_fit"]
    ends = gms["alpha"].get("ci95"), gms["k"].get("ci95")
    limits = [list(pair) for pair in zip(*ends, strict=True)] if all(ends) else []
    blocks = {"knots": result.fit.blocks.displacement.tolist(), "alpha": gms["alpha"]["value"], "k": gms["k"]["value"]}
    records = [{"name": item["record"], "rmse": item["rmse"]["value"]} for item in fit["records"]]
    return blocks | {"ci95": limits, "records": records, "rmse": fit["rmse"]["value"]}


def _knots_page(start: GMSResult) -> str:
    curve, motion = start.fit.curve, start.fit.motion
    length, force, stiffness = (si_unit(name, motion) for name in ("position", "force", "stiffness"))
    units = {
        "length": prefixed(float(curve.displacement[-1]) / 10, length),
        "force": prefixed(float(curve.force.max()), force),
        "stiffness": prefixed(float(start.fit.blocks.k.max()), stiffness),
    }
    data: dict[str, Any] = {name: getattr(curve, name).tolist() for name in ("displacement", "force", "band")}
    data["units"] = {name: {"factor": factor, "unit": unit} for name, (factor, unit) in units.items()}
    data |= {"most": MOST_KNOTS, "found": _found(start)}
    return environment().get_template("knots.html.j2").render(axis=start.fit.axis, data=data)
