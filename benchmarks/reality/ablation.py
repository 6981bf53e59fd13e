"""What each correction of the static map earns, and each warning: what is found with all of them, and without each.

`python -m benchmarks.reality.ablation [--seeds N] [--minutes N] [--to FOLDER] [--write PAGE.md] [MACHINE …]` adds
sessions to FOLDER/ablation.json, and writes its sections of the page anew; `python -m benchmarks.reality --write`
writes all. A warning changes no number: what it earns is counted from the sessions that the bench keeps.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import partial
from itertools import chain, product
from pathlib import Path
from time import monotonic
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.reality.bench import Outcome, Row
from benchmarks.reality.judge import Step, judged_static
from benchmarks.reality.page import silent
from benchmarks.reality.results import Results
from benchmarks.reality.session import CLEAN, Session, Sessions, flaws
from fric.documents.plant import PlantDocument, plant_tree
from fric.errors import FricError
from fric.flaws import FAMILIES, entries, flaw_of
from fric.identify.plant.identify import identify_plant
from fric.identify.static_map import corrections, map_fit, stribeck_fit
from fric.output import staged

MACHINES = ("base", "all", "backlash", "cogging", "direction", "drift", "dwell", "gravity", "step", "waves")
"""Machines whose flaw strokes show, beside the one that has none."""


def _left_out(name: str) -> AbstractContextManager[Any]:
    for table in (corrections.AT_ANY_SPEED, corrections.OF_A_MAP):
        if name in table:
            kept = {key: look for key, look in table.items() if key != name}
            return patch.dict(table, kept, clear=True)
    raise KeyError(name)


OFF: Mapping[str, Callable[[], AbstractContextManager[Any]]] = {
    **{name: partial(_left_out, name) for name in (*corrections.AT_ANY_SPEED, *corrections.OF_A_MAP)},
    "ageing": lambda: patch.object(map_fit, "_with_ageing", lambda plain, solution, held_out: held_out),
    "other speeds": lambda: patch.object(map_fit, "_at_other_speeds", lambda *_: True),
    "standing off": lambda: patch.object(stribeck_fit, "_beyond", lambda problem, solution, own, **_: 0.0 * own),
}
"""What is left out, by name: the corrections, and the looks for other forms and for strokes that stand off."""

OPTIONS: Mapping[str, dict[str, Any]] = {
    "direction": {"direction": "both"}, "shape": {"delta": 1.0}, "fall": {"form": "stribeck"}
}  # fmt: skip
"""What is left out by an option of `identify_static`."""

ALL = "nothing"
NAMES = (ALL, *OFF, *OPTIONS)


def steps(session: Session) -> dict[str, Step]:
    """Return what strokes of a session give with everything, and without each."""
    logs, found = session.logs, {}
    try:
        tree = plant_tree(identify_plant(logs["frequency-response"]), logs["frequency-response"])
        plant = PlantDocument.model_validate(tree).plant("linear")
    except FricError:
        plant = None
    for name in NAMES:
        found[name] = Step()
        with OFF.get(name, nullcontext)():
            try:
                judged_static(found[name], session, logs["constant-velocity"], plant, **OPTIONS.get(name, {}))
            except FricError as error:
                found[name].failure = str(error)
    return found


@dataclass(frozen=True)
class Earned:
    """What strokes gave without one thing, over all sessions."""

    name: str
    changed: tuple[str, ...]
    """Machines on which a number or a warning is another than with everything."""
    intervals: tuple[int, int]
    """Intervals, with everything and without it: a map for each direction has twice as many."""
    covered: tuple[int, int]
    """Those that hold the truth, with everything and without it."""
    silent: tuple[int, int]
    """Those that do not, while no warning says so, with everything and without it."""
    width: float
    """Median ratio of the widths of the intervals, without it to with everything."""
    codes: Mapping[str, int]
    """Sessions by which warnings of severity wrong or doubt come more often without it, or less often."""


def earned(sessions: Iterable[Mapping[str, Any]]) -> list[Earned]:
    """Return what each earns, from the sessions that `main` keeps."""
    held = [
        (one["machine"], one["seed"], {name: Step.of(step) for name, step in one["steps"].items()}) for one in sessions
    ]
    found = []
    for name in NAMES[1:]:
        both = [(machine, seed, given[ALL], given[name]) for machine, seed, given in held if name in given]
        counts = [[_counts(machine, seed, step) for step in pair] for machine, seed, *pair in both]
        total, covered, silent = (
            (int(whole), int(without)) for whole, without in (np.sum(counts, axis=0).T if counts else np.zeros((3, 2)))
        )
        codes: Counter[str] = Counter()
        for _, _, whole, without in both:
            codes.update(_told(without))
            codes.subtract(_told(whole))
        widths = [ratio for _, _, *pair in both for ratio in _widths(*pair)]
        found.append(Earned(
            name, tuple(dict.fromkeys(machine for machine, _, a, b in both if a.as_dict() != b.as_dict())),
            total, covered, silent, float(np.median(widths)) if widths else 1.0,
            {code: n for code, n in codes.items() if n},
        ))  # fmt: skip
    return found


def _counts(machine: str, seed: int, step: Step) -> tuple[int, int, int]:
    """Return how many intervals there are, how many hold the truth, and how many do not while nothing says so."""
    steps = {"plant": Step(), "static": step}
    row = Row(machine, (Outcome(machine, seed, steps, None),))
    names = row.names("static")
    covered = [row.covered("static", name) > 0 for name in names]
    return len(names), sum(covered), sum(row.holds("static", name) == 0 for name in names)


def _told(step: Step) -> set[str]:
    return {notice.code for notice in step.notices if notice.severity != "note" and flaw_of(notice).code}


def _widths(whole: Step, without: Step) -> Iterable[float]:
    for name in whole.numbers.keys() & without.numbers.keys():
        a, b = whole.numbers[name], without.numbers[name]
        if 0.0 < a.high - a.low < np.inf and b.high - b.low < np.inf:
            yield (b.high - b.low) / (a.high - a.low)


HEADING = "## What each correction earns"

HEAD = """
The same strokes, with one thing left out of `identify static` at a time: the machines on which a number or a warning
changes; how many intervals hold the truth with everything, and without it; how many do not while no warning names the
flaw; the median width of the intervals without it over that with everything; and in how many sessions more, or fewer,
a warning comes of severity *doubt* or *wrong*. What changes nothing on these machines corrects what none of them has:
a spring along the axis (`slope`), a speed that ripples (`swing`), friction that is as large at all speeds and logged in
steps (`rounding`: 12 of 12 intervals of F_c hold in steps of 5 N, and 6 without it), strokes that end before the force
has settled (`settling`), records that differ (`between records`), other shapes of the fall. Tests have records of each.
`python -m benchmarks.reality.ablation --write docs/reality.md` writes this section and the next.

