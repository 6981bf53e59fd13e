"""After a first identification: the one more record that would narrow the predicted glitch most."""

from dataclasses import replace
from typing import Any

from fric.documents.friction import FrictionDocument
from fric.documents.plan import experiment_entry
from fric.errors import FricError
from fric.flaws.plan import PLAN_FRICTION_ALONE
from fric.planning.next_record import Narrowing, narrowing
from fric.planning.plan import Limits, Plan
from fric.results.given import Advance, in_si, silent
from fric.results.given_models import document_of
from fric.results.machine import machine_of, schemes_of
from fric.results.plan import GOOD_TO, PlanResult, settings_in_words
from fric.results.prior import TYPICAL, prior_axis
from fric.results.text import Piece, Table
from fric.units import readable
from fric.verb import verb


class NextRecordResult(PlanResult):
    """A plan of one record: of all candidates the one that narrows the predicted glitch most."""

    def report(self) -> list[Piece]:
        """Return the candidates by what they leave, and what the glitch is not known for."""
        given = self.document["narrowing"]
        feed, radius = (readable(**given[name]) for name in ("feed", "radius"))
        rows = [
            (
                one["kind"], readable(one["duration"]["value"], "s"), readable(one["half_width"]["value"], "m", 2),
                f"{one['half_width']['value'] / given['half_width']['value'] - 1:+.0%}".replace("-", "−"),
                settings_in_words(planned, self.plan.axis.motion),
            )
            for one, planned in zip(given["records"], self.candidates, strict=True)
        ]  # fmt: skip
        shares = sorted(given["shares"].items(), key=lambda item: -item[1])
        described = ", ".join(f"{name} {share:.0%}" for name, share in shares if share > 0.02)
        return [
            f"the glitch of scheme ({given['scheme']}) at {feed} on a circle of {radius} is known to "
            f"± {readable(given['half_width']['value'], 'm', 2)}, for {described}",
            Table(("one more record", "time", "then ±", "", "what to run"), rows),
            f"{GOOD_TO}; of records that differ by less the shorter one comes first",
        ]

    @property
    def candidates(self) -> list[Any]:
        """The candidates, the best first."""
        from fric.documents.plan import PlanDocument

        part = PlanDocument.model_validate(self.document).narrowing
        assert part is not None
        return [one.planned(self.plan.axis.motion) for one in part.records]


@verb
def plan_next(
    last: Any,
    *,
    stroke: float | str = 0.3,
    feed: float | str = 0.1,
    acceleration: float | str = 5.0,
    machine: Any = None,
    scheme: Any = "c",
    noise: float | str | None = None,
    encoder: float | str | None = None,
    like: Any = None,
    advance: Advance = silent,
) -> NextRecordResult:
    """Tell which one more record would narrow the predicted glitch of an axis most.

    Parameters
    ----------
    last
        The last result: a friction file with a GMS model and its covariance, or a result.
    stroke, feed, acceleration
        What the axis may do [m], [m/s], [m/s²], also as texts with units.
    machine
        The machine that runs the circle: plant, controller, the other axis; a typical one where not given.
    scheme
        The compensation whose glitch is predicted.
    noise, encoder, like
        As in `plan`.
    advance
        Is told of each circle and each record.

    Raises
    ------
    FricError
        When the file has no GMS model with covariance, or the machine no two axes.
    """
    document = document_of("plan_next", FrictionDocument, last)
    axis, notices = prior_axis(machine, document.axis, document, noise=noise, encoder=encoder, like=like)
    described = [document.fit_of(section).covariance for section in ("static", "gms") if section in document.sections()]
    if len(described) < 2 or not all(described):
        raise FricError(
            "the friction file does not tell how static map and GMS model err",
            hint="It takes one of `fric identify gms --static`; `fric plan --friction` says which records that takes.",
        )
    (chosen,) = schemes_of("plan_next", scheme)
    subject = machine_of("plan_next", TYPICAL if machine is None else machine)
    if axis.name not in subject.axes:
        axis = replace(axis, name="x")
    limits = Limits(
        in_si(stroke, "position", axis.motion), in_si(feed, "velocity", axis.motion),
        in_si(acceleration, "acceleration", axis.motion),
    )  # fmt: skip
    fit = document.fit_of("static")
    between = 0.0 if fit.between_strokes is None else float(fit.between_strokes.si("force", axis.motion))
    covariances = [block.covariance() for block in described if block is not None]
    found = narrowing(subject, axis, limits, covariances, between, chosen, advance)
    axis = replace(axis, name=document.axis)
    best = found.candidates[0]
    notices.append(PLAN_FRICTION_ALONE.found(scheme=chosen.name))
    made = Plan(axis, limits, (best.planned,), [best.lasting], {})
    entry = _entry(found, chosen.name, axis.name)
    return NextRecordResult(made, None, f"axis {axis.name} as identified last", notices, entry)


def _entry(found: Narrowing, scheme: str, axis: str) -> dict[str, Any]:
    def metres(value: float) -> dict[str, Any]:
        return {"value": value, "unit": "m"}

    return {
        "scheme": scheme, "radius": metres(found.test.radius), "feed": {"value": found.test.feed, "unit": "m/s"},
        "half_width": metres(found.half_width), "shares": dict(found.shares),
        "records": [
            experiment_entry(one.planned, "linear", axis, one.lasting) | {"half_width": metres(one.half_width)}
            for one in found.candidates
        ],
    }  # fmt: skip
