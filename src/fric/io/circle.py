"""Circle test files: HDF5 with ``fric = "circle/1"``. The root is a test; ``tests/`` holds further ones of its form."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, cast

import h5py

from fric.circles.measured import CHANNELS, AxisTrace, Instrument, MeasuredCircle, measured_from_run
from fric.columns import BALL_BAR, channel_dimension
from fric.errors import FricError, clean
from fric.input import TAKEN, foreign, other_kind
from fric.io.run import FORMAT as RUN
from fric.io.run import read_runs
from fric.io.safe_hdf5 import column, open_file, text
from fric.io.staged_hdf5 import staged_hdf5, write_column
from fric.simulate.circle import CircleRun
from fric.units import si_unit

FORMAT = "circle/1"
OWN = ("instrument", "scheme", "source", "sha256", "name")


def write_circles(path: Path, tests: Sequence[MeasuredCircle], provenance: str = "", *, force: bool = False) -> None:
    """Write circle tests to a file, whole or not at all.

    path: The file.
    tests: The tests: the first at the root, further ones, of the other direction or another feed, in ``tests/``.
    provenance: What made the file, as JSON.
    force: Replace a file that exists.
    """
    with staged_hdf5(path, force=force) as (file, check):
        file.attrs.update({"fric": FORMAT, "provenance": provenance})
        for n, test in enumerate(tests):
            _write(file if n == 0 else file.create_group(f"tests/{n + 1}"), test)
            check()


def _write(group: h5py.Group, test: MeasuredCircle) -> None:
    group.attrs.update({"radius": test.radius, "feed": test.feed, "direction": test.direction})
    group.attrs.update({key: clean(getattr(test, key)) for key in OWN if getattr(test, key)})
    for key, unit in BALL_BAR.items():
        if (values := getattr(test, key)) is not None:
            write_column(group, key, values, unit)
    for name, trace in test.axes.items():
        axis = group.create_group(name)
        axis.attrs["order"] = list(test.axes).index(name)
        for channel, values in trace.channels().items():
            write_column(axis, channel, values, si_unit(channel_dimension(channel)))


def read_circles(path: Path, scheme: str | None = None) -> list[MeasuredCircle]:
    """Read the circle tests of a file of `fric ingest --kind circle`, or the circles of a run file, one a scheme.

    path: The file.
    scheme: Name of the one scheme of a run file that is wanted; all where it is not given.
    Raises FricError: When it is neither, is cut short, or has no such scheme.
    """
    path = Path(path)
    with open_file(path) as file:
        found = text(file.attrs, "fric", "nothing of fric's")
        if found == FORMAT:
            with foreign(path, "Make it again with `fric ingest --kind circle`.", lacking=True):
                groups = [file, *(file[f"tests/{name}"] for name in sorted(file.get("tests", ()), key=int))]
                return [_read(group, str(path)) for group in groups]
    if found != RUN and found.partition("/")[0] in TAKEN:
        raise other_kind(path, found, FORMAT)
    if found != RUN:
        raise FricError(
            f"holds {found}, not {FORMAT} or {RUN}", where=str(path),
            hint="Read the trace with `fric ingest --kind circle`, or give a file of `fric simulate circle -o`.",
        )  # fmt: skip
    runs = [run for run in read_runs(path) if isinstance(run, CircleRun)]
    names = ", ".join(run.scheme.name for run in runs)
    if not runs:
        raise FricError("holds no circle", where=str(path), hint="Give a file of `fric simulate circle -o`.")
    if scheme is not None:
        runs = [run for run in runs if run.scheme.name == scheme]
        if not runs:
            raise FricError(f"holds no scheme '{scheme}'", where=str(path), hint=f"Its schemes are {names}.")
    return [measured_from_run(run, str(path)) for run in runs]


def _read(group: h5py.Group, source: str) -> MeasuredCircle:
    words = {key: text(group.attrs, key) for key in OWN if key in group.attrs and key != "source"}
    axes = {
        name: AxisTrace(**{channel: column(part, channel) for channel in CHANNELS if channel in part})
        for name, part in sorted(
            ((name, part) for name, part in group.items() if isinstance(part, h5py.Group) and "position" in part),
            key=lambda item: (int(item[1].attrs.get("order", 99)), item[0]),
        )
    }
    bar = {key: column(group, key) for key in BALL_BAR if key in group}
    words["instrument"] = cast(Instrument, words.get("instrument", ""))
    return MeasuredCircle(
        float(group.attrs["radius"]), float(group.attrs["feed"]), int(group.attrs["direction"]), axes,
        source=source, **cast(Any, {**bar, **words}),
    )  # fmt: skip


def choose_circles(paths: Iterable[Path], scheme: str | None = None) -> list[MeasuredCircle]:
    """Read the circle tests of some files; of a run file with several schemes one must be named.

    Raises FricError: As `read_circles`, and when it is not said which scheme of a run is meant.
    """
    found: list[MeasuredCircle] = []
    for path in map(Path, paths):
        tests = read_circles(path, scheme if _is_run(path) else None)
        schemes = [test.scheme for test in tests]
        if _is_run(path) and len(tests) > 1:
            raise FricError(
                f"holds {len(tests)} schemes", where=str(path),
                hint=f"Say which with `scheme=`: {' or '.join(schemes)}.",
            )  # fmt: skip
        found += tests
    return found


def _is_run(path: Path) -> bool:
    with open_file(path) as file:
        return text(file.attrs, "fric") == RUN
