"""Files of circles, runs and paths.

In a circle test (``circle/1``) the root is a test, and ``tests/`` holds further ones. What was learned
(``feedforward/1``) is voltage against friction. A path is two columns, or a recorded reference. Run files (``run/1``)
have a group per scheme, in it a group per axis and the metrics as attributes.
"""

import json
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, fields
from math import ceil
from pathlib import Path
from typing import Any, cast

import h5py
import numpy as np

from fric.arrays import Real
from fric.circles.learn import LearnedFeedforward
from fric.circles.measured import CHANNELS, AxisTrace, Instrument, MeasuredCircle, measured_from_run
from fric.circles.prediction import Prediction
from fric.columns import BALL_BAR, channel_dimension
from fric.contour import Circularity, ContourError, Figures, Reversal
from fric.control.scheme import Scheme
from fric.documents.base import run_provenance
from fric.documents.contours import MonteCarloPart, prediction_of, prediction_tree
from fric.documents.mapping import ColumnMapping
from fric.errors import FricError, clean, found_in
from fric.input import foreign
from fric.io.channels import origin_of
from fric.io.readers import tables
from fric.io.safe_hdf5 import check_type, column, members, open_file, staged_hdf5, text, write_column
from fric.notice import Notice
from fric.series import keep, require_plausible
from fric.simulate.axis import Trace
from fric.simulate.contour_run import Circle, CircleRun, PathRun, PointPath, RecordedPath
from fric.simulate.processes import MonteCarlo
from fric.units import si_unit

RUN = "run/1"
AGAIN = "Make it again with `fric simulate`."
MONTE_CARLO = "monte_carlo"  # The group of the results of many machines; every other group is of a scheme

DIMENSIONS = {
    "time": "time", "reference": "position", "position": "position", "measured": "position", "velocity": "velocity",
    "input": "input", "friction": "force", "feedforward": "input", "disturbance": "input",
}  # fmt: skip
REVERSAL = [("axis", "i8"), ("x", "f8"), ("y", "f8"), ("glitch", "f8")]


def write_runs(
    path: Path, runs: Iterable[CircleRun | PathRun], provenance: str = "", *, many: MonteCarlo | None = None,
    prediction: Prediction | None = None, most_samples: int | None = None, force: bool = False,
) -> None:  # fmt: skip
    """Write the runs of schemes on a circle or a path to a run file, whole or not at all.

    most_samples: Largest number of samples of a trace that are kept: of a longer trace every n-th sample. Radial errors
        and metrics are those of all samples. All where it is not given.
    many: What the schemes made of it on many machines.
    prediction: What these show of the identified machine.
    """
    with staged_hdf5(path, force=force) as (file, check):
        file.attrs.update({"fric": RUN, "provenance": provenance})
        if many is not None:
            _write_monte_carlo(file.create_group(MONTE_CARLO), many)
            if prediction is not None:
                file[f"{MONTE_CARLO}/prediction"] = json.dumps(prediction_tree(prediction))
        for run in runs:
            group = file.create_group(run.scheme.name)
            group.attrs.update({f"scheme_{key}": value for key, value in run.scheme.plain().items()})
            group.attrs.update({"unit": "m", "glitch": run.contour.glitch, "warnings": "\n".join(run.warnings)})
            group.attrs["warnings_coded"] = json.dumps([Notice.of(warning).as_dict() for warning in run.warnings])
            if run.places:
                rows = [(*place.glitches, place.rms, place.range, place.oscillation) for place in run.places]
                write_column(group, "places", np.array(rows), "m")
            if isinstance(run, CircleRun):
                _write_circle(group, run)
            else:
                _write_path(group, run)
            for name, trace in run.traces.items():
                axis = group.create_group(f"axes/{name}")
                every = ceil(len(trace.time) / most_samples) if most_samples else 1
                axis.attrs.update({"saturated": trace.saturated, "every": every})
                for channel, dimension in DIMENSIONS.items():
                    write_column(axis, channel, getattr(trace, channel)[::every], si_unit(dimension))
                check()


def _write_monte_carlo(group: h5py.Group, many: MonteCarlo) -> None:
    text = MonteCarloPart.model_validate(many).model_dump()
    group.attrs.update({key: json.dumps(text.pop(key)) for key in ("spreads", "from_intervals")})
    group.attrs["warnings"] = "\n".join(text.pop("warnings"))
    schemes = text.pop("schemes")
    group.attrs.update(text | {"schemes": list(schemes)})
    write_column(group, "quadrants", many.quadrants, "m")
    write_column(group, "swings", many.swings, "m")
    for key in next(iter(schemes.values())):
        group.attrs[key] = np.array([scheme[key] for scheme in schemes.values()], float)
    drawn = group.create_group("drawn")
    for name in sorted({name for outcome in many.outcomes for name in outcome.drawn}):
        drawn[name] = np.array([outcome.drawn.get(name, np.nan) for outcome in many.outcomes])


