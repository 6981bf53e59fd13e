"""The steps of `fric auto`: each is a verb, run in this process, with the equivalent command."""

import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, fields, replace
from functools import partial
from os import environ, fsencode
from pathlib import Path
from time import monotonic
from typing import Any, Literal, NamedTuple

from fric.automatic.sources import MOTION, Source, Sources
from fric.columns import FORCE_VELOCITY, PRESLIDING
from fric.documents.base import commanded
from fric.documents.controller import ControllerDocument
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import read_identified
from fric.documents.plant import PlantDocument
from fric.documents.yaml import dump, plain, read_document, read_tree, write_document
from fric.errors import FricError, as_options
from fric.flaws.files import FILE_UNUSED, STEP_FAILED
from fric.io.hdf5 import read_records
from fric.io.ingest import keep_freed_memory
from fric.notice import Notice, enumerated
from fric.output import folder_made, together, write_folder
from fric.process import tried as say_step
from fric.records.inspection import SPEEDS
from fric.report.summary import make_report
from fric.reproduce.step_cache import StepCache
from fric.results.base import Advance, Result
from fric.results.circles import diagnose, tune
from fric.results.design import design_controller, design_observer
from fric.results.identify import identify_controller, identify_gms, identify_model, identify_plant, identify_static
from fric.results.ingest import ingest, ingest_circles
from fric.results.kinds import EncoderName
from fric.results.simulate import circle
from fric.simulate.processes import default_workers, outcomes
from fric.units import Motion, drive_unit, is_effort, of_effort, rotates

ALONE = 2  # Number of axes that are identified before other processes have started
BYTES = 5e8  # Memory of a process that identifies an axis, about [byte]
PARTS = ("plant", "controller", "observer", "friction")
NO_GMS = "GMS: slow sines before sliding, of about {size}, or micro-steps, with force"
NO_STRIBECK = "F_s and v_s of the static map: strokes at constant velocity, at five speeds or more, with force"
NO_C = "C of the GMS model: a sine in sliding, around a steady speed"
NO_OBSERVER = "observer: a frequency response from the drive's input to position"
NO_CONTROLLER = "controller: its gains, or a frequency response from the drive's input to position"
SPARED = {"GMS", "C of the GMS model", "gms", "lugre", "observer"}  # What a circle without compensation does not need


@dataclass(frozen=True)
class Step:
    """A verb, its arguments, and the files that it writes."""

    name: str  # What it gives, as in ``x: plant``
    command: str  # The command of the verb, as in ``identify plant``
    given: tuple[Path, ...]  # Files that it is given by position
    options: Mapping[str, Any]  # Its options, by name
    reads: tuple[Path, ...]  # Files that it depends on
    leaves: tuple[Path, ...]  # Files that are there when it is done
    output: Path | None = None  # Where the result goes
    plot: Path | None = None  # Where the figure goes

    @property
    def ready(self) -> bool:
        """Whether all files that it reads exist."""
        return all(path.exists() for path in self.reads)

    @property
    def words(self) -> tuple[str, ...]:
        """The command, without ``fric``; its outputs are replaced."""
        words = [*self.command.split(), *self.given]
        for name, value in self.options.items():
            flag = f"--{name.replace('_', '-')}"
            words += [flag] if value is True else _repeated(flag, value)
        words += _repeated("-o", self.output) + _repeated("--plot", self.plot)
        return (*(word.as_posix() if isinstance(word, Path) else str(word) for word in words), "--force")

    def make(self) -> Result:
        """Call the verb, write its outputs, and return its result."""
        done, of = 0, 0

        def advance(steps: int = 1, *, total: int | None = None) -> None:
            nonlocal done, of
            done, of = done + steps, total or of
            say_step(f"{self.name}{f', {done / of:.0%}' if of else ''}")

        with commanded("fric", *self.words), together(*self.leaves) as made:
            result = VERBS[self.command](self, advance)
            if self.output is not None and self.command != "ingest":  # which writes as it reads
                result.save(self.output, force=True)
                made.append(self.output)
            if self.plot is not None:
                result.plot(self.plot, force=True)
        return result


def _repeated(flag: str, value: Any) -> list[object]:
    values = value if isinstance(value, list | tuple) else [] if value is None else [value]
    return [word for value in values for word in (flag, value)]


