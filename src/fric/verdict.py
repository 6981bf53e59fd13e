"""The verdict: its evidence, and the function that decides for every command, page and ``--json``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from os import sep
from pathlib import Path
from shlex import quote
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from fric.arrays import Real
from fric.documents.base import provenance
from fric.documents.bundled import bundled
from fric.estimate import Estimate
from fric.flaws import flaw_of, prediction
from fric.flaws.blocks import LEVEL_OF_ANOTHER
from fric.flaws.circle import COMPLETED_DISAGREES, GAINS_UNKNOWN, LOOP_LAGS
from fric.flaws.files import GAINS_DESIGNED
from fric.flaws.prediction import CIRCLE_UNUSED, NO_MEASURED_CIRCLE, NOTHING_SIMULATED
from fric.flaws.static_map import STROKES_SCATTER
from fric.notice import Notice
from fric.simulate.contour_run import Chance
from fric.units import readable

if TYPE_CHECKING:
    from fric.circles.prediction import Predicted, Prediction
    from fric.control.scheme import Scheme
    from fric.simulate.contour_run import ContourRun
    from fric.simulate.machine import Machine
    from fric.simulate.processes import MonteCarlo

SHARE = 0.95  # Share of the drawn machines that stay below the reported value
CLOSE = 1.25  # Ratio of predicted to measured glitch, either way, up to which agreement within intervals is trust
MIXED = {STROKES_SCATTER.code, LEVEL_OF_ANOTHER.code}  # Flaws by which records are of two machines
FAR = 1.7  # The same ratio from which machines fitted to the circle decide nothing: friction varies less between days


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """Result of one compensation scheme on a contour."""

    scheme: Scheme  # The scheme
    glitches: tuple[float, ...]  # Signed glitch at each reversal [m]
    glitch: float  # The largest magnitude of them [m]; the median over places where it depends on counts
    places: tuple[float, ...] = ()  # The same at each place between two counts [m]; empty where one run is enough
    warnings: tuple[Notice, ...] = ()  # Warnings of the simulation; severity ``wrong`` forbids the scheme
    drawn: tuple[float, ...] = ()  # Glitch on each machine drawn [m], the same for all schemes; nan where it cannot run
    oscillation: float = 0.0  # Oscillation where no axis reverses [m]; 0 where it is not known
    swings: tuple[float, ...] = ()  # The same on each of the machines that were drawn [m]; empty where it is not known
    predicted: Predicted | None = None  # On machines drawn from what was identified, with the encoder's step; else None

    @property
    def named(self) -> str:
        """Name of the scheme in a sentence."""
        return f"({self.scheme.name}) {self.scheme.title}"

    @property
    def stays_under(self) -> float:
        """Bound of the glitch on 95 % of the machines that were drawn [m]; inf where it runs on fewer.

        The glitch of the given machine if none was drawn.
        """
        bound = float(upper(np.array([self.drawn]))[0]) if self.drawn else self.glitch
        return bound if self.predicted is None else max(bound, self.predicted.under)

    @property
    def chance(self) -> Chance:
        """The glitch of the given machine, and its range by chance [m]."""
        return Chance(self.places or (self.glitch,), 0.0)

    @property
    def middle(self) -> float:
        """The median over the machines that were drawn [m]; the glitch of the given machine if none was."""
        return self._quantile(0.5) if self.drawn else self.glitch

    @property
    def interval(self) -> tuple[float, float] | None:
        """Range of the glitch on the drawn machines [m]: 2.5 % are below, 5 % above `stays_under`.

        None where it ran on none. Without machines it is the range by chance, if encoder counts matter.
        """
        if self.places and not self.drawn:
            return self.chance.low, self.chance.high
        if self.predicted is not None and np.isfinite(self.predicted.ci95).all():
            return self.predicted.ci95[0], self.stays_under
        low = self._quantile(0.025)
        return (low, self.stays_under) if np.isfinite(low) else None

    def _quantile(self, share: float) -> float:
        """Return a quantile of the glitch on the machines that it ran on [m]; inf where it ran on none."""
        ran = [glitch for glitch in self.drawn if np.isfinite(glitch)]
        return float(np.quantile(ran, share)) if ran else np.inf

    @property
    def demand(self) -> int:
        """Its effort: 1 for a static map or a control block, 2 for a model with pre-sliding."""
        model = 0 if self.scheme.friction is None else 1 if self.scheme.friction == "static" else 2
        return model + len(self.scheme.blocks) + int(self.scheme.controller != "cascade")


def upper(drawn: Real) -> Real:
    """Return the `SHARE` quantile of each row of glitches [m]; nan (the machine could not run) is the largest."""
    return np.asarray(np.quantile(np.where(np.isnan(drawn), np.inf, drawn), SHARE, axis=1, method="higher"))


def bare(candidates: Iterable[Candidate]) -> Candidate | None:
    """Return the candidate without any compensation."""
    return next((candidate for candidate in candidates if candidate.scheme.bare), None)


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Data that a verdict is based on."""

    candidates: Sequence[Candidate] = ()  # What was run
    axes: tuple[str, ...] = ()  # Names of the axes that were run; the verdict is of no other
    resolution: float = 0.0  # The coarsest step of their encoders [m]: smaller differences are not reported
    exact: bool = False  # Whether the controllers believe exactly the friction and the plant that the machine has
    compared: bool = False  # Whether a measured circle was compared with the prediction
    disagreements: Sequence[Notice] = ()  # Where a measured circle is not as predicted, with the likely cause
    agree: int = 0  # Measured circles that are as predicted
    notices: Sequence[Notice] = ()  # What the files that the machine is made of, and the runs, warn of
    distrust: Sequence[Notice] = ()  # Why no interval of a prediction must be trusted
    settled: Sequence[Notice] = ()  # Against the machine's files, not machines that agree with a measured circle
    measured: Mapping[str, float] = field(default_factory=dict)  # Largest on this circle [m], by the scheme that was on
    tolerance: float | None = None  # Glitch that is allowed [m]; None where none was given
    machine: str = "MACHINE.yaml"  # machine, circle: names of both files, for what to type next
    circle: str = "CIRCLE.h5"
    command: str = ""  # The command that simulated; empty where it is not known
    rotary: bool = False  # Whether all axes are rotary, which no circle is of
    failed: str = ""  # Why the simulation failed; empty where it did not
    missing: tuple[str, ...] = ()  # What could not be made of logs, and the record that is missing for it
    glitches: tuple[float, float] | None = None  # Largest of the measured circle, predicted and measured [m]
    unmodelled: Mapping[str, float] = field(default_factory=dict)  # The same, by axis without a model [m]

    @property
    def designed(self) -> bool:
        """Whether fric designed the gains, and no measured circle shows the real ones."""
        unknown = any(notice.code == GAINS_UNKNOWN.code for notice in self.distrust)
        shown = self.compared and not self.disagreements and not unknown
        return not shown and any(notice.code == GAINS_DESIGNED.code for notice in self.notices)

    @property
    def mixed(self) -> bool:
        """Whether the records of an axis may be of two machines."""
        return any(notice.code in MIXED and notice.severity == "wrong" for notice in self.notices)

    @property
    def rigid(self) -> bool:
        """Whether friction before sliding is not known: simulated, a static map is what the machine has."""
        return any(notice.code == prediction.PRESLIDING_UNKNOWN.code for notice in self.notices)

    @property
    def far(self) -> list[Notice]:
        """Differences from a measured circle that no fit settles: they are larger than those of friction over time."""
        predicted, measured = self.glitches or (1.0, 1.0)
        close = 1.0 / FAR <= predicted / max(measured, 1e-12) <= FAR
        return [] if close else [notice for notice in self.settled if flaw_of(notice).disagrees]

    @property
    def machines(self) -> int:
        """Machines that were drawn for every candidate."""
        return min((len(candidate.drawn) for candidate in self.candidates), default=0)


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What to do."""

    choice: Candidate | None  # What is recommended; None where nothing is
    headline: str  # The verdict in a sentence or two
    why: tuple[Notice, ...] = ()  # Why it is not to be trusted yet; empty where it is
    now: str = ""  # The glitch without compensation; empty where it was not run
    effort: tuple[str, ...] = ()  # What less or more effort would change, if that is sure; what must not be used
    next: tuple[str, ...] = ()  # What to type next
    kept: bool | None = None  # Whether the tolerance is kept on 95 % of the machines; None where none was given
    settled: tuple[Notice, ...] = ()  # As in `Evidence`
    compared: tuple[float, float] | None = None  # The predicted and the measured glitch of a measured circle [m]
    unmodelled: Mapping[str, float] = field(default_factory=dict)  # As in `Evidence`

    @property
    def result(self) -> tuple[str, str]:
        """Return ``pass``, ``fail`` or ``not decided``, and its meaning; both empty where no tolerance was given.

        It passes where the tolerance is kept and there is no reason to doubt the verdict.
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
        """Whether the tolerance is kept; None where none was given, and where that is not decided."""
        return {"pass": True, "fail": False}.get(self.result[0])

    @property
    def trusted(self) -> bool:
        """Whether there is no reason to doubt it."""
        return not self.why

    @property
    def differs(self) -> bool:
        """Whether a measured circle is not as the identified machine predicts, which machines fitted to it explain."""
        return any(flaw_of(notice).disagrees for notice in self.settled)

    @property
    def checked(self) -> str:
        """The comparison of the prediction with a measured circle, in a sentence; empty without a circle."""
        if self.compared is None:
            return ""
        predicted, measured = (readable(value, "m", 3) for value in self.compared)
        word = "trusted" if self.trusted else "not trusted yet"
        if self.trusted and self.differs:
            word = "the identified machine differs; the decision is for machines fitted to this circle (`fric tune`)"
        elif self.trusted and not 1.0 / CLOSE <= self.compared[0] / max(self.compared[1], 1e-12) <= CLOSE:
            word = "within the interval of the prediction, which is wide. Identify again from more records"
        left = self.unmodelled.items()
        others = (f" {name.upper()} was not identified: its {readable(m, 'm', 3)} remain." for name, m in left)
        return f"Predicted {predicted}, measured {measured}: {word}.{''.join(others)}"

    def lines(self) -> list[str]:
        """Return it as lines for people: the sentence, why not to trust it, the next commands."""
        described = [self.headline, *self.effort]
        described += [": ".join(self.result)] if self.kept is not None else []
        described += [self.checked] if self.checked else []
        settled = ", ".join(self.settled_by_code)
        described += [f"settled by the measured circle: {settled} (`fric help CODE`)"] if settled else []
        described += [f"not trusted yet: {text}" for text in self.why if text.code != NOTHING_SIMULATED.code]
        commands = "\n".join(f"next: {text}" for text in self.next).replace("   # ", "\n      # ")  # fit 80 columns
        return [*described, *commands.splitlines()]

    @property
    def settled_by_code(self) -> list[str]:
        """The codes of the flaws that a measured circle settles, each once, but for what `checked` says."""
        left = (notice for notice in self.settled if not (self.compared and flaw_of(notice).disagrees))
        return list(dict.fromkeys(notice.code or str(notice) for notice in left))