def _write_circle(group: h5py.Group, run: CircleRun) -> None:
    found = run.circularity
    group.attrs.update(vars(run.circle))
    group.attrs.update({"quadrants": found.quadrants, "radial_rms": found.rms, "radial_range": found.range})
    write_column(group, "angle", found.angle, "rad")
    write_column(group, "error", found.error, "m")


def _write_path(group: h5py.Group, run: PathRun) -> None:
    found = run.contour
    group.attrs.update({"feed": run.test.feed, "contour_rms": found.rms, "contour_range": found.range})
    write_column(group, "station", found.station, "m")
    write_column(group, "error", found.error, "m")
    write_column(group, "points", np.column_stack([run.test.x, run.test.y]), "m")
    if isinstance(run.test, RecordedPath):
        write_column(group, "time", run.test.time, "s")
    group["reversals"] = np.array([astuple(reversal) for reversal in found.reversals], REVERSAL)


def read_runs(path: Path, *, traces: bool = True) -> list[CircleRun | PathRun]:
    """Read the runs of a run file, one per scheme.

    traces: Read what each axis recorded too, which is nearly all of the file.
    """
    with open_file(path, hint=AGAIN, wanted="run") as file:
        check_type(file, path, RUN, "Give a file of `fric simulate circle`.")
        with foreign(path, AGAIN, lacking=True):
            return [_read_run(group, traces) for name, group in members(file) if name != MONTE_CARLO]


def read_run_provenance(path: Path) -> dict[str, Any]:
    """Return what made a run file: ``fric``, ``created``, ``command``, ``machine``; empty where it is not stated."""
    with open_file(path, hint=AGAIN) as file, foreign(path, AGAIN, lacking=True):
        return run_provenance(json.loads(text(file.attrs, "provenance") or "{}"), str(path))


def read_prediction(path: Path) -> Prediction | None:
    """Return the predictions of schemes on the circle of a run file; None where no machines were drawn."""
    with open_file(path, hint=AGAIN) as file, foreign(path, AGAIN, lacking=True):
        key = f"{MONTE_CARLO}/prediction"
        return prediction_of(json.loads(file[key][()])) if key in file else None


@dataclass(frozen=True)
class DrawnGlitches:
    """Glitch of a scheme on each of the drawn machines [m]: nan where it could not run."""

    glitches: tuple[float, ...]  # The largest glitch
    swings: tuple[float, ...] = ()  # What swings where no axis reverses; empty in a file before that was kept


def read_drawn(path: Path) -> dict[str, DrawnGlitches]:
    """Return what each scheme left on the machines that were drawn, by its name; empty where none was drawn."""
    with open_file(path, hint=AGAIN) as file, foreign(path, AGAIN, lacking=True):
        if MONTE_CARLO not in file:
            return {}
        group = file[MONTE_CARLO]
        names = [str(name) for name in group.attrs["schemes"]]
        glitches = np.abs(column(group, "quadrants", ndim=3)).max(axis=2)
        swings = column(group, "swings", ndim=2) if "swings" in group else np.empty((0, len(names)))
        return {
            name: DrawnGlitches(tuple(map(float, glitches[:, n])), tuple(map(float, swings[:, n])))
            for n, name in enumerate(names)
        }


