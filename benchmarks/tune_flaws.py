"""Tune: machines with flaws (`configs/reality/`)

The controller believes the machine without its flaw. Rows with *drawn* also differ in level, stiffness, C, K_f and T_d
(`configs/spread.yaml`). Circles are recorded as the drive's trace keeps them, with the flaws of its clock and its
encoder.

- A row shows the glitch of scheme (f) before → after, at 100 mm/s, then at 10 mm/s, and the warnings that were given.
- What is refused leaves the belief as it was.
- Differences below 0.05 µm, a fifth of the encoder's step, do not count.
- `drift` and `force-constant` change while the circles run. A warning says that friction drifts, and the next circle is
  judged by its upper end: a warm machine does not show what a cold one has.
"""

from __future__ import annotations

from typing import Any

from benchmarks._machines import Study
from benchmarks._tuned import CONFIGS, tuned

WORSE = 5e-8
"""By how much a glitch is larger that is larger [m]."""


def run(study: Study) -> list[tuple[str, str, str]]:
    """Tune each machine as it is, and from 20 machines on as drawn too."""
    flaws = sorted(f"reality/{path.name}" for path in (CONFIGS / "reality").glob("*.yaml"))
    drawn = range(-1, min(2, study.number(0) // 20))
    ran = study.run(tuned, [(source, "spread.yaml", study.seed, n) for n in drawn for source in flaws])
    pairs = sorted(zip(ran.tasks, ran.found, strict=True), key=lambda pair: (pair[0][0], pair[0][3]))
    return [ran.row(), *(_row(source, index, one) for (source, _, _, index), one in pairs)]


def _row(source: str, index: int, one: dict[str, Any]) -> tuple[str, str, str]:
    """Return before and after in (f) at both feeds, and what is told."""
    what = f"`{source.removeprefix('reality/').removesuffix('.yaml')}`" + ("" if index < 0 else f", drawn {index}")
    what += ": (f) at 100, 10 mm/s"
    if "error" in one:
        return what, f"error: {one['error'].splitlines()[0]}", "a warning"
    pairs = [(one["before"][key], one["after"][key]) for key in ("f100", "f10")]
    told = [text.split(":")[0] for text in one["told"] if not text.endswith(":note")]
    glitches = ", ".join(f"{a * 1e6:.2f} → {b * 1e6:.2f}" for a, b in pairs)
    worse = "**worse**; " if any(b > a + WORSE for a, b in pairs) else ""
    return what, f"{glitches}; {worse}{', '.join(told) or 'no warning'}", "not worse, or a warning"
