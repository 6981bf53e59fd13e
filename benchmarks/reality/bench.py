"""Every machine with every seed: what was covered, what was warned of, what was silent, and what the circle then is."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from math import comb
from time import monotonic

from benchmarks.reality.judge import Number, Step, Verdict, identified
from benchmarks.reality.session import CLEAN, Sessions, machine_with
from fric.control.scheme import choose_schemes
from fric.errors import FricError
from fric.simulate.contour_run import run_circle
from fric.simulate.machine import Machine, NominalFriction
from fric.simulate.reality.flaws import NONE

STEPS = ("plant", "static", "gms")
HOLDS = 0.9
"""Share of the seeds in which a parameter is covered, or a warning says that it is wrong."""
CHANCE = 0.05
"""Probability from which on misses are taken for chance, and more sessions asked for; of 40, four are."""
SCHEMES = ("a", "c")
"""The schemes whose circle is predicted: none, and the feedforward of the GMS model that was identified."""
OVER_PLACE = {"force-over-position", "friction-over-position"}
NAMES: dict[str, set[str]] = {
    "backlash": {"lost-motion", "A-holds-friction"},
    "cogging": OVER_PLACE,
    "direction": {"directions-differ", "offset-shared"},
    "drift": {"force-drifts", "energy-drifts"},
    "dwell": {"friction-ages", "rest-raises-friction"},
    "force-constant": {"force-drifts", "energy-drifts"},
    "jitter": {"sampling-jitters"},
    "lost-untold": {"samples-lost"},
    "second-mass": {"spring-in-series", "A-holds-friction"},
    "second-mass-table": {"A-holds-friction"},
    "sparse-lines": {"A-holds-friction"},
    "waves": OVER_PLACE,
}
"""The warnings that name the flaw of a machine: no other one tells of it. Where a machine has none, none could."""


@dataclass(frozen=True)
class Glitches:
    """Largest glitch by scheme [m]: as `simulate circle` predicts it, and as the machine then does."""

    predicted: dict[str, float]
    done: dict[str, float]


@dataclass(frozen=True)
class Outcome:
    """One session on one machine: what each `identify` gave, and the circles where they were asked for."""

    flaw: str
    seed: int
    steps: dict[str, Step]
    glitches: Glitches | None


@dataclass(frozen=True)
class Row:
    """All sessions on one machine."""

    flaw: str
    outcomes: tuple[Outcome, ...]

    @property
    def naming(self) -> set[str]:
        """The codes that name the flaw, or one of the flaws."""
        return set().union(*NAMES.values()) if self.flaw == "all" else NAMES.get(self.flaw, set())

    def names(self, step: str) -> list[str]:
        """Return the parameters that a step gave, in their order."""
        return list(dict.fromkeys(name for o in self.outcomes for name in o.steps[step].numbers))

    def numbers(self, step: str, name: str) -> list[Number]:
        """Return one parameter over the sessions."""
        return [o.steps[step].numbers[name] for o in self.outcomes if name in o.steps[step].numbers]

    def covered(self, step: str, name: str) -> float:
        """Return the share of the sessions in which the interval of a parameter holds the truth."""
        return sum(number.covered for number in self.numbers(step, name)) / max(len(self.numbers(step, name)), 1)

    def holds(self, step: str, name: str) -> float:
        """Return the share in which it does, or a warning of this step or the ones before names the flaw as wrong."""
        fine = [
            o.steps[step].numbers[name].covered or not self.naming.isdisjoint(_wrong(o, step)) or _refused(o, step)
            for o in self.outcomes
            if name in o.steps[step].numbers
        ]
        return sum(fine) / max(len(fine), 1)

    def verdict(self, step: str) -> str:
        """Return ``covered``, ``warned``, ``silent``, or ``open`` where so few sessions cannot say, for a step."""
        if any(o.steps[step].crash for o in self.outcomes):
            return "silent"
        failed = sum(bool(o.steps[step].failure) for o in self.outcomes)
        names = self.names(step)
        if failed > (1 - HOLDS) * len(self.outcomes):
            return "warned"
        if all(self.covered(step, name) >= HOLDS for name in names):
            return "covered"
        if all(self.holds(step, name) >= HOLDS for name in names):
            return "warned"
        return "open" if all(self.chance(step, name) >= CHANCE for name in names) else "silent"

    def chance(self, step: str, name: str) -> float:
        """Return how probable it is that an interval that holds in 95 % of all sessions misses as often, untold."""
        n = len(self.numbers(step, name))
        missed = round((1.0 - self.holds(step, name)) * n)
        return 1.0 - sum(comb(n, m) * 0.05**m * 0.95 ** (n - m) for m in range(missed))

    def codes(self, severities: Sequence[str] = ("wrong", "doubt")) -> dict[str, float]:
        """Return the codes of the warnings that came, the commonest first, with the share of the sessions."""
        seen: Counter[str] = Counter()
        for o in self.outcomes:
            found = {n.code for step in o.steps.values() for n in step.notices if n.severity in severities and n.code}
            seen.update(found)
        return {code: count / len(self.outcomes) for code, count in seen.most_common()}

    @property
    def glitches(self) -> Glitches | None:
        """The circles of the first session that has them."""
        return next((o.glitches for o in self.outcomes if o.glitches is not None), None)


def _wrong(outcome: Outcome, step: str) -> list[str]:
    """Return what says that a step is wrong: it builds on those before it."""
    before = STEPS[: STEPS.index(step) + 1]
    return [code for name in before for code in outcome.steps[name].wrong]


def _refused(outcome: Outcome, step: str) -> bool:
    """Return whether this step or one that it builds on ended in an error: nothing is then given silently."""
    return any(outcome.steps[name].failure for name in STEPS[: STEPS.index(step) + 1])


def run(flaw: str, seeds: Iterable[int]) -> list[Outcome]:
    """Run the sessions of some seeds on one machine."""
    sessions, found = Sessions(flaw), []
    for seed in seeds:
        verdict = identified(sessions.session(seed))
        circles = glitches(flaw, verdict) if seed == 0 and flaw != CLEAN else None
        found.append(Outcome(flaw, seed, verdict.steps, circles))
    return found


def run_all(
    missing: Sequence[tuple[str, Sequence[int]]], workers: int, minutes: float, share: int = 4
) -> Iterator[list[Outcome]]:
    """Run the sessions that are missing, some seeds of each machine in turn, and yield them as they are ready.

    Parameters
    ----------
    missing
        Machines, and the seeds that are missing of each.
    workers
        Processes.
    minutes
        Time after which no more are begun.
    share
        Sessions of one machine that a process runs in one go: motions that no seed changes are simulated once.
    """
    most = max((len(seeds) for _, seeds in missing), default=0)
    parts = [
        (flaw, seeds[first : first + share])
        for first in range(0, most, share)
        for flaw, seeds in missing
        if seeds[first : first + share]
    ]
    end = monotonic() + 60 * minutes
    if workers == 1:
        for part in parts:
            if monotonic() > end:
                return
            yield run(*part)
        return
    with ProcessPoolExecutor(workers) as pool:
        for done in as_completed([pool.submit(run, *part) for part in parts]):
            yield done.result()
            if monotonic() > end:
                pool.shutdown(cancel_futures=True)
                return


def glitches(flaw: str, verdict: Verdict) -> Glitches | None:
    """Return the glitch on a circle, by what was identified and of the machine; None where too little was."""
    if verdict.plant is None or verdict.model is None:
        return None
    machine = machine_with(flaw)
    nominal_friction = NominalFriction({"gms": verdict.model}, 1.0)
    true = replace(machine.axis("x"), nominal_friction=nominal_friction, nominal=verdict.plant)
    seen = replace(
        true, plant=verdict.plant, friction=verdict.model, load=verdict.offset, reality=NONE, second_mass=None
    )
    return Glitches(_glitch(machine, seen), _glitch(machine, true))


def _glitch(machine: Machine, axis: object) -> dict[str, float]:
    run_on = replace(machine, axes={**machine.axes, "x": axis})  # type: ignore[dict-item]
    found = {}
    for scheme in choose_schemes(",".join(SCHEMES)):
        try:
            found[scheme.name] = float(run_circle(run_on, scheme, only="x").circularity.glitch)
        except FricError:
            found[scheme.name] = float("nan")
    return found
