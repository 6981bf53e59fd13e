"""`auto`: recognise, ingest, identify, design, simulate, compare with the measured circle, and report."""

import re
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from math import inf
from os.path import realpath, relpath
from pathlib import Path
from typing import Annotated, Any

from pydantic import ValidationError

from fric.automatic import steps
from fric.automatic.fleet import FleetResult, FleetStudy, find_fleet, fleet
from fric.automatic.sources import BY_SIGNS, LEAVES_OUT, Source, Sources, find_sources
from fric.automatic.steps import AxisOutcome, Session, Step, step
from fric.circles.gains import GAINS, USUAL
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.base import provenance
from fric.documents.bundled import located
from fric.documents.contours import AutoDocument
from fric.documents.controller import ControllerDocument
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import MachineDocument
from fric.documents.yaml import plain, read_document, read_tree
from fric.errors import FricError, near
from fric.estimate import Estimate, estimate_rows
from fric.flaws.channel import HOLDING_MAP
from fric.flaws.circle import CONTROLLER_DIFFERS
from fric.flaws.files import FILE_LEFT_OUT
from fric.io.circle import choose_circles
from fric.io.propose import NO_FORCE, NO_POSITION, NO_SCALE, first_of, proposal
from fric.io.questions import MOST_QUESTIONS, Ask, Question, Review
from fric.io.readers import tables
from fric.notice import Notice, once
from fric.output import folder_made
from fric.report.summary import Report, make_report
from fric.results.base import Piece, Result, Table, bounded, named
from fric.results.given_models import machine_of
from fric.results.ingest import mapping_of
from fric.results.kinds import Address, CircleFiles, EncoderName, MachineFile, Quantity, Workers
from fric.simulate.contour_run import pair
from fric.units import Motion, drive_unit, is_effort, rotates, si_unit
from fric.verb import Kind, verb
from fric.verdict import Evidence, Verdict, decide

EXAMPLE = "K_v=100 1/s, K_p=131 V*s/m, K_i=4090 V/m"  # Gains as a text
GAIN_NAMES = ("K_v", "K_p", "K_i", "velocity_filter", "velocity_feedforward", "acceleration_feedforward", "sampling")
_GAIN = re.compile(rf"({'|'.join(GAIN_NAMES)})\s*[=: ]\s*([^,;=]+)")
_AXIS = re.compile(r"\s*(\w[\w.+-]*)\s*:\s*(?=K_)")
APART = 1.25  # Ratio of a stated K_p to the interval of the logs from which it is another
EXACT = 1.05  # Largest ratio of the limits of K_p of a circle that no log is held against
WITHOUT = "report without circle"  # The step that makes the page where a circle or the machine prevents it
FRICTION = ("strokes at constant velocity", "slow sines before sliding", "a frequency response")
"""Records that a machine is identified from."""
MACHINES = 24  # Machines that are drawn from the intervals of what was identified
FOUND: Mapping[str, tuple[str, ...]] = {  # Sections of each part's file that the table of results shows
    "plant": (), "controller": (), "friction": ("static", "static_negative", "gms", "at_speed")
}  # fmt: skip
SHOWN = (  # The numbers that it shows
    "A", "B", "T_d", "K_f", "K_f/B", "K_v", "K_p", "K_i", "velocity_feedforward", "acceleration_feedforward",
    "F_c", "F_s", "v_s", "delta", "sigma", "F_v", "offset", "C",
)  # fmt: skip


@dataclass(frozen=True)
class Stated:
    """Gains that were stated, by axis: files, and texts; a text without an axis holds for all."""

    files: Mapping[str, Path]
    texts: Mapping[str, str]

    @classmethod
    def of(cls, given: Iterable[Path | str]) -> "Stated":
        """Sort what was given into files of controllers, and texts like `EXAMPLE` with the axis before a colon."""
        files, texts = dict[str, Path](), dict[str, str]()
        for item in given:
            if ("=" in str(item) or _GAIN.search(str(item))) and not Path(item).exists():
                named = _AXIS.match(str(item))
                texts[named[1] if named else ""] = text = str(item)[named.end() if named else 0 :]
                _named(text)  # refused before logs are read
            else:
                files[read_document(item, ControllerDocument).axis] = Path(item)
        return cls(files, texts)


