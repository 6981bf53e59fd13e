"""Collection of files of every kind, recognised by their content, for a report; and how numbers drift between dates."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import hypot, inf, isclose, isfinite, nan
from pathlib import Path
from typing import Any, Literal, TypeVar

from fric.arrays import Real
from fric.circles.prediction import Predicted, Prediction
from fric.circles.tune import LEARNED, wrong_shape_measured
from fric.contour import QUADRANTS, Circularity
from fric.control.scheme import Scheme
from fric.documents.base import AxisDocument, OfAxis, run_provenance
from fric.documents.bundled import bundled, located
from fric.documents.contours import CircleMapDocument, prediction_of, prediction_tree
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import NOMINAL_DOCUMENTS
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.estimate import Estimate, elements
from fric.figures.style import thinned
from fric.flaws import flaw_of
from fric.input import foreign
from fric.io.circle import DrawnGlitches, choose_circles, read_drawn, read_prediction, read_run_provenance, read_runs
from fric.io.hdf5 import read_records
from fric.io.recognise import FORMAT, read_report, recognise
from fric.log import Record
from fric.notice import Notice
from fric.results.circles import DiagnosisResult, diagnose
from fric.series import keep
from fric.simulate.contour_run import CircleRun, ContourRun, PathRun
from fric.units import Motion, readable
from fric.verdict import Candidate, Verdict, candidates_of, decide, evidence_of, machine_name

KINDS = ("friction", "plant", "controller", "observer")  # The documents that a report shows, in its order
_alike = partial(isclose, rel_tol=0.02)


@dataclass(frozen=True)
class Change:
    """One number at two dates."""

    name: str  # name, unit: its name, and its SI unit
    unit: str
    before: float  # before, after: its values
    after: float
    before_ci95: tuple[float, float] | None = None  # before_ci95, after_ci95: None without; an infinite limit is unseen
    after_ci95: tuple[float, float] | None = None

    @property
    def difference(self) -> float:
        """After less before."""
        return self.after - self.before

    @property
    def relative(self) -> float | None:
        """The difference over the earlier value; None where that is 0."""
        return self.difference / abs(self.before) if self.before else None

    @property
    def difference_ci95(self) -> tuple[float, float] | None:
        """95 % interval of the difference of two independent numbers with intervals that need not be symmetric.

        The distances of the limits from the values add in quadrature (Zou and Donner 2008, the method of variance
        estimates recovery): below, the later number's lower with the earlier number's upper; above, the other way
        round.
        """
        if self.before_ci95 is None or self.after_ci95 is None:
            return None
        below = hypot(self.after - self.after_ci95[0], self.before_ci95[1] - self.before)
        above = hypot(self.after_ci95[1] - self.after, self.before - self.before_ci95[0])
        return self.difference - below, self.difference + above

    @property
    def verdict(self) -> Literal["moved", "within", "unknown"]:
        """``moved`` if the interval of the difference does not contain 0; ``unknown`` without an interval."""
        if (interval := self.difference_ci95) is None or interval == (-inf, inf):
            return "unknown"
        return "within" if interval[0] <= 0 <= interval[1] else "moved"


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
        """The document as plain values, without keys that hold nothing (null): a page takes them for absent."""
        return self.document.tree(nulls=False)

    @property
    def provenance(self) -> Mapping[str, Any]:
        """What made it."""
        return self.tree.get("provenance") or {}

    @property
    def created(self) -> str:
        """When it was made, in ISO 8601; empty where not stated."""
        return str(self.provenance.get("created", ""))

    @property
    def warnings(self) -> list[Notice]:
        """Warnings: what the data do not determine."""
        return list(self.document.notices())

    def sections(self) -> dict[str, dict[str, Estimate]]:
        """Return its numbers in SI by section; a document without sections is a section of its name."""
        if isinstance(document := self.document, AxisDocument):
            return {self.kind: document.estimates(self.motion)}
        assert isinstance(document, FrictionDocument)
        return {name: document.estimates(name) for name in document.sections()}

    def changes(self, later: "Item") -> list[Change]:
        """Return the change of each number that a later document of this kind and axis has, too.

        Values that were set by hand or assumed are left out. Slip blocks are compared one by one if their number is
        equal.
        """
        found: list[Change] = []
        earlier_sections = self.sections()
        for section, estimates in later.sections().items():
            prefix = "" if section in {"static", later.kind} else f"{section}."
            earlier = earlier_sections.get(section, {})
            for name in (name for name in estimates if name in earlier):
                estimate, other = earlier[name], estimates[name]
                if not (estimate.fixed or estimate.assumed or other.fixed or other.assumed):
                    found += _changes(prefix + name, estimate, other)
        return found


@dataclass(frozen=True, eq=False, kw_only=True)
class Contour(Candidate):
    """Result of one compensation scheme on a contour: a candidate of the verdict, with its curves."""

    rms: float  # rms, range: root mean square, and largest less smallest contour error [m]
    range: float
    place: Real  # Angle on the circle [rad], or station along the path [m], shape (n,); thinned
    error: Real  # Contour error there [m], outwards positive, shape (n,)

    def __post_init__(self) -> None:
        keep(self, {"place": "position", "error": "position"}, self.named, least=1)


@dataclass(frozen=True, eq=False)
class Measured:
    """A measured circle."""

    source: str  # File that it was read from
    path: Path  # The same, as it was given
    result: DiagnosisResult  # The circle taken apart, and held against the machine where that is known


@dataclass(frozen=True)
class ContourTest:
    """One contour followed under one or more schemes."""

    source: str  # File that it was read from
    provenance: Mapping[str, Any]  # What made the file
    feed: float  # Speed along the contour [m/s]
    radius: float | None  # Radius of the circle [m]; None for a path
    direction: int  # 1 counter-clockwise, -1 clockwise
    labels: tuple[str, ...]  # The place of each glitch: the quadrants of a circle, the reversals of a path
    contours: tuple[Contour, ...]  # One per scheme
    prediction: Prediction | None = None  # Results on the machines drawn from what was identified; None where none were
    runs: Sequence[ContourRun[Any, Any]] = field(default=(), compare=False)  # The runs, without traces

    def __post_init__(self) -> None:
        if len({contour.scheme.name for contour in self.contours}) < len(self.contours):
            raise FricError("holds two results of one scheme", where=self.source, hint="Make it again.")
        if not all(0.0 < size < inf for size in (self.feed, self.radius) if size is not None):
            raise FricError("holds a radius or a feed that is not above 0", where=self.source, hint="Make it again.")

    @property
    def created(self) -> str:
        """When it was made, in ISO 8601; empty where the file does not state it."""
        return str(self.provenance.get("created", ""))

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes that were run; x and y if the file does not name them."""
        return tuple(map(str, self.provenance.get("axes", ("x", "y"))))

    @property
    def machine(self) -> Path | None:
        """The machine file that it was run on, if it still exists; or the name of a bundled machine."""
        path = str(self.provenance.get("origin", {}).get("path", ""))
        return Path(path) if path in bundled("machine") or (path and Path(path).exists()) else None

    @property
    def of_file(self) -> str:
        """Of which machine curves and reversals are; empty where no others were drawn."""
        return " on the machine of the file" if any(contour.drawn for contour in self.contours) else ""

    @property
    def same(self) -> tuple[Any, ...]:
        """The common properties of two comparable tests."""
        return (self.radius, self.feed, self.direction, self.labels)

    def changes(self, later: "ContourTest") -> list[Change]:
        """Return the change of the glitch of each scheme that a later test ran, too."""
        earlier = {contour.scheme.name: contour for contour in self.contours}
        both = [(earlier[after.scheme.name], after) for after in later.contours if after.scheme.name in earlier]
        known = [(old, new) for old, new in both if isfinite(new.middle + old.middle)]
        return [Change(new.named, "m", old.middle, new.middle, old.interval, new.interval) for old, new in known]


