"""Files of every kind, recognised by their content, brought together for a report."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import isfinite, nan
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from fric.arrays import Real
from fric.circles.next_circle import LEARNED, wrong_shape_measured
from fric.circles.prediction import Prediction
from fric.contour import QUADRANTS, Circularity
from fric.control.scheme import Scheme
from fric.documents.bundled import located
from fric.documents.contours import CircleMapDocument, prediction_of, prediction_tree
from fric.documents.machine_files import NOMINAL_DOCUMENTS
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.input import foreign
from fric.io.hdf5 import read_records
from fric.io.recognise import recognise
from fric.io.report import FORMAT, read_report
from fric.io.run import Drawn, read_drawn, read_prediction, read_run_provenance, read_runs
from fric.log import Record
from fric.notice import Notice
from fric.report.report_input import KINDS, Contour, ContourTest, Item, Measured, ReportInput
from fric.results.diagnose import diagnose
from fric.simulate.circle import CircleRun
from fric.simulate.path import PathRun
from fric.verdict.evidence import candidates_of

T = TypeVar("T", Item, ContourTest)

BINS = 720
"""Parts of a contour; its least and its greatest error in each are kept, so that no spike is thinned away."""


def collect(paths: Iterable[Path], circles: Iterable[Path] = (), tolerance: float | None = None) -> ReportInput:
    """Read what a report is made of; each file is recognised by its content.

    Run files, log files, documents of friction, plant, controller and observer, and earlier reports, which carry what
    they were made of. Where two files tell of the same thing, the one made later is reported, and the earlier is
    compared with it. Measured circles are held against the machine file, or that of the runs.

    paths: The files; the name of a bundled machine counts as its file.
    circles: Measured circles besides.
    tolerance: Glitch that is allowed [m].
    Raises FricError: When a file cannot be read, is of a kind that a report has no place for, or nothing was given to
        report.
    """
    items: list[Item] = []
    tests: list[ContourTest] = []
    records: list[Record] = []
    logs: list[tuple[str, str]] = []
    measured = list(circles)
    maps: list[tuple[str, CircleMapDocument]] = []
    machine = ""
    for path in (located(Path(given), "machine") for given in paths):
        found = recognise(path)
        kind = found.partition("/")[0]
        if kind in KINDS:
            items.append(Item(path.name, read_document(path, NOMINAL_DOCUMENTS[kind])))
        elif kind == "run":
            test = _test(path.name, read_run_provenance(path), read_runs(path, traces=False))
            tests.append(_with_drawn(test, read_drawn(path), read_prediction(path)))
        elif kind == "log":
            own = read_records(path)
            records += own
            logs.append(
                (path.name, ", ".join(dict.fromkeys(str(getattr(one, "kind", "frequency-response")) for one in own)))
            )
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
            raise FricError(
                f"holds {found}, which a report has no place for",
                where=str(path),
                hint="Give runs, circle tests, maps, logs, earlier reports, a machine file, and documents of friction, "
                "plant, controller and observer.",
            )
    if not (items or tests or measured or maps):
        raise FricError(
            "there is nothing to report but logs, or a machine",
            hint="Give a friction file of `fric identify`, a run file of `fric simulate circle`, or a circle test too.",
        )
    machine = machine or next((str(test.machine) for test in tests if test.machine), "")
    held = _with_shape([Measured(path.name, path, diagnose(path, machine=machine or None)) for path in measured])
    inputs = _sorted(items, tests, records)
    return replace(inputs, logs=tuple(logs), circles=held, machine=machine, tolerance=tolerance, maps=tuple(maps))


def _with_shape(held: Sequence[Measured]) -> tuple[Measured, ...]:
    """Return measured circles, the one that was learned with what it says of the friction model."""
    notices = wrong_shape_measured(one.result.found.test for one in held)
    made = []
    for one in held:
        found = one.result.found
        if notices and found.test.scheme == LEARNED:
            found = replace(found, warnings=(*found.warnings, *notices))
        made.append(replace(one, result=replace(one.result, found=found)))
    return tuple(made)


def _sorted(items: Sequence[Item], tests: Sequence[ContourTest], records: Sequence[Record]) -> ReportInput:
    """Tell what is newest from what came before it."""
    newest, pairs, replaced = [], [], []
    for kind in KINDS:
        for axis in dict.fromkeys(item.axis for item in items if item.kind == kind):
            alike = _by_date([item for item in items if (item.kind, item.axis) == (kind, axis)])
            last = alike[-1]
            replaced += [item for item in alike[:-1] if _carried_over(item, last)]
            before = [item for item in alike[:-1] if not _carried_over(item, last)]
            newest.append(last)
            pairs += [(earlier, last) for earlier in before]
    last_tests, test_pairs = [], []
    for same in dict.fromkeys(test.same for test in tests):
        runs = _by_date([test for test in tests if test.same == same])
        last_tests.append(runs[-1])
        test_pairs += [(earlier, runs[-1]) for earlier in runs[:-1]]
    return ReportInput(
        tuple(newest), tuple(last_tests), tuple(records), tuple(pairs), tuple(test_pairs), tuple(replaced)
    )  # fmt: skip


def _by_date(things: list[T]) -> list[T]:
    """Sort by date where each has one; else the order given is that of time."""
    return sorted(things, key=lambda thing: thing.created) if all(thing.created for thing in things) else things


def _carried_over(earlier: Item, later: Item) -> bool:
    """Say whether all that the earlier document identified stands in the later one: a static map, then its GMS."""
    about = {"fric", "axis", "motion", "fit", "warnings", "provenance"}
    return all(later.tree.get(key) == value for key, value in earlier.tree.items() if key not in about)


def _test(source: str, provenance: Mapping[str, Any], runs: Sequence[CircleRun | PathRun]) -> ContourTest:
    first, contours = runs[0], _contours(runs)
    if isinstance(first, CircleRun):
        circle = first.circle
        return ContourTest(
            source, provenance, circle.feed, circle.radius, circle.direction, QUADRANTS, contours, runs=runs
        )
    labels = tuple(
        f"{'xy'[reversal.axis]} at ({reversal.x * 1e3:.3g}, {reversal.y * 1e3:.3g}) mm"
        for reversal in first.contour.reversals
    )
    return ContourTest(source, provenance, first.path.feed, None, 1, labels, contours, runs=runs)


def _with_drawn(test: ContourTest, drawn: Mapping[str, Drawn], prediction: Prediction | None) -> ContourTest:
    schemes = prediction.schemes if prediction else {}
    contours = (
        replace(one, drawn=drawn[name].glitches, swings=drawn[name].swings, predicted=schemes.get(name))
        if (name := one.scheme.name) in drawn
        else one
        for one in test.contours
    )
    return replace(test, contours=tuple(contours), prediction=prediction)


def _contours(runs: Sequence[CircleRun | PathRun]) -> tuple[Contour, ...]:
    made = []
    for run, one in zip(runs, candidates_of(runs), strict=True):
        found = run.contour
        place, error = thinned(found.angle if isinstance(found, Circularity) else found.station, found.error)
        made.append(
            Contour(
                **vars(one), rms=run.chance("rms").median, range=run.chance("range").median, place=place, error=error
            )
        )
    return tuple(made)


def thinned(place: Real, error: Real, bins: int = BINS) -> tuple[Real, Real]:
    """Return the least and the greatest of each of so many parts of a curve, in order, and its two ends."""
    if len(place) <= 2 * bins:
        return place, error
    edges = np.linspace(0, len(place), bins + 1).astype(int)
    kept = {0, len(place) - 1}
    for start, stop in pairwise(edges):
        kept |= {start + int(np.argmin(error[start:stop])), start + int(np.argmax(error[start:stop]))}
    chosen = np.array(sorted(kept))
    return place[chosen], error[chosen]


def as_data(inputs: ReportInput) -> dict[str, Any]:
    """Return what a report is made of as plain data, which stands in its page and `contour_test` reads again."""
    return {
        "fric": FORMAT,
        "documents": [{"source": item.source, "tree": item.tree} for item in inputs.items],
        "tests": [_test_data(test) for test in inputs.tests],
    }


def _test_data(test: ContourTest) -> dict[str, Any]:
    head = {key: getattr(test, key) for key in ("source", "feed", "radius", "direction")}
    contours = []
    for one in test.contours:
        numbers = {key: getattr(one, key) for key in ("glitch", "rms", "range", "oscillation")}
        contours.append(
            {
                "scheme": one.scheme.plain(), "glitches": list(one.glitches), **numbers,
                "warnings": [Notice.of(text).as_dict() for text in one.warnings],
                "place": [float(f"{value:.6g}") for value in one.place],
                "error": [float(f"{value:.4g}") for value in one.error],
                "drawn": [float(f"{value:.4g}") if isfinite(value) else None for value in one.drawn],
                "swings": [float(f"{value:.3g}") if isfinite(value) else None for value in one.swings],
                "places": list(one.places),
            }
        )  # fmt: skip
    head |= {"prediction": prediction_tree(test.prediction) if test.prediction else None}
    return head | {"provenance": dict(test.provenance), "labels": list(test.labels), "contours": contours}


def contour_test(data: Mapping[str, Any], before: str) -> ContourTest:
    """Return a test from the data of an earlier report."""
    prediction = prediction_of(data["prediction"]) if data.get("prediction") else None

    def machines(given: Sequence[float | None]) -> tuple[float, ...]:
        return tuple(nan if value is None else float(value) for value in given)

    contours = tuple(
        Contour(
            scheme=Scheme.of(one["scheme"]), glitches=tuple(map(float, one["glitches"])), glitch=float(one["glitch"]),
            rms=float(one["rms"]), range=float(one["range"]), place=np.array(one["place"], float),
            error=np.array(one["error"], float),
            warnings=tuple(map(Notice.of, one["warnings"])),
            drawn=machines(one.get("drawn", ())), oscillation=float(one.get("oscillation", 0.0)),
            swings=machines(one.get("swings", ())), places=tuple(map(float, one.get("places", ()))),
            predicted=prediction.schemes.get(one["scheme"]["name"]) if prediction else None,
        )
        for one in data["contours"]
    )  # fmt: skip
    return ContourTest(
        before + data["source"], dict(data["provenance"]), float(data["feed"]),
        None if data["radius"] is None else float(data["radius"]), int(data["direction"]),
        tuple(map(str, data["labels"])), contours, prediction,
    )  # fmt: skip