Made with {seeds} seeds of {machines}.

| left out | changes | hold the truth | silent | width | warnings |
|---|---|---|---|---|---|
"""


def section(sessions: Sequence[Mapping[str, Any]]) -> str:
    """Return what each earns, as docs/reality.md shows it; nothing where no session was run."""
    if not sessions:
        return ""
    lines = []
    for one in earned(sessions):
        codes = ", ".join(f"{code} {n:+d}" for code, n in sorted(one.codes.items(), key=lambda item: item[1]))
        held = (f"{some} of {total}" for some, total in zip(one.covered, one.intervals, strict=True))
        cells = [
            one.name, ", ".join(f"`{machine}`" for machine in one.changed) or "none", " → ".join(held),
            "{} → {}".format(*one.silent), f"{one.width:.2f}", codes or "none",
        ]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    seeds = sorted(Counter(one["machine"] for one in sessions).values())
    machines = ", ".join(f"`{name}`" for name in dict.fromkeys(one["machine"] for one in sessions))
    shown = " to ".join(str(count) for count in dict.fromkeys((seeds[0], seeds[-1])))
    return f"\n{HEADING}\n" + HEAD.format(seeds=shown, machines=machines) + "\n".join(lines) + "\n"


@dataclass(frozen=True)
class Warned:
    """Where a warning came, and where nothing else says what it says."""

    code: str
    severities: tuple[str, ...]
    machines: Mapping[str, float]
    """Share of the sessions on each machine with it."""
    alone: int
    """Sessions with an interval that does not hold the truth, of which no other warning names the flaw as wrong."""
    always_with: tuple[str, ...]
    """Other warnings that came in each session with it."""


def warned(rows: Sequence[Row]) -> list[Warned]:
    """Return what each warning earns on the machines of some rows, by its code."""
    sessions: dict[str, set[tuple[str, int]]] = {}
    severities: dict[str, set[str]] = {}
    alone: Counter[str] = Counter()
    counts = {row.flaw: len(row.outcomes) for row in rows}
    for row, outcome in chain.from_iterable(product([row], row.outcomes) for row in rows):
        needed, wrong = set[str](), set[str]()
        for step in outcome.steps.values():
            wrong |= row.naming.intersection(step.wrong)
            if len(wrong) == 1 and any(not number.covered for number in step.numbers.values()):
                needed |= wrong
            for notice in step.notices:
                if not flaw_of(notice).code or flaw_of(notice).word[0]:  # of older code, or said of every session
                    continue
                sessions.setdefault(notice.code, set()).add((row.flaw, outcome.seed))
                severities.setdefault(notice.code, set()).add(notice.severity)
        alone.update(needed)
    return [
        Warned(
            code, tuple(sorted(severities[code])),
            {flaw: n / counts[flaw] for flaw, n in sorted(Counter(flaw for flaw, _ in found).items())}, alone[code],
            tuple(other for other in sorted(sessions) if other != code and found <= sessions[other]),
        )
        for code, found in sorted(sessions.items())
    ]  # fmt: skip


OF_RECORDS = ("channel", "drift", "static_map", "response", "blocks")
"""Families of flaws that sessions may have."""

WARNINGS = "## What each warning earns"

WARNINGS_HEAD = """
Where each warning of a session came: its severity; the share of {clean} fresh machines without a flaw (`clean`), where
it is false or a note on what the records hold; the machines with a flaw and the share of their sessions; in how many
sessions an interval misses the truth while nothing else names the flaw; and the warnings that came each time with it.

