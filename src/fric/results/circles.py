"""Measured circles: by causes and against a prediction, to refit a machine, to learn the next circle."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import hypot, isfinite
from pathlib import Path
from typing import Annotated, Any, Self

from fric.circles.diagnose import CAUSES, DRAWS, Agreement, Diagnosis, agreement, both_directions, predict
from fric.circles.diagnose import diagnose as take_apart
from fric.circles.learn import OTHERS, Learned, LearnedFeedforward, Learning, learn_from
from fric.circles.learn import learn as learn_rounds
from fric.circles.measured import MeasuredCircle
from fric.circles.prediction import Prediction, predicted
from fric.circles.tune import LEARNED, LeftOver, Tuned, distrusts, measured_glitch, observers_distrust
from fric.circles.tune import tune as refit
from fric.contour import of_axes
from fric.documents import circle_findings
from fric.documents.base import provenance
from fric.documents.machine_files import IdentifiedMachine, machine_to_predict
from fric.errors import FricError
from fric.estimate import Estimate, estimate_rows, in_digits
from fric.flaws.prediction import CIRCLE_UNUSED, NOT_AS_PREDICTED
from fric.io.circle import read_feedforward, write_feedforward, write_runs
from fric.notice import Notice
from fric.output import refuse_existing, together
from fric.process import one_blas_thread
from fric.results.base import Advance, DataFrame, Figure, Piece, Result, Table, bounded, named, quantity, silent
from fric.results.given_models import machine_of, machine_ran_on, schemes_of, some_circles
from fric.results.kinds import CircleLike, KnownSchemes, MachineLike, Quantity, SchemeName
from fric.simulate.contour_run import Circle, pair
from fric.simulate.machine import Machine
from fric.simulate.processes import MonteCarlo
from fric.units import readable, si_unit
from fric.verb import Kind, useless, verb


class DiagnosisResult(Result, schema=circle_findings.DiagnosisDocument):
    """A measured circle: geometry, control loops, backlash, friction glitches, and the figures of ISO 230-4."""

    found: Diagnosis  # The diagnosis
    held: Agreement | None = None  # Comparison with the prediction of a machine file, if given
    reported: dict[str, Estimate] | None = None  # Figures that the ball bar's software found, by name, if given

    @property
    def warnings(self) -> Sequence[Notice]:
        """What the circle does not show, and what does not agree."""
        return [*self.found.warnings, *(self.held.warnings if self.held else ())]

    def report(self) -> list[Piece]:
        """Return the glitches, beside those predicted, and the geometry."""
        pieces: list[Piece] = [self._glitches(), "", self._geometry()]
        return [*pieces, "", self._beside()] if self.reported else pieces

    def disagreements(self, source: str) -> list[Notice]:
        """Return where the circle of a file differs from its prediction, with the likely cause."""
        if self.held is None:
            return []
        both = self.found.glitches, self.held.predicted.glitches
        seen, said = ({name: Estimate(glitch.value, "m") for name, glitch in of.items()} for of in both)
        return [
            NOT_AS_PREDICTED.found(source, quadrant=n, measured=seen[n], predicted=said[n], cause=CAUSES[cause])
            for n, cause in self.held.causes.items()
        ]

    def _glitches(self) -> Table:
        found, held, test = self.found, self.held, self.found.test
        columns = ["glitch", "µm", "95 %", "width mm", "place mm"] + (["predicted", "95 %", "agrees"] if held else [])
        rows = []
        for name, glitch in found.glitches.items():
            shown, text = in_digits(glitch.value, glitch.ci95, 1e6)
            row = [name, shown, text, f"{glitch.width * 1e3:.2f}", f"{glitch.place * 1e3:.2f}"]
            if held and name in held.agrees:
                limits = held.intervals[name] if held.intervals else None
                shown, text = in_digits(held.predicted.glitches[name].value, limits, 1e6)
                row += [shown, text, "yes" if held.agrees[name] else f"no: {held.causes[name]}"]
            elif held:
                row += ["", "", "no model"]
            rows.append(row)
        sense = "both directions" if len(found.tests) > 1 else circle_findings.SENSES[test.direction]
        of = f"circle of {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}"
        turns = sum(test.count for test in found.tests)
        return Table(columns, rows, f"{of}, {sense}, {turns} revolution{'s' * (turns != 1)}")

    def causes(self) -> Table:
        """Return the deviation of the radius by each cause, the largest first, with its share of the sum.

        It is the height of a spike or step, the amplitude of an ellipse or wave. The parts are those of
        `fric.circles.diagnose.diagnose`, without the centre and parts whose interval contains 0.
        """
        found, R = self.found, self.found.test.radius
        geometry, names = found.geometry, found.test.names
        parts = list[tuple[str, float, float]]()
        for name, letter in zip(names, "xy", strict=True):
            both = [glitch for at, glitch in found.glitches.items() if at[1:] == letter]
            peak = max(both, key=lambda glitch: abs(glitch.value))
            parts.append((f"friction of {name}", peak.value, 0.5 * (peak.ci95[1] - peak.ci95[0])))
            parts.append((f"reversal error of {name}", *_sized(geometry[f"backlash.{name}"])))
        (first, half), (other, its) = (_sized(geometry[f"scale.{name}"], 0.5 * R) for name in names)
        parts.append((f"scale of {names[0]} against {names[1]}", first - other, hypot(half, its)))
        parts.append(("mismatch of the loops", *_sized(geometry["mismatch"])))
        parts.append(("squareness", *_sized(geometry["squareness"], 0.5 * R)))
        for line, amplitude in found.periodic:
            parts.append((f"error every {readable(line.pitch, 'm')} of {names[line.axis]}", *_sized(amplitude)))
        seen = sorted(((abs(size), what) for what, size, half in parts if abs(size) > half), reverse=True)
        total = sum(size for size, _ in seen)
        unseen = [what for what, size, half in parts if abs(size) <= half]
        title = "Causes of the deviation" + (f" (not found: {', '.join(unseen)})" if unseen else "")
        rows = [[what, f"{1e6 * size:.1f}", f"{size / total:.0%}"] for size, what in seen]
        return Table(["cause", "µm", "share"], rows, title)

    def _geometry(self) -> Table:
        found, geometry = self.found, self.found.geometry
        rows = []
        for what, unit, offset in (("centre", "µm", 0.0), ("scale", "ppm", 1.0), ("backlash", "µm", 0.0)):
            said = "reversal error" if what == "backlash" else what  # of ISO 230-2: wind-up and the loop leave one too
            rows += [_row(f"{said} {name}", geometry[f"{what}.{name}"], unit, offset) for name in found.test.names]
        rows.append(_row("mismatch of the loops", geometry["mismatch"], "µm"))
        rows.append(_row("squareness", geometry["squareness"], "µrad"))
        rows += [_row(f"lag {name}", lag, "µs") for name, lag in found.lag.items()]
        for line, amplitude in found.periodic:
            text = f"repeats every {readable(line.pitch, 'm')} of {found.test.names[line.axis]}"
            rows.append(_row(text, amplitude, "µm"))
        figures = found.figures
        plain: list[tuple[str, float | None, int]]
        plain = [("residual, rms", found.rest, 3), ("between revolutions", found.scatter, 3)]
        plain += [(f"circular deviation G {'ccw' if sense > 0 else 'cw'}", G, 2) for sense, G in figures.G.items()]
        plain += [("bidirectional G(b)", figures.G_b, 2), ("mean bidirectional D", figures.D, 2)]
        plain += [("radial deviation F max", figures.F_max, 2), ("radial deviation F min", figures.F_min, 2)]
        rows += [[name, f"{v * 1e6:.{digits}f}", "", "µm"] for name, v, digits in plain if v is not None]
        return Table(["", "value", "95 %", "unit"], rows)

    def _beside(self) -> Table:
        """Return the figures of the ball bar's software, beside those that are of the same here."""
        found, test = self.found, self.found.test
        first, other = (float(found.geometry[f"scale.{name}"]) for name in test.names)
        ours = {
            ("circularity", "m"): found.figures.F_max - found.figures.F_min,
            ("squareness", "rad"): float(found.geometry["squareness"]),
            ("scale mismatch", "m"): 2.0 * test.radius * (first - other),
            ("scale mismatch", "1"): first - other,
            ("servo mismatch", "s"): 2.0 * float(found.geometry["mismatch"]) / test.feed,
        }
        ours |= {(f"reversal spikes {name}", "m"): glitch.value for name, glitch in found.glitches.items()}
        for name, side in product(test.names, "+-"):
            ours[f"backlash {side}{name}", "m"] = float(found.geometry[f"backlash.{name}"])
        rows = []
        for name, said in (self.reported or {}).items():  # of another unit it is another figure
            here = readable(ours[name, said.unit], said.unit, 3) if (name, said.unit) in ours else ""
            rows.append([name, readable(float(said), said.unit, 3), here])
        return Table(["figure", "ball bar's", "here"], rows, "Figures of the ball bar's software; signs are its own")

    def glitches(self) -> tuple[float, float] | None:
        """Return the predicted and the measured glitch of one reversal [m]: the largest that is measured.

        Where reversals differ from their prediction, it is the largest of these.
        """
        if self.held is None:
            return None
        said, seen = self.held.predicted.glitches, self.found.glitches
        worst = max(self.held.causes or self.held.agrees, key=lambda name: abs(seen[name].value))
        return abs(said[worst].value), abs(seen[worst].value)

    def unmodelled(self) -> dict[str, float]:
        """Return the largest measured glitch of each axis that the machine file has not [m], by its name."""
        known, found = self.held.agrees if self.held else self.found.glitches, dict[str, float]()
        for name, glitch in self.found.glitches.items():
            if name not in known:
                found[name[1:]] = max(found.get(name[1:], 0.0), abs(glitch.value))
        return found

    def brief(self) -> str:
        """Return what was measured, and what was predicted."""
        if (both := self.glitches()) is None:
            return f"measured {readable(max(abs(glitch.value) for glitch in self.found.glitches.values()), 'm', 3)}"
        predicted, measured = (readable(value, "m", 3) for value in both)
        return f"measured {measured}, predicted {predicted}: {self.held.said if self.held else 'differs'}"

    def figure(self) -> Figure:
        """Return the circle, and the glitches measured and predicted."""
        from fric.figures.diagnosis import draw_diagnosis

        return draw_diagnosis(self.found, self.held)

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return the glitches [m] by quadrant, measured and predicted."""
        rows = {}
        for name, glitch in self.found.glitches.items():
            low, high = glitch.ci95
            rows[name] = {"value": glitch.value, "low": low, "high": high, "width": glitch.width}
            if self.held:
                rows[name]["predicted"] = self.held.predicted.glitches[name].value
        return rows


def _sized(found: Estimate, factor: float = 1.0) -> tuple[float, float]:
    return float(found) * factor, found.half_width * factor


def _row(label: str, found: Estimate, unit: str, offset: float = 0.0) -> list[str]:
    value, limits = float(found) - offset, [float(limit) - offset for limit in found.ci95 or ()]  # type: ignore[arg-type]
    if not all(map(isfinite, limits)):
        return [label, "", "not determined", unit]
    shown, text = in_digits(value, limits or None, 1e6)
    return [label, shown, text, unit]


@verb
def diagnose(
    *circles: CircleLike, machine: MachineLike | None = None, scheme: SchemeName | None = None,
    known: KnownSchemes | None = None, feed: Annotated[Quantity | None, "velocity"] = None,
    reported: Annotated[Path | str | None, Kind(metavar="RESULT.b5r")] = None, advance: Advance = silent,
) -> DiagnosisResult:  # fmt: skip
    """Split a measured circle by causes: geometry, loops, backlash, friction glitches, and the values of ISO 230-4.

    Both directions of a circle, in one file or two, separate more causes than one direction.

    machine: Predict the circle too. The machine, its file, or the name of a bundled machine.
    scheme: Scheme of a run file; or the scheme that was on, for the prediction.
    feed: Feed of the tests to use, of several in a file.
    reported: Result of Renishaw's ball bar: its figures are shown beside these.
    Raises FricError: When a file is no circle test, or the tests are not of one circle.
    """
    measured = some_circles(circles, scheme, other=machine is not None)
    found = take_apart(both_directions(measured, quantity(feed, "velocity")))
    beside = None if reported is None else _reported(Path(reported), found.test.names)
    useless("a machine", known=known if machine is None else None)
    if machine is None or (scheme is None and found.test.scheme == LEARNED):  # which no machine file tells
        return DiagnosisResult(found, reported=beside)
    wanted = schemes_of(scheme or found.test.scheme or "a", known)[0]
    file = machine if isinstance(machine, Path | str) else None
    subject, identified = (machine_of(machine), None) if file is None else machine_to_predict(Path(file))
    if not of_axes(names := found.test.names, subject.axes):
        why = f"it is of {' and '.join(names)}, and the machine has {' and '.join(subject.axes)}"
        found = replace(found, warnings=(*found.warnings, CIRCLE_UNUSED.found(why=why)))
        return DiagnosisResult(found, reported=beside)
    drawn = identified.drawn() if identified else None
    advance(0, total=1 + (DRAWS if drawn else 0))
    predicted, limits = predict(found, subject, wanted, drawn, done=advance)
    step = max(axis.encoder.resolution for axis in subject.axes.values())
    return DiagnosisResult(found, agreement(found, predicted, limits, wanted.name, step, subject.axes), beside)


def _reported(path: Path, names: Sequence[str]) -> dict[str, Estimate]:
    """Return the figures of a ball bar's result of the plane of two axes."""
    from fric.io.readers.ball_bar import figures  # with the readers, which a diagnosis need not

    plane, found = figures(path)
    if {*plane} != {*names}:
        raise FricError(f"is of the plane {' and '.join(plane)}, and the circle of {' and '.join(names)}",
                        where=str(path), hint="Give the result of the same test.")  # fmt: skip
    return found