def _named(text: str, motion: Motion = "linear") -> dict[str, str]:
    """Return the gains in a text by name; raise a `FricError` where one is missing, or has no unit."""
    given = {name: value.strip() for name, value in _GAIN.findall(text)}
    for name in (name for name in re.findall(r"(\w+)\s*=", text) if name not in GAIN_NAMES):
        raise FricError(
            f"`controllers=`: '{name}' is not a gain", hint=f"{near(name, GAIN_NAMES)}Write '{_example(motion)}'."
        )
    for name, dimension in {**GAINS, "sampling": "frequency"}.items():
        if name in given and not re.search("[a-zA-Z]", value := given[name]):
            hint = f"Write '{name}={value} {si_unit(dimension, motion)}'."
            raise FricError(f"`controllers=`: {name} has no unit in '{text}'", hint=hint)
    if lacks := " and ".join(sorted({"K_v", "K_p", "K_i"} - given.keys(), reverse=True)):
        raise FricError(f"`controllers=`: '{text}' lacks {lacks}", hint=f"Write '{_example(motion)}'.")
    return given


def gains_of(text: str, axis: str, motion: Motion) -> dict[str, Any]:
    """Return the controller document of gains in a text; filter and sampling have their defaults where it has none."""
    usual = {name: Estimate(getattr(USUAL, name), "Hz", assumed=True) for name in ("velocity_filter", "sampling")}
    content: dict[str, Any] = {"fric": ControllerDocument.type_name(), "axis": axis, "motion": motion}
    try:
        document = ControllerDocument.model_validate(content | usual | _named(text, motion))
    except ValidationError as error:
        wrong = error.errors()[0]["msg"].removeprefix("Value error, ").partition("\n")[0]
        unlogged = f": no voltage is in its logs, and a loop in {drive_unit(motion)} is simulated" * is_effort(motion)
        raise FricError(f"axis {axis}: {wrong}{unlogged}", hint=f"Write '{_example(motion)}'.") from None
    document.in_si(motion)  # refuses what no controller has
    return document.tree()


def _example(motion: Motion) -> str:
    """Return gains in the units of an axis: an example, without numbers where they depend on the force's unit."""
    return re.sub(r"=\d+", "=…", EXAMPLE).replace("V", drive_unit(motion)) if is_effort(motion) else EXAMPLE


def find_gains(
    session: Session,
    found: Sources,
    logs: Sequence[Source],
    stated: Stated,
    ask: Ask | None,
    *,
    needed: bool,
    rate: float | None = None,
) -> Path | None:
    """Return the file of an axis' gains; None where they were neither given nor found.

    ask: Asks the user, where gains are needed and no log shows them.
    rate: Of the controller of another axis [Hz]: one controller has one rate.
    """
    axis, motion = logs[0].axis, logs[0].motion
    typed, made = session.folder / axis / "gains.yaml", session.folder / axis / "controller.yaml"
    driven = [log.path for log in logs if log.driven]
    of_logs = made.with_stem("controller-of-logs")
    file, text = stated.files.get(axis) or found.controllers.get(axis), stated.texts.get(axis, stated.texts.get(""))
    if file or text is not None:
        known = plain(read_tree(file)) if file else gains_of(text or "", axis, motion)
        closed = step(f"{axis}: gains of logs", "identify controller", driven, {"axis": axis}, output=of_logs)
        against = _against(known, of_logs) if driven and session.take(closed, tried=True) else []
        if file and not against:
            return file
        session.write(known | {"warnings_coded": [*known.get("warnings_coded", ()), *against]}, typed)
        return typed
    shown, slow = None, False  # the file of a circle's gains, and whether it is slower than the controller
    rates = [rate for log in found.logs for rate in log.rates if rate < 4e4]  # what is faster, a recorder samples

    def sampled(*logged: float) -> dict[str, str]:  # a controller is as fast as the fastest voltage that is logged
        if rate is not None:
            return {"sampling": f"{rate!r} Hz"}
        return {"sampling": f"{max(rates):.6g} Hz"} if rates and 1.5 * min(logged) < max(rates) else {}

    options = {"axis": axis} | ({"motion": motion} if is_effort(motion) else {})
    for path, test in ((file, test) for file in found.circles for test in choose_circles([file])):
        trace = test.axes.get(axis)
        driven_by = None if trace is None else test.of_effort({axis: motion}).axes[axis].input
        if trace is None or driven_by is None or trace.reference is None or test.scheme not in ("", "a"):
            continue
        at = sampled(logged := len(trace.time) / float(trace.time[-1] - trace.time[0]))
        slow = 1.5 * logged < (rate or max(rates, default=0.0))
        if session.take(step(f"{axis}: gains", "identify controller", [path], options | at, output=made)):
            shown = made
            break
    if shown and _are_known(shown, 2.0 if slow else 10.0) and (not driven or _spread(shown, "K_p") < EXACT):
        return shown
    if driven and (shown or needed or is_effort(motion) or any("motion" in log.kinds for log in logs)):
        of_logs, at = of_logs if shown else made, sampled(*rates)
        closed = step(f"{axis}: gains", "identify controller", driven, {"axis": axis} | at, output=of_logs)
        if session.take(closed, tried=True):  # a compensation is in the voltage of a circle, seldom in that of strokes
            return min(filter(None, (of_logs, shown)), key=lambda file: _spread(file, "K_p"))
    if shown or typed.exists():
        return shown or typed
    if needed and ask is not None and session.may_know and not made.exists():  # designed after an earlier answer
        answer = list[dict[str, Any]]()
        ask(_question(axis, motion, answer))
        if answer:
            session.write(answer[0], typed)
            return typed
        session.may_know = False
    return None


