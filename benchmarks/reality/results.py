"""What sessions gave, one JSON file a machine: it grows as more seeds are run, and the page is made from it."""

from __future__ import annotations

import json
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.reality.bench import Glitches, Outcome
from benchmarks.reality.judge import Step
from benchmarks.reality.session import file_of
from fric.output import staged

if TYPE_CHECKING:
    from collections.abc import Sequence

SOURCE = Path(__file__).parents[2] / "src" / "fric"
ROOMS = ("control", "drive", "friction", "identify", "kernels", "simulate")
"""The rooms that what a session gives depends on."""


def version(flaw: str) -> str:
    """Return a digest of all that the sessions of a machine depend on: code, machine, bench."""
    files = sorted(file for room in ROOMS for file in (SOURCE / room).rglob("*.py"))
    files += [*sorted(Path(__file__).parent.glob("*.py")), file_of("base"), file_of(flaw)]
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


class Results:
    """The sessions on one machine, as they stand in a folder; those that older code gave are left out.

    Parameters
    ----------
    folder
        The folder.
    flaw
        The machine.
    any_version
        Take those of older code too.
    """

    def __init__(self, folder: Path, flaw: str, *, any_version: bool = False) -> None:
        self.flaw, self.file, self.version = flaw, folder / f"{flaw}.json", version(flaw)
        held: dict[str, Any] = json.loads(self.file.read_text(encoding="utf-8")) if self.file.exists() else {}
        current = any_version or held.get("version") == self.version
        self.outcomes = [_read(flaw, one) for one in held["sessions"]] if held and current else []

    def missing(self, seeds: int) -> list[int]:
        """Return the seeds up to a number that have not been run."""
        done = {outcome.seed for outcome in self.outcomes}
        return [seed for seed in range(seeds) if seed not in done]

    def add(self, outcomes: Sequence[Outcome]) -> None:
        """Add sessions, and write the file."""
        self.outcomes = sorted([*self.outcomes, *outcomes], key=lambda outcome: outcome.seed)
        sessions = [_plain(outcome) for outcome in self.outcomes]
        self.file.parent.mkdir(parents=True, exist_ok=True)
        with staged(self.file, force=True) as part:
            part.write_text(json.dumps({"version": self.version, "sessions": sessions}), encoding="utf-8")


def _plain(outcome: Outcome) -> dict[str, Any]:
    steps = {name: step.as_dict() for name, step in outcome.steps.items()}
    return {"seed": outcome.seed, "steps": steps, "glitches": outcome.glitches and asdict(outcome.glitches)}


def _read(flaw: str, entry: dict[str, Any]) -> Outcome:
    steps = {name: Step.of(step) for name, step in entry["steps"].items()}
    return Outcome(flaw, entry["seed"], steps, Glitches(**entry["glitches"]) if entry["glitches"] else None)