@dataclass(frozen=True)
class ReportInput:
    """Input of a report: the newest data on each subject, and the older data that they replace."""

    items: tuple[Item, ...] = ()  # The newest document of each kind and axis
    tests: tuple[ContourTest, ...] = ()  # The newest run of each contour
    records: tuple[Record, ...] = ()  # Records of logs, for measured points
    pairs: tuple[tuple[Item, Item], ...] = ()  # Earlier and newest document of one kind and axis
    test_pairs: tuple[tuple[ContourTest, ContourTest], ...] = ()  # Earlier and newest run of one contour
    replaced: tuple[Item, ...] = ()  # Earlier documents within newer ones, as a static map in the GMS model's file
    logs: tuple[tuple[str, str], ...] = ()  # Names of the log files, each with the kinds of its records
    circles: tuple[Measured, ...] = ()  # Measured circles
    machine: str = ""  # The machine file that was given, or that the runs were made with; empty where there is none
    tolerance: float | None = None  # Glitch that is allowed [m]; None where nothing was asked
    failed: tuple[str, ...] = ()  # Steps that failed on the way to what is reported, and why
    maps: tuple[tuple[str, CircleMapDocument], ...] = ()  # Names of the maps over feed and radius, and their content

    def of(self, kind: str, axis: str) -> Item | None:
        """Return the document of a kind for an axis, or None."""
        return next((item for item in self.items if (item.kind, item.axis) == (kind, axis)), None)

    def verdict(self, test: ContourTest) -> Verdict:
        """Return the verdict by a test and all measured circles."""
        held = [circle for circle in self.circles if circle.result.held is not None]
        held.sort(key=lambda circle: not self._of_test(circle, test))  # the circle that was simulated judges first
        more: dict[str, Any] = {"machine": machine_name(self.machine)} if self.machine else {}
        file = self.machine or str(test.provenance.get("origin", {}).get("path", ""))
        if test.radius and file and not str(test.provenance.get("command", "")).startswith("fric simulate "):
            circle = f'--radius "{readable(test.radius, "m")}" --velocity "{readable(test.feed, "m/s")}"'
            more["command"] = f"fric simulate circle {machine_name(file)} {circle} -o run.h5"
        compared = [circle.result for circle in held if circle.result.glitches() is not None]
        more |= {"glitches": compared[0].glitches(), "unmodelled": compared[0].unmodelled()} if compared else {}
        more |= {"circle": str(held[0].path)} if held else {}
        given = evidence_of(
            test.provenance, test.contours, test.prediction, compared=bool(held), tolerance=self.tolerance,
            disagreements={circle.source: circle.result.disagreements(circle.source) for circle in held},
            measured=self._measured(test), notices=self._notices(test), **more,
        )  # fmt: skip
        return decide(given)

    @staticmethod
    def _of_test(circle: Measured, test: ContourTest) -> bool:
        """Return whether a measured circle has the feed and the radius of a test."""
        seen = circle.result.found.test
        return _alike(seen.feed, test.feed) and _alike(seen.radius, test.radius or 0.0)

    def _measured(self, test: ContourTest) -> dict[str, float]:
        """Return the largest glitch measured on the circle of a test [m], by active scheme, stated or supposed."""
        found: dict[str, float] = {}
        for circle in self.circles:
            seen, held = circle.result.found.test, circle.result.held
            scheme = seen.scheme or (held.scheme if held else "")
            if scheme and self._of_test(circle, test):
                found[scheme] = max(circle.result.found.glitch, found.get(scheme, 0.0))
        return found

    def _notices(self, test: ContourTest) -> list[Notice]:
        """Return the warnings of files, run and circles, and separately circles that differ from their prediction."""
        notices = [notice for item in self.items for notice in item.warnings]
        circles = [notice for circle in self.circles for notice in circle.result.warnings]
        return notices + self.warned(test) + [circle for circle in circles if not flaw_of(circle).disagrees]

    def warned(self, test: ContourTest) -> list[Notice]:
        """Return the warnings of a run, without those repeated from the given files."""
        known = {(notice.code, notice.says) for item in self.items for notice in item.warnings}
        again = map(Notice.of, test.provenance.get("warnings_coded", ()))
        return [notice for notice in again if (notice.code, notice.says) not in known]

    def axes(self) -> list[str]:
        """Return the axes of documents."""
        return list(dict.fromkeys(item.axis for item in self.items))


