"""Results of schemes on a contour, as `--json` prints them: circle, path, many circles, the paper, a folder of logs."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from fric.arrays import Real
from fric.circles.prediction import Predicted, Prediction
from fric.contour import beside
from fric.documents.base import CodedWarning, Document, PartOf, Written, again
from fric.documents.fields import Known, of, said
from fric.documents.listings import StepsPart
from fric.simulate.spread import Distribution
from fric.units import readable

Rows = list[list[Known]]


def _by_scheme(made: Any) -> dict[str, Any]:
    return {run.scheme.name: run for run in made.runs}


class ChancePart(Written):
    """Range of 95 % of further runs, if encoder counts determine the result of a run."""

    places: int = of(
        lambda run: len(run.places), "places between two counts at which it was run; all values are medians over these"
    )
    glitch: list[float] = of(lambda run: [run.chance().low, run.chance().high], "[m]")
    reversals: list[list[float]] = of(
        lambda run: [[glitch.low, glitch.high] for glitch in run.glitches], "of the signed glitch at each reversal [m]"
    )


class ContourScheme(Written):
    """Result of one scheme on a contour."""

    title: str = of("scheme.title")
    glitch: float = of(lambda run: run.chance().median, "largest size at a reversal, on the given machine [m]")


class CircleScheme(ContourScheme):
    """Result of one scheme on a circle."""

    quadrants: list[float] = of(
        lambda run: [glitch.median for glitch in run.glitches], "at +x, +y, -x, -y, outwards positive [m]"
    )
    radial_rms: float = of(lambda run: run.chance("rms").median, "[m]")
    radial_range: float = of(lambda run: run.chance("range").median, "largest less smallest radial error [m]")
    chance: ChancePart | None = of(lambda run: run if run.places else None, "null where a single run determines it")
    warnings: list[str] = Field(default_factory=list)


class SchemeSpread(Written):
    """Distribution of the glitch of a scheme over machines; null where it ran on none."""

    median: Known = of(lambda item: item.quantiles["median"], "[m]")
    p05: Known = of(lambda item: item.quantiles["p05"])
    p95: Known = of(lambda item: item.quantiles["p95"])
    ci95: list[Known] = of(lambda item: [item.quantiles["low"], item.quantiles["high"]])
    best: float = Field(description="share of the machines on which no other scheme is better")
    failed: int = Field(description="machines on which it could not run")
    saturated: int


class SpreadFactor(Written):
    """A spread parameter and its range."""

    distribution: Distribution
    factor: list[float] = of(lambda item: [item.low, item.high])


class MonteCarloPart(Written):
    """The test on many machines."""

    machines: int = of(len)
    asked: int
    seed: int = of("study.seed")
    accuracy: float = of("study.accuracy", "largest error of a glitch by the integration [m]")
    from_intervals: dict[str, list[str]] = of(
        lambda many: {name: sorted(interval) for name, interval in many.study.intervals.items()},
        "parameters drawn from identified intervals, by axis",
    )
    spreads: dict[str, SpreadFactor] = of("study.spreads")
    schemes: dict[str, SchemeSpread] = of(lambda many: many.distributions())
    warnings: list[str] = of(lambda many: many.warnings())


class VerdictPart(Written):
    """The scheme to switch on, whether to trust that, and the next commands; lengths in m."""

    scheme: str | None = of(lambda it: it.choice and it.choice.scheme.name, "null where none is recommended")
    glitch: float | None = of(lambda it: it.choice and it.choice.middle, "median over the machines that were drawn")
    ci95: list[float] | None = of(lambda it: it.choice and it.choice.interval)
    stays_under: float | None = of(
        lambda it: it.choice and it.choice.stays_under, "bound of the glitch on 95 % of the drawn machines"
    )
    trusted: bool
    passes: bool | None = Field(description="whether the tolerance is kept; null if none was given, or not decided")
    result: Literal["", "pass", "fail", "not decided"] = of(lambda it: it.result[0], "empty if no tolerance was given")
    headline: str
    why: list[str] = Field(description="why it is not to be trusted yet")
    settled: list[str] = Field(description="warnings of the files that the measured circle settles")
    effort: list[str]
    next: list[str] = Field(description="next commands")


class PredictedScheme(PartOf[Predicted]):
    """Prediction of one scheme on machines drawn from the uncertainty of the identified machine."""

    glitch: Known = Field(description="median [m]")
    under: Known = Field(description="bound of the glitch on 95 % of the machines [m]")
    trusted: bool
    why: list[CodedWarning] = Field(description="why it must not be trusted")


class PredictionPart(PartOf[Prediction]):
    """Predictions of schemes on the circle, and whether they may be trusted."""

    schemes: dict[str, PredictedScheme]


def prediction_tree(found: Prediction) -> dict[str, Any]:
    """Return a prediction as plain values."""
    return PredictionPart.model_validate(found, from_attributes=True).model_dump(exclude_unset=True)


def prediction_of(tree: Mapping[str, Any]) -> Prediction:
    """Return the prediction from plain values."""
    found: Prediction = again(Prediction, tree)
    schemes = {
        name: replace(scheme, distrust=tuple(why for why in scheme.why if why not in found.distrust))
        for name, scheme in found.schemes.items()
    }
    return replace(found, schemes=schemes)


class ReproducedFeed(Written):
    """Results of schemes on a circle."""

    velocity: float = of(lambda made: made.runs[0].circle.feed, "feed [m/s]")
    radius: float = of(lambda made: made.runs[0].circle.radius, "[m]")
    direction: Literal[1, -1] = of(lambda made: made.runs[0].circle.direction, "1 counter-clockwise")
    schemes: dict[str, CircleScheme] = of(_by_scheme)


class CircleResultDocument(Document, ReproducedFeed, type="circle-result"):
    """Results of schemes on a circle."""

    monte_carlo: MonteCarloPart | None = of("many", default=None)
    verdict: VerdictPart | None = said("the scheme to switch on, by this circle alone")
    prediction: PredictionPart | None = of("prediction", default=None)


class ReproductionDocument(Document, type="reproduction"):
    """Result of a reproduction of the paper: the page, and the glitches of each scheme."""

    page: str = of(lambda made: str(made.page))
    steps: int
    made_now: int = of("made", "steps that were not up to date", alias="made")
    feeds: dict[str, ReproducedFeed] = of(
        lambda made: {f"{circle.runs[0].circle.feed:g}": circle for circle in made.circles()}, "by feed [m/s]"
    )


class PathReversal(Written):
    """The glitch at one reversal of an axis."""

    axis: str
    x: float
    y: float
    glitch: float = Field(description="[m]")


def _reversals(run: Any) -> list[dict[str, Any]]:
    names = tuple(run.traces)
    names = names if len(names) > 1 else beside(names[0])
    pairs = zip(run.contour.reversals, run.glitches, strict=True)
    return [{"axis": names[at.axis], "x": at.x, "y": at.y, "glitch": glitch.median} for at, glitch in pairs]


class PathScheme(ContourScheme):
    """Result of one scheme on a path."""

    reversals: list[PathReversal] = of(_reversals)
    contour_rms: float = of(lambda run: run.chance("rms").median)
    contour_range: float = of(lambda run: run.chance("range").median)
    chance: ChancePart | None = of(lambda run: run if run.places else None, "null where a single run determines it")
    warnings: list[str] = Field(default_factory=list)


class PathResultDocument(Document, type="path-result"):
    """Results of schemes on a path."""

    velocity: float = of(lambda made: made.runs[0].test.feed, "feed [m/s]")
    schemes: dict[str, PathScheme] = of(_by_scheme)


class MappedScheme(Written):
    """Result of one scheme on every circle."""

    title: str
    glitch: Rows = Field(description="a row for each radius, a column for each feed [m]; null where it could not run")
    failures: list[str] = said("the reason where it could not run", list)


class MapDifference(Written):
    """Difference between the glitches of two schemes."""

    scheme: str
    against: str
    less: Rows = Field(description="a row for each radius, a column for each feed [m]; negative where it is worse")


class CircleMapDocument(Document, type="circle-map"):
    """Results of schemes on circles of many feeds and radii."""

    machine: str = of("grid.machine.name")
    feeds: list[float] = of("grid.feeds", "[m/s]")
    radii: list[float] = of("grid.radii", "[m]")
    schemes: dict[str, MappedScheme] = of(lambda found: {
        scheme.name: {"title": scheme.title, "glitch": glitch.tolist(), "failures": [*dict.fromkeys(
            why for cell in found.cells if (why := cell.failures.get(scheme.name))
        )]}
        for scheme, glitch in zip(found.grid.schemes, found.glitches, strict=True)
    })  # fmt: skip
    differences: dict[str, MapDifference] = of(lambda found: {
        name: {"scheme": scheme.name, "against": other.name, "less": found.less(scheme, other).tolist()}
        for name, (scheme, other) in found.pairs().items()
    }, "advantage of blocks over a static map, and of an observer over a feedforward")  # fmt: skip

    @model_validator(mode="after")
    def _shaped(self) -> Self:
        shape = [len(self.feeds)] * len(self.radii)
        for rows in [*(e.glitch for e in self.schemes.values()), *(e.less for e in self.differences.values())]:
            if [*map(len, rows)] != shape:
                raise ValueError(f"glitches are a row for each of {len(self.radii)} radii, of {len(self.feeds)} feeds")
        return self

    def describe(self) -> list[str]:
        """Return where and how much each pair of schemes differs, a sentence for each pair."""
        return [self._described(name, np.array(pair.less, float)) for name, pair in self.differences.items()]

    def _described(self, name: str, less: Real) -> str:
        if not (ran := np.isfinite(less)).any():
            return f"{name}: no circle ran with both"

        def at(place: np.intp) -> str:
            row, column = np.unravel_index(int(place), less.shape)
            by = readable(abs(float(less[row, column])), "m")
            return f"{by} at {readable(self.radii[row], 'm')} and {readable(self.feeds[column], 'm/s')}"

        better, worse = less > 0, less < 0
        text = f"{name}: less on {np.count_nonzero(better)} of {np.count_nonzero(ran)} circles"
        text += f", at most by {at(np.nanargmax(less))}" if better.any() else ""
        return text + (f"; more on {np.count_nonzero(worse)}, by {at(np.nanargmin(less))}" if worse.any() else "")


class AutoDocument(Document, type="auto"):
    """The report, what was done by axis, and the verdict."""

    report: str | None = of(lambda made: str(made.folder / "report.html") if made.page else None)
    axes: dict[str, StepsPart]
    verdict: VerdictPart