def _spread(file: Path, name: str) -> float:
    """Return the ratio of the limits of a gain in a file; 1 where it has none."""
    low, high = getattr(read_document(file, ControllerDocument), name).ci95 or (1.0, 1.0)
    return float(high / low) if low and high else inf


def _are_known(file: Path, most: float) -> bool:
    """Return whether the gains in a file have intervals that bound them.

    most: Largest ratio of the limits of K_v and K_i, which may hold both orders of the two: the loop is the same.
    """
    return all(_spread(file, name) < (2.0 if name == "K_p" else most) for name in ("K_v", "K_p", "K_i"))


def _against(stated: Mapping[str, Any], file: Path) -> list[dict[str, Any]]:
    """Return the notice that a stated K_p is not what the voltage of logs shows; K_v and K_i may be exchanged."""
    known, found = ControllerDocument.model_validate(stated), read_document(file, ControllerDocument)
    K_p, (low, high) = known.in_si(known.motion).K_p, getattr(found, "K_p").ci95 or (0.0, inf)  # noqa: B009
    if known.motion != found.motion or low / APART < K_p < high * APART:
        return []
    shows = f"K_p is {K_p:.4g} {si_unit(GAINS['K_p'], found.motion)}, and their voltage shows {low:.4g} to {high:.4g}"
    how = f"The stated gains are not those of the logs: {shows}"
    return [CONTROLLER_DIFFERS.found(f"axis {found.axis}", how=how, friction=False).as_dict()]


def _rate(file: Path) -> float:
    """Return the rate of the controller in a file [Hz]."""
    document = read_document(file, ControllerDocument)
    return document.in_si(document.motion).sampling


def _question(axis: str, motion: Motion, answer: list[dict[str, Any]]) -> Question:
    """Return the question for the gains of an axis; the document of the typed gains goes into ``answer``."""

    def understood(text: str) -> dict[str, Any] | None:
        try:
            return gains_of(text, axis, motion)
        except FricError:
            return None

    def apply(meant: dict[str, Any]) -> None:
        answer.extend([meant] if meant else [])

    text = f"No log shows the gains of axis {axis}. Type those of its controller, as {_example(motion)}"
    return Question(
        text, [("not known: fric designs them, and its result is for these", {})], apply, understood=understood
    )


