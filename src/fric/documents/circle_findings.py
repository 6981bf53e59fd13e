"""What measured circles tell, as `--json` prints it: ``fric: diagnosis/1`` and ``fric: tuning/1``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import Field

from fric.documents.base import Document
from fric.documents.quantity import Part, Quantity
from fric.estimate import Estimate
from fric.notice import Notice

if TYPE_CHECKING:
    from fric.identify.circle.agreement import Agreement
    from fric.identify.circle.diagnose import Diagnosis
    from fric.identify.circle.tune import Tuned


class GlitchPart(Part):
    """A friction glitch at a quadrant."""

    value: float
    unit: str
    ci95: list[float | None]
    width: float
    place: float


class PredictedGlitch(GlitchPart):
    """What a machine file predicts for a quadrant."""

    ci95: list[float | None] | None  # type: ignore[assignment]  # without what was identified there is none
    agrees: bool
    cause: str | None


class PitchPart(Part):
    """What comes again along an axis."""

    axis: str
    pitch: Quantity
    amplitude: Quantity


class DiagnosisDocument(Document):
    """A measured circle, taken apart."""

    type: ClassVar[str] = "diagnosis"

    radius: Quantity
    feed: Quantity
    direction: Quantity = Field(description="1 counter-clockwise, -1 clockwise")
    revolutions: list[int]
    centre: dict[str, Quantity]
    scale: dict[str, Quantity]
    squareness: Quantity
    backlash: dict[str, Quantity]
    mismatch: Quantity
    lag: dict[str, Quantity | None]
    glitch: dict[str, GlitchPart]
    glitch_of: dict[str, dict[str, GlitchPart]]
    pitch: list[PitchPart]
    rest: Quantity | None
    scatter: Quantity | None
    noise: Quantity | None
    iso230: dict[str, Quantity | dict[str, Quantity] | None]
    predicted: dict[str, PredictedGlitch] | None = None
    scheme: str | None = None
    agrees: bool | None = None


class ResidualPart(Part):
    """What is left of the voltage of an axis [V]."""

    before: float
    after: float
    noise: float | None


class TunedAxisPart(Part):
    """What circles gave an axis."""

    parameters: dict[str, Quantity]
    residual: ResidualPart
    full_shape: bool
    improves: bool


class NextCircle(Part):
    """What the next circle should show."""

    glitch: float = Field(description="[m]")
    ci95: list[float | None]
    radius: float = Field(description="[m]")


class TuningDocument(Document):
    """What controllers believe, refitted to recorded circles."""

    type: ClassVar[str] = "tuning"

    axes: dict[str, TunedAxisPart]
    predicted: dict[str, dict[str, NextCircle]] = Field(description="by feed [m/s] and scheme")
    measured: dict[str, float] = Field(description="recorded glitch [m] by feed")
    files: list[str] | None = None


def diagnosis_tree(found: Diagnosis, held: Agreement | None, notices: Iterable[Notice]) -> dict[str, Any]:
    """Return a measured circle that was taken apart, and how it agrees with a prediction, ready to be printed."""
    test, figures, geometry = found.test, found.figures, found.geometry
    names = test.names

    def plain(value: float | None, unit: str = "m") -> Estimate | None:
        return None if value is None else Estimate(value, unit)

    def per_axis(what: str) -> dict[str, Estimate]:
        return {name: geometry[f"{what}.{name}"] for name in names}

    directions = {1: "counter-clockwise", -1: "clockwise"}
    content: dict[str, Any] = {
        "radius": plain(test.radius),
        "feed": plain(test.feed, "m/s"),
        "direction": plain(float(test.direction), "1"),
        "revolutions": [one.count for one in found.tests],
        "centre": per_axis("centre"),
        "scale": per_axis("scale"),
        "squareness": geometry["squareness"],
        "backlash": per_axis("backlash"),
        "mismatch": geometry["mismatch"],
        "lag": found.lag,
        "glitch": found.glitches,
        "glitch_of": {
            directions[one.test.direction]: of for one, of in zip(found.tests, found.all_glitches, strict=True)
        },
        "pitch": [
            {"axis": names[line.axis], "pitch": plain(line.pitch), "amplitude": amplitude}
            for line, amplitude in found.periodic
        ],
        "rest": plain(found.rest),
        "scatter": plain(found.scatter),
        "noise": plain(found.noise),
        "iso230": {
            "G": plain(max(figures.G.values())),
            "G_of": {directions[k]: plain(value) for k, value in figures.G.items()},
            "G_b": plain(figures.G_b),
            "F_max": plain(figures.F_max),
            "F_min": plain(figures.F_min),
            "D": plain(figures.D),
        },
    }
    if held is not None:
        content |= {"predicted": _predicted(held), "scheme": held.scheme, "agrees": held.all_agree}
    return DiagnosisDocument.made(content, notices=notices).tree()


def _predicted(held: Agreement) -> dict[str, dict[str, Any]]:
    limits = held.intervals or {}
    return {
        name: {**vars(one), "ci95": limits.get(name), "agrees": held.agrees[name], "cause": held.causes.get(name)}
        for name, one in held.predicted.glitches.items()
    }


def tuning_tree(found: Tuned) -> dict[str, Any]:
    """Return what was tuned, ready to be printed."""
    from fric.identify.circle.next_circle import measured_glitch  # with SciPy, which a schema needs not

    axes = {}
    for name, one in found.axes.items():
        estimates = one.estimates
        sections = {} if estimates is None else {**estimates.static, **estimates.gms, **estimates.plant}
        axes[name] = {
            "parameters": sections,
            "residual": {"before": one.before.rms, "after": one.after.rms, "noise": one.after.noise()},
            "full_shape": one.full,
            "improves": one.improves,
        }
    predicted: dict[str, dict[str, Any]] = {}
    for ahead in found.predicted:
        entry = {"glitch": ahead.glitch, "ci95": list(ahead.ci95), "radius": ahead.radius}
        predicted.setdefault(f"{ahead.feed:g}", {})[ahead.scheme] = entry
    measured = {f"{test.feed:g}": measured_glitch(test) for test in found.tests}
    content = {"axes": axes, "predicted": predicted, "measured": measured}
    return TuningDocument.made(content, notices=found.warnings).tree()