T = TypeVar("T", Item, ContourTest)

DIGITS = {"place": 6, "error": 4, "drawn": 4, "swings": 3}  # Digits of a contour's numbers in a page
BINS = 720  # Number of parts of a contour; the least and greatest error of each are kept, so that no spike is lost


def collect(paths: Iterable[Path], circles: Iterable[Path] = (), tolerance: float | None = None) -> ReportInput:
    """Read the data of a report; each file is recognised by its content.

    Run files, log files, documents of friction, plant, controller and observer, and earlier reports, which contain
    their data. Of two files on the same subject, the later is reported, and the earlier is compared with it. Measured
    circles, of several in a file the fastest, are compared with the machine file, or that of the runs.
    """
    items, tests, records = list[Item](), list[ContourTest](), list[Record]()
    logs, maps = list[tuple[str, str]](), list[tuple[str, CircleMapDocument]]()
    measured, machine = list(circles), ""
    for path in (given if given.suffix else located(given, "machine") for given in map(Path, paths)):
        found = recognise(path)
        if (kind := found.partition("/")[0]) in KINDS:
            items.append(Item(path.name, read_document(path, NOMINAL_DOCUMENTS[kind])))
        elif kind == "run":
            tests.append(_test(path))
        elif kind == "log":
            of_file = read_records(path)
            records += of_file
            logs.append((path.name, ", ".join(dict.fromkeys(str(record.kind) for record in of_file))))
        elif kind == "circle":
            measured.append(path)
        elif kind == "machine":
            machine = str(path)
        elif kind == CircleMapDocument.type:
            maps.append((path.name, read_document(path, CircleMapDocument)))
        elif found == FORMAT:
            earlier = read_report(path)
            with foreign(path, "Make it again with `fric report`.", lacking=True):
                for entry in earlier["documents"]:
                    document = NOMINAL_DOCUMENTS[str(entry["tree"]["fric"]).partition("/")[0]]
                    items.append(Item(f"{path.name}: {entry['source']}", document.model_validate(entry["tree"])))
                tests += [contour_test(entry, f"{path.name}: ") for entry in earlier["tests"]]
        else:
            hint = "Give runs, circle tests, maps, logs, earlier reports, a machine file, and documents of friction, "
            hint += "plant, controller and observer."
            raise FricError(f"holds {found}, which a report does not show", where=str(path), hint=hint)
    if not (items or tests or measured or maps):
        hint = "Give a friction file of `fric identify`, a run file of `fric simulate circle`, or a circle test too."
        raise FricError("logs or a machine alone make no report", hint=hint)
    machine = machine or next((str(test.machine) for test in tests if test.machine), "")
    fastest = {path: max(test.feed for test in choose_circles([path])) for path in measured}  # of several in a file
    held = _with_shape([
        Measured(path.name, path, diagnose(path, machine=machine or None, feed=f"{feed!r} m/s"))
        for path, feed in fastest.items()
    ])  # fmt: skip
    inputs = _sorted(items, tests, records)
    return replace(inputs, logs=tuple(logs), circles=held, machine=machine, tolerance=tolerance, maps=tuple(maps))


