"""A plan, ``fric: plan/1``: the records to take of an axis, and the expected intervals."""

from collections.abc import Iterable
from typing import Any, Self

from pydantic import Field, model_validator

from fric.documents.base import FilePart, OfAxis, Part, Quantity, in_units
from fric.documents.fields import Known, SchemaError, known, of, read_off, refused, said
from fric.estimate import Estimate
from fric.notice import Notice
from fric.simulate.experiment import EXPERIMENTS, Limits, Narrowing, Plan, Planned, Setting
from fric.units import Motion

SETTINGS = {  # Dimension of each setting of an experiment
    "speeds": "velocity", "distance": "position", "lasting": "time", "ramp": "time", "repeats": "ratio",
    "amplitudes": "position", "frequency": "frequency", "cycles": "ratio", "mean": "velocity", "swing": "velocity",
    "peaks": "velocity", "lowest": "frequency", "highest": "frequency", "lines": "ratio", "periods": "ratio",
    "step": "position", "steps": "ratio", "loops": "ratio", "dwell": "time",
    "radius": "position", "feed": "velocity", "revolutions": "ratio",
}  # fmt: skip


class ExperimentPart(Part):
    """One experiment: the motion of the axis."""

    kind: str
    axis: str = ""
    duration: Quantity | None = None
    why: str = ""
    settings: dict[str, Quantity]

    def planned(self, motion: Motion) -> Planned:
        """Return the experiment; raise SchemaError where there is no such kind or setting, or a unit does not fit."""
        if self.kind not in {*EXPERIMENTS, "circle"}:
            hint = f"There are {', '.join(EXPERIMENTS)}, and circle."
            raise SchemaError(f"there is no experiment '{self.kind}'", hint=hint)
        found: dict[str, Setting] = {}
        for name, given in self.settings.items():
            if name not in SETTINGS:
                raise SchemaError(f"'{name}' is not a setting", hint=f"Known are {', '.join(SETTINGS)}.")
            with refused(name):
                size = given.si(SETTINGS[name], motion)
                if name in {"amplitudes", "peaks", "speeds"}:
                    found[name] = size.value if isinstance(size.value, tuple) else (size.value,)
                else:
                    found[name] = round(float(size)) if SETTINGS[name] == "ratio" else float(size)
        return Planned(self.kind, found, self.why)


class ExpectedPart(Part):
    """Expected interval of one parameter."""

    value: float = Field(description="median of the identified values over several runs, in SI")
    half_width: Known = Field(description="half the 95 % interval; null where the records set no limit")
    unit: str
    between: tuple[Known, Known] | None = said("half-widths of single runs, least and largest of the simulated runs")


class CandidatePart(ExperimentPart):
    """A further record, and the interval after it."""

    half_width: Quantity = Field(description="half the 95 % interval of the predicted glitch with it")


class NarrowingPart(Part):
    """The further record that would narrow a predicted glitch most."""

    scheme: str
    radius: Quantity = of("test.radius", unit="m")
    feed: Quantity = of("test.feed", unit="m/s")
    half_width: Quantity = of("half_width", "half the 95 % interval of the predicted glitch at present", unit="m")
    shares: dict[str, float] = Field(description="share of its variance due to each parameter")
    records: list[CandidatePart]


class PlanDocument(OfAxis, type="plan"):
    """Records to take of an axis, and the expected intervals."""

    limits: FilePart[Limits]
    prior: str = said("the assumed axis", "")
    experiments: list[ExperimentPart]
    expected: dict[str, ExpectedPart] = said("by parameter; k_2 is of block 2", dict)
    blocks: int | None = said("slip blocks that the records determine: identify gms --blocks")
    narrowing: NarrowingPart | None = said("after a first result: effect of a further record")

    @model_validator(mode="after")
    def _settings_fit(self) -> Self:
        self.planned()
        self.limits.estimates(self.motion, "limits")
        return self

    def planned(self) -> tuple[Planned, ...]:
        """Return the experiments."""
        return tuple(experiment.planned(self.motion) for experiment in self.experiments)


def plan_tree(
    plan: Plan, blocks: int | None, prior: str, notices: Iterable[Notice], narrowing: Narrowing | None = None
) -> dict[str, Any]:
    """Return a plan, with the assumed axis and what one more record would do, ready to be written or printed."""
    axis, motion = plan.axis.name, plan.axis.motion

    def entry(record: Planned, lasting: float, **also: Estimate) -> dict[str, Any]:
        settings = in_units(record.settings, {name: SETTINGS[name] for name in record.settings}, motion)
        lasts = Estimate(lasting, "s")
        return {"kind": record.kind, "axis": axis, "duration": lasts, "why": record.why, "settings": settings, **also}

    content = {
        "axis": axis, "motion": motion, "limits": FilePart[Limits].of(plan.limits, motion), "prior": prior,
        "experiments": list(map(entry, plan.planned, plan.lasting)), "expected": plan.expected,
    }  # fmt: skip
    if narrowing is not None:
        records = [entry(c.planned, c.lasting, half_width=Estimate(c.half_width, "m")) for c in narrowing.candidates]
        content["narrowing"] = read_off(NarrowingPart, narrowing, {"records"}) | {"records": records}
    return PlanDocument.made(content | known(blocks=blocks), notices=notices).tree()
