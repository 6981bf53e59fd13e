"""What a verdict rests on, and what it is: what each scheme left of one machine, and of those drawn around it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from fric.arrays import Real
from fric.documents.base import provenance
from fric.documents.bundled import bundled
from fric.flaws import flaw_of
from fric.flaws.files import GAINS_DESIGNED
from fric.flaws.prediction import NO_MEASURED_CIRCLE
from fric.notice import Notice
from fric.simulate.chance import Chance
from fric.units import readable

if TYPE_CHECKING:
    from fric.circles.prediction import Predicted, Prediction
    from fric.control.scheme import Scheme
    from fric.simulate.contour_run import ContourRun
    from fric.simulate.machine import Machine
    from fric.simulate.monte_carlo import MonteCarlo


SHARE = 0.95
"""Share of the machines that were drawn which stay under what is told."""


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """What one compensation scheme leaves of a contour."""

    scheme: Scheme  # The scheme
    glitches: tuple[float, ...]  # Signed glitch at each reversal [m]
    glitch: float  # The largest magnitude of them [m]; the median over places where it hangs on counts
    # The same at each place between two counts [m], the same places for every scheme (`fric.simulate.chance`); empty
    # where one run tells it
    places: tuple[float, ...] = ()
    warnings: tuple[Notice, ...] = ()  # What the simulation told; one of severity ``wrong`` forbids the scheme
    # Glitch on each of the machines that were drawn [m], the same machines for every scheme; nan on one where the
    # scheme cannot run. Empty where none was drawn.
    drawn: tuple[float, ...] = ()
    # What swings where no axis reverses [m] (`fric.contour.Circularity.oscillation`); 0 where it is not known
    oscillation: float = 0.0
    swings: tuple[float, ...] = ()  # The same on each of the machines that were drawn [m]; empty where it is not known
    # What the machines drawn from what was identified say of it, with the encoder's step taken in, and why that must
    # not be trusted; None where they were drawn otherwise, or none was
    predicted: Predicted | None = None

    @property
    def named(self) -> str:
        """How the scheme is called in a sentence."""
        return f"({self.scheme.name}) {self.scheme.title}"

    @property
    def stays_under(self) -> float:
        """What it stays under on 95 % of the machines that were drawn [m]; inf where it runs on fewer.

        The glitch of the one machine where none was drawn.
        """
        own = float(upper(np.array([self.drawn]))[0]) if self.drawn else self.glitch
        return own if self.predicted is None else max(own, self.predicted.under)

    @property
    def chance(self) -> Chance:
        """The glitch of the one machine with its chance [m]."""
        return Chance(self.places or (self.glitch,), 0.0)

    @property
    def middle(self) -> float:
        """The median over the machines that were drawn [m]; the glitch of the one machine where none was."""
        return float(np.quantile(self._ran, 0.5)) if self.drawn else self.glitch

    @property
    def interval(self) -> tuple[float, float] | None:
        """Between what the glitch lies on the machines that were drawn [m]: 2.5 % are below, 5 % above `stays_under`.

        None where it ran on none. Without machines between what it lies by chance, where it hangs on counts.
        """
        if self.places and not self.drawn:
            return self.chance.low, self.chance.high
        if self.predicted is not None and np.isfinite(self.predicted.ci95).all():
            return self.predicted.ci95[0], self.stays_under
        if not np.isfinite(self._ran).any():
            return None
        return float(np.quantile(self._ran, 0.025)), self.stays_under

    @property
    def _ran(self) -> Real:
        drawn = np.array(self.drawn, float)
        return drawn[np.isfinite(drawn)] if np.isfinite(drawn).any() else np.array([np.inf])

    @property
    def demand(self) -> int:
        """How much it asks for: 1 for a static map or a control block, 2 for a model with pre-sliding."""
        model = 0 if self.scheme.friction is None else 1 if self.scheme.friction == "static" else 2
        return model + len(self.scheme.blocks) + int(self.scheme.controller != "cascade")


def upper(drawn: Real) -> Real:
    """Return the `SHARE` quantile of each row of glitches [m]; nan, a machine that could not run, is beyond all."""
    return np.asarray(np.quantile(np.where(np.isnan(drawn), np.inf, drawn), SHARE, axis=1, method="higher"))


def bare(candidates: Iterable[Candidate]) -> Candidate | None:
    """Return the candidate without any compensation."""
    return next((one for one in candidates if one.scheme.bare), None)


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What a verdict rests on."""

    candidates: Sequence[Candidate] = ()  # What was run
    axes: tuple[str, ...] = ()  # Names of the axes that were run; the verdict is of no other
    resolution: float = 0.0  # The coarsest step of their encoders [m]: no smaller difference is spoken of
    exact: bool = False  # Whether the controllers believe exactly the friction and the plant that the machine has
    compared: bool = False  # Whether a measured circle was held against the prediction
    disagreements: Sequence[Notice] = ()  # Where a measured circle is not as predicted, with the likely cause
    notices: Sequence[Notice] = ()  # What the files that the machine is made of, and the runs, warn of
    distrust: Sequence[Notice] = ()  # Why no interval of a prediction must be trusted
    # What speaks against the machine's files, and not against the machines that were drawn: they were made to agree
    # with the circle that shows it
    settled: Sequence[Notice] = ()
    # The largest glitch that was measured on this circle [m], by name of the scheme that was on
    measured: Mapping[str, float] = field(default_factory=dict)
    tolerance: float | None = None  # Glitch that is allowed [m]; None where nothing was asked
    # machine, circle: names of the machine's file and of the measured circle's, for what to type next
    machine: str = "MACHINE.yaml"
    circle: str = "CIRCLE.h5"
    command: str = ""  # The command that simulated; empty where it is not known
    rotary: bool = False  # Whether all axes are rotary, which no circle is of
    # The largest glitch that is predicted of the measured circle, and that was measured [m]; None without one
    glitches: tuple[float, float] | None = None

    @property
    def designed(self) -> bool:
        """Whether the gains are those that fric designed, and no measured circle shows them."""
        return any(one.code == GAINS_DESIGNED.code for one in self.notices) and bool(
            not self.compared or self.disagreements
        )

    @property
    def machines(self) -> int:
        """Machines that were drawn for every candidate."""
        return min((len(one.drawn) for one in self.candidates), default=0)


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What to do."""

    choice: Candidate | None  # What is recommended; None where nothing is
    headline: str  # The verdict in a sentence or two
    why: tuple[Notice, ...] = ()  # Why it is not to be trusted yet; empty where it is
    # What less, or more, effort would change, as far as differences are sure; what must not be used
    effort: tuple[str, ...] = ()
    next: tuple[str, ...] = ()  # What to type next
    kept: bool | None = None  # Whether the tolerance is kept on 95 % of the machines; None where none was asked
    settled: tuple[Notice, ...] = ()  # As in `Evidence`
    compared: tuple[float, float] | None = None  # The glitch that is predicted of a measured circle, and its own [m]

    @property
    def result(self) -> tuple[str, str]:
        """Return ``pass``, ``fail`` or ``not decided``, and what that means; both empty where no tolerance was asked.

        It passes where the tolerance is kept and nothing at all speaks against the verdict.
        """
        if self.kept is None:
            return "", ""
        if self.choice is None:
            return "not decided", "no scheme is recommended"
        if not self.kept:
            return "fail", "no scheme that was run surely stays within it"
        if not self.trusted:
            return "not decided", "it is kept in simulation, which is not to be trusted yet"
        return "pass", "on 95 % of the machines drawn around this one"

    @property
    def passes(self) -> bool | None:
        """Whether the tolerance is kept; None where none was asked, and where that is not decided."""
        return {"pass": True, "fail": False}.get(self.result[0])

    @property
    def trusted(self) -> bool:
        """Whether nothing speaks against it."""
        return not self.why

    @property
    def checked(self) -> str:
        """What a measured circle says of the prediction, in a sentence; empty without one."""
        if self.compared is None:
            return ""
        predicted, measured = (readable(one, "m", 3) for one in self.compared)
        return f"Predicted {predicted}, measured {measured}: {'trusted' if self.trusted else 'not trusted yet'}."

    def lines(self) -> list[str]:
        """Return it as lines for people: the sentence, why not to trust it, what to type next."""
        described = [self.headline, *self.effort]
        described += [": ".join(self.result)] if self.kept is not None else []
        described += [self.checked] if self.checked else []
        described += [f"settled by the measured circle: {', '.join(self.settled_by_code)}"] if self.settled else []
        described += [f"not trusted yet: {text}" for text in self.why]
        return [*described, *(f"next: {text}" for text in self.next)]

    @property
    def settled_by_code(self) -> list[str]:
        """The codes of what a measured circle settles, each once."""
        return list(dict.fromkeys(one.code or str(one) for one in self.settled))


def candidates_of(
    runs: Sequence[ContourRun[Any, Any]], many: MonteCarlo | None = None, prediction: Prediction | None = None
) -> list[Candidate]:
    """Return what schemes left of one machine, and on the machines that were drawn."""
    found = []
    for n, run in enumerate(runs):
        found.append(
            Candidate(
                scheme=run.scheme, glitches=tuple(one.median for one in run.glitches), glitch=run.chance().median,
                places=tuple(one.glitch for one in run.places), warnings=run.warnings,
                oscillation=run.chance("oscillation").median,
                drawn=tuple(map(float, many.glitches[:, n])) if many else (),
                swings=tuple(map(float, many.swings[:, n])) if many else (),
                predicted=prediction.schemes.get(run.scheme.name) if prediction else None,
            )
        )  # fmt: skip
    return found


def facts(machine: Machine, runs: Sequence[ContourRun[Any, Any]]) -> dict[str, Any]:
    """Return what a run file keeps of a machine, as plain data that `evidence_of` reads."""
    names = list(runs[0].traces)
    return provenance() | {
        "machine": machine.name,
        "warnings_coded": [Notice.of(one).as_dict() for one in machine.warnings],
        "axes": names,
        "resolution": max((machine.axes[name].encoder.resolution for name in names), default=0.0),
        "exact": machine.is_nominal([run.scheme.friction for run in runs], names),
        "origin": dict(machine.origin),
    }


def evidence_of(
    made: Mapping[str, Any],
    candidates: Sequence[Candidate],
    prediction: Prediction | None = None,
    *,
    compared: bool = False,
    disagreements: Mapping[str, Sequence[Notice]] = MappingProxyType({}),
    **more: Any,
) -> Evidence:
    """Return the evidence of candidates whose run file keeps `facts`; of an older file what it has of them.

    made: The facts.
    candidates: What was run.
    prediction: What the machines drawn from what was identified say. Where they were made to agree with measured
        circles, what such a circle shows beside the machine file is explained by that, and what even they do not show
        stands against it.
    compared: As in `Evidence`.
    disagreements: By file of a measured circle, where it is not as the machine file predicts. That of a circle that all
        machines were made to agree with is settled.
    more: Further fields of `Evidence`.
    """
    distrust = prediction.distrust if prediction else ()
    seen = {Path(where.partition(", test ")[0]).name for where in (prediction.measured if prediction else ())}
    compared = compared or bool(seen)
    against = [one for one in distrust if flaw_of(one).disagrees]
    distrust = tuple(
        one for one in distrust if one not in against and not (compared and one.code == NO_MEASURED_CIRCLE.code)
    )
    settled = list[Notice]()
    for file, found in disagreements.items():
        (settled if Path(file).name in seen else against).extend(found)
    coded = [*map(Notice.of, made.get("warnings_coded", ()))]
    notices = more.pop("notices", coded)
    if seen:
        settled += [one for one in notices if flaw_of(one).circle_settles and one.severity == "wrong"]
        notices = [one for one in notices if not flaw_of(one).circle_settles]
    file = str(made.get("origin", {}).get("path", ""))
    names = {"machine": machine_name(file) if file else "MACHINE.yaml", "command": str(made.get("command", ""))}
    names |= {"circle": min(seen)} if seen else {}
    return Evidence(
        candidates=candidates,
        axes=tuple(map(str, made.get("axes", ()))),
        resolution=float(made.get("resolution", 0.0)),
        exact=bool(made.get("exact", False)),
        compared=compared,
        disagreements=against,
        distrust=distrust,
        settled=tuple(dict.fromkeys(settled)),
        notices=notices,
        **names | more,
    )


def machine_name(file: str) -> str:
    """Return what to type for a machine's file: the name of a bundled one, else its path."""
    names = {str(path): name for name, path in bundled("machine").items()}
    return names.get(str(Path(file)), file)
