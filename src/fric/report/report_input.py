"""What a report is made of, in one plain structure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isclose
from pathlib import Path
from typing import Any

from fric.arrays import Real
from fric.circles.prediction import Prediction
from fric.documents.base import AxisDocument, OfAxis
from fric.documents.bundled import bundled
from fric.documents.contours import CircleMapDocument
from fric.documents.friction import FrictionDocument
from fric.estimate import Estimate
from fric.flaws import flaw_of
from fric.log import Record
from fric.notice import Notice
from fric.results.diagnose import DiagnosisResult
from fric.simulate.contour_run import ContourRun
from fric.units import Motion, readable
from fric.verdict.decide import decide
from fric.verdict.evidence import Candidate, Verdict, evidence_of, machine_name

KINDS = ("friction", "plant", "controller", "observer")
"""The documents that a report tells of, in its order."""


@dataclass(frozen=True)
class Item:
    """One document, and where it is from."""

    source: str  # File that it was read from
    document: OfAxis  # The document: friction, plant, controller or observer

    @property
    def kind(self) -> str:
        """Its type, one of `KINDS`."""
        return self.document.type

    @property
    def axis(self) -> str:
        """Name of its axis."""
        return self.document.axis

    @property
    def motion(self) -> Motion:
        """Linear or rotary."""
        return self.document.motion

    @cached_property
    def tree(self) -> Mapping[str, Any]:
        """The document as plain values."""
        return self.document.tree()

    @property
    def provenance(self) -> Mapping[str, Any]:
        """What made it."""
        return self.tree.get("provenance") or {}

    @property
    def created(self) -> str:
        """When it was made, in ISO 8601; empty where it does not say."""
        return str(self.provenance.get("created", ""))

    @property
    def warnings(self) -> list[Notice]:
        """What the data could not tell."""
        return list(self.document.notices())

    def sections(self) -> dict[str, dict[str, Estimate]]:
        """Return its numbers in SI by section; a document without sections is one of its own name."""
        document = self.document
        if isinstance(document, AxisDocument):
            return {self.kind: document.estimates(self.motion)}
        assert isinstance(document, FrictionDocument)
        return {name: document.estimates(name) for name in document.sections()}


@dataclass(frozen=True, eq=False, kw_only=True)
class Contour(Candidate):
    """What one compensation scheme leaves of a contour: a candidate of the verdict, with what is drawn of it."""

    # rms, range: root mean square, and largest less smallest contour error [m]
    rms: float
    range: float
    place: Real  # Angle on the circle [rad], or station along the path [m], shape (n,); thinned
    error: Real  # Contour error there [m], outwards positive, shape (n,)


@dataclass(frozen=True, eq=False)
class Measured:
    """A measured circle."""

    source: str  # File that it was read from
    path: Path  # The same, as it was given
    result: DiagnosisResult  # The circle taken apart, and held against the machine where that is known

    @property
    def glitch(self) -> float:
        """The largest glitch that was measured [m]."""
        return max(abs(one.value) for one in self.result.found.glitches.values())

    def disagreements(self) -> list[Notice]:
        """Return where the circle is not as predicted, with the likely cause."""
        return self.result.disagreements(self.source)


@dataclass(frozen=True)
class ContourTest:
    """One contour followed under one or more schemes."""

    source: str  # File that it was read from
    provenance: Mapping[str, Any]  # What made the file
    feed: float  # Speed along the contour [m/s]
    radius: float | None  # Radius of the circle [m]; None for a path
    direction: int  # 1 counter-clockwise, -1 clockwise
    labels: tuple[str, ...]  # What each glitch stands at: the quadrants of a circle, the reversals of a path
    contours: tuple[Contour, ...]  # One per scheme
    prediction: Prediction | None = None  # What the machines drawn from what was identified say; None where none were
    # The runs themselves, without traces; none of an earlier report
    runs: Sequence[ContourRun[Any, Any]] = field(default=(), compare=False)

    @property
    def created(self) -> str:
        """When it was made, in ISO 8601; empty where the file does not say."""
        return str(self.provenance.get("created", ""))

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes that were run; x and y where the file does not say."""
        return tuple(map(str, self.provenance.get("axes", ("x", "y"))))

    @property
    def machine(self) -> Path | None:
        """The machine file that it was run on, where it is still there; the name of a bundled one counts."""
        path = str(self.provenance.get("origin", {}).get("path", ""))
        known = path in bundled("machine") or (path and Path(path).exists())
        return Path(path) if known else None

    @property
    def same(self) -> tuple[Any, ...]:
        """What two tests share that can be compared."""
        return (self.radius, self.feed, self.direction, self.labels)