def _plain(verb: Callable[..., Result]) -> Callable[[Step, Advance], Result]:
    """Return a factory of steps that take the options of the verb's command."""
    return lambda step, _: verb(*step.given, **step.options)


def _shaken(step: Step, _: Advance) -> Result:
    result = identify_plant(*step.given, **step.options)
    wrong = [text for text in result.warnings if text.severity == "wrong"]
    if wrong and step.options.get("method") == "motion":  # a motion that hardly shows the mass gives any
        raise FricError(str(wrong[0]))
    return result


def _ingested(step: Step, advance: Advance) -> Result:
    keep_freed_memory()
    given: dict[str, Any] = dict(step.options)
    read: Callable[..., Result] = ingest_circles if given.get("kind") == "circle" else ingest
    if read is ingest_circles:
        del given["kind"]
    mapping = given.pop("map", None)
    return read(*step.given, output=step.leaves[0], mapping=mapping, force=True, advance=advance, **given)


def _simulated(step: Step, advance: Advance) -> Result:
    given = dict(step.options)
    machines, files, schemes = given.pop("monte_carlo"), given.pop("friction", ()), given.pop("scheme", "all")
    given.pop("from_intervals")
    subject = read_identified(step.given[0], nominal_files=files)
    return circle(subject, schemes, machines=machines, advance=advance, **given)


class NothingBetterError(FricError):
    """A search ends without outputs: what it started from is the best."""


def _tuned(step: Step, advance: Advance) -> Result:
    result = tune(*step.given, **step.options, advance=advance)
    if not result.found.improves:
        raise NothingBetterError("nothing to change: no other parameters explain the circles better")
    return result


def _reported(step: Step, advance: Advance) -> Result:
    given = dict(step.options)
    return make_report(*step.given, circles=given.pop("circle", ()), advance=advance, **given)


VERBS: Mapping[str, Callable[[Step, Advance], Result]] = {  # Factory of the step of each command
    "ingest": _ingested,
    "identify plant": _shaken,
    "identify static": _plain(identify_static),
    "identify gms": _plain(identify_gms),
    "identify lugre": _plain(partial(identify_model, "lugre")),
    "design controller": _plain(design_controller),
    "identify controller": _plain(identify_controller),
    "design observer": _plain(design_observer),
    "simulate circle": _simulated,
    "diagnose": lambda step, advance: diagnose(*step.given, **step.options, advance=advance),
    "tune": _tuned,
    "report": _reported,
}


@dataclass
class AxisOutcome:
    """Results for the records of one axis."""

    motion: Motion  # Of the axis
    done: list[str] = field(default_factory=list)  # Steps that were made, or are up to date
    missing: list[str] = field(default_factory=list)  # What cannot be made: which record is missing, or why it failed
    files: Mapping[str, Path] = field(default_factory=dict)  # Its documents by `PARTS`, there or not
    logs: Sequence[Path] = ()  # Its log files

    @property
    def whole(self) -> bool:
        """Whether all parts that a machine file needs are known, K_f and a friction model among them."""
        known = all(path.exists() for part, path in self.files.items() if part != "observer")
        if not known or read_document(self.files["plant"], PlantDocument).K_f is None:
            return False
        friction = read_document(self.files["friction"], FrictionDocument)
        return friction.static is not None or bool(friction.model_names())  # of one speed it holds a point

    @property
    def there(self) -> list[Path]:
        """Its existing documents."""
        return [path for path in self.files.values() if path.exists()]


def _quoted(word: str) -> str:
    """Return a word as `sh` reads it, without its control characters: a terminal that shows the script obeys them."""
    if word.isprintable():
        return shlex.quote(word)
    printed = (letter if letter.isprintable() else "".join(map("\\{:03o}".format, fsencode(letter)))
               for letter in word.replace("\\", "\\\\").replace("%", "%%"))  # fmt: skip
    return f'"$(printf {shlex.quote("".join(printed))})"'


@dataclass
class Journal:
    """What steps did, in their order."""

    script: list[str] = field(default_factory=list)  # Their commands
    log: list[str] = field(default_factory=list)  # What they printed
    said: list[str] = field(default_factory=list)  # The outcome of each, in a line
    failed: dict[str, str] = field(default_factory=dict)  # Why each failed, by its name
    steps: int = 0  # Steps that were to be done
    made: int = 0  # Steps that had to be run


