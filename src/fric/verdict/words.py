"""What a verdict says, and what to type next."""

from collections.abc import Iterator

from fric.units import readable
from fric.verdict.evidence import Candidate, Evidence

MACHINES = 100
"""Machines that are asked for where none, or too few, were drawn."""


def headline(chosen: Candidate, without: Candidate | None, evidence: Evidence, *, kept: bool | None) -> str:
    """Return the verdict in a sentence: what to switch on, what 95 % stay under, and what it was before."""
    text = _recommended(chosen, without, evidence)
    if kept is False and evidence.tolerance is not None:
        return f"No scheme that was run surely stays within {readable(evidence.tolerance, 'm')}. {text}"
    return text


def _recommended(chosen: Candidate, without: Candidate | None, evidence: Evidence) -> str:
    of = f" of axis {evidence.axes[0]}" if len(evidence.axes) == 1 else ""
    left = f"{'stays under' if chosen.drawn else 'is'} {readable(chosen.stays_under, 'm', 2)}"
    if chosen.drawn:
        left += f" on 95 % of the {len(chosen.drawn)} machines drawn around this one"
    if len(evidence.candidates) == 1:
        return f"Only {chosen.named} was run, so nothing is compared: the glitch{of} {left}."
    if chosen is without:
        more = "no scheme that was run is better by what its effort is worth"
        return f"Leave it as it is: the glitch{of} {left}, and {more}."
    before = f"{readable(without.middle, 'm', 2)} without compensation" if without else ""
    if chosen.drawn:
        before = f"; half of them leave {readable(chosen.middle, 'm', 2)} or less" + (
            f", and {before}" if before else ""
        )
    elif before:
        before = f", {before}"
    return f"Switch on {chosen.named}: the glitch{of} {left}{before}."


def nothing(evidence: Evidence) -> str:
    """Return why no scheme is recommended."""
    if evidence.disagreements:
        return (
            f"No scheme is recommended: the measured circle is not what this machine file predicts "
            f"({evidence.disagreements[0]}). Explain that first."
        )
    if evidence.rotary:
        return "No scheme is recommended: what one leaves is told by a circle, and that takes two linear axes."
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