def _alike(one: float, other: float) -> bool:
    return isclose(one, other, rel_tol=0.02)


@dataclass(frozen=True)
class ReportInput:
    """All that was given for a report, the newest of each, and what it takes the place of."""

    items: tuple[Item, ...] = ()  # The newest document of each kind and axis
    tests: tuple[ContourTest, ...] = ()  # The newest run of each contour
    records: tuple[Record, ...] = ()  # Records of logs, for measured points
    pairs: tuple[tuple[Item, Item], ...] = ()  # Earlier and newest document of one kind and axis
    test_pairs: tuple[tuple[ContourTest, ContourTest], ...] = ()  # Earlier and newest run of one contour
    # Earlier documents that stand whole in a newer one, as a static map does in the file of the GMS model
    replaced: tuple[Item, ...] = ()
    logs: tuple[tuple[str, str], ...] = ()  # Names of the log files, each with the kinds of its records
    circles: tuple[Measured, ...] = ()  # Measured circles
    machine: str = ""  # The machine file that was given, or that the runs were made with; empty where there is none
    tolerance: float | None = None  # Glitch that is allowed [m]; None where nothing was asked
    failed: tuple[str, ...] = ()  # Steps that failed on the way to what is reported, and why
    maps: tuple[tuple[str, CircleMapDocument], ...] = ()  # Names of the maps over feed and radius, and what they hold

    def of(self, kind: str, axis: str) -> Item | None:
        """Return the document of a kind for an axis, or None."""
        return next((item for item in self.items if (item.kind, item.axis) == (kind, axis)), None)

    def verdict(self, test: ContourTest) -> Verdict:
        """Return what to switch on, by one test and all measured circles."""
        held = [one for one in self.circles if one.result.held is not None]
        more: dict[str, Any] = {"machine": machine_name(self.machine)} if self.machine else {}
        file = self.machine or str(test.provenance.get("origin", {}).get("path", ""))
        if test.radius and file and not str(test.provenance.get("command", "")).startswith("fric simulate "):
            circle = f'--radius "{readable(test.radius, "m")}" --velocity "{readable(test.feed, "m/s")}"'
            more["command"] = f"fric simulate circle {machine_name(file)} {circle} -o run.h5"
        compared = [both for one in held if (both := one.result.glitches()) is not None]
        more |= {"glitches": compared[-1]} if compared else {}
        given = evidence_of(
            test.provenance, test.contours, test.prediction, compared=bool(held), tolerance=self.tolerance,
            disagreements={one.source: one.disagreements() for one in held}, measured=self._measured(test),
            notices=self._notices(test), **({"circle": str(held[0].path)} if held else {}), **more,
        )  # fmt: skip
        return decide(given)

    def _measured(self, test: ContourTest) -> dict[str, float]:
        """Return the largest glitch that was measured on the circle of a test [m], by the scheme that was on."""
        found: dict[str, float] = {}
        for one in self.circles:
            seen = one.result.found.test
            if seen.scheme and _alike(seen.feed, test.feed) and _alike(seen.radius, test.radius or 0.0):
                found[seen.scheme] = max(one.glitch, found.get(seen.scheme, 0.0))
        return found

    def _notices(self, test: ContourTest) -> list[Notice]:
        """Return what files, a run and the circles warn of; a circle that is not as predicted is told apart."""
        own = [notice for item in self.items for notice in item.warnings]
        circles = [notice for one in self.circles for notice in one.result.warnings]
        return own + self.warned(test) + [one for one in circles if not flaw_of(one).disagrees]

    def warned(self, test: ContourTest) -> list[Notice]:
        """Return what a run warns of, less what it tells again of the files that were given."""
        known = {(notice.code, notice.says) for item in self.items for notice in item.warnings}
        again = map(Notice.of, test.provenance.get("warnings_coded", ()))
        return [one for one in again if (one.code, one.says) not in known]

    def axes(self) -> list[str]:
        """Return the axes that documents tell of."""
        return list(dict.fromkeys(item.axis for item in self.items))