class Session(Journal):
    """One run: its folder, its script, and the output and outcome of each step.

    folder: Where all files go. Beside the files of each step it is recorded what they were made from.
    run: Makes one step; raises a `FricError` where it fails.
    say: Receives the outcome of each step in a line.
    done: Called after each step, and with the ``total`` of all where that changes.
    """

    def __init__(
        self,
        folder: Path,
        run: Callable[[Step], Result | None],
        say: Callable[[str], None],
        done: Callable[..., object] = lambda *_, **__: None,
    ) -> None:
        super().__init__()
        self.folder, self.run, self.say, self.done = folder_made(folder), run, say, done
        before = folder / "steps.log"  # what steps printed that are up to date now
        printed = before.read_text("utf-8", "replace").split("\n$ ") if before.is_file() else []
        self.printed = dict(part.removeprefix("$ ").partition("\n")[::2] for part in printed)
        self.last: Result | None = None  # What the last step made, where it was run
        self.may_know = True  # Whether the user was not asked for gains yet, or knew them

    def take(self, step: Step, *, tried: bool = False) -> bool:
        """Run a step unless it is up to date; return whether its outputs exist.

        A ``tried`` step may fail: only the log reports that.
        """
        if not step.ready:
            return False
        self.steps, self.last = self.steps + 1, None
        text, begun = " ".join(map(_quoted, ["fric", *step.words])), monotonic()
        for path in step.leaves:
            folder_made(path.parent)
        results: list[Result | None] = []
        say_step(step.name)
        try:
            made = StepCache(step.leaves[0].parent).step(
                step.name, lambda: results.append(self.run(step)), reads=step.reads, leaves=step.leaves,
                settings={"words": list(step.words)},
            )  # fmt: skip
        except FricError as error:
            if tried:
                self.steps -= 1
                self.log += [f"$ {text}", as_options(str(error)), ""]
                return False
            if isinstance(error, NothingBetterError):
                self.made += 1
                self._tell(step, text, str(error), str(error))
                return False
            failure = as_options(str(error)).replace("\n", ". ")
            same = next((name for name, why in self.failed.items() if why == failure), None)
            self.failed[step.name] = failure = f"for the same reason as {same}" if same else failure
            self.script.append(f"# failed: {' '.join(text.splitlines())}")
            self._tell(step, text, f"failed: {failure}", str(error))
            return False
        self.made += made
        self.script.append(text)
        self.last = found = results[0] if results else None
        printed = ("", "") if made else ("up to date", self.printed.get(text, "").rstrip())
        brief, whole = printed if found is None else (found.brief(), repr(found))
        timed = made and "SOURCE_DATE_EPOCH" not in environ  # which asks for the same text again
        self._tell(step, text, brief, whole, f"{monotonic() - begun:5.1f} s" if timed else "")
        return True

    def expect(self, steps: int) -> None:
        """Say how many steps are to come."""
        self.done(0, total=self.steps + steps)

    def _tell(self, step: Step, command: str, brief: str, whole: str, lasted: str = "") -> None:
        self.log += [f"$ {command}", as_options(whole or brief), ""]
        self.said.append(f"{f'{step.name:<18} {brief}':<72}{lasted}".rstrip())  # 80 columns with the time
        self.say(self.said[-1])
        self.done()

    def take_over(self, beside: Journal) -> None:
        """Add what another process did, and report it."""
        self.script += beside.script
        self.log += beside.log
        self.failed |= beside.failed
        self.steps, self.made = self.steps + beside.steps, self.made + beside.made
        for text in beside.said:
            self.said.append(text)
            self.say(text)
            self.done()

    def write(self, tree: dict[str, Any], path: Path) -> None:
        """Write a document, and the lines of the script that write it."""
        known = plain(read_tree(path)) if path.exists() else {}
        if any(known.get(key) != plain(tree[key]) for key in tree.keys() - {"provenance"}):
            folder_made(path.parent)
            write_document(path, tree, force=True)
        self.script += [f"cat > {_quoted(str(path))} <<'END'", dump(tree).rstrip(), "END"]

    def close(self) -> None:
        """Write the script, and the output of the steps."""
        head = ["#!/bin/sh", "# What `fric auto` ran, to be run again by hand.", "set -eu"]
        head.append(f"cd {_quoted(str(Path.cwd()))}")
        texts = {"steps.sh": [*head, *self.script], "steps.log": self.log}
        files = {of: "\n".join([*lines, ""]).encode("utf-8", "surrogateescape") for of, lines in texts.items() if lines}
        write_folder(self.folder, files, force=True)


