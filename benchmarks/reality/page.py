"""The table of the bench, as docs/reality.md shows it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from benchmarks.reality.bench import HOLDS, STEPS, Row
from benchmarks.reality.session import CLEAN, machine_with

HEAD = """# Flaws of real drives

Identification is right on a machine that is as the model assumes. This page shows what becomes of it on machines that
are not: those of `configs/reality/`, each the same machine with one flaw of real drives on its x axis, and one with all
of them (see [Formats](formats.md#machine-machine1)). Pre-sliding of the base machine has ten blocks, more than are
identified.

```sh
make reality          # 40 seeds a machine; writes this page, and ends with status 1 where a flaw is silent
```

It takes two hours of one core, and goes on where it was stopped: `python -m benchmarks.reality --minutes 10` runs ten
minutes of it. The results are in `build/reality/`, one JSON file a machine.

Each session logs strokes at 11 speeds, sines in pre-sliding, a sine in sliding and a multisine; `identify plant`,
`static` and `gms` then run with their defaults, each on what the one before found. The truth that an interval is held
against is the effective one, what can be seen in these logs: A with the guideway's viscous friction, T_d with the time
by which the position is late, the map as eq. (2) fits the mean force at the speeds and over the travel that were
driven, the virgin curve as the mean of both directions, at the place of the sines.

- **covered**: in {holds:.0%} of the sessions or more, the interval of every parameter holds the truth.
- **warned**: in {holds:.0%} or more it does, or a warning of severity *wrong* that names this flaw (or an error) says
  that it does not; a warning that names another one does not count.
- **open**: neither, but so few sessions miss that chance may do it to an interval that holds in 95% of all: more seeds
  are needed to say.
- **silent**: neither, or a crash. This is a defect.

Below the verdict stand the parameters whose interval holds the truth less often, with the share of the sessions and the
median error. `curve` is the measured virgin curve: it holds where nine tenths of it lie inside its band. Of the
warnings, the codes of severity *wrong* are bold. The glitch is that of a circle of 30 mm at 100 mm/s on this axis, in
µm: as `simulate circle` predicts it from what was identified in the first session, and what the machine then does;
under scheme (a), no compensation, and (c), with the GMS model that was identified.

Made with {seeds} seeds a machine.

| machine | plant | static | gms | warnings (share of the sessions) | (a) predicted, done | (c) predicted, done |
|---|---|---|---|---|---|---|
"""


def page(rows: Sequence[Row]) -> str:
    """Return the page."""
    lines = []
    for row in rows:
        cells = [f"`{row.flaw}`<br>{_flaw(row.flaw)}", *(_cell(row, step) for step in STEPS), _codes(row)]
        cells += [_glitch(row, scheme) for scheme in ("a", "c")]
        lines.append("| " + " | ".join(cells) + " |")
    undecided = [row.flaw for row in rows if any(row.verdict(step) == "open" for step in STEPS)]
    lines += ["", f"Open, for want of seeds: {', '.join(f'`{flaw}`' for flaw in undecided)}."] if undecided else []
    lines += ["", silent(rows)]
    counts = sorted({len(row.outcomes) for row in rows})
    seeds = " to ".join(str(count) for count in dict.fromkeys((counts[0], counts[-1])))
    return HEAD.format(seeds=seeds, holds=HOLDS) + "\n".join(lines) + "\n"


def silent(rows: Iterable[Row]) -> str:
    """Return a sentence on the machines and steps that are silent."""
    found = [(row.flaw, ", ".join(step for step in STEPS if row.verdict(step) == "silent")) for row in rows]
    named = ", ".join(f"`{flaw}` ({steps})" for flaw, steps in found if steps)
    return f"Silent now: {named}." if named else "No flaw is seen to be silent."


def _flaw(flaw: str) -> str:
    if flaw == CLEAN:
        return "no flaw, and another machine in each session"
    name = machine_with(flaw).name
    return name.removeprefix("ten blocks, and ").removeprefix("ten blocks")


def _cell(row: Row, step: str) -> str:
    failed = sum(bool(o.steps[step].failure) for o in row.outcomes)
    told = [f"**{row.verdict(step)}**"]
    if failed:
        told.append(f"error in {failed / len(row.outcomes):.0%}")
    told += ["crash"] * any(o.steps[step].crash for o in row.outcomes)
    for name in row.names(step):
        share = row.covered(step, name)
        if share < HOLDS:
            errors = [number.value / number.truth - 1 for number in row.numbers(step, name) if number.truth]
            off = f", {np.median(errors):+.1%}" if errors and name not in {"curve", "offset", "force_lag"} else ""
            told.append(f"{name} {share:.0%}{off}")
    return "<br>".join(told)


def _codes(row: Row) -> str:
    wrong = row.codes(("wrong",))
    told = [f"**{code}** {share:.0%}" for code, share in wrong.items()]
    told += [f"{code} {share:.0%}" for code, share in row.codes(("doubt",)).items() if code not in wrong]
    return "<br>".join(told) or "none"


def _glitch(row: Row, scheme: str) -> str:
    both = row.glitches
    if both is None:
        return "not identified"
    return f"{both.predicted[scheme] * 1e6:.1f}, {both.done[scheme] * 1e6:.1f}"