Made with {seeds} seeds of each machine with a flaw.

| warning | severity | `clean` | machines | alone | always with |
|---|---|---|---|---|---|
"""


def warnings_section(rows: Sequence[Row]) -> str:
    """Return what each warning earns, as docs/reality.md shows it; nothing where no session was kept."""
    if not rows:
        return ""
    found, lines = warned(rows), []
    for one in found:
        machines = (f"`{flaw}` {share:.0%}" for flaw, share in one.machines.items() if flaw != CLEAN)
        cells = [
            one.code, "/".join(one.severities), f"{one.machines.get(CLEAN, 0.0):.0%}", ", ".join(machines) or "none",
            str(one.alone or ""), ", ".join(one.always_with) if len(one.always_with) < 4 else "",
        ]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    families = (family for family in FAMILIES if family.__name__.rpartition(".")[2] in OF_RECORDS)
    listed = {flaw.code for family in families for flaw in entries(family) if not flaw.word[0]}
    rest = ", ".join(f"`{code}`" for code in sorted(listed - {one.code for one in found}))
    text = f"No machine has what these find; records of the tests have, or verbs that are not run here: {rest}."
    clean = sum(len(row.outcomes) for row in rows if row.flaw == CLEAN)
    seeds = min(len(row.outcomes) for row in rows)
    head = WARNINGS_HEAD.format(clean=clean, seeds=seeds)
    text += " By these sessions: " + silent(row for row in rows if row.flaw != CLEAN)
    return f"\n{WARNINGS}\n{head}" + "\n".join(lines) + f"\n\n{text}\n"


def sections(folder: Path) -> str:
    """Return what each correction and each warning earns, from the sessions that a folder holds."""
    held = [Row(flaw, tuple(Results(folder, flaw, any_version=True).outcomes)) for flaw in [*flaws(), CLEAN]]
    return section(kept(folder)) + warnings_section([row for row in held if row.outcomes])


def kept(folder: Path) -> list[dict[str, Any]]:
    """Return the sessions that a folder holds."""
    file = folder / "ablation.json"
    return list(json.loads(file.read_text(encoding="utf-8"))) if file.exists() else []


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("machines", nargs="*", default=MACHINES, metavar="MACHINE")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="begin no session after this time")
    parser.add_argument("--to", type=Path, default=Path("build/reality"), metavar="FOLDER", help="of the results")
    parser.add_argument("--write", type=Path, metavar="PAGE.md", help="write the section of this page anew")
    given = parser.parse_args()
    held = kept(given.to)
    done = {(one["machine"], one["seed"]) for one in held}
    given.to.mkdir(parents=True, exist_ok=True)
    sessions, end = {machine: Sessions(machine) for machine in given.machines}, monotonic() + 60 * given.minutes
    for seed, machine in product(range(given.seeds), given.machines):
        if (machine, seed) not in done and monotonic() < end:
            found = {name: step.as_dict() for name, step in steps(sessions[machine].session(seed)).items()}
            held.append({"machine": machine, "seed": seed, "steps": found})
            with staged(given.to / "ablation.json", force=True) as part:
                part.write_text(json.dumps(held), encoding="utf-8")
    print(written := sections(given.to))
    if given.write:
        first = HEADING if held else WARNINGS  # without sessions here, the page keeps what it says of corrections
        rest = given.write.read_text(encoding="utf-8").partition(f"\n{first}")[0]
        given.write.write_text(rest + written, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