class AutoResult(Result, schema=AutoDocument):
    """Results for a folder of logs."""

    folder: Path  # Where all files are
    axes: dict[str, AxisOutcome]  # Results for each axis: which steps were done, and what is missing
    description: list[Notice]  # What was guessed or left out
    steps: int  # Number of steps
    made: int  # Number of steps that had to be run
    failed: Sequence[str]  # Steps that failed, with the reason
    page: Report | None  # The report; None where there was nothing to report
    rotary: bool = False  # Whether all axes are rotary
    alone: str = ""  # The schemes that one axis could run alone, in a sentence

    @property
    def warnings(self) -> Sequence[Notice]:
        """What was guessed or left out."""
        return self.description

    @cached_property
    def verdict(self) -> Verdict:
        """The scheme to use, its glitch, and whether that is to be trusted, and why not."""
        inputs = self.page.inputs if self.page else None
        if inputs and inputs.tests:
            return inputs.verdict(inputs.tests[-1])
        lacks = (text for axis in self.axes.values() for text in axis.missing if not axis.whole)
        missing = tuple(text for text in lacks if text.partition(":")[0] not in steps.SPARED)
        if not (self.axes or self.failed):  # a circle alone, whose logs were left out
            left = next((notice for notice in self.description if notice.code == FILE_LEFT_OUT.code), None)
            missing, failed = () if left else FRICTION, f"{left.where}: {left.says}" if left else ""
            return decide(Evidence(missing=missing, failed=failed))
        failed = next((text.partition(": ")[2] for text in self.failed if text.startswith("circle: ")), "")
        return decide(Evidence(axes=tuple(self.axes), rotary=self.rotary, missing=missing, failed=failed))

    def report(self) -> list[Piece]:
        """Return what was found and is missing of each axis, the verdict, and what failed."""
        pieces: list[Piece] = []
        held = [str(notice) for notice in self.description if notice.code == HOLDING_MAP.code]
        turned = next((n.where for n in self.description if BY_SIGNS in str(n.values.get("why"))), "")
        there = f" ({turned}: see below)" * bool(turned)
        for name, axis in self.axes.items():
            pieces += [_found(name, axis)] if axis.there else [f"axis {name}: {'; '.join(held) or 'nothing'}"]
            lacks = (text for text in axis.missing if f"{name}: {text}" not in self.failed)
            pieces += [f"missing for {text}{there * ('static map' in text)}" for text in lacks]
        pieces += [self.alone] if self.alone else []
        pieces += ["", *self.verdict.lines(), *self._doubts()]
        kept = self.steps - self.made - len(self.failed)
        numbers = {"run": self.made, "up to date": kept, "failed": len(self.failed)}
        counts = ", ".join(f"{count} {what}" for what, count in numbers.items() if count)
        steps = f"{self.steps} step{'s' * (self.steps != 1)}"
        pieces += ["", f"{steps}: {counts}; what they printed: {self.folder / 'steps.log'}"]
        pieces += [f"failed: {text}" for text in self.failed]
        made = self.page is not None and not any(text.startswith(f"{WITHOUT}: ") for text in self.failed)
        return [*pieces, f"{self.folder / 'report.html'}"] if made else pieces

    def _doubts(self) -> list[str]:
        """Return what is wrong in the files, and each doubt, where the verdict does not name it."""
        if self.page is None:
            return []
        named = {notice.code for notice in (*self.verdict.why, *self.verdict.settled)}
        items = [(item, told) for item in self.page.inputs.items for told in item.warnings if told.code not in named]
        wrong = [f"wrong: {item.kind} of axis {item.axis}: {text}" for item, text in items if text.severity == "wrong"]
        doubts = {n.code: _in_short(n) for _, n in items if n.severity == "doubt"}
        return [*dict.fromkeys(wrong), *(f"doubt: {says} (`fric help {code}`)" for code, says in doubts.items())]


def _in_short(notice: Notice) -> str:
    """Return the first sentence of a notice, with the record that it is of."""
    record = re.search(r"record '([^']+)'$", notice.where)
    return (record[1] + ": " if record else "") + re.split(r"(?<!Eq)[.] ", notice.says)[0].rstrip(".")