def _read_run(group: h5py.Group, with_traces: bool) -> CircleRun | PathRun:
    attributes = {key: value.item() if isinstance(value, np.generic) else value for key, value in members(group.attrs)}
    with found_in(f"{group.file.filename}, {group.name}"):
        scheme = Scheme.of({key[7:]: value for key, value in attributes.items() if key.startswith("scheme_")})
    where = f"{group.file.filename}, scheme '{scheme.name}'"
    traces = {
        axis: Trace(
            **{channel: column(recorded, channel) for channel in DIMENSIONS}, saturated=int(recorded.attrs["saturated"])
        )
        for axis, recorded in (members(group["axes"]) if with_traces else ())
    }
    for trace in traces.values():
        keep(trace, DIMENSIONS, where)
    warnings: tuple[Notice, ...] = tuple(map(Notice.of, json.loads(str(attributes.get("warnings_coded", "[]")))))
    warnings = warnings or tuple(Notice.of(line) for line in str(attributes["warnings"]).splitlines() if line)
    rows = column(group, "places", ndim=2).tolist() if "places" in group else ()
    at_places = tuple(Figures(tuple(each), *others) for *each, others in ((*row[:-3], row[-3:]) for row in rows))
    if "points" in group:
        reversals = tuple(Reversal(int(row[0]), *map(float, tuple(row)[1:])) for row in group["reversals"][:])
        contour = ContourError(column(group, "station"), column(group, "error"), reversals)
        keep(contour, {"station": "position", "error": "position"}, where)
        points = column(group, "points", ndim=2)
        x, y = points[:, 0], points[:, 1]
        path = RecordedPath(column(group, "time"), x, y) if "time" in group else PointPath(x, y, attributes["feed"])
        return PathRun(scheme, path, traces, contour, warnings, at_places)
    circle = Circle(**{field.name: attributes[field.name] for field in fields(Circle)})
    first, second, third, fourth = (float(value) for value in attributes["quadrants"])
    found = Circularity(column(group, "angle"), column(group, "error"), (first, second, third, fourth))
    keep(found, {"angle": "angle", "error": "position"}, where)
    require_plausible("glitch", np.array(found.quadrants), "position", where)
    return CircleRun(scheme, circle, traces, found, warnings, at_places)


FEEDFORWARD = "feedforward/1"


def write_feedforward(path: Path, table: LearnedFeedforward, provenance: str = "", *, force: bool = False) -> None:
    """Write the feedforward of the next round: attributes of its circle, and a group per axis; whole or not at all."""
    test = table.circle
    with staged_hdf5(path, force=force) as (file, check):
        file.attrs.update({"fric": FEEDFORWARD, "provenance": provenance})
        file.attrs.update({"radius": test.radius, "feed": test.feed, "direction": test.direction})
        file.attrs.update({"share": table.how.share, "bandwidth": table.how.bandwidth})
        for name in table.voltage:
            group = file.create_group(name)
            for key, unit in (("time", "s"), ("reference", "m"), ("voltage", "V")):
                write_column(group, key, np.asarray(getattr(table, key)[name], float), unit)
            check()


def read_feedforward(path: Path) -> dict[str, Real]:
    """Read the voltage that each axis fed forward against friction [V], by its name."""
    with open_file(path) as file:
        check_type(file, path, FEEDFORWARD, "Give a file of `fric learn -o`.")
        found = {name: column(group, "voltage") for name, group in members(file)}
    for name, volts in found.items():
        require_plausible("voltage", volts, "input", f"{path}, axis {name}")
    return found


def read_path(path: Path, feed: float) -> PointPath | RecordedPath:
    """Read a path from a CSV file with a header such as ``x [mm], y [mm]``, or a reference that was recorded.

    With a column ``time`` it is a recorded reference, as is that of the first test of a circle file, or of the first
    scheme of a run file.

    feed: Speed along the path [m/s]; a recorded reference includes its speed.
    """
    with foreign(path):
        if path.suffix in {".h5", ".hdf5"}:
            return _of_circle(path)
        found = _columns(path)
        return RecordedPath(**found) if "time" in found else PointPath(**found, feed=feed)


def _of_circle(path: Path) -> RecordedPath:
    recorded = (read_runs(path)[0].traces if _is_run(path) else read_circles(path)[0].axes).values()
    traces: list[Trace | AxisTrace | None] = [*recorded, None, None]
    first, second = traces[:2]
    if first is None or second is None or first.reference is None or second.reference is None:
        raise FricError("holds no reference of two axes", hint="Record where the axes were asked to be.")
    if len(first.time) != len(second.time) or not np.allclose(first.time, second.time):
        raise FricError("has axes that were recorded at different times", hint="Record both axes at the same instants.")
    return RecordedPath(first.time, first.reference, second.reference)


def _columns(path: Path) -> dict[str, Real]:
    """Return x and y [m], and time [s] where there is such a column."""
    table = next(iter(tables(path)))
    channels = {"time": "time"} if any(column.name.lower() == "time" for column in table.columns) else {}
    channels |= {"x": "x.position", "y": "y.position"}
    try:
        found = [origin_of(table, of, ColumnMapping(column=name), "linear", {}) for name, of in channels.items()]
    except FricError as error:
        raise FricError(error.what, where=error.where, hint="Head the columns 'x [mm], y [mm]'.") from None
    blocks = zip(*(block.columns for block in table.read([origin.column or 0 for origin in found])), strict=True)
    values = zip(channels, found, blocks, strict=True)
    return {name: origin.factor * np.concatenate(parts) for name, origin, parts in values}