class TuneResult(Result, schema=circle_findings.TuningDocument):
    """A machine with nominal parameters from recorded circles."""

    found: Tuned  # The result of the fit
    source: str  # The machine file that it was tuned from; empty for a machine without a file: save its `machine`
    files: list[Path] = field(default_factory=list)  # The files written; empty until it is saved

    @property
    def machine(self) -> Machine:
        """The machine with its new nominal parameters."""
        return self.found.machine

    @property
    def measured(self) -> dict[str, float]:
        """Recorded glitch [m] by feed."""
        return {f"{test.feed:g}": measured_glitch(test) for test in self.found.tests}

    def brief(self) -> str:
        """Return the expected glitch of the next circle."""
        best = min(ahead, key=lambda circle: circle.glitch) if (ahead := self.found.predicted) else None
        return "" if best is None else f"next circle with ({best.scheme}): {readable(best.glitch, 'm', 2)}"

    def report(self) -> list[Piece]:
        """Return the parameters by axis, and the next circles."""
        pieces: list[Piece] = []
        for name, axis in self.found.axes.items():
            unit = si_unit("input", axis.axis.motion)
            before, after = (readable(fitted.rms, unit) for fitted in (axis.before, axis.after))
            title = f"axis {name}: {before} left of the input, {after} when tuned" + "; refused" * (not axis.improves)
            pieces += [named(["", "value", "95 %", "unit"], estimate_rows(axis.parameters), title), ""]
        rows = [
            [
                f"{circle.feed * 1e3:g} mm/s", f"({circle.scheme})", f"{self.measured[f'{circle.feed:g}'] * 1e6:.2f}",
                f"{circle.glitch * 1e6:.2f}", " … ".join(f"{limit * 1e6:.2f}" for limit in circle.ci95),
            ]
            for circle in self.found.predicted
        ]  # fmt: skip
        if rows:
            pieces.append(Table(["the next circle", "scheme", "recorded µm", "glitch µm", "95 %"], rows))
            pieces.append("Intervals are from these circles alone: with strokes and sines, `fric auto` narrows them.")
        if self.files:
            pieces.append(f"wrote {', '.join(map(str, self.files))}")
        return pieces

    def figure(self) -> Figure:
        """Return the voltage at the reversals of the first axis, before and after."""
        from fric.figures.diagnosis import draw_tuned

        return draw_tuned(next(iter(self.found.axes.values())))

    def to_frame(self) -> DataFrame:
        """Return the expected glitches of the next circles [m]."""
        import pandas as pd

        rows = [(circle.feed, circle.scheme, circle.glitch, *circle.ci95) for circle in self.found.predicted]
        return pd.DataFrame(rows, columns=["feed", "scheme", "glitch", "low", "high"])

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write machine.yaml, friction and plant files of each axis, and a figure of its reversals, into a folder."""
        from fric.figures.diagnosis import draw_tuned
        from fric.figures.style import save_figure

        if not self.source:
            raise FricError("the tuned machine has no file", hint='`result.machine.save("machine.yaml")` writes it.')
        folder = Path(path)
        figures = {folder / f"{name}.png": axis for name, axis in self.found.axes.items()}
        if folder.is_dir():
            refuse_existing(*circle_findings.tuned_files(self.found, folder), *figures, force=force)
        with together(*circle_findings.tuned_files(self.found, folder), *figures) as made:
            written = circle_findings.write_tuned(self.found, Path(self.source), folder, force=force, done=made)
            for place, figure in figures.items():
                save_figure(draw_tuned(figure), place, force=force)
                made.append(place)
        self.files[:] = [*written, *figures]
        self.__dict__.pop("document", None)  # it names them


@verb
def tune(
    machine: MachineLike, *circles: CircleLike, scheme: SchemeName | None = None, loop: bool = False,
    advance: Advance = silent,
) -> TuneResult:  # fmt: skip
    """Refit the nominal parameters of a machine's controllers to recorded circles: friction, plant, delay and lead.

    circles: Circle tests, or run files of `fric simulate circle`. One fast and one slow, with reference, position and
        voltage of both axes; measured circles are taken, too.
    loop: Design new gains if friction that falls with speed makes errors grow.
    Raises FricError: When a test lacks a channel, or there is no nominal GMS model.
    """
    subject = machine_of(machine)
    motions = {name: axis.motion for name, axis in subject.axes.items()}
    tests = [test.of_effort(motions) for test in some_circles(circles, scheme)]
    advance(0, total=3 * 2 + 2 * len(tests))  # of each axis three stages, and two schemes on each circle ahead
    with one_blas_thread():  # products of small matrices between compiled replays
        return TuneResult(refit(subject, tests, advance, loop=loop), str(subject.origin.get("path", "")))


class LearnResult(Result, schema=circle_findings.LearningDocument, of="found"):
    """A circle that was learned in simulation."""

    found: Learned  # The rounds

    def report(self) -> list[Piece]:
        """Return the glitch of each round, and of other circles: medians, with the chance of one run."""
        found, test = self.found, self.found.circle
        runs = [(run.scheme.title, (*run.glitches, run.chance())) for run in found.rounds]
        rows = [[title, *(chance.text(digits=2) for chance in chances)] for title, chances in runs]
        title = f"{found.machine.name}: {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}; glitches in µm"
        pieces: list[Piece] = [Table(["round", "+x", "+y", "-x", "-y", "glitch"], rows, title)]
        carried = [[f"{readable(r, 'm')} at {readable(feed, 'm/s')}", f"{g * 1e6:.2f}"] for r, feed, g in found.carried]
        return [*pieces, "", Table(["carried over to", "glitch µm"], carried)]

    def to_frame(self) -> DataFrame:
        """Return the glitch [m] by round."""
        import pandas as pd

        return pd.DataFrame({"glitch": self.found.glitches}).rename_axis("round")

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write a run file with a run for each round; its traces hold the feedforward."""
        made = json.dumps(provenance() | {"machine": self.found.machine.name})
        write_runs(Path(path), self.found.rounds, made, force=force)