def identify_axes(
    session: Session,
    found: Sources,
    gains: Callable[[Sequence[Source]], Path | None] | None = None,
    encoder: EncoderName = "motor",
    workers: int | None = 1,
) -> dict[str, AxisOutcome]:
    """Ingest and identify; return the results for each axis.

    gains: Returns the file of the controller's gains of an axis from its logs; None where they are to be designed.
        Without it only friction and plant are identified: no figures, no controller, no observer.
    encoder: Of axes with two encoders, the one whose position friction is identified on.
    workers: Processes that share the axes; by default one a core, and this one alone for two axes.
    """
    logs = [log for log in found.logs if log.mapping is None]
    for step, left in ingest_steps(found.logs, session.folder):
        if session.take(step):
            logs.append(left)
        else:
            found.description.append(STEP_FAILED.found(step.name, why=session.failed.get(step.name, "failed")))
    by_axis = {name: [log for log in logs if log.axis == name] for name in sorted({log.axis for log in logs})}
    found_gains = {name: gains(of_axis) if gains else None for name, of_axis in by_axis.items()}
    documents = (read_document(file, ControllerDocument) for file in found_gains.values() if file)
    rates = {document.in_si(document.motion).sampling for document in documents}
    rate = rates.pop() if len(rates) == 1 else None  # of one machine: a designed one takes it
    study = _Axes(session.folder, by_axis, found_gains, session.printed, rate, gains is None, encoder)
    workers = (len(by_axis) > ALONE) * default_workers() if workers is None else workers
    beside = session.run is Step.make and min(workers, len(by_axis)) > 1
    if beside:
        say_step(f"{len(by_axis)} axes")
    each = ((*study.identified(session, name), Journal()) for name in by_axis)
    opened = outcomes(study, len(by_axis), workers=workers, memory=BYTES) if beside else nullcontext(each)
    axes: dict[str, AxisOutcome] = {}
    with opened as identified:
        for name, (outcome, unused, journal) in zip(by_axis, identified, strict=True):
            session.take_over(journal)
            found.description += unused
            axes[name] = outcome
    return axes