def candidates_of(
    runs: Sequence[ContourRun[Any, Any]], many: MonteCarlo | None = None, prediction: Prediction | None = None
) -> list[Candidate]:
    """Return the results of schemes on the given machine, and on the drawn machines."""
    return [
        Candidate(
            scheme=run.scheme, glitches=tuple(glitch.median for glitch in run.glitches), glitch=run.chance().median,
            places=tuple(place.glitch for place in run.places), warnings=run.warnings,
            oscillation=run.chance("oscillation").median,
            drawn=tuple(map(float, many.glitches[:, n])) if many else (),
            swings=tuple(map(float, many.swings[:, n])) if many else (),
            predicted=prediction.schemes.get(run.scheme.name) if prediction else None,
        )
        for n, run in enumerate(runs)
    ]  # fmt: skip


def facts(machine: Machine, runs: Sequence[ContourRun[Any, Any]]) -> dict[str, Any]:
    """Return the data of a machine for a run file, which `evidence_of` reads."""
    names = list(runs[0].traces)
    return provenance() | {
        "machine": machine.name,
        "warnings_coded": [Notice.of(warning).as_dict() for warning in machine.warnings],
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
    """Return the evidence of candidates from the `facts` in their run file; an older file has only some of them.

    prediction: Results on the machines drawn from what was identified. Where they were made to agree with measured
        circles, this explains a difference of such a circle from the machine file, and a difference that remains speaks
        against the prediction. With unknown gains it explains nothing: the machines agree with any circle.
    disagreements: By file of a measured circle, where it differs from the prediction of the machine file. It is settled
        for a circle that all machines were made to agree with.
    """
    distrust = prediction.distrust if prediction else ()
    files = [where.partition(", test ")[0] for where in (prediction.measured if prediction else ())]
    seen = {Path(file).name: file for file in files}
    compared = compared or bool(seen)
    against = [notice for notice in distrust if flaw_of(notice).disagrees]
    beside = {NO_MEASURED_CIRCLE.code} if compared else set()
    distrust = tuple(notice for notice in distrust if notice not in against and notice.code not in beside)
    settled, unknown = list[Notice](), any(notice.code == GAINS_UNKNOWN.code for notice in distrust)
    for file, found in disagreements.items():
        (settled if Path(file).name in seen and not unknown else against).extend(found)
    apart = {_file_of(notice).name for notice in against}
    agree = sum(not found and Path(file).name not in apart for file, found in disagreements.items())
    notices = more.pop("notices", [*map(Notice.of, made.get("warnings_coded", ()))])
    if seen and not unknown:
        settled += [notice for notice in notices if flaw_of(notice).circle_settles and notice.severity == "wrong"]
        notices = [notice for notice in notices if not flaw_of(notice).circle_settles]
    file = str(made.get("origin", {}).get("path", ""))
    names = {"machine": machine_name(file) if file else "MACHINE.yaml", "command": str(made.get("command", ""))}
    names |= {"circle": min(seen.values())} if seen else {}
    return Evidence(
        candidates=candidates, axes=tuple(map(str, made.get("axes", ()))),
        resolution=float(made.get("resolution", 0.0)), exact=bool(made.get("exact", False)), compared=compared,
        disagreements=against, agree=agree, distrust=distrust,
        settled=tuple(dict.fromkeys(settled)), notices=notices,
        **names | more,
    )  # fmt: skip


def machine_name(file: str) -> str:
    """Return the name of a machine in a command: that of a bundled machine, else the path of its file."""
    return {str(path): name for name, path in bundled("machine").items()}.get(str(Path(file)), file.replace(sep, "/"))


WIDE = 1.1  # Ratio of the ends of a glitch's range from which it is said
EARNED = 0.05  # Share of the uncompensated glitch by which a scheme must be better to be worth its additional effort
LOOSE = 3.0  # Ratio of its bound to the expected glitch without compensation from which nothing is recommended
ENOUGH_MACHINES = 20  # Machines below which a share of 95 % is a guess
NEARLY_ALL = 0.9  # Share of the drawn machines on which a scheme is better, from which it is, whatever the worst leave
RESAMPLES = 400  # Resamples of the drawn machines for the interval of a difference
CYCLE = 0.5e-6
"""Oscillation below which nothing is called a limit cycle [m]: on the machines of configs/reality, waves and cogging
leave up to 0.75 µm, encoders 0.2 µm; limit cycles of too fast observers on a second mass leave 3 to 31 µm."""
CYCLE_RATIO = 2.5
"""Ratio to the oscillation without compensation from which it is a limit cycle: a peak of 6 dB doubles disturbances."""
MACHINES = 100  # Machines to request where none, or too few, were drawn


def decide(evidence: Evidence) -> Verdict:
    """Return which compensation to switch on, by the glitch that 95 % of the drawn machines stay under.

    It is the scheme of least effort among those as good as the best or, with a tolerance, those that keep it. A scheme
    with a limit cycle is never recommended, and no scheme against a measured circle.
    """
    reasons = {_same(notice): notice for notice in distrust(evidence)}.values()
    said_of = {(notice.says, notice.where) for notice in reasons}  # of a step; a file carries it on with its place
    carried = {(says, of) for says, of in said_of for s, at in said_of if s == says and of != at and of.endswith(at)}
    why = tuple(notice for notice in reasons if (notice.says, notice.where) not in carried)
    refused = [(candidate, text) for candidate in evidence.candidates for text in forbidden(candidate, evidence)]
    usable = [candidate for candidate in evidence.candidates if all(candidate is not other for other, _ in refused)]
    kept = None if evidence.tolerance is None else False
    said = tuple(f"{candidate.named} must not be used: {text}" for candidate, text in refused)
    given: dict[str, Any] = {"settled": tuple(evidence.settled), "compared": evidence.glitches}
    given["unmodelled"] = evidence.unmodelled
    given["now"] = now = glitch_now(without, evidence) if (without := bare(evidence.candidates)) else ""
    if evidence.disagreements or evidence.far or evidence.mixed or evidence.rigid or not usable:
        why += tuple(evidence.far[:1])
        then = tuple(steps(evidence, None))
        return Verdict(choice=None, headline=nothing(evidence), why=why, effort=said, next=then, kept=kept, **given)
    chosen = _choose(usable, evidence)
    why += tuple(chosen.predicted.distrust) if chosen.predicted else ()
    if chosen is without and chosen.drawn and chosen.stays_under > LOOSE * chosen.middle:
        glitch, most = Estimate(chosen.middle, "m"), Estimate(chosen.stays_under, "m")
        why += (prediction.GLITCH_OPEN.found(glitch=glitch, most=most),)
        said_open = "No scheme is recommended yet: the glitch to expect is open."
        then = tuple(steps(evidence, None))
        return Verdict(choice=None, headline=said_open, why=why, effort=said, next=then, kept=kept, **given)
    if evidence.tolerance is not None:
        seen = evidence.measured.get(chosen.scheme.name, 0.0)
        kept = max(chosen.stays_under, seen) <= evidence.tolerance
        if seen > evidence.tolerance:
            why += (prediction.MEASURED_BEYOND.found(scheme=chosen.named, seen=Estimate(seen, "m")),)
    # an export of what is not trusted is refused; the reasons say what to mend
    then = tuple(step for step in steps(evidence, chosen, kept=kept) if not (why and step.startswith("fric export ")))
    return Verdict(
        choice=chosen, headline=headline(chosen, without, now, evidence, kept=kept), why=why, kept=kept,
        effort=(*_effort(chosen, usable, evidence), *said), next=then, **given,
    )  # fmt: skip


def _same(notice: Notice) -> str:
    """Return the key of a reason: only one reason of each key is reported, but errors of two files both."""
    if flaw_of(notice).disagrees:
        return "disagrees"
    return str(notice) if notice.severity == "wrong" else notice.code or str(notice)


def forbidden(candidate: Candidate, evidence: Evidence) -> list[Notice]:
    """Return what forbids a scheme at any glitch: a limit cycle, machines on which it cannot run."""
    found = [text for text in map(Notice.of, candidate.warnings) if text.severity == "wrong"]
    least = bare(evidence.candidates) or min(evidence.candidates, key=lambda other: other.oscillation)
    swings, other = np.array([candidate.oscillation, *candidate.swings]), np.array([least.oscillation, *least.swings])
    other = other if len(other) == len(swings) else other[:1]
    cycles = swings > np.maximum(max(CYCLE, 4 * evidence.resolution), CYCLE_RATIO * other)
    if cycles.any():
        size, machines = Estimate(float(swings[cycles].max()), "m"), 0 if cycles[0] else int(cycles.sum())
        found.append(prediction.LIMIT_CYCLE.found(size=size, machines=machines, drawn=len(candidate.swings)))
    if not np.isfinite(candidate.stays_under):
        share = float(np.mean(np.isnan(candidate.drawn)))
        found.append(prediction.CANNOT_RUN.found(share=share, bare=candidate.scheme.bare))
    return found


def reasons_against(candidate: Candidate, evidence: Evidence) -> list[Notice]:
    """Return why a scheme should not be switched on: what forbids it, and where it leaves more than no compensation.

    Only a difference of more than two encoder steps counts.
    """
    found, without = forbidden(candidate, evidence), bare(evidence.candidates)
    if without is not None and candidate.stays_under > without.stays_under + 2 * evidence.resolution:
        left, alone = Estimate(candidate.stays_under, "m"), Estimate(without.stays_under, "m")
        found.append(prediction.SCHEME_SPOILS.found(scheme=candidate.scheme.name, left=left, alone=alone))
    return found


def distrust(evidence: Evidence) -> Iterator[Notice]:
    """Yield why a verdict from this evidence is not to be trusted yet."""
    yield from evidence.disagreements
    if not evidence.candidates:
        yield prediction.NOTHING_SIMULATED.found()
        return
    if not evidence.machines and evidence.exact:
        yield prediction.BELIEF_IS_TRUTH.found()
    elif not evidence.machines:
        yield prediction.ONE_MACHINE.found()
    elif evidence.machines < ENOUGH_MACHINES:
        yield prediction.FEW_MACHINES.found(machines=evidence.machines)
    if not evidence.compared and not evidence.rotary:
        yield prediction.NO_MEASURED_CIRCLE.found()
    yield from dict.fromkeys(notice for notice in evidence.notices if notice.severity == "wrong")
    yield from evidence.distrust


def _choose(usable: Sequence[Candidate], evidence: Evidence) -> Candidate:
    """Return the scheme of least effort of those that keep the tolerance; else of those as good as the best."""
    best, without = min(usable, key=lambda candidate: candidate.stays_under), bare(usable)
    least = EARNED * (max(candidate.middle for candidate in usable) if without is None else without.middle)
    least = max(evidence.resolution, least)  # a smaller difference is not seen, or not worth the effort
    good = [scheme for scheme in usable if evidence.tolerance is not None and scheme.stays_under <= evidence.tolerance]
    good = good or [
        scheme for scheme in usable
        if scheme is best or not (surely_less(best, scheme, least) or _less_on_most(best, scheme, least))
    ]  # fmt: skip
    return min(good, key=lambda candidate: (candidate.demand, candidate.stays_under))


def surely_less(better: Candidate, worse: Candidate, least: float) -> bool:
    """Return whether a scheme has a smaller glitch: by more than ``least`` [m], and beyond the interval of 0."""
    return worse.stays_under - better.stays_under > least and difference(worse, better)[0] > 0


def _less_on_most(better: Candidate, worse: Candidate, least: float) -> bool:
    """Return whether nearly every drawn machine has a smaller glitch with a scheme, by more than ``least`` [m]."""
    if len(better.drawn) != len(worse.drawn) or len(better.drawn) < ENOUGH_MACHINES:
        return False
    return float(np.mean(np.array(worse.drawn) - np.array(better.drawn) > least)) >= NEARLY_ALL


def difference(candidate: Candidate, other: Candidate) -> tuple[float, float]:
    """Return the 95 % interval of the difference of two `stays_under` [m], by bootstrap over the drawn machines.

    Both use the same machines, so common effects cancel. Without machines it is the plain difference, or its range by
    chance if encoder counts matter.
    """
    if not candidate.drawn or len(candidate.drawn) != len(other.drawn):
        if candidate.places or other.places:
            chance = candidate.chance - other.chance
            return chance.low, chance.high
        return (candidate.stays_under - other.stays_under,) * 2
    again = np.random.default_rng(0).integers(len(candidate.drawn), size=(RESAMPLES, len(candidate.drawn)))
    with np.errstate(invalid="ignore"):
        found = upper(np.array(candidate.drawn)[again]) - upper(np.array(other.drawn)[again])
    low, high = np.quantile(np.nan_to_num(found, nan=0.0, posinf=1.0, neginf=-1.0), [0.025, 0.975])
    return float(low), float(high)


def _effort(chosen: Candidate, usable: Sequence[Candidate], evidence: Evidence) -> Iterator[str]:
    """Return what less effort would cost, and what more effort would gain, where the difference is sure."""
    if evidence.exact and evidence.machines and evidence.glitches is None:
        decide = f"{evidence.machines} varied machine{'s decide' if evidence.machines > 1 else ' decides'}"
        yield f"The simulated controller knows its machine exactly, and a real one does not: {decide}."
    less = [candidate for candidate in usable if 0 < candidate.demand < chosen.demand]
    more = [candidate for candidate in usable if candidate.demand > chosen.demand]
    if less:
        other = min(less, key=lambda candidate: candidate.stays_under)
        if surely_less(chosen, other, evidence.resolution):
            low, high = difference(other, chosen)
            yield f"{_asks(other, 'less')} ({_between(low, high)} more)."
    if more:
        other = min(more, key=lambda candidate: candidate.stays_under)
        if surely_less(other, chosen, evidence.resolution):
            low, high = difference(chosen, other)
            gain = f"{_between(low, high)} less than ({chosen.scheme.name}): not worth the effort."
            yield f"{_asks(other, 'more')}, {gain}"
        elif other.stays_under < chosen.stays_under:
            yield f"{other.named} takes more effort and is not clearly better."


def _asks(other: Candidate, how: str) -> str:
    return f"{other.named} takes {how} effort and leaves at most {readable(other.stays_under, 'm', 2)}"


def _between(low: float, high: float) -> str:
    (least, _, unit), most = readable(low, "m", 2).partition(" "), readable(high, "m", 2)
    least = least if most.endswith(f" {unit}") else f"{least} {unit}"
    return most if most == f"{least} {unit}" else f"{least} to {most}"


def glitch_now(without: Candidate, evidence: Evidence) -> str:
    """Return the glitch without compensation: as measured, or else as it is predicted, with its range where wide."""
    if evidence.glitches is not None and without.scheme.name in evidence.measured:
        return readable(evidence.glitches[1], "m", 3)
    low, high = without.predicted.ci95 if without.predicted else (np.inf, np.inf)
    return _between(low, high) if np.isfinite(high) and high > WIDE * low else readable(without.middle, "m", 2)


def headline(chosen: Candidate, without: Candidate | None, now: str, evidence: Evidence, *, kept: bool | None) -> str:
    """Return the verdict in a sentence: what to switch on, the glitch to expect, and the glitch now."""
    on = f" on {' and '.join(axis.upper() for axis in evidence.axes)}" if evidence.axes else ""
    expected = f"glitch{on} {readable(chosen.middle, 'm', 2)}"
    if chosen.drawn:
        machines = f"{len(chosen.drawn)} varied machine{'s' * (len(chosen.drawn) > 1)}"
        expected += f", at most {readable(chosen.stays_under, 'm', 2)} ({machines})"
    if len(evidence.candidates) == 1:
        text = f"Only {chosen.named} was run, so nothing is compared: expected {expected}."
    elif chosen is without:
        text = f"Leave it as it is: expected {expected}; no scheme is worth its effort."
    else:
        surely = without is None or chosen.stays_under < without.middle
        use = f"Use {chosen.named}." if surely else f"{chosen.named} is the best, and may leave more than now."
        text = f"{use} Expected {expected}{now and f'; now {now}'}."
    if kept is False and evidence.tolerance is not None:
        text = f"No scheme surely stays within {readable(evidence.tolerance, 'm')}. {text}"
    return f"For a controller that fric designed: {text[0].lower()}{text[1:]}" if evidence.designed else text


def _file_of(notice: Notice) -> Path:
    """Return the file of a circle that is not as predicted."""
    return Path(notice.where.partition(", ")[0])


def _circle_apart(evidence: Evidence) -> Path:
    """Return the file of the first circle that is not as predicted."""
    return Path(evidence.circle).with_name(_file_of(evidence.disagreements[0]).name)


DIFFERS = "the measured circle differs from its prediction"


def nothing(evidence: Evidence) -> str:
    """Return the sentence why no scheme is recommended."""
    if evidence.mixed:
        return "No scheme is recommended: records take different forces. Are they of two machines, or did it warm?"
    if evidence.disagreements and evidence.designed:
        return "No scheme is recommended: the controller's gains are not known."
    if evidence.disagreements:
        unused = any(notice.code == CIRCLE_UNUSED.code for notice in evidence.distrust)
        fitted = not unused and all(notice.code == COMPLETED_DISAGREES.code for notice in evidence.disagreements)
        differs = "a machine fitted to the measured circle does not reproduce it" if fitted else DIFFERS
        if n := evidence.agree:
            others = f"{n} other circle{'s agree' if n > 1 else ' agrees'}"
            differs = f"{_circle_apart(evidence).stem} differs from its prediction, and {others}"
        lags = any(notice.code == LOOP_LAGS.code and notice.severity == "wrong" for notice in evidence.distrust)
        lost = any("backlash" in str(notice.values.get("cause")) for notice in evidence.disagreements)
        cause = "is there backlash?" if lost else "was a compensation on?"
        rigid = any(
            notice.code == prediction.PRESLIDING_UNKNOWN.code for notice in (*evidence.settled, *evidence.notices)
        )
        cause = "friction before sliding was not identified." if rigid else cause
        cause = "the drive feeds no velocity forward." if lags else cause
        return f"No scheme is recommended: {differs}. Find out why first: {cause}"
    if evidence.far and evidence.glitches:
        predicted, measured = (readable(glitch, "m", 3) for glitch in evidence.glitches)
        doubt = f"predicted {predicted}, measured {measured}. Are the gains, and the circle, those of this machine?"
        return f"No scheme is recommended: {doubt}"
    if evidence.rotary:
        said = "schemes are compared on a circle, which needs a linear axis."
        screw = "Of a screw, give `motion: linear/A` and each scale as a length (docs/formats.md, ball screw)."
        return f"No scheme is recommended: {said} {screw}"
    if evidence.rigid and not evidence.missing:
        return "No scheme is recommended yet: friction before sliding was not identified, and decides what is left."
    if evidence.missing:
        names = dict.fromkeys(re.split("[:,]", text)[0] for text in evidence.missing)
        return f"No scheme is recommended yet. Missing for a circle: {', '.join(names)}."
    if not evidence.candidates:
        return f"No scheme is recommended: {evidence.failed or 'nothing was simulated.'}"
    return "No scheme is recommended: each scheme that was run has a reason against it."


LOG_WHOLE = "fric ingest --kind circle LOG.csv -o circle.h5   # with voltage, at the controller's rate"


def steps(evidence: Evidence, chosen: Candidate | None, *, kept: bool | None = None) -> Iterator[str]:
    """Yield the next commands, the most urgent first."""
    machine, circle = quote(evidence.machine), quote(evidence.circle.replace(sep, "/"))
    unused = any(notice.code == CIRCLE_UNUSED.code for notice in evidence.distrust)
    if evidence.rotary or evidence.failed:
        return
    if evidence.designed:
        command = evidence.command if evidence.command.startswith("fric auto ") else "fric auto LOGS -o DIR"
        yield f"{command} --controller 'K_v=… 1/s, K_p=… V*s/m, K_i=… V/m'   # of your drive"
        if evidence.compared:
            return
    if evidence.missing or evidence.rigid:
        yield 'fric plan --stroke "300 mm" --feed "100 mm/s" -o plan   # motions that record what is missing'
        return
    if evidence.disagreements and evidence.agree:
        circle = quote(_circle_apart(evidence).as_posix())
    if evidence.disagreements or evidence.far:
        yield f"fric diagnose {circle} --machine {machine} --plot circle.png"
        if unused:  # no fit: nor can it be tuned
            yield LOG_WHOLE
        else:
            yield f"fric tune {machine} {circle} -o tuned   # if it is of this machine, without compensation"
        return
    if not evidence.candidates:
        yield f"fric simulate circle {machine} --monte-carlo {MACHINES} -o run.h5"
    elif not evidence.machines:
        known = evidence.command.startswith("fric simulate ")
        command = evidence.command if known else f"fric simulate circle {machine} -o run.h5"
        command = command.replace(" --json", "").replace(" --force", "")
        yield f"{command} --monte-carlo {MACHINES}{' --force' if ' -o ' in command and known else ''}"
    if not evidence.compared:
        yield "fric ingest --kind circle LOG.csv -o circle.h5   # of the machine itself, without compensation"
        yield f"fric diagnose circle.h5 --machine {machine}"
    elif kept is False:
        yield f"fric tune {machine} {circle} -o tuned"
    elif unused:
        yield LOG_WHOLE
    elif chosen is not None and not chosen.scheme.bare:
        yield from _onto(evidence, chosen, machine, circle)


def _onto(evidence: Evidence, chosen: Candidate, machine: str, circle: str) -> Iterator[str]:
    """Yield the commands that put a scheme onto the controller."""
    if any(flaw_of(notice).disagrees for notice in evidence.settled):
        yield f"fric tune {machine} {circle} -o tuned   # the identified machine differs"
    axis = evidence.axes[0] if evidence.axes else "x"
    place = re.search(r" -o ('[^']*'|\S+)", evidence.command)  # of the run that the verdict is from
    run = place[1] + "/circle.h5" * evidence.command.startswith("fric auto ") if place else "run.h5"
    of_axis, folder = f"--axis {axis} --scheme {chosen.scheme.name}", machine.removesuffix("/machine.yaml")
    if run == f"{folder}/circle.h5" and f" --measured {circle} " in evidence.command:
        tabled = chosen.scheme.friction == "static" and not chosen.scheme.blocks  # which a table of a drive holds
        others = "twincat, sinumerik, st, c" if tabled else "st, c, fmi"
        both = "".join(f"; then --axis {other}" for other in evidence.axes[1:])
        yield f"fric export linuxcnc {folder} {of_axis} -o controller   # or to {others}{both}"
    else:
        yield f"fric export linuxcnc {machine} {of_axis} --run {run} --circle {circle} -o controller"