def _found(name: str, outcome: AxisOutcome) -> Table:
    """Return what was found of an axis: its plant, its controller, its static map, and its blocks."""
    rows, notices = list[Sequence[str]](), list[Notice]()
    of_motion: dict[str, Any] = {}
    for part, wanted in FOUND.items():
        path = outcome.files[part]
        tree = plain(read_tree(path)) if path.exists() else {}
        notices += map(Notice.of, tree.get("warnings_coded") or ())
        sections = {name: tree.get(name) or {} for name in wanted} if part == "friction" else {part: tree}
        of_motion |= (tree.get("fit") or {}).get("parameters") or {} if part == "plant" else {}
        lacks = () if "gms" in tree else (None,)
        if part == "friction" and of_motion and None in (sections["static"].get("F_c") or {}).get("ci95", lacks):
            sections = {"": of_motion}  # a replay that leaves it open, and one speed, say nothing beside its fit
        for of, section in sections.items():
            known = {key: value for key, value in section.items() if key in SHOWN and isinstance(value, dict)}
            mark = "negative." * (of == "static_negative")  # as in its covariance
            given = "designed by fric" if tree.get("margins") else "given" if part == "controller" else ""
            rows += [
                (mark + symbol, value, interval or given, unit)
                for symbol, value, interval, unit in estimate_rows(known) if symbol in SHOWN
            ]  # fmt: skip
            if isinstance(alpha := section.get("alpha"), dict):
                rows.append(("blocks", str(len(alpha["value"])), "", ""))
    return named(("", "value", "95 % interval", "unit"), rows, f"axis {name}", notices)


