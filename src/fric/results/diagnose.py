"""A measured circle by causes, compared with a machine file."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, isfinite
from pathlib import Path
from typing import Annotated, Any

from fric.circles.agreement import CAUSES, Agreement, agreement, circles_to_predict, predict
from fric.circles.diagnose import Diagnosis, both_directions
from fric.circles.diagnose import diagnose as take_apart
from fric.circles.next_circle import LEARNED
from fric.documents.circle_findings import DiagnosisDocument
from fric.documents.identified import machine_to_predict
from fric.estimate import Estimate, in_digits
from fric.flaws.prediction import NOT_AS_PREDICTED
from fric.notice import Notice
from fric.results.base import Figure, Result
from fric.results.given import Advance, quantity, silent
from fric.results.given_models import CIRCLES, circles_of, machine_of, schemes_of
from fric.results.kinds import CircleLike, KnownSchemes, MachineLike, Quantity, SchemeName
from fric.results.text import Piece, Table
from fric.units import readable
from fric.verb import UnfitError, verb


@dataclass(frozen=True, eq=False, repr=False)
class DiagnosisResult(Result, schema=DiagnosisDocument):
    """A measured circle: geometry, control loops, backlash, friction glitches, and the figures of ISO 230-4."""

    found: Diagnosis  # The diagnosis
    held: Agreement | None = None  # Comparison with the prediction of a machine file, if given

    @property
    def warnings(self) -> Sequence[Notice]:
        """What the circle does not show, and what does not agree."""
        return [*self.found.warnings, *(self.held.warnings if self.held else ())]

    def report(self) -> list[Piece]:
        """Return the glitches, beside those predicted, and the geometry."""
        return [self._glitches(), "", self._geometry()]

    def disagreements(self, source: str) -> list[Notice]:
        """Return where the circle of a file differs from its prediction, with the likely cause."""
        if self.held is None:
            return []
        seen, said = self.found.glitches, self.held.predicted.glitches
        return [
            NOT_AS_PREDICTED.found(
                source,
                quadrant=name,
                measured=Estimate(seen[name].value, "m"),
                predicted=Estimate(said[name].value, "m"),
                cause=CAUSES[cause],
            )
            for name, cause in self.held.causes.items()
        ]

    def _glitches(self) -> Table:
        found, held, test = self.found, self.held, self.found.test
        columns = ["glitch", "µm", "95 %", "width mm", "place mm"]
        columns += ["predicted", "95 %", "agrees"] if held else []
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
        sense = (
            "both directions" if len(found.tests) > 1 else "counter-clockwise" if test.direction > 0 else "clockwise"
        )
        of = f"circle of {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}"
        return Table(columns, rows, f"{of}, {sense}, {sum(test.count for test in found.tests)} revolutions")

    def causes(self) -> Table:
        """Return what each cause adds to the range of the radius, the largest first, with its share of the sum.

        The parts are those of `fric.circles.diagnose.diagnose`, without the centre and parts whose interval contains 0.
        """
        found, R = self.found, self.found.test.radius
        geometry, names = found.geometry, found.test.names
        parts = list[tuple[str, float, float]]()
        for name, letter in zip(names, "xy", strict=True):
            peak = max(
                (glitch for at, glitch in found.glitches.items() if at[1:] == letter),
                key=lambda glitch: abs(glitch.value),
            )
            parts.append((f"friction of {name}", peak.value, 0.5 * (peak.ci95[1] - peak.ci95[0])))
            parts.append((f"backlash of {name}", *_sized(geometry[f"backlash.{name}"])))
        (one, half), (other, its) = (_sized(geometry[f"scale.{name}"], R) for name in names)
        parts.append((f"scale of {names[0]} against {names[1]}", one - other, hypot(half, its)))
        parts.append(("mismatch of the loops", *_sized(geometry["mismatch"], 2.0)))
        parts.append(("squareness", *_sized(geometry["squareness"], R)))
        for line, amplitude in found.periodic:
            parts.append((f"error every {readable(line.pitch, 'm')} of {names[line.axis]}", *_sized(amplitude, 2.0)))
        seen = sorted(((abs(size), what) for what, size, half in parts if abs(size) > half), reverse=True)
        total = sum(size for size, _ in seen)
        unseen = [what for what, size, half in parts if abs(size) <= half]
        title = "Causes of the deviation" + (f"; not seen: {', '.join(unseen)}" if unseen else "")
        rows = [[what, f"{1e6 * size:.1f}", f"{size / total:.0%}"] for size, what in seen]
        return Table(["cause", "µm", "share"], rows, title)

    def _geometry(self) -> Table:
        found, geometry = self.found, self.found.geometry
        rows = []
        for what, unit, offset in (("centre", "µm", 0.0), ("scale", "ppm", 1.0), ("backlash", "µm", 0.0)):
            rows += [_row(f"{what} {name}", geometry[f"{what}.{name}"], unit, offset) for name in found.test.names]
        rows.append(_row("mismatch of the loops", geometry["mismatch"], "µm"))
        rows.append(_row("squareness", geometry["squareness"], "µrad"))
        rows += [_row(f"lag {name}", lag, "µs") for name, lag in found.lag.items()]
        for line, amplitude in found.periodic:
            text = f"repeats every {readable(line.pitch, 'm')} of {found.test.names[line.axis]}"
            rows.append(_row(text, amplitude, "µm"))
        figures = found.figures
        plain: list[tuple[str, float | None, int]] = [("residual, rms", found.rest, 3)]
        plain += [("between revolutions", found.scatter, 3)]
        plain += [
            (f"circular deviation G {'ccw' if sense > 0 else 'cw'}", value, 2) for sense, value in figures.G.items()
        ]
        plain += [("bidirectional G(b)", figures.G_b, 2), ("mean bidirectional D", figures.D, 2)]
        plain += [("radial deviation F max", figures.F_max, 2), ("radial deviation F min", figures.F_min, 2)]
        rows += [[name, f"{v * 1e6:.{digits}f}", "", "µm"] for name, v, digits in plain if v is not None]
        return Table(["", "value", "95 %", "unit"], rows)

    def glitches(self) -> tuple[float, float] | None:
        """Return the largest predicted and the largest measured glitch of the known axes [m]."""
        if self.held is None or not self.held.agrees:
            return None
        said, seen = self.held.predicted.glitches, self.found.glitches
        predicted, measured = (max(abs(mapping[name].value) for name in self.held.agrees) for mapping in (said, seen))
        return predicted, measured

    def brief(self) -> str:
        """Return what was measured, and what was predicted."""
        if (both := self.glitches()) is None:
            return f"measured {readable(max(abs(glitch.value) for glitch in self.found.glitches.values()), 'm', 3)}"
        predicted, measured = (readable(value, "m", 3) for value in both)
        agrees = "agrees" if self.held and self.held.all_agree else "differs"
        return f"measured {measured}, predicted {predicted}: {agrees}"

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
        return [label, f"{value * 1e6:.2f}", "not determined", unit]
    shown, text = in_digits(value, limits or None, 1e6)
    return [label, shown, text, unit]


@verb
def diagnose(
    *circles: CircleLike,
    machine: MachineLike | None = None,
    scheme: SchemeName | None = None,
    known: KnownSchemes | None = None,
    feed: Annotated[Quantity | None, "velocity"] = None,
    advance: Advance = silent,
) -> DiagnosisResult:
    """Split a measured circle by causes: geometry, loops, backlash, friction glitches, and the values of ISO 230-4.

    Both directions of a circle, in one file or two, separate more causes than one direction.

    Parameters
    ----------
    machine
        Predict the circle too. The machine, its file, or the name of a bundled machine.
    scheme
        Scheme of a run file; or the scheme that was on, for the prediction.
    feed
        Feed of the tests to use, of several in a file.

    Raises
    ------
    FricError
        When a file is no circle test, or the tests are not of one circle.
    """
    if not (measured := circles_of(circles, scheme)):
        raise UnfitError(CIRCLES, None)
    found = take_apart(both_directions(measured, quantity(feed, "velocity")))
    if machine is None or (scheme is None and found.test.scheme == LEARNED):  # which no machine file tells
        return DiagnosisResult(found)
    wanted = schemes_of(scheme or found.test.scheme or "a", known)[0]
    file = machine if isinstance(machine, Path | str) else None
    subject, identified = (machine_of(machine), None) if file is None else machine_to_predict(Path(file))
    drawn = identified.drawn() if identified else None
    advance(0, total=circles_to_predict(drawn))
    predicted, limits = predict(found, subject, wanted, drawn, done=advance)
    step = max(axis.encoder.resolution for axis in subject.axes.values())
    return DiagnosisResult(found, agreement(found, predicted, limits, wanted.name, step, subject.axes))
