"""`auto`: recognise, ingest, identify, design, simulate, compare with the measured circle, and report."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from fric.automatic.fleet import FleetResult, find_fleet, fleet
from fric.automatic.sources import Sources, find_sources
from fric.automatic.steps import (
    AxisOutcome,
    Session,
    Step,
    circle_step,
    diagnosis_step,
    identify_axes,
    machine_tree,
    run_step,
    step,
    trace_step,
    tune_step,
)
from fric.documents.automatic import AutoDocument
from fric.documents.bundled import located
from fric.documents.friction import FrictionDocument
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.flaws.files import GAINS_DESIGNED, STEP_FAILED, TUNED
from fric.notice import Notice, once
from fric.report.summary import Report, make_report
from fric.results.base import Result
from fric.results.diagnose import diagnose
from fric.results.given import bounded
from fric.results.given_models import machine_of
from fric.results.kinds import Address, CircleFiles, Count, MachineFile, Quantity
from fric.results.text import Piece
from fric.units import rotates
from fric.verb import Kind, verb
from fric.verdict.decide import decide
from fric.verdict.evidence import Evidence, Verdict


@dataclass(frozen=True, eq=False, repr=False)
class AutoResult(Result):
    """What came of a folder of logs.

    Parameters
    ----------
    folder
        Where all files are.
    axes
        What came of each axis: which steps were done, and what is missing.
    description
        What was guessed or left out.
    steps, made
        Steps there are, and how many had to be run.
    page
        The report; None where there was nothing to report.
    rotary
        Whether all axes are rotary.
    """

    folder: Path
    axes: dict[str, AxisOutcome]
    description: list[Notice]
    steps: int
    made: int
    page: Report | None
    rotary: bool = False

    @property
    def warnings(self) -> Sequence[Notice]:
        """What was guessed or left out."""
        return self.description

    @cached_property
    def document(self) -> dict[str, Any]:
        """Report, axes, and the verdict."""
        report = str(self.folder / "report.html") if self.page else None
        content = {"report": report, "axes": self.axes, "verdict": self.verdict}
        return AutoDocument.made(content, notices=self.warnings).tree()

    @cached_property
    def verdict(self) -> Verdict:
        """The scheme to use, its glitch, and whether that is to be trusted, and why not."""
        inputs = self.page.inputs if self.page else None
        if inputs and inputs.tests:
            return inputs.verdict(inputs.tests[-1])
        return decide(Evidence(axes=tuple(self.axes), rotary=self.rotary))

    def report(self) -> list[Piece]:
        """Return what was done and is missing of each axis, and the verdict."""
        lines: list[Piece] = []
        for name, one in self.axes.items():
            lines.append(f"axis {name}: {', '.join(one.done) or 'nothing'}")
            lines += [f"  missing for {text}" for text in one.missing]
        lines += self.verdict.lines()
        lines.append(f"{self.made} of {self.steps} steps were run, the rest was up to date")
        return [*lines, f"{self.folder / 'report.html'}"] if self.page else lines


@verb
def auto(
    *logs: Annotated[Path | str, Kind(metavar="LOGS")],
    output: Annotated[Path | str, Kind(metavar="DIR")],
    machine: MachineFile | None = None,
    circles: CircleFiles = (),
    tolerance: Annotated[Quantity | None, "position"] = None,
    mapping: Annotated[str | None, Kind(metavar="MAP.yaml")] = None,
    assume: bool = False,
    workers: Count | None = None,
    scheduler: Address | None = None,
    run: Callable[[Step], None] = run_step,
    say: Callable[[str], None] = lambda _: None,
    advance: Callable[..., object] = lambda *_, **__: None,
) -> AutoResult | FleetResult:
    """Go the whole way: recognise, ingest, identify, design, simulate, compare with the measured circle, report.

    Each step is an ordinary command, printed as it is run and kept in DIR/steps.sh. What cannot be done says which
    record is missing. Steps whose inputs have not changed are not run again.

    A folder of many machines (DIR/machine/date/…) is a fleet: each axis is identified at each date, on all cores or a
    Dask cluster, and DIR/fleet.html tells which changed beyond their intervals.

    Parameters
    ----------
    logs
        Logs and circle tests, or folders of them. Or the folder of a fleet.
    output
        Folder for all that is made.
    machine
        The machine; made of what is identified, else. Its file, or the name of a bundled one.
    circles
        A measured circle; repeatable. The simulation is held against it.
    tolerance
        Glitch that is allowed, as "5 um". The first scheme that surely stays within it is chosen.
    mapping
        What the columns of foreign logs mean. The bundled one that fits where the header does not say it.
    assume
        Take the likeliest of what neither headers nor values of foreign logs tell, and say so.
    workers
        Of a fleet: processes at a time; one a core, else.
    scheduler
        Of a fleet: a Dask scheduler, as tcp://host:8786.
    run
        Makes one step, raising a `FricError` where it fails; of a fleet in other processes, and so a function that
        can be pickled.
    say
        Is told each command as it is run.
    advance
        Is told of each machine and date of a fleet.

    Raises
    ------
    FricError
        When a file is not there, or none holds a record.
    """
    folder = Path(output)
    if units := find_fleet(list(map(Path, logs))):
        if machine or circles or tolerance is not None:
            raise FricError("a fleet is identified, and takes no machine, circle or tolerance")
        return fleet(units, folder, mapping=mapping, run=run, workers=workers, scheduler=scheduler, advance=advance)
    found = find_sources(map(Path, logs), mapping, folder / "mappings", assume=assume)
    tests = find_sources(map(Path, circles))
    found.circles, found.traces = [*found.circles, *tests.circles], [*found.traces, *tests.traces]
    found.description += tests.description
    nothing = not (found.logs or found.circles or found.traces)
    if nothing and found.open.found:
        raise found.open.error()
    if nothing:
        hint = (
            "Give logs, or their folder; or say what their columns are: `fric ingest FILES --propose MAP.yaml`, --map."
        )
        raise FricError("there is no log in these files", hint="\n".join([*found.description[:1], hint]))
    session = Session(folder, run, say)
    for trace in found.traces:
        one = trace_step(trace, folder)
        found.circles += one.leaves if session.take(one) else ()
    axes = identify_axes(session, found)
    given = located(Path(machine), "machine") if machine else None
    subject = _machine(session, axes, given)
    _circles(session, found, axes, subject, given is not None)
    pages = [path for one in axes.values() for path in one.there]
    pages += [path for path in (folder / "circle.h5",) if path.exists()]
    page, allowed = None, None if tolerance is None else bounded("tolerance", tolerance)
    if pages:
        pages += [subject] if subject is not None else []
        read = [*pages, *(path for one in axes.values() for path in one.logs)]
        asked = {"circle": found.circles, "tolerance": None if allowed is None else f"{allowed!r} m"}
        session.take(step("report", "report", read, asked, [*read, *found.circles], output=folder / "report.html"))
        page = make_report(*pages, circles=found.circles, tolerance=allowed)
    session.close()
    for name, failure in session.failed.items():
        if name.partition(":")[0] not in axes:
            found.description.append(STEP_FAILED.found(name, why=str(failure)))
    described = list(once(found.description))
    rotary = bool(axes) and all(rotates(one.motion) for one in axes.values())
    return AutoResult(folder, axes, described, session.steps, session.made, page, rotary)


def _machine(session: Session, axes: dict[str, AxisOutcome], given: Path | None) -> Path | None:
    """Return the machine file: the one that is given, or one made of what was identified."""
    if given is not None:
        return given
    whole = {name: one.files for name, one in axes.items() if not rotates(one.motion) and one.whole}
    if not whole or any(read_document(files["plant"], PlantDocument).K_f is None for files in whole.values()):
        return None
    path = session.folder / "machine.yaml"
    session.write(machine_tree(whole, session.folder), path)
    return path


def _circles(session: Session, found: Sources, axes: dict[str, AxisOutcome], machine: Path | None, given: bool) -> None:
    """Simulate the circle, and hold measured ones against the machine."""
    if machine is None:
        return
    options: dict[str, Any] = {}
    reads, whole = [path for one in axes.values() for path in one.there], [n for n, one in axes.items() if one.whole]
    if given:
        names = machine_of(machine).axes
        parts = [
            (name, axes[name].files[part]) for name in axes if name in names for part in ("friction", "plant")
        ]  # fmt: skip
        options["friction"] = [f"{name}={path}" for name, path in parts if path.exists()]
    else:
        frictions = [read_document(axes[name].files["friction"], FrictionDocument) for name in whole]
        if not all(one.section("gms") for one in frictions):
            options["scheme"] = "a,b,d,e"  # there is no GMS model to feed forward
        if len(whole) == 1:
            options["axis"] = whole[0]
    if found.circles:
        test = diagnose(found.circles[0]).found.test
        options |= {"radius": f"{test.radius!r} m", "velocity": f"{test.feed!r} m/s", "measured": found.circles}
        reads += found.circles
        if not given:
            found.description.append(GAINS_DESIGNED.found())
    session.take(circle_step(machine, session.folder, options, reads))
    for circle in found.circles:
        session.take(diagnosis_step(circle, machine, session.folder, reads))
    if found.circles and session.take(tune_step(found.circles, machine, session.folder, reads)):
        found.description.append(TUNED.found(folder=str(session.folder / "tuned")))