def _with_shape(held: Sequence[Measured]) -> tuple[Measured, ...]:
    """Return measured circles; the learned circle with its statement about the friction model."""
    notices = wrong_shape_measured(circle.result.found.test for circle in held)
    made = []
    for circle in held:
        found = circle.result.found
        if notices and found.test.scheme == LEARNED:
            found = replace(found, warnings=(*found.warnings, *notices))
        made.append(replace(circle, result=replace(circle.result, found=found)))
    return tuple(made)


def _sorted(items: Sequence[Item], tests: Sequence[ContourTest], records: Sequence[Record]) -> ReportInput:
    """Separate the newest documents from earlier ones."""
    newest, pairs, replaced = [], [], []
    for kind in KINDS:
        for axis in dict.fromkeys(item.axis for item in items if item.kind == kind):
            alike = _by_date([item for item in items if (item.kind, item.axis) == (kind, axis)])
            last = alike[-1]
            replaced += [item for item in alike[:-1] if _carried_over(item, last)]
            newest.append(last)
            pairs += [(item, last) for item in alike[:-1] if not _carried_over(item, last)]
    latest, test_pairs = [], []
    for same in dict.fromkeys(test.same for test in tests):
        runs = _by_date([test for test in tests if test.same == same])
        latest.append(runs[-1])
        test_pairs += [(earlier, runs[-1]) for earlier in runs[:-1]]
    return ReportInput(tuple(newest), tuple(latest), tuple(records), tuple(pairs), tuple(test_pairs), tuple(replaced))


def _by_date(things: list[T]) -> list[T]:
    """Sort by date if each has a date; else keep the given order."""
    return sorted(things, key=lambda thing: thing.created) if all(thing.created for thing in things) else things


def _carried_over(earlier: Item, later: Item) -> bool:
    """Return whether the later document contains all results of the earlier: a static map, then its GMS."""
    about = {"fric", "axis", "motion", "fit", "warnings", "provenance"}
    return all(later.tree.get(key) == value for key, value in earlier.tree.items() if key not in about)


def _test(path: Path) -> ContourTest:
    """Return the runs of a file, with what was left on the machines that were drawn."""
    head, runs = (path.name, read_run_provenance(path)), read_runs(path, traces=False)
    drawn, prediction = read_drawn(path), read_prediction(path)
    candidates = zip(runs, candidates_of(runs), strict=True)
    contours = tuple(_contour(*item, drawn.get(item[0].scheme.name), prediction) for item in candidates)
    if isinstance(first := runs[0], CircleRun):
        circle = first.circle
        return ContourTest(*head, circle.feed, circle.radius, circle.direction, QUADRANTS, contours, prediction, runs)
    labels = tuple(f"{'xy'[r.axis]} at ({r.x * 1e3:.3g}, {r.y * 1e3:.3g}) mm" for r in first.contour.reversals)
    return ContourTest(*head, first.test.feed, None, 1, labels, contours, prediction, runs)