@dataclass(frozen=True)
class _Axes:
    """Identifies the axes of a session: in its process by name, or in others by number."""

    folder: Path  # Of the session
    logs: Mapping[str, Sequence[Source]]  # Logs of each axis
    gains: Mapping[str, Path | None]  # File of its controller's gains
    printed: dict[str, str]  # What the steps of an earlier session printed
    rate: float | None  # Of the known controllers, as in `axis_steps`
    lean: bool
    encoder: EncoderName

    def __call__(self, index: int) -> tuple[AxisOutcome, list[Notice], Journal]:
        name = [*self.logs][index]
        session = Session(self.folder / name, Step.make, lambda _: None)
        session.printed = self.printed
        found = self.identified(session, name)
        return *found, Journal(**{part.name: getattr(session, part.name) for part in fields(Journal)})

    def identified(self, session: Session, name: str) -> tuple[AxisOutcome, list[Notice]]:
        """Identify an axis; return what was found, and the logs that no step reads."""
        of_axis, folder, lean, controller = self.logs[name], self.folder / name, self.lean, self.gains[name]
        given = partial(
            axis_steps, of_axis, folder, lean=lean, controller=controller, encoder=self.encoder, rate=self.rate
        )
        each = [plan for plan in map(given, ("any", "others", "strokes")) if plan.shaken]
        tries = list({(plan.shaken, str(plan.steps[0].options)): plan for plan in each}.values())
        took = (plan for plan in tries if session.take(plan.steps[0], tried=plan is not tries[-1]))
        plan = next(took, None) or given("none" if tries else "any")
        tried = [] if plan.shaken else [of.steps[0] for of in tries]  # of which each failed, and says why
        read = {path for step in [*plan.steps, *tried] for path in step.reads}
        used = {kind for log in of_axis if log.path in read for kind in log.kinds}
        left_out = list[Notice]()
        for unused in (log for log in of_axis if log.path not in read and log.kinds != {"holding-map"}):
            what = {"kinds": sorted(unused.kinds), "motion": MOTION in unused.kinds, "others": unused.kinds <= used}
            what |= {"alone": (alone := not read and not what["motion"]), "other": not (alone or what["motion"])}
            what |= {"why": unused.unfit, "unfit": bool(unused.unfit)}
            made = unused.path.is_relative_to(folder)  # of files that the user knows by the names of their records
            where = enumerated(record.name for record in read_records(unused.path)) if made else str(unused.path)
            left_out.append(FILE_UNUSED.found(where, axis=name, **what))
        done = ["plant"] * bool(plan.shaken)
        done += [step.name.partition(": ")[2] for step in plan.steps[len(done) :] if session.take(step)]
        asked = dict.fromkeys([f"{name}: plant", *(step.name for step in plan.steps)])  # without a plant no plan has it
        failed = [step for step in asked if step in session.failed]
        broken = [f"{name.partition(': ')[2]}: {session.failed[name]}" for name in failed]
        files = {part: folder / f"{part}.yaml" for part in PARTS if part != "observer" or part in done}  # of these logs
        if not lean and "plant" in done and read_document(files["plant"], PlantDocument).K_f is None:
            plan.missing.append("K_f, and so the circle: a record with voltage and force, torque or current together")
        files |= {} if controller is None else {"controller": controller}
        if "gms" not in done and "static" in done:
            files["friction"] = folder / "static.yaml"
        tree = (plain(read_tree(files["friction"])) if files["friction"].exists() else None) or {}
        limits = [(tree.get("static") or {}).get(of, {}).get("ci95") for of in ("F_s", "v_s")]
        shown = all(of and None not in of for of in limits)  # by a motion, too
        lacks = [text for text in plan.missing if not (shown and text.startswith(NO_STRIBECK))]
        lacks += [NO_STRIBECK] * ("at_speed" in tree)  # of strokes at one speed
        missing, paths = [*lacks, *broken], [source.path for source in of_axis]
        return AxisOutcome(of_axis[0].motion, done, missing, files, paths), left_out


def take_efforts(found: Sources) -> None:
    """Take the force of axes as the input of their drives, where no log of them holds another effort."""
    for axis in sorted({log.axis for log in found.logs}):
        of_axis = [log for log in found.logs if log.axis == axis]
        efforts = frozenset[str]().union(*(log.efforts for log in of_axis))
        if len(efforts) == 1:
            moves: Motion = "rotary/V" if rotates(of_axis[0].motion) else "linear/V"
            motion = of_effort(moves if "input" in efforts else of_axis[0].motion)
            taken = [
                replace(log, mapping=log.mapping or "", driven=True, motion=motion, uses=log.uses | log.in_volts)
                for log in of_axis
            ]  # fmt: skip
            found.logs = [*(log for log in found.logs if log not in of_axis), *taken]


def step(
    name: str,
    command: str,
    given: Iterable[Path],
    options: Mapping[str, Any],
    reads: Iterable[Path] | None = None,
    *,
    output: Path | None = None,
    plot: Path | None = None,
    leaves: Iterable[Path] | None = None,
) -> Step:
    """Return a step; by default it depends on its arguments, and writes result and figure."""
    files, asked = tuple(given), {key: option for key, option in options.items() if option is not None}
    left = tuple(path for path in (output, plot) if path is not None) if leaves is None else tuple(leaves)
    return Step(name, command, files, asked, files if reads is None else tuple(reads), left, output, plot)