@verb
def auto(
    *logs: Annotated[Path | str, Kind(metavar="LOGS")],
    output: Annotated[Path | str, Kind(metavar="DIR")],
    machine: MachineFile | None = None,
    circles: CircleFiles = (),
    controllers: Annotated[Sequence[Path | str], Kind(list[Path], "GAINS")] = (),
    tolerance: Annotated[Quantity | None, "position"] = None,
    mapping: Annotated[Sequence[str] | str | None, Kind(list[str], "MAP.yaml")] = None,
    assume: bool = False,
    encoder: EncoderName = "motor",
    workers: Workers | None = None,
    scheduler: Address | None = None,
    run: Callable[[Step], Result | None] = Step.make,
    say: Callable[[str], None] = lambda _: None,
    ask: Ask | None = None,
    advance: Callable[..., object] = lambda *_, **__: None,
) -> AutoResult | FleetResult:
    """Do all steps: recognise, ingest, identify, design, simulate, compare with the measured circle, report.

    Each step is an ordinary command, kept in DIR/steps.sh. A step that cannot be done says which record is missing.
    Steps whose inputs have not changed are not run again.

    A folder of many machines (DIR/machine/date/…) is a fleet: each axis is identified at each date, on all cores or a
    Dask cluster, and DIR/fleet.html shows which changed beyond their intervals.

    logs: Logs and circle tests, or folders of them. Or the folder of a fleet.
    output: Folder for all that is made.
    machine: The machine; by default it is made from the results. Its file, or the name of a bundled one.
    circles: A measured circle; repeatable. The simulation is compared with it.
    controllers: A controller's gains: its file, or "K_v=100 1/s, K_p=131 V*s/m, K_i=4090 V/m"; repeatable. "x: " before
        them limits them to axis x. Without, they are found among the logs: on a circle with voltage, or in closed loop;
        else fric asks for them, or designs them.
    tolerance: Allowed glitch, as "5 um". The simplest scheme that surely stays within it is chosen.
    mapping: What the columns of foreign logs mean; repeatable, where strokes and circles have other columns. Without,
        or where none has the columns of a file, its header says it, or a bundled mapping that fits.
    assume: Assume the likeliest meaning where headers and values of foreign logs leave it open, and report it.
    workers: Parallel processes, of a fleet or of three axes and more; by default one per core.
    scheduler: Of a fleet: a Dask scheduler, as tcp://host:8786.
    run: Makes one step, raising a `FricError` where it fails, axis after axis; of a fleet in other processes, and so a
        function that can be pickled.
    say: Receives a line on the result of each step.
    ask: Asks about what headers and values of foreign logs leave open, three questions at most. The answers become a
        mapping beside the logs, which is used from then on.
    Raises FricError: When a file is not there, or none holds a record.
    """
    folder = Path(output)
    mappings = [mapping] if isinstance(mapping, str) else [*(mapping or ())]
    list(map(mapping_of, mappings))  # refused before logs are read, where its place is known
    if units := find_fleet(list(map(Path, logs))):
        if machine or circles or controllers or tolerance is not None:
            what = "a fleet is identified, and takes no machine, circle, controller or tolerance"
            raise FricError(what, hint="Leave them out, or give one unit's folder.")
        study = FleetStudy(tuple(units), folder_made(folder).resolve(), mappings, run, assume, encoder)
        return fleet(study, folder, workers, scheduler, advance)
    _refuse_among(folder, list(map(Path, logs)), scheduler)
    allowed = None if tolerance is None else bounded("tolerance", tolerance)
    given = located(Path(machine), "machine") if machine else None
    if given is not None:
        machine_of(given)  # refused before logs are read
    stated = Stated.of(controllers)
    questions = list[Question]()

    def put(question: Question) -> None:
        questions.append(question)
        assert ask is not None
        ask(question)

    of_columns = put if ask is not None and not isinstance(ask, Review) else ask
    found = find_sources(map(Path, logs), mappings, folder / "mappings", assume=assume, ask=of_columns)
    tests = find_sources(map(Path, circles))
    if circles and not (tests.circles or tests.traces):
        hint = "Make a circle of its log with `fric ingest LOG.csv --kind circle -o circle.h5`."
        raise FricError("there is no measured circle in it", where=str(circles[0]), hint=hint)
    found.circles, found.traces = [*found.circles, *tests.circles], found.traces | tests.traces
    found.description += tests.description
    nothing = not (found.logs or found.traces or (found.circles and given))  # a circle alone shows no friction
    beside = [log for log in found.logs if log.path not in found.traces]
    if found.open.found and (nothing or not (beside or given)):  # a circle alone is no machine: its logs are asked for
        raise found.open.error()
    if nothing:
        raise _none_found(found, logs)
    if encoder == "load" and not any(log.loaded for log in found.logs):
        raise FricError("no log has the position of the load", hint="Name its column load_position in a mapping.")
    if given is None:  # else its plant says what its input is
        steps.take_efforts(found)
    session = Session(folder, run, say, advance)
    session.expect(steps.expected(found, folder) + 1 + len(found.circles) + len(found.traces))
    session.may_know = len(questions) < MOST_QUESTIONS
    for trace, meaning in found.traces.items():
        traced = steps.trace_step(trace, folder, meaning)
        found.circles += traced.leaves if session.take(traced) else ()
    slow = [path for path in found.circles if any(test.is_slow for test in choose_circles([path]))]
    found.circles.sort(key=lambda path: (path in slow, -max(test.feed for test in choose_circles([path]))))

    rates = [_rate(file) for file in (*stated.files.values(), *found.controllers.values())]

    def gains(of_axis: Sequence[Source]) -> Path | None:
        effort = is_effort(of_axis[0].motion) and not rotates(of_axis[0].motion)  # whose circle depends on them
        whole = effort or any("frequency-response" in log.kinds for log in of_axis)
        needed, rate = whole and machine is None, rates[0] if rates else None
        file = find_gains(session, found, of_axis, stated, ask, needed=needed, rate=rate)
        rates.extend([] if file is None else [_rate(file)])
        return file

    axes = steps.identify_axes(session, found, gains, encoder, workers)
    session.expect(2 + len(found.circles))  # steps that lack a record are not to come
    subject = _machine(session, axes, given)
    _circles(session, found, axes, subject, slow, given is not None)
    pages = [path for axis in axes.values() for path in axis.there]
    pages += [path for path in (folder / "circle.h5",) if path.exists()]
    page = None
    session.expect(bool(pages))
    if pages:
        pages += [subject] if subject is not None else []
        records = [path for axis in axes.values() for path in axis.logs]
        for name in ("report", WITHOUT):  # what was identified can be shown without the circle and the machine
            failed = [f"{of}: {failure}" for of, failure in session.failed.items()]
            asked = {"circle": found.circles, "tolerance": allowed and f"{allowed!r} m", "failed": failed}
            read = [*pages, *records]
            if session.take(step(name, "report", read, asked, [*read, *found.circles], output=folder / "report.html")):
                break
            pages, found.circles = [path for axis in axes.values() for path in axis.there], []
        made = session.last if isinstance(session.last, Report) else None
        page = made or make_report(*pages, circles=found.circles, tolerance=allowed)
    session.close()
    described = list(once(found.description))
    rotary = bool(axes) and all(rotates(axis.motion) for axis in axes.values())
    failed = [f"{name}: {failure}" for name, failure in session.failed.items()]
    alone = "" if subject is None or given is not None else _schemes(axes, subject)[1]
    return AutoResult(folder, axes, described, session.steps, session.made, failed, page, rotary, alone)


