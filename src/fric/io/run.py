"""Run files: HDF5 with ``fric = "run/1"``, a group per scheme, in it a group per axis and the metrics as attributes."""

import json
from collections.abc import Iterable
from dataclasses import dataclass, fields
from math import ceil
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fric.circles.prediction import Prediction
from fric.contour import Circularity, ContourError, Figures, Reversal
from fric.control.scheme import Scheme
from fric.documents.contours import MonteCarloPart, prediction_of, prediction_tree
from fric.input import foreign
from fric.io.safe_hdf5 import check_type, column, open_file, staged_hdf5, text, write_column
from fric.notice import Notice
from fric.series import keep, require_plausible
from fric.simulate.axis import Trace
from fric.simulate.contour_run import Circle, CircleRun, PathRun, PointPath, RecordedPath
from fric.simulate.processes import MonteCarlo
from fric.units import si_unit

FORMAT = "run/1"
AGAIN = "Make it again with `fric simulate`."
MONTE_CARLO = "monte_carlo"  # The group of the results of many machines; every other group is of a scheme

DIMENSIONS = {
    "time": "time", "reference": "position", "position": "position", "measured": "position", "velocity": "velocity",
    "input": "input", "friction": "force", "feedforward": "input", "disturbance": "input",
}  # fmt: skip
REVERSAL = [("axis", "i8"), ("x", "f8"), ("y", "f8"), ("glitch", "f8")]


def write_runs(
    path: Path,
    runs: Iterable[CircleRun | PathRun],
    provenance: str = "",
    *,
    many: MonteCarlo | None = None,
    prediction: Prediction | None = None,
    most_samples: int | None = None,
    force: bool = False,
) -> None:
    """Write the runs of schemes on a circle or a path to a run file, whole or not at all.

    path: The run file.
    runs: One run per scheme.
    provenance: What made the file, as JSON.
    most_samples: Largest number of samples of a trace that are kept: of a longer trace every n-th sample. Radial errors
        and metrics are those of all samples. All where it is not given.
    many: What the schemes made of it on many machines.
    prediction: What these show of the identified machine.
    force: Replace a file that exists.
    """
    with staged_hdf5(path, force=force) as (file, check):
        file.attrs.update({"fric": FORMAT, "provenance": provenance})
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
    group.attrs.update({"feed": run.path.feed, "contour_rms": found.rms, "contour_range": found.range})
    write_column(group, "station", found.station, "m")
    write_column(group, "error", found.error, "m")
    write_column(group, "points", np.column_stack([run.path.x, run.path.y]), "m")
    if isinstance(run.path, RecordedPath):
        write_column(group, "time", run.path.time, "s")
    group["reversals"] = np.array(
        [(reversal.axis, reversal.x, reversal.y, reversal.glitch) for reversal in found.reversals], REVERSAL
    )


def read_runs(path: Path, *, traces: bool = True) -> list[CircleRun | PathRun]:
    """Read the runs of a run file, one per scheme.

    path: The run file.
    traces: Read what each axis recorded too, which is nearly all of the file.
    Raises FricError: When it is no run file, or cut short.
    """
    with open_file(path, hint=AGAIN) as file:
        check_type(file, path, FORMAT, "Give a file of `fric simulate circle`.")
        with foreign(path, AGAIN, lacking=True):
            return [_read(group, traces) for name, group in file.items() if name != MONTE_CARLO]


def read_run_provenance(path: Path) -> dict[str, Any]:
    """Return what made a run file: ``fric``, ``created``, ``command``, ``machine``; empty where it is not stated."""
    with open_file(path, hint=AGAIN) as file:
        words = json.loads(text(file.attrs, "provenance") or "{}")
    return words if isinstance(words, dict) else {}


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


def _read(group: h5py.Group, with_traces: bool) -> CircleRun | PathRun:
    attributes = {key: value.item() if isinstance(value, np.generic) else value for key, value in group.attrs.items()}
    scheme = Scheme.of({key[7:]: value for key, value in attributes.items() if key.startswith("scheme_")})
    where = f"{group.file.filename}, scheme '{scheme.name}'"
    traces = {
        axis: Trace(
            **{channel: column(recorded, channel) for channel in DIMENSIONS}, saturated=int(recorded.attrs["saturated"])
        )
        for axis, recorded in (group["axes"].items() if with_traces else ())
    }
    for trace in traces.values():
        keep(trace, DIMENSIONS, where)
    coded = json.loads(str(attributes.get("warnings_coded", "[]")))
    warnings: tuple[Notice, ...] = tuple(map(Notice.of, coded))
    warnings = warnings or tuple(Notice.of(line) for line in str(attributes["warnings"]).splitlines() if line)
    rows = column(group, "places", ndim=2).tolist() if "places" in group else ()
    at_places = tuple(
        Figures(tuple(glitches), *others) for *glitches, others in ((*row[:-3], row[-3:]) for row in rows)
    )
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
