"""A fleet: a folder ``DIR/machine/date`` of logs, identified on all cores or on a cluster, and what changed since."""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from fric.automatic.session import Run, Session, identify_axes, run_apart
from fric.automatic.sources import find_sources
from fric.documents.yaml import plain, read_tree
from fric.errors import FricError
from fric.flaws.files import CIRCLE_FAILED, NO_LOG, UNIT_FAILED
from fric.notice import Notice
from fric.results.diagnose import diagnose
from fric.simulate.processes import run_all
from fric.units import readable

DATE = re.compile(r"\d{4}-?\d{2}(-?\d{2}(\D.*)?)?")
"""Names of folders that are dates: 2026-11, 2026-11-21, 20261121, with a time behind it or without."""

KINDS = ("static", "friction", "plant")
"""Documents of an axis whose numbers are compared; the friction of a GMS model holds its static map."""


@dataclass(frozen=True)
class Unit:
    """The logs of one machine at one date."""

    machine: str
    date: str
    folder: Path


@dataclass(frozen=True)
class UnitOutcome:
    """What came of the logs of one machine at one date."""

    unit: Unit  # Where they are from
    # By axis, which steps were done and what is missing, its documents by kind, and its glitches on measured circles
    axes: dict[str, dict[str, Any]]
    description: tuple[Notice, ...]  # What was guessed, left out, or could not be read
    # steps, made: steps there are, and how many had to be run
    steps: int = 0
    made: int = 0


def find_fleet(given: Sequence[Path]) -> list[Unit]:
    """Return machines and dates, where what is given is one folder of folders of dates; nothing, else."""
    if len(given) != 1 or not given[0].is_dir():
        return []
    machines = [one for one in sorted(given[0].iterdir()) if one.is_dir() and not one.name.startswith(".")]
    units = [
        Unit(machine.name, date.name, date.resolve())
        for machine in machines
        for date in sorted(machine.iterdir())
        if date.is_dir()
    ]
    dated = all(DATE.fullmatch(one.date) for one in units)
    return units if dated and {one.machine for one in units} == {one.name for one in machines} else []


@dataclass(frozen=True)
class FleetStudy:
    """Identifies the axes of one machine at one date, by its number in the fleet."""

    units: tuple[Unit, ...]  # Machines and dates
    output: Path  # Folder for all that is made: a folder of each machine and date, with its steps
    mapping: str | None = None  # What the columns of foreign logs mean
    run: Run = run_apart  # Runs one command

    def __call__(self, index: int) -> UnitOutcome:
        """Identify plant, static map and GMS of each axis; what fails is said, and is no end of the others."""
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):  # what commands print of hundreds is no help
            return self._identified(self.units[index])

    def _identified(self, unit: Unit) -> UnitOutcome:
        try:
            found = find_sources([unit.folder], self.mapping, self.output / unit.machine / unit.date / "mappings")
        except FricError as error:
            return UnitOutcome(unit, {}, (UNIT_FAILED.found(why=str(error)),))
        if not (found.logs or found.circles):
            return UnitOutcome(unit, {}, (NO_LOG.found(), *found.description))
        session = Session(self.output / unit.machine / unit.date, self.run, lambda _: None)
        axes: dict[str, dict[str, Any]] = {}
        for name, one in identify_axes(session, found, lean=True).items():
            files = {kind: session.folder / name / f"{kind}.yaml" for kind in KINDS}
            documents = {kind: plain(read_tree(file)) for kind, file in files.items() if file.exists()}
            axes[name] = {"done": one["done"], "missing": one["missing"], "documents": documents, "glitches": {}}
        for path in found.circles:
            try:
                glitches = _glitches(diagnose(path).document)
            except FricError as error:
                found.description.append(CIRCLE_FAILED.found(str(path), why=error.what))
                continue
            for name, one in glitches.items():
                known = axes.setdefault(name, {"done": [], "missing": [], "documents": {}, "glitches": {}})
                known["glitches"] |= one
                known["done"] += [] if "circle" in known["done"] else ["circle"]
        session.close()
        return UnitOutcome(unit, axes, tuple(found.description), session.steps, session.made)


def _glitches(diagnosis: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the glitches of a measured circle by axis and name, which says quadrant and test."""
    radius, feed = (readable(diagnosis[name]["value"], unit) for name, unit in (("radius", "m"), ("feed", "m/s")))
    sense = ", clockwise" if diagnosis["direction"]["value"] < 0 else ""
    found: dict[str, dict[str, Any]] = {}
    for quadrant, one in diagnosis["glitch"].items():
        found.setdefault(quadrant[1:], {})[f"glitch {quadrant}, {radius} at {feed}{sense}"] = one
    return found


def run_fleet(
    units: Sequence[Unit],
    output: Path,
    *,
    mapping: str | None = None,
    run: Run = run_apart,
    workers: int | None = None,
    scheduler: str | None = None,
    advance: Callable[..., object] = lambda *_, **__: None,
) -> list[UnitOutcome]:
    """Return what came of each machine and date in their order, run by processes here or by a Dask cluster.

    Parameters
    ----------
    units
        Machines and dates.
    output
        Folder for all that is made; a cluster's workers see it, and the logs, under the same names.
    mapping, run
        As in `FleetStudy`.
    workers
        Processes; one a core where not given.
    scheduler
        Address of a Dask cluster.
    advance
        Is told of each that is done.

    Raises
    ------
    FricError
        When the cluster does not answer, or a process was killed.
    """
    study = FleetStudy(tuple(units), output.resolve(), mapping, run)
    advance(0, total=len(units))
    return run_all(study, len(units), workers=workers, scheduler=scheduler, advance=advance)