def _contour(
    run: CircleRun | PathRun, candidate: Candidate, drawn: DrawnGlitches | None, prediction: Prediction | None
) -> Contour:
    found = run.contour
    place, error = thinned(found.angle if isinstance(found, Circularity) else found.station, found.error, BINS)
    known = vars(candidate) | {"rms": run.chance("rms").median, "range": run.chance("range").median}
    if drawn is not None:
        predicted = prediction.schemes.get(run.scheme.name) if prediction else None
        known |= {"drawn": drawn.glitches, "swings": drawn.swings, "predicted": predicted}
    return Contour(**known, place=place, error=error)


def as_data(inputs: ReportInput) -> dict[str, Any]:
    """Return the content of a report as plain data, which its page contains and `contour_test` reads again."""
    documents = [{"source": item.source, "tree": item.tree} for item in inputs.items]
    return {"fric": FORMAT, "documents": documents, "tests": [_test_data(test) for test in inputs.tests]}


def _test_data(test: ContourTest) -> dict[str, Any]:
    head = {key: getattr(test, key) for key in ("source", "feed", "radius", "direction")}
    contours = [
        {"scheme": contour.scheme.plain(), "glitches": list(contour.glitches)}
        | {key: getattr(contour, key) for key in ("glitch", "rms", "range", "oscillation")}
        | {"warnings": [Notice.of(text).as_dict() for text in contour.warnings]}
        | {
            key: [float(f"{value:.{digits}g}") if isfinite(value) else None for value in getattr(contour, key)]
            for key, digits in DIGITS.items()
        }
        | {"places": list(contour.places)}
        for contour in test.contours
    ]
    head |= {"prediction": prediction_tree(test.prediction) if test.prediction else None}
    return head | {"provenance": dict(test.provenance), "labels": list(test.labels), "contours": contours}


def contour_test(data: Mapping[str, Any], before: str) -> ContourTest:
    """Return a test from the data of an earlier report."""
    prediction = prediction_of(data["prediction"]) if data.get("prediction") else None
    schemes: Mapping[str, Predicted] = prediction.schemes if prediction else {}

    def numbers(item: Mapping[str, Any]) -> dict[str, Any]:
        """Return numbers that are not there as nan, and none where a file before them has none."""
        series = {key: item.get(key, ()) for key in ("drawn", "swings", "places")}
        many = {key: tuple(nan if v is None else float(v) for v in values) for key, values in series.items()}
        return many | {key: float(item[key]) for key in ("glitch", "rms", "range")}

    try:
        contours = tuple(
            Contour(
                scheme=Scheme.of(item["scheme"]), predicted=schemes.get(item["scheme"]["name"]),
                warnings=tuple(map(Notice.of, item["warnings"])), place=item["place"], error=item["error"],
                glitches=tuple(map(float, item["glitches"])), oscillation=float(item.get("oscillation", 0.0)),
                **numbers(item),
            )
            for item in data["contours"]
        )  # fmt: skip
    except FricError as error:
        where, hint = f"{before}{data['source']}: {error.where}", "Make it again with `fric report`."
        raise FricError(error.what, where=where, hint=hint) from None
    return ContourTest(
        before + data["source"], run_provenance(data["provenance"], before + data["source"]), float(data["feed"]),
        None if data["radius"] is None else float(data["radius"]), int(data["direction"]),
        tuple(map(str, data["labels"])), contours, prediction,
    )  # fmt: skip


def _changes(name: str, before: Estimate, after: Estimate) -> Iterator[Change]:
    earlier, later = (dict(elements({name: estimate})) for estimate in (before, after))
    for key, estimate in later.items() if earlier.keys() == later.keys() else ():
        ends: Any = earlier[key].ci95, estimate.ci95
        yield Change(key, estimate.unit, float(earlier[key]), float(estimate), *ends)


def description(changes: list[Change]) -> str:
    """Return a sentence on how many numbers changed by more than their intervals allow."""
    moved = [change for change in changes if change.verdict == "moved"]
    known = [change for change in changes if change.verdict != "unknown"]
    if not any(change.difference for change in changes):
        return "No number changed." if changes else "The two share no identified number."
    if not known:
        return "None of the numbers has an interval: whether a difference is a change is not known."
    if not moved:
        return f"None of the {len(known)} numbers with intervals moved beyond them."
    shares = ("from 0" if change.relative is None else f"{change.relative:+.1%}" for change in moved)
    names = ", ".join(f"{item.name} ({share.replace('-', '−')})" for item, share in zip(moved, shares, strict=True))
    return f"{len(moved)} of {len(known)} numbers moved beyond their intervals: {names}."