def _none_found(found: Sources, logs: Sequence[Path | str]) -> FricError:
    """Return the error that no file shows friction, with what to log or to fill in."""
    if not found.refused:
        hint = "Give these, beside circle tests, or their folder. `fric ingest --list` lists the formats."
        empty = all(path.is_dir() and not any(path.iterdir()) for path in map(Path, logs))
        what = f"there is no log of strokes, sines or a response in {'it: it is empty' if empty else 'it'}"
        return FricError(what, where=", ".join(map(str, logs)), hint=hint)
    ((why, files), *more) = sorted(found.refused.items(), key=lambda item: "column" not in item[0])
    beside = [f"{first_of(others)}: {reason}" for reason, others in more[:3]]
    lacks = "Log time, position or velocity, and force, torque or current of a moving axis in one file; where they are "
    lacks += "there, name them in a mapping"
    mapped = shlex.join(["fric", "ingest", files[0].as_posix(), "--propose", "map.yaml"])
    hint = f"{'Say it in a mapping' if NO_SCALE in why else lacks}: `{mapped}`."
    if LEAVES_OUT in why or files[0].suffix == ".h5":
        hint = ""
    else:
        try:
            next(tables(files[0]), None)
        except FricError as error:  # no mapping opens it
            hint = error.hint
    moved, pushed = (found.refused.get(lacking, []) for lacking in (NO_FORCE, NO_POSITION))
    if moved and pushed:  # the channels of a record in files of their own
        names = {path.name: path for path in moved}
        pair = [pushed[0], *(names[name] for name in get_close_matches(pushed[0].name, names, n=1, cutoff=0.0))]
        joined = shlex.join(["fric", "ingest", "--join", *(path.name for path in pair)])  # a long text is cut
        made = f"`{joined} --assume -o record.h5`."
        if '"?' in proposal(pair, join=True, assume=True):  # units that no likelihood tells
            made = f"`{joined} --propose map.yaml` writes a mapping to fill in, for `--map map.yaml -o record.h5`."
        hint = f"Where two files hold one record, join them, and give what is made: {made}"
    hint = ". ".join(filter(None, [*beside, hint]))
    return FricError(f"no log here can be used: {why}", where=first_of(files), hint=hint)


def _refuse_among(folder: Path, logs: Sequence[Path], scheduler: str | None) -> None:
    """Refuse an output folder among the logs, whose files the next run would take for logs; a file; and a cluster."""
    if scheduler is not None:
        raise FricError("logs that are no fleet use no cluster", hint="Leave `scheduler=` out.")
    if folder.is_file():
        raise FricError("is a file, and the results take a folder", where=str(folder), hint="Name another folder.")
    out = Path(realpath(folder))
    for path in logs:
        place = Path(realpath(path)) if path.is_dir() else Path(realpath(path)).parent  # links may lead to themselves
        if out == place or (path.is_dir() and out.is_relative_to(place)):
            what = f"the results would lie among the logs in {path if path.is_dir() else path.parent}"
            raise FricError(what, where=str(folder), hint=f"Give a folder beside them: -o {place.parent / 'found'}.")


def _machine(session: Session, axes: dict[str, AxisOutcome], given: Path | None) -> Path | None:
    """Return the machine file: the one that is given, or one made of what was identified."""
    if given is not None:
        return given
    whole = {name: axis.files for name, axis in axes.items() if axis.whole}
    if not whole:
        return None
    tree: dict[str, Any] = {"fric": MachineDocument.type_name(), "name": "identified machine", "axes": {}}
    for name, files in whole.items():
        there = {part: file for part, file in files.items() if file.exists()}
        tree["axes"][name] = {part: Path(relpath(file, session.folder)).as_posix() for part, file in there.items()}
        tree["axes"][name] |= {"motion": motion} if (motion := axes[name].motion) != "linear" else {}
    session.write(tree | {"provenance": provenance()}, path := session.folder / "machine.yaml")
    return path