FORMAT = "circle/1"
TEXTS = ("instrument", "scheme", "source", "sha256", "name")


def write_circles(path: Path, tests: Sequence[MeasuredCircle], provenance: str = "", *, force: bool = False) -> None:
    """Write circle tests to a file, whole or not at all.

    tests: The tests: the first at the root, further ones, of the other direction or another feed, in ``tests/``.
    """
    with staged_hdf5(path, force=force) as (file, check):
        file.attrs.update({"fric": FORMAT, "provenance": provenance})
        for n, test in enumerate(tests):
            _write(file if n == 0 else file.create_group(f"tests/{n + 1}"), test)
            check()


def _write(group: h5py.Group, test: MeasuredCircle) -> None:
    group.attrs.update({"radius": test.radius, "feed": test.feed, "direction": test.direction})
    group.attrs.update({key: clean(getattr(test, key)) for key in TEXTS if getattr(test, key)})
    for key, unit in BALL_BAR.items():
        if (values := getattr(test, key)) is not None:
            write_column(group, key, values, unit)
    for name, trace in test.axes.items():
        axis = group.create_group(name)
        axis.attrs["order"] = list(test.axes).index(name)
        for channel, values in trace.channels().items():
            unit = trace.unit if channel == "force" else si_unit(channel_dimension(channel))
            write_column(axis, channel, values, unit)


def read_circles(path: Path, scheme: str | None = None) -> list[MeasuredCircle]:
    """Read the circle tests of a file of `fric ingest --kind circle`, or the circles of a run file, one a scheme.

    scheme: Name of the scheme of a run file; all where not given. Of a circle file it says nothing.
    """
    with open_file(path, wanted="circle") as file:
        if (found := text(file.attrs, "fric", "nothing of fric's")) == FORMAT:
            with foreign(path, "Make it again with `fric ingest --kind circle`.", lacking=True):
                groups = [file, *(file[f"tests/{name}"] for name in sorted(file.get("tests", ()), key=int))]
                return [_read(group, str(path)) for group in groups]
        hint = "Read the trace with `fric ingest --kind circle`, or give a file of `fric simulate circle -o`."
        if found != RUN:
            check_type(file, path, f"{FORMAT} or {RUN}", hint)
    if not (runs := [run for run in read_runs(path) if isinstance(run, CircleRun)]):
        raise FricError("holds no circle", where=str(path), hint="Give a file of `fric simulate circle -o`.")
    if not (chosen := [run for run in runs if scheme in (None, run.scheme.name)]):
        names = ", ".join(run.scheme.name for run in runs)
        raise FricError(f"holds no scheme '{scheme}'", where=str(path), hint=f"Its schemes are {names}.")
    return [measured_from_run(run, str(path)) for run in chosen]


def _read(group: h5py.Group, source: str) -> MeasuredCircle:
    words = {key: text(group.attrs, key) for key in TEXTS if key in group.attrs and key != "source"}
    axes = {
        name: AxisTrace(
            **{channel: column(part, channel) for channel in CHANNELS if channel in part},
            unit=text(part["force"].attrs, "unit", "N") if "force" in part else "N",
        )
        for name, part in sorted(
            ((name, part) for name, part in members(group) if isinstance(part, h5py.Group) and "position" in part),
            key=lambda item: (int(item[1].attrs.get("order", 99)), item[0]),
        )
    }
    bar = {key: column(group, key) for key in BALL_BAR if key in group}
    words["instrument"] = cast("Instrument", words.get("instrument", ""))
    return MeasuredCircle(
        float(group.attrs["radius"]), float(group.attrs["feed"]), int(group.attrs["direction"]), axes,
        source=source, **cast("Any", {**bar, **words}),
    )  # fmt: skip


def choose_circles(paths: Iterable[Path], scheme: str | None = None) -> list[MeasuredCircle]:
    """Read the circle tests of some files; of a run file with several schemes a scheme must be named."""
    found: list[MeasuredCircle] = []
    for path in paths:
        if len(tests := read_circles(path, scheme)) > 1 and _is_run(path):
            hint = f"Say which with `scheme=`: {' or '.join(test.scheme for test in tests)}."
            raise FricError(f"holds {len(tests)} schemes", where=str(path), hint=hint)
        found += tests
    return found


def _is_run(path: Path) -> bool:
    with open_file(path, wanted="circle") as file:
        return text(file.attrs, "fric") == RUN
