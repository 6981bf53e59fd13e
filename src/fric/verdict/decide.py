"""The one function that decides, for the report, `fric auto`, `fric simulate`, `fric export` and ``--json``."""

from collections.abc import Iterator, Sequence

import numpy as np

from fric.estimate import Estimate
from fric.flaws import flaw_of, prediction
from fric.notice import Notice
from fric.units import readable
from fric.verdict.evidence import Candidate, Evidence, Verdict, bare, upper

EARNED = 0.05
"""Share of the uncompensated glitch by which a scheme must be better before its further effort is worth it."""

FEW = 20
"""Machines below which a share of 95 % is a guess."""

RESAMPLES = 400
"""How often the drawn machines are drawn again for the interval of a difference."""

CYCLE = 0.5e-6
"""Oscillation below which nothing is called a limit cycle [m].

On the machines of configs/reality waves and cogging leave up to 0.75 µm, as much without compensation as with it, and
encoders 0.2 µm; limit cycles of too fast observers on a second mass leave 3 to 31 µm.
"""

CYCLE_RATIO = 2.5
"""Ratio of the oscillation to that without compensation from which it is a limit cycle.

A loop with a peak sensitivity of 6 dB doubles what the guideway does.
"""


def decide(evidence: Evidence) -> Verdict:
    """Return which compensation to switch on, by what 95 % of the machines that were drawn stay under.

    Of the schemes that cannot be told from the best the one that asks for the least; with a tolerance, of those that
    keep it. A scheme with a limit cycle is never recommended, and none is against a measured circle.

    evidence: What was run, drawn and measured.
    """
    why = tuple({_same(one): one for one in distrust(evidence)}.values())
    refused = [(one, text) for one in evidence.candidates for text in forbidden(one, evidence)]
    usable = [one for one in evidence.candidates if all(one is not other for other, _ in refused)]
    kept = None if evidence.tolerance is None else False
    said = tuple(f"{one.named} must not be used: {text}" for one, text in refused)
    if evidence.disagreements or not usable:
        return Verdict(
            choice=None, headline=nothing(evidence), why=why, effort=said, next=tuple(steps(evidence, None)), kept=kept,
            settled=tuple(evidence.settled), compared=evidence.glitches,
        )  # fmt: skip
    chosen = _choose(usable, evidence)
    why += tuple(chosen.predicted.distrust) if chosen.predicted else ()
    if evidence.tolerance is not None:
        seen = evidence.measured.get(chosen.scheme.name, 0.0)
        kept = max(chosen.stays_under, seen) <= evidence.tolerance
        if seen > evidence.tolerance:
            why += (prediction.MEASURED_BEYOND.found(scheme=chosen.named, seen=Estimate(seen, "m")),)
    return Verdict(
        choice=chosen, headline=headline(chosen, bare(usable), evidence, kept=kept), why=why,
        effort=(*_effort(chosen, usable, evidence), *said), kept=kept, settled=tuple(evidence.settled),
        next=tuple(steps(evidence, chosen, kept=kept)), compared=evidence.glitches,
    )  # fmt: skip


def _same(one: Notice) -> str:
    """Return what two reasons share of which one is enough; what is wrong in two files is told of both."""
    if flaw_of(one).disagrees:
        return "disagrees"
    return str(one) if one.severity == "wrong" else one.code or str(one)


def forbidden(one: Candidate, evidence: Evidence) -> list[Notice]:
    """Return what forbids a scheme, whatever it leaves: a limit cycle, machines on which it cannot run."""
    found = [text for text in map(Notice.of, one.warnings) if text.severity == "wrong"]
    least = bare(evidence.candidates) or min(evidence.candidates, key=lambda other: other.oscillation)
    own, other = np.array([one.oscillation, *one.swings]), np.array([least.oscillation, *least.swings])
    other = other if len(other) == len(own) else other[:1]
    cycles = own > np.maximum(max(CYCLE, 4 * evidence.resolution), CYCLE_RATIO * other)
    if cycles.any():
        size, machines = Estimate(float(own[cycles].max()), "m"), 0 if cycles[0] else int(cycles.sum())
        found.append(prediction.LIMIT_CYCLE.found(size=size, machines=machines, drawn=len(one.swings)))
    if not np.isfinite(one.stays_under):
        found.append(prediction.CANNOT_RUN.found(share=float(np.mean(np.isnan(one.drawn)))))
    return found