def ingest_steps(logs: Sequence[Source], folder: Path) -> Iterator[tuple[Step, Source]]:
    """Yield a step for the foreign logs of each axis, kind and mapping, with its outputs."""
    groups: dict[tuple[str, str, str], list[Source]] = {}
    for source in logs:
        if source.mapping is not None:
            groups.setdefault((source.axis, "-".join(sorted(source.kinds)), source.mapping), []).append(source)
    for (axis, kind, mapping), members in groups.items():
        wide, assumed = any(member.wide for member in members), any(member.assumed for member in members)
        log = folder / axis / f"{kind}{'-' + Path(mapping).stem if mapping else ''}.h5"
        files = [member.path for member in members]
        options = {"map": mapping or None, "kind": kind if len(members[0].kinds) == 1 else None}
        options |= {"axis": axis if wide else None, "bad_cells": "drop" if assumed else None}
        options |= {"motion": motion} if is_effort(motion := members[0].motion) else {}
        left = Source(
            log, axis, members[0].motion, members[0].kinds, frozenset().union(*(m.uses for m in members)),
            both=all(m.both for m in members), driven=all(m.driven for m in members),
            strokes=sum(m.strokes for m in members), loaded=any(m.loaded for m in members),
            efforts=frozenset().union(*(m.efforts for m in members)), rates=sum((m.rates for m in members), ()),
            unfit=next((m.unfit for m in members if m.unfit), ""), uneven=max(m.uneven for m in members),
        )  # fmt: skip
        reads = [*files, *([Path(mapping)] if mapping.endswith(".yaml") else [])]
        yield step(f"{axis}: ingest {kind}", "ingest", files, options, reads, output=log), left


def trace_step(trace: Path, folder: Path, mapping: str = "") -> Step:
    """Return the step that reads a foreign file with circle tests, by the mapping of its axes if it takes one."""
    test = folder / "circles" / f"{trace.stem}.h5"
    return step(f"ingest {trace.stem}", "ingest", [trace], {"kind": "circle", "map": mapping or None}, output=test)


class AxisSteps(NamedTuple):
    """Steps that the records of one axis allow, and what cannot be made, with the record that is missing."""

    steps: list[Step]
    missing: list[str]

    @property
    def shaken(self) -> tuple[Path, ...]:
        """The records that give the plant, of the first step."""
        return self.steps[0].given if self.steps and self.steps[0].command == "identify plant" else ()


def expected(found: Sources, folder: Path) -> int:
    """Return how many steps read the files, identify their axes and simulate the circle, if none falls away."""
    by_axis = [[log for log in found.logs if log.axis == axis] for axis in {log.axis for log in found.logs}]
    of_axes = sum(len(axis_steps(of_axis, folder, lean=True).steps) + 1 for of_axis in by_axis)  # and its gains
    observed = sum(any("frequency-response" in log.kinds and log.driven for log in of_axis) for of_axis in by_axis)
    return len(found.traces) + len(list(ingest_steps(found.logs, folder))) + of_axes + observed + bool(by_axis)