def _schemes(axes: Mapping[str, AxisOutcome], machine: Path) -> tuple[list[str], str]:
    """Return the schemes that both axes of the circle can run, and which an axis could run alone, in a sentence."""
    if all(rotates(axis.motion) for axis in machine_of(machine).axes.values()):
        return [], ""
    files = {name: axes[name].files for name in pair(machine_of(machine)) if name in axes}
    modelled = {n: bool(read_document(of["friction"], FrictionDocument).section("gms")) for n, of in files.items()}
    observed = all("observer" in of and of["observer"].exists() for of in files.values())
    can = [
        name for name, scheme in PAPER_SCHEMES.items()
        if (all(modelled.values()) or scheme.friction != "gms") and (observed or not scheme.observer)
    ]  # fmt: skip
    lacks, alone = (next((name for name, has in modelled.items() if has is known), "") for known in (False, True))
    if not (lacks and alone):
        return can, ""
    command = shlex.join(["fric", "simulate", "circle", machine.as_posix(), "--axis", alone])
    left_out = f"Schemes with the GMS model were left out, since {lacks.upper()} has none."
    return can, f"{left_out} For {alone.upper()} alone: `{command}`."


def _circles(
    session: Session, found: Sources, axes: dict[str, AxisOutcome], machine: Path | None, slow: list[Path], given: bool
) -> None:
    """Simulate the circle, and compare measured circles with the machine, which those that are not slow tune."""
    folder, options = session.folder, dict[str, Any]()
    for circle in found.circles if machine is None else ():  # it shows its glitches by itself
        plot = folder / f"{circle.stem}-diagnosis.png"
        session.take(step(f"{circle.stem}: diagnosis", "diagnose", [circle], {}, [circle], plot=plot))
    if machine is None or all(rotates(axis.motion) for axis in machine_of(machine).axes.values()):
        return
    reads = [machine, *(path for axis in axes.values() for path in axis.there)]
    if given:
        names = machine_of(machine).axes
        parts = [(name, axes[name].files[part]) for name in axes if name in names for part in ("friction", "plant")]
        options["friction"] = [f"{name}={path}" for name, path in parts if path.exists()]
    else:
        can, _ = _schemes(axes, machine)
        options |= {"scheme": ",".join(can)} if len(can) < len(PAPER_SCHEMES) else {}
    if found.circles:
        test = max(choose_circles(found.circles[:1]), key=lambda test: test.feed)  # glitches grow with the feed
        options |= {"radius": f"{test.radius!r} m", "velocity": f"{test.feed!r} m/s", "measured": found.circles}
        reads += found.circles
    options |= {"monte_carlo": MACHINES, "from_intervals": True}
    run, drawn = folder / "circle.h5", folder / "circle.png"
    session.take(step("circle", "simulate circle", [machine], options, reads, output=run, plot=drawn))
    for circle in found.circles:
        name, plot = f"{circle.stem}: diagnosis", folder / f"{circle.stem}-diagnosis.png"
        session.take(step(name, "diagnose", [circle], {"machine": machine}, [circle, *reads], plot=plot))
    nominal = machine_of(machine).axes if found.circles else {}
    shared = {name for name in nominal if name in test.names}
    motions = {name: axes[name].motion for name in shared if name in axes}
    traces = test.of_effort(motions).axes if motions else {}
    if any(is_effort(motions[name]) and traces[name].input is None for name in motions if name in traces):
        return  # its circle has no current, which tuning needs
    if not all("gms" in nominal[name].nominal_friction.models for name in shared):
        return  # tuning starts from it
    if shared and (len(found.circles) > 1 or len(shared) == len(test.names)):  # one circle of one axis tells little
        target, tuning = folder / "tuned", [path for path in found.circles if path not in slow] or found.circles
        leaves = [target / "machine.yaml"]
        session.take(step("tune", "tune", [machine, *tuning], {}, [*tuning, *reads], output=target, leaves=leaves))