def reasons_against(one: Candidate, evidence: Evidence) -> list[Notice]:
    """Return why a scheme should not be switched on: what forbids it, and where it leaves more than none at all does.

    By more than two steps of the encoder.
    """
    found, without = forbidden(one, evidence), bare(evidence.candidates)
    if without is not None and one.stays_under > without.stays_under + 2 * evidence.resolution:
        left, alone = Estimate(one.stays_under, "m"), Estimate(without.stays_under, "m")
        found.append(prediction.SCHEME_SPOILS.found(scheme=one.scheme.name, left=left, alone=alone))
    return found


def distrust(evidence: Evidence) -> Iterator[Notice]:
    """Yield why a verdict from this evidence is not to be trusted yet."""
    yield from evidence.disagreements
    if not evidence.candidates:
        yield prediction.NOTHING_SIMULATED.found()
    elif not evidence.machines and evidence.exact:
        yield prediction.BELIEF_IS_TRUTH.found()
    elif not evidence.machines:
        yield prediction.ONE_MACHINE.found()
    elif evidence.machines < FEW:
        yield prediction.FEW_MACHINES.found(machines=evidence.machines)
    if not evidence.compared and not evidence.rotary:
        yield prediction.NO_MEASURED_CIRCLE.found()
    yield from dict.fromkeys(one for one in evidence.notices if one.severity == "wrong")
    yield from evidence.distrust


def _choose(usable: Sequence[Candidate], evidence: Evidence) -> Candidate:
    """Return what asks for the least of those that keep the tolerance; else of those as good as the best."""
    best = min(usable, key=lambda one: one.stays_under)
    good = [one for one in usable if evidence.tolerance is not None and one.stays_under <= evidence.tolerance]
    good = good or [one for one in usable if one is best or not _worth(one, best, usable, evidence)]
    return min(good, key=lambda one: (one.demand, one.stays_under))


def _worth(worse: Candidate, better: Candidate, usable: Sequence[Candidate], evidence: Evidence) -> bool:
    """Tell whether one surely leaves more than another, by more than an encoder's step and what is worth effort."""
    without = bare(usable)
    earned = EARNED * (max(one.middle for one in usable) if without is None else without.middle)
    return surely_less(better, worse, max(evidence.resolution, earned))


def surely_less(better: Candidate, worse: Candidate, least: float) -> bool:
    """Tell whether one stays under less than another: by more than ``least`` [m], and beyond the interval of 0."""
    return worse.stays_under - better.stays_under > least and difference(worse, better)[0] > 0


def difference(one: Candidate, other: Candidate) -> tuple[float, float]:
    """Return the 95 % interval of the difference of what two stay under [m], by drawing the drawn machines again.

    The same machines for both: what a machine does to both falls out. Without machines it is the plain difference, or
    where that hangs on counts between what it lies by chance.
    """
    if not one.drawn or len(one.drawn) != len(other.drawn):
        if one.places or other.places:
            chance = one.chance - other.chance
            return chance.low, chance.high
        return (one.stays_under - other.stays_under,) * 2
    again = np.random.default_rng(0).integers(len(one.drawn), size=(RESAMPLES, len(one.drawn)))
    with np.errstate(invalid="ignore"):
        found = upper(np.array(one.drawn)[again]) - upper(np.array(other.drawn)[again])
    low, high = np.quantile(np.nan_to_num(found, nan=0.0, posinf=1.0, neginf=-1.0), [0.025, 0.975])
    return float(low), float(high)