def axis_steps(
    logs: Sequence[Source],
    folder: Path,
    shaken: Literal["any", "others", "strokes", "none"] = "any",
    *,
    lean: bool = False,
    controller: Path | None = None,
    encoder: EncoderName = "motor",
    rate: float | None = None,
) -> AxisSteps:
    """Return the steps of one axis: plant, static map, GMS, controller, observer.

    shaken: Records that give the plant: responses or a motion, motions of other kinds (a sine in sliding, a circle),
        strokes alone, or none.
    lean: Only identify: no figures, controller or observer; the static map has one form, so that dates compare.
    controller: The file of the controller's gains; designed where there is none, for the ``rate`` of others [Hz].
    """
    axis = logs[0].axis
    which = {"encoder": encoder} if encoder != "motor" and any(log.loaded for log in logs) else {}
    steps, missing = list[Step](), list[str]()
    plant, static, friction = (folder / name for name in ("plant.yaml", "static.yaml", "friction.yaml"))
    observer = folder / "observer.yaml"

    def of(*kinds: str, use: str = "") -> list[Path]:
        return [log.path for log in logs if log.kinds & set(kinds) and (not use or use in log.uses)]

    def identify(what: str, files: list[Path], output: Path, reads: Iterable[Path], options: Mapping[str, Any]) -> None:
        figure = None if lean else output.with_suffix(".png")
        given = (f"{axis}: {what}", f"identify {what}", files, {**options, **which}, [*files, *reads])
        steps.append(step(*given, output=output, plot=figure))

    responses = [log.path for log in logs if "frequency-response" in log.kinds and (log.driven or not log.efforts)]
    mapped = of("constant-velocity", FORCE_VELOCITY, use="static")

    def enough_in(files: list[Path]) -> bool:
        return sum(log.strokes for log in logs if log.path in files) > SPEEDS

    if not enough_in(mapped) and enough_in(moves := of("motion", use="static")):
        mapped = moves  # strokes in a motion are strokes, too
    enough = enough_in(mapped)
    effort = is_effort(logs[0].motion)
    fast = [log for log in logs if MOTION in log.uses and not (log.kinds <= PRESLIDING and "gms" in log.uses)]
    fast = [log for log in fast if shaken != "strokes" or "constant-velocity" in log.kinds]
    fast = [log for log in fast if shaken != "others" or not log.kinds & {"constant-velocity", "motion"}]
    other = [log for log in fast if effort or not enough or "constant-velocity" not in log.kinds]
    motions = of("motion", *["constant-velocity"] * effort)  # strokes of an effort show what depends on position
    moving = (shaken == "any" and of("motion") and motions) or [log.path for log in other]
    responses = responses if shaken == "any" or not effort else []  # a force alone shows the mass in its motion, too
    responses, shaking = (responses, responses or moving) if shaken != "none" else ([], [])
    if shaking:
        scaled = any(log.both for log in logs if log.path in shaking)
        steady = [log.path for log in logs if log.kinds == {"constant-velocity"} and log.both and not scaled]
        beside = steady if responses else []  # K_f, which no response determines
        identify("plant", [*shaking, *beside], plant, (), {} if responses else {"method": "motion"})
    elif shaken == "any":
        uneven = max(f" ({log.uneven})" * bool(log.uneven) for log in logs)
        missing.append(f"plant: a frequency response, or an ordinary motion with position and voltage or force{uneven}")
    driven = shaking and all(log.driven for log in logs if log.path in shaking)
    whole = bool(responses or driven)  # it has B, and no friction in its damping
    known = [plant] if whole else []
    damping: dict[str, Any] = {"plant": plant} if whole else {}
    if strokes := mapped if enough else []:
        form = {"delta": "1", "over_position": "off", "direction": "both"} if lean else {}
        identify("static", strokes, static, known, damping | form)
    else:
        text = NO_STRIBECK if moving and not responses else NO_STRIBECK.removeprefix("F_s and v_s of the ")
        unfit = next((log.unfit for log in logs if log.unfit and "constant-velocity" in log.kinds), "")
        missing.append(text + f" ({unfit})" * bool(unfit))
    if slow := of(*PRESLIDING, use="gms"):
        sines = list(dict.fromkeys([*slow, *of("sliding-sine", use="gms")]))
        given = {"static": static} if strokes else {}
        identify("gms", sines, friction, [*known, *given.values()], damping | given)
        if not of("sliding-sine"):
            missing.append(NO_C)
    else:
        unfit = next((log.unfit for log in logs if log.unfit and log.kinds & PRESLIDING), "")
        size = "a tenth of a degree" if rotates(logs[0].motion) else "ten micrometres"
        missing.append(NO_GMS.format(size=size) + f" ({unfit})" * bool(unfit))
        if moving and not (strokes or responses or lean):  # what a motion shows of friction
            identify("lugre", moving, friction, known, damping)
    if lean:
        return AxisSteps(steps, missing)
    if controller is None and (responses or (effort and shaking)):
        controller = folder / "controller.yaml"
        asked = {"sampling": rate and f"{rate!r} Hz"}
        steps.append(step(f"{axis}: controller", "design controller", [plant], asked, output=controller))
    measured = effort and drive_unit(logs[0].motion) != "V"
    if responses and controller and not measured:  # a force that acts when it is logged does not show the delay
        read = [plant, *responses[:1]]
        named = [record.name for record in read_records(responses[0]) if record.kind == "frequency-response"]
        options = {"controller": controller, "record": named[0] if len(named) > 1 else None}
        steps.append(
            step(
                f"{axis}: observer", "design observer", read, options, [*read, controller],
                output=observer, plot=observer.with_suffix(".png"),
            )
        )  # fmt: skip
    else:
        seen = ": a logged current does not show the delay of the drive before it" * (measured and bool(responses))
        missing += [NO_OBSERVER + seen] if controller else [NO_CONTROLLER, NO_OBSERVER]
    return AxisSteps(steps, missing)