class LearnedTable(Result, schema=circle_findings.LearnedFeedforwardDocument, of="table"):
    """The feedforward of the next round, from a measured circle."""

    table: LearnedFeedforward  # The feedforward

    def report(self) -> list[Piece]:
        """Return the feedforward by axis."""
        test = self.table.circle
        rows = [[name, f"{abs(array).max():.3f}", str(len(array))] for name, array in self.table.voltage.items()]
        title = f"feedforward for {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}"
        return [Table(["axis", "largest V", "samples"], rows, title)]

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write the feedforward file."""
        write_feedforward(Path(path), self.table, json.dumps(provenance()), force=force)


@verb
def learn(
    given: Annotated[MachineLike | CircleLike, Kind(Path, "MACHINE.yaml|CIRCLE.h5")], *,
    rounds: Annotated[int | None, Kind(least=1, most=50)] = None,
    velocity: Annotated[Quantity, "velocity"] = "100 mm/s", radius: Annotated[Quantity, "position"] = "30 mm",
    clockwise: bool = False, observer: bool = True, machine: MachineLike | None = None,
    before: Annotated[Path | str | None, Kind(metavar="TABLE.h5")] = None, scheme: SchemeName | None = None,
    share: float | None = None, bandwidth: Annotated[Quantity | None, "frequency"] = None, advance: Advance = silent,
) -> LearnResult | LearnedTable:  # fmt: skip
    """Learn the voltage to feed forward against friction on a repeated circle, without a friction model.

    With a machine all rounds are simulated, and the result is tried at another feed and radius, where it does not hold.
    With a recorded circle the result is the feedforward of the next circle.

    given: A machine; or a recorded circle. A machine, or its file, goes with ``rounds``; a circle test with
        ``machine``.
    rounds: In simulation: circles to learn from. Each takes a second or two of a core.
    velocity: In simulation: feed along the circle.
    radius: In simulation: radius of the circle.
    clockwise: In simulation: turn clockwise.
    observer: In simulation: switch the disturbance observer on.
    machine: Of a circle: its machine; a run file names it. Learning uses its nominal plants.
    before: Of a circle: the feedforward that it was run with.
    share: Share of a round's correction to learn; by default set by the feed.
    bandwidth: Highest frequency to learn; by default set by the feed.
    Raises FricError: When a channel or the machine is missing, or there is nothing to learn from.
    """
    corner = quantity(bandwidth, "frequency")
    if rounds is not None:
        useless("a recorded circle", machine=machine, before=before, scheme=scheme)
        subject = machine_of(given)
        feed = bounded("speed", velocity)
        test = Circle(bounded("radius", radius), feed, direction=-1 if clockwise else 1)
        how = Learning.at(feed, share, corner)
        advance(0, total=rounds + 1 + len(OTHERS))
        return LearnResult(learn_rounds(subject, test, rounds, how, observer=observer, done=advance))
    if (velocity, radius, clockwise, observer) != ("100 mm/s", "30 mm", False, True):
        hint = "A recorded circle has its own."
        raise FricError("`velocity=`, `radius=`, `clockwise=`, `observer=` go with rounds in simulation", hint=hint)
    subject = machine_ran_on(given) if machine is None else machine_of(machine)
    circle = some_circles([given], scheme)[0]
    how = Learning.at(circle.feed, share, corner)
    last = None if before is None else read_feedforward(Path(before))
    return LearnedTable(learn_from(circle, subject, how, last))


@dataclass(frozen=True)
class KnownMachine:
    """The distribution that machines are drawn from, and the circles that they are fitted to."""

    identified: IdentifiedMachine  # The machine with the intervals of what was identified
    tests: Sequence[MeasuredCircle]  # Measured circles
    left: LeftOver | None  # What the machine's models leave of them; None without any
    unused: tuple[Notice, ...] = ()  # Why a circle could not be used

    @classmethod
    def of(
        cls, identified: IdentifiedMachine, tests: Sequence[MeasuredCircle], axes: Sequence[str] | None, seed: int
    ) -> Self:
        """Return the knowledge of a machine from its identified parameters and measured circles."""
        machine, left, unused = identified.machine, None, []
        for test in tests:
            try:  # one that lacks a channel still judges, and completes nothing
                names = axes or [name for name in pair(machine) if name in machine.axes]
                left = LeftOver.of([*(left.tests if left else ()), test], machine, names, seed)
            except FricError as error:
                unused.append(CIRCLE_UNUSED.found(error.where, why=error.what))
        return cls(identified, tests, left, tuple(unused))

    def drawn(self) -> dict[str, Any]:
        """Return the distribution that a study draws its machines from."""
        return self.identified.drawn() | {"completion": self.left}

    def prediction(self, many: MonteCarlo) -> Prediction:
        """Return the prediction for the schemes by the machines that were run, and whether to trust it."""
        study, notices = many.study, self.identified.machine.warnings
        whole = self.left(study.machine) if self.left else study.machine
        records = [record for group in self.left.records.values() for record in group] if self.left else []
        measured, unused = ([test.where for test in self.left.tests], ()) if self.left else ((), self.unused)
        seen = self.left.seen(study.circle) if self.left else {}
        return predicted(
            many, widened=self.identified.widened, measured=measured,
            distrust=(*unused, *distrusts(whole, notices, self.tests, records, study.circle, self.identified.gains)),
            of_schemes=observers_distrust(study.schemes, notices), seen=seen,
        )  # fmt: skip
