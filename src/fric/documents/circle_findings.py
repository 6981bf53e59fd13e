"""Results of measured circles, as `--json` prints them: diagnosis, tuning, learning; files of a tuned machine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field

from fric.circles.revolutions import Glitch
from fric.documents.base import Document, PartOf, Quantity, Written
from fric.documents.controller import ControllerPart
from fric.documents.fields import Known, of
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import MachineDocument, read_machine_document
from fric.documents.plant import PlantDocument
from fric.documents.yaml import write_document
from fric.estimate import Estimate
from fric.output import folder_made, refuse_existing
from fric.units import si_unit

if TYPE_CHECKING:
    from fric.circles.measured import MeasuredCircle
    from fric.circles.tune import Tuned
    from fric.circles.tune_fit import TunedAxis

SENSES = {1: "counter-clockwise", -1: "clockwise"}


class GlitchPart(PartOf[Glitch]):
    """A friction glitch at a quadrant."""


class PredictedGlitch(GlitchPart):
    """Prediction of a machine file for a quadrant."""

    ci95: list[Known] | None  # without what was identified there is none
    agrees: bool
    cause: str | None


class PitchPart(Written):
    """A periodic deviation along an axis."""

    axis: str
    pitch: Quantity
    amplitude: Quantity


def _per_axis(what: str) -> Callable[[Any], Any]:
    """Return a reader of a part of the geometry, by axis."""
    return lambda made: {name: made.found.geometry[f"{what}.{name}"] for name in made.found.test.names}


def _iso230(made: Any) -> dict[str, Any]:
    found, names = made.found.figures, ("G_b", "F_max", "F_min", "D")
    plain = {name: None if (value := getattr(found, name)) is None else Estimate(value, "m") for name in names}
    by_sense = {SENSES[sense]: Estimate(value, "m") for sense, value in found.G.items()}
    return {"G": Estimate(max(found.G.values()), "m"), "G_of": by_sense} | plain


def _predicted(made: Any) -> Any:
    if (held := made.held) is None:
        return None
    limits = held.intervals or {}
    return {
        name: {**vars(glitch), "ci95": limits.get(name), "agrees": held.agrees[name], "cause": held.causes.get(name)}
        for name, glitch in held.predicted.glitches.items() if name in held.agrees
    }  # fmt: skip


class DiagnosisDocument(Document, type="diagnosis"):
    """A measured circle, by causes."""

    radius: Quantity = of("found.test.radius", unit="m")
    feed: Quantity = of("found.test.feed", unit="m/s")
    direction: Quantity = of(lambda its: float(its.found.test.direction), "1 counter-clockwise, -1 clockwise", unit="1")
    revolutions: list[int] = of(lambda made: [test.count for test in made.found.tests])
    centre: dict[str, Quantity] = of(_per_axis("centre"))
    scale: dict[str, Quantity] = of(_per_axis("scale"))
    squareness: Quantity = of(lambda made: made.found.geometry["squareness"])
    backlash: dict[str, Quantity] = of(_per_axis("backlash"))
    mismatch: Quantity = of(lambda made: made.found.geometry["mismatch"])
    lag: dict[str, Quantity | None] = of("found.lag")
    glitch: dict[str, GlitchPart] = of("found.glitches")
    glitch_of: dict[str, dict[str, GlitchPart]] = of(
        lambda made: {SENSES[of.test.direction]: made.found.all_glitches[n] for n, of in enumerate(made.found.tests)}
    )
    pitch: list[PitchPart] = of(lambda made: [
        {"axis": made.found.test.names[line.axis], "pitch": Estimate(line.pitch, "m"), "amplitude": amplitude}
        for line, amplitude in made.found.periodic
    ])  # fmt: skip
    rest: Quantity | None = of("found.rest", unit="m")
    scatter: Quantity | None = of("found.scatter", unit="m")
    noise: Quantity | None = of("found.noise", unit="m")
    iso230: dict[str, Quantity | dict[str, Quantity] | None] = of(_iso230)
    predicted: dict[str, PredictedGlitch] | None = of(_predicted, default=None)
    reported: dict[str, Quantity] | None = of("reported", "figures of the ball bar's software", default=None)
    scheme: str | None = of(lambda made: made.held and made.held.scheme, default=None)
    agrees: bool | None = of(lambda made: made.held and made.held.all_agree, default=None)


class ResidualPart(Written):
    """Residual voltage of an axis [V]."""

    before: float = of("before.rms")
    after: float = of("after.rms")
    noise: float | None = of(lambda axis: axis.after.noise())


class TunedAxisPart(Written):
    """Results of circles for an axis."""

    parameters: dict[str, Quantity]
    residual: ResidualPart = of(lambda axis: axis)
    full_shape: bool = of("full")
    improves: bool


class NextCircle(Written):
    """Prediction of the next circle."""

    glitch: float = Field(description="[m]")
    ci95: list[Known]
    radius: float = Field(description="[m]")


def _ahead(made: Any) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for item in made.found.predicted:
        found.setdefault(f"{item.feed:g}", {})[item.scheme] = item
    return found


class TuningDocument(Document, type="tuning"):
    """The nominal parameters of controllers, refitted to recorded circles."""

    axes: dict[str, TunedAxisPart] = of("found.axes")
    predicted: dict[str, dict[str, NextCircle]] = of(_ahead, "by feed [m/s] and scheme")
    measured: dict[str, float] = Field(description="recorded glitch [m] by feed")
    files: list[str] | None = of(lambda made: list(map(str, made.files)) or None, default=None)


class LearnedCircle(Document):
    """The circle that was learned."""

    radius: float = of("circle.radius", "[m]")
    feed: float = of("circle.feed", "[m/s]")
    direction: Literal[1, -1] = of("circle.direction", "1 counter-clockwise")
    share: float = of("how.share", "share of a round's correction that is learned")
    bandwidth: float = of("how.bandwidth", "highest learned frequency [Hz]")


class RoundPart(Written):
    """One round."""

    glitch: float = of(lambda run: run.chance().median, "median over places between two counts [m]")
    ci95: list[float] = of(lambda run: [run.chance().low, run.chance().high], "range of 95 % of runs [m]")
    quadrants: list[float] = of(
        lambda run: [glitch.median for glitch in run.glitches], "at +x, +y, -x, -y, outwards positive, medians [m]"
    )


class CarriedPart(Written):
    """Result of another circle with the voltage learned on this circle."""

    radius: float = of(lambda item: item[0], "[m]")
    feed: float = of(lambda item: item[1], "[m/s]")
    glitch: float = of(lambda item: item[2], "[m]")


class LearningDocument(LearnedCircle, type="learning"):
    """Rounds of learning in simulation."""

    rounds: list[RoundPart]
    carried_over: list[CarriedPart] = of("carried")


class LearnedAxis(Written):
    """Feedforward of an axis."""

    largest: float = of(lambda voltage: float(abs(voltage).max()), "[V]")
    samples: int = of(len)


class LearnedFeedforwardDocument(LearnedCircle, type="learned-feedforward"):
    """Feedforward for the next round of a measured circle."""

    axes: dict[str, LearnedAxis] = of("voltage")


def tuned_files(found: Tuned, folder: Path) -> list[Path]:
    """Return the files that `write_tuned` writes."""
    better = [name for name, axis in found.axes.items() if axis.improves]
    return [folder / "machine.yaml", *(folder / f"{name}{end}.yaml" for name in better for end in ("", "-plant"))]


def write_tuned(
    found: Tuned, machine: Path, folder: Path, *, force: bool = False, done: list[Path] | None = None
) -> list[Path]:
    """Write a machine file with the new nominal parameters, and the friction and the plant of each axis that it names.

    An axis that was not improved stays as it was. ``done`` gets each file that is there.
    """
    files = tuned_files(found, folder_made(folder))
    refuse_existing(*files, force=force)
    done = [] if done is None else done
    tree, trees = read_machine_document(machine).content(), list[dict[str, Any]]()
    tree.pop("like", None)
    better = {name: axis for name, axis in found.axes.items() if axis.improves}
    for name, tuned in better.items():
        trees += [friction_tree(tuned, found.tests), plant_tree(tuned, found.tests)]
        axis = tree["axes"][name]
        axis.pop("nominal", None)  # it, and what is fed forward, are named once the rest has been checked
        axis["feedforward"] = {"lead": "auto"}
        if isinstance(axis.get("observer"), dict):  # its G_n is the nominal plant
            axis["observer"] = {key: part for key, part in axis["observer"].items() if key not in ("A", "B")}
        if tuned.loop:  # its gains were designed again
            cascade, watch = tuned.axis.cascade, tuned.axis.observer
            gains = ControllerPart.of(cascade, tuned.axis.motion)
            axis["controller"] = {key: gain.as_dict() for key, gain in gains.items()}
            if watch is not None:
                axis["observer"] = {"filter": watch.q.name, "cutoff": {"value": watch.q.cutoff, "unit": "Hz"}}
    written = MachineDocument.made(tree, notices=found.warnings, also=_sources(found.tests)).tree()
    for name, tuned in better.items():
        gain = tuned.axis.nominal_friction.gain
        share = {} if gain == 1.0 else {"gain": {"value": gain, "unit": "1"}}
        feedforward = {"lead": "auto", "friction": f"{name}.yaml", **share}
        written["axes"][name] |= {"nominal": f"{name}-plant.yaml", "feedforward": feedforward}
    for file, content in zip([*files[1:], files[0]], [*trees, written], strict=True):  # the machine names the others
        write_document(file, content, force=force)
        done.append(file)
    return files


def _sources(tests: Sequence[MeasuredCircle]) -> dict[str, Any]:
    return {"circles": [{"file": test.source, "test": test.name, "sha256": test.sha256} for test in tests]}


def friction_tree(tuned: TunedAxis, tests: Sequence[MeasuredCircle]) -> dict[str, Any]:
    """Return the friction that circles gave an axis as a friction document."""
    estimates, axis = tuned.estimates, tuned.axis
    assert estimates is not None  # of what is improved
    rmse = Estimate(tuned.after.rms * tuned.nominal.K_f, si_unit("force", axis.motion))
    method = "circles: voltage balance, " + ("full shape" if tuned.full else "level, stiffness, C and T_d")
    text = {"rmse": rmse, "method": method, "covariance": estimates.covariance}
    content: dict[str, Any] = {"axis": axis.name, "motion": axis.motion, "static": estimates.static}
    if estimates.negative is not None:
        content["static_negative"] = estimates.negative
    content |= {"gms": estimates.gms, "gms_fit": text}
    return FrictionDocument.made(content, notices=tuned.warnings, also=_sources(tests)).tree()


def plant_tree(tuned: TunedAxis, tests: Sequence[MeasuredCircle]) -> dict[str, Any]:
    """Return the nominal plant that circles gave an axis as a plant document."""
    estimates, axis = tuned.estimates, tuned.axis
    assert estimates is not None
    content = {"axis": axis.name, "motion": axis.motion, **estimates.plant}
    return PlantDocument.made(content, also=_sources(tests)).tree()
