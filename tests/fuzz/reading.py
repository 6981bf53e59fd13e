"""How each kind of input is read, as the commands do it, and what must hold of what comes out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

import fric
from fric.control.scheme import Scheme, choose_schemes
from fric.documents import document_types
from fric.documents.machine_files import read_machine
from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.circle import read_circles, read_drawn, read_path, read_run_provenance, read_runs
from fric.io.hdf5 import read_records
from fric.io.ingest import ingest
from fric.io.propose import proposal
from fric.io.recognise import read_report, recognise
from fric.log import Log
from fric.report.collect import collect
from fric.simulate.contour_run import Circle, run_circle
from tests.fuzz.words import AbsurdError, run_words


def _mapping(**columns: dict[str, object]) -> MappingDocument:
    return MappingDocument.model_validate({"fric": "mapping/1", "columns": columns})


_BAG = _mapping(
    time={"column": "time"},
    position={"column": "/j.position[x]", "unit": "mm"},
    force={"column": "/j.effort[x]", "unit": "N"},
)
MAPPINGS = {
    ".mcap": _BAG,
    ".db3": _BAG,
    ".bag": _BAG,
    ".mat": _mapping(time={"column": "time", "unit": "s"}, position={"column": "position", "unit": "mm"}),
    ".xml": _mapping(time={"column": "time"}, position={"column": "Position X", "unit": "mm"}),
    ".txt": _mapping(time={"rate": "4 kHz"}, position={"column": 2, "unit": "mm"}, input={"column": 3, "unit": "V"}),
}
"""Of formats whose files do not tell their units."""


def _foreign(path: Path) -> None:
    """Read a log in; what is written is whole or absent."""
    output = path.with_name("out.h5")
    output.unlink(missing_ok=True)
    try:
        ingest(path, output, mapping=MAPPINGS.get(path.suffix), bad_cells="drop", force=True)
        read_records(output)
    finally:
        left = [one.name for one in path.parent.iterdir() if one.name.startswith(".out-")]
        if left:
            raise AbsurdError(f"left over: {left}")
    _printable(proposal([path]))


def _printable(text: str) -> None:
    if not all(one.isprintable() or one in "\n\t" for one in text):
        raise AbsurdError(f"control characters in {text!r}"[:300])


def _log(path: Path) -> None:
    read_records(path)
    _foreign(path)


def _run(path: Path) -> None:
    read_runs(path)
    read_run_provenance(path)
    read_drawn(path)


def _yaml(path: Path) -> None:
    kind = recognise(path).partition("/")[0]
    read_document(path, document_types().get(kind, document_types()["plant"]))


def _report(path: Path) -> None:
    read_report(path)
    collect([path])


def _machine(path: Path) -> None:
    """Read a machine, and run a small circle on it."""
    machine = read_machine(path)
    blocks = next((tuple(axis.blocks) for axis in machine.axes.values()), ())
    scheme = Scheme("k", "its blocks", blocks=blocks) if blocks else choose_schemes("a")[0]
    result = run_circle(machine, scheme, Circle(0.0002, 0.05))
    if not isfinite(result.circularity.glitch):
        raise AbsurdError(f"a glitch of {result.circularity.glitch}")


def _values(path: Path) -> None:
    """Identify what records allow, and hold the numbers to what friction can be."""
    logs = [one for one in fric.read(path) if isinstance(one, Log)]
    kinds = {one.kind for one in logs}
    if "constant-velocity" in kinds:
        _judge(fric.identify_static(*logs).document)
    elif "presliding-sine" in kinds:
        _judge(fric.identify_gms(*logs, blocks=3, refine=False).document)
        _judge(fric.identify_model("dahl", *logs, fix={"n": 1.0}).document)
    else:
        _judge(fric.identify_plant(*logs).document)


SIGNED = frozenset({"offset", "force_lag", "n", "matrix", "phase", "delta"})
"""Numbers that may be below zero."""


def _judge(document: Mapping[str, Any]) -> None:
    """Raise where a parameter is not finite, or negative where it cannot be, or R² is below 0 without a warning."""
    for name, value in _parameters(document):
        if not isfinite(value) or (value < 0.0 and name not in SIGNED):
            raise AbsurdError(f"{name} is {value}")
    quality = document.get("fit", {}).get("r2")
    if quality is not None and not quality >= 0.0 and not document.get("warnings"):
        raise AbsurdError(f"R² is {quality} without a warning")


def _parameters(tree: Mapping[str, Any], name: str = "") -> Iterator[tuple[str, float]]:
    for key, value in tree.items():
        if key == "value" and isinstance(value, int | float | list):
            yield from ((name, float(one)) for one in np.ravel(value))
        elif isinstance(value, Mapping):
            yield from _parameters(value, key)


def changed_values(path: Path, rng: np.random.Generator) -> list[Log]:
    """Return the records of a log file with values changed as flaws, wrong units and broken channels change them."""
    logs = [replace(one, source=path.name) for one in read_records(path) if isinstance(one, Log)]
    for _ in range(int(rng.integers(1, 4))):
        name = str(rng.choice(["position", "force", "input", "velocity", "time"]))
        change = CHANGES[int(rng.integers(len(CHANGES)))]
        some = rng.random() < 0.7
        seed = int(rng.integers(1 << 32))
        with suppress(FricError):  # what no record can be; `tests/hostile/test_types.py` holds those to that
            logs = [
                replace(log, **{name: change(getattr(log, name), np.random.default_rng(seed))})
                if getattr(log, name) is not None and (some or n == 0)
                else log
                for n, log in enumerate(logs)
            ]
    kept = rng.random() < 0.2
    return logs[: int(rng.integers(1, len(logs) + 1))] if kept else logs


def _put(values: np.ndarray, rng: np.random.Generator, what: float) -> np.ndarray:
    changed = values.copy()
    changed[rng.integers(len(values), size=int(rng.integers(1, 20)))] = what
    return changed


CHANGES: tuple[Callable[[np.ndarray, np.random.Generator], np.ndarray], ...] = (
    lambda v, rng: v * 10.0 ** int(rng.integers(-9, 10)),
    lambda v, rng: -v,
    lambda v, rng: 0.0 * v + float(rng.choice([0.0, 5.0, -1e-9])),
    lambda v, rng: np.clip(v, *np.quantile(v, np.sort(rng.random(2)))),
    lambda v, rng: np.round(v / (step := np.ptp(v) * 10.0 ** -rng.uniform(0, 5) + 1e-30)) * step,
    lambda v, rng: _put(v, rng, float(rng.choice([0.0, 1e300, -1e300, 1e12, 1e-300, 1e9]))),
    lambda v, rng: v + np.ptp(v) * rng.normal(size=len(v)) * 10.0 ** -rng.uniform(0, 4),
    lambda v, rng: rng.normal(size=len(v)),
    lambda v, rng: v + np.ptp(v) * np.linspace(0, 1, len(v)) * 10.0 ** rng.uniform(-2, 2),
    lambda v, rng: v + 10.0 ** rng.uniform(-3, 6) * np.ptp(v),
    lambda v, rng: np.roll(v, int(rng.integers(len(v)))),
    lambda v, rng: np.repeat(v[:: (k := int(rng.integers(2, 64)))], k)[: len(v)],
    lambda v, rng: v[::-1].copy(),
    lambda v, rng: np.sort(v),
    lambda v, rng: np.abs(v),
    lambda v, rng: np.where(np.arange(len(v)) < len(v) * rng.random(), v, v[0]),
    lambda v, rng: np.sign(v) * np.abs(v) ** rng.uniform(0.2, 4.0),
)
"""What is done to the values of a channel."""

READ: dict[str, Callable[[Path], object]] = {
    "foreign": _foreign,
    "log": _log,
    "run": _run,
    "circle": read_circles,
    "path": lambda path: read_path(path, 0.05),
    "yaml": _yaml,
    "report": _report,
    "machine": _machine,
    "values": _values,
    "words": run_words,
}