def _effort(chosen: Candidate, usable: Sequence[Candidate], evidence: Evidence) -> Iterator[str]:
    """Tell what less effort would leave, and what more would gain, where the difference is sure."""
    if evidence.exact and evidence.machines and evidence.glitches is None:
        yield f"The controller knows this machine exactly, as no real one: the {evidence.machines} varied ones decide."
    less = [one for one in usable if 0 < one.demand < chosen.demand]
    more = [one for one in usable if one.demand > chosen.demand]
    if less:
        other = min(less, key=lambda one: one.stays_under)
        if surely_less(chosen, other, evidence.resolution):
            low, high = difference(other, chosen)
            yield f"{_asks(other, 'less')} ({_between(low, high)} more)."
    if more:
        other = min(more, key=lambda one: one.stays_under)
        if surely_less(other, chosen, evidence.resolution):
            low, high = difference(chosen, other)
            yield f"{_asks(other, 'more')} ({_between(low, high)} less): not worth its effort."
        elif other.stays_under < chosen.stays_under:
            yield f"{other.named} asks for more, and is not surely better."


def _asks(other: Candidate, how: str) -> str:
    return f"{other.named} asks for {how}, and leaves {readable(other.stays_under, 'm', 2)} at most"


def _between(low: float, high: float) -> str:
    same = readable(low, "m", 2) == readable(high, "m", 2)
    return readable(high, "m", 2) if same else f"{readable(low, 'm', 2)} to {readable(high, 'm', 2)}"


MACHINES = 100
"""Machines that are asked for where none, or too few, were drawn."""


def headline(chosen: Candidate, without: Candidate | None, evidence: Evidence, *, kept: bool | None) -> str:
    """Return the verdict in a sentence: what to switch on, what 95 % stay under, and what it was before."""
    text = _recommended(chosen, without, evidence)
    if kept is False and evidence.tolerance is not None:
        text = f"No scheme surely stays within {readable(evidence.tolerance, 'm')}. {text}"
    return f"For a controller that fric designed: {text[0].lower()}{text[1:]}" if evidence.designed else text


def _recommended(chosen: Candidate, without: Candidate | None, evidence: Evidence) -> str:
    on = f" on {evidence.axes[0].upper()}" if len(evidence.axes) == 1 else ""
    expected = f"glitch{on} {readable(chosen.middle, 'm', 2)}"
    if chosen.drawn:
        expected += f", at most {readable(chosen.stays_under, 'm', 2)} ({len(chosen.drawn)} varied machines)"
    if len(evidence.candidates) == 1:
        return f"Only {chosen.named} was run, so nothing is compared: expected {expected}."
    if chosen is without:
        return f"Leave it as it is: expected {expected}; no scheme gains what its effort is worth."
    now = f"; now {readable(without.middle, 'm', 2)}" if without else ""
    return f"Use {chosen.named}. Expected {expected}{now}."


def nothing(evidence: Evidence) -> str:
    """Return why no scheme is recommended."""
    if evidence.disagreements and evidence.designed:
        return "No scheme is recommended: the controller's gains are not known. Give them (--controller)."
    if evidence.disagreements:
        return "No scheme is recommended: the measured circle is not as predicted. Explain that first."
    if evidence.rotary:
        return "No scheme is recommended: schemes are compared on a circle, which needs a linear axis."
    if not evidence.candidates:
        return "No scheme is recommended: nothing was simulated."
    return "No scheme is recommended: something forbids each that was run."


def steps(evidence: Evidence, chosen: Candidate | None, *, kept: bool | None = None) -> Iterator[str]:
    """Yield what to type next, the most urgent first."""
    machine, circle = evidence.machine, evidence.circle
    if evidence.rotary:
        return
    if evidence.disagreements:
        yield f"fric diagnose {circle} --machine {machine} --plot circle.png"
        yield f"fric tune {machine} {circle} -o tuned"
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
    elif chosen is not None and not chosen.scheme.bare:
        axis = evidence.axes[0] if evidence.axes else "x"
        _, _, end = evidence.command.partition(" -o ")  # the run that the verdict is from
        run = end.split()[0] if end else "run.h5"
        given = f"--run {run} --circle {circle}"
        yield f"fric export linuxcnc {machine} --axis {axis} --scheme {chosen.scheme.name} {given} -o controller"
