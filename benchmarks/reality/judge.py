"""One session identified as a user would, and held against the effective truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from traceback import format_exc
from typing import Any

import numpy as np

from benchmarks.reality.session import Session
from benchmarks.reality.truth import gms_truth, plant_truth, static_truth, virgin_truth
from fric.documents.friction import FrictionDocument, gms_tree, static_tree
from fric.documents.plant import PlantDocument, plant_tree
from fric.documents.yaml import read_document, write_document
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.friction.gms import GMS
from fric.identify.gms.identify import identify_gms
from fric.identify.plant.identify import identify_plant
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked
from fric.log import Log
from fric.notice import Notice

INSIDE = 0.9
"""Share of the virgin curve that lies inside its 95 % band, at least: neighbouring points err alike."""


@dataclass(frozen=True)
class Number:
    """One identified number, its interval, and the effective truth."""

    value: float
    low: float
    high: float
    truth: float

    @property
    def covered(self) -> bool:
        """Whether the interval holds the truth."""
        return self.low <= self.truth <= self.high


@dataclass
class Step:
    """What one `identify` gave."""

    numbers: dict[str, Number] = field(default_factory=dict)
    notices: list[Notice] = field(default_factory=list)
    failure: str = ""
    crash: str = ""

    @property
    def wrong(self) -> list[str]:
        """Codes of the warnings that say the result is wrong until mended."""
        return [n.code or "(no code)" for n in self.notices if n.severity == "wrong"]

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON holds it; a limit that is open is null."""
        numbers = {
            name: [None if np.isinf(value) else float(f"{value:.8g}") for value in (n.value, n.low, n.high, n.truth)]
            for name, n in self.numbers.items()
        }
        notices = [[n.code, n.severity] for n in self.notices]
        return {"numbers": numbers, "notices": notices, "failure": self.failure, "crash": self.crash}

    @classmethod
    def of(cls, entry: Mapping[str, Any]) -> Step:
        """Return it from what `as_dict` gave; of the warnings the text is their code."""
        numbers = {
            name: Number(value, -np.inf if low is None else low, np.inf if high is None else high, truth)
            for name, (value, low, high, truth) in entry["numbers"].items()
        }
        notices = [Notice(code, code, severity) for code, severity in entry["notices"]]
        return cls(numbers, notices, entry["failure"], entry["crash"])


@dataclass
class Verdict:
    """What the `identify` of one session gave, by step; and the models, for the circle."""

    steps: dict[str, Step]
    plant: Plant | None = None
    model: GMS | None = None
    offset: float = 0.0


def identified(session: Session) -> Verdict:
    """Identify plant, static map and GMS model of a session's logs, each with what the step before it gave."""
    logs, steps = session.logs, {name: Step() for name in ("plant", "static", "gms")}
    verdict = Verdict(steps)
    with TemporaryDirectory() as folder:
        plant_file, friction_file = Path(folder) / "plant.yaml", Path(folder) / "friction.yaml"

        def plant() -> None:
            records = logs["frequency-response"]
            tree = plant_tree(identify_plant(records), records)
            write_document(plant_file, tree)
            _enter(steps["plant"], tree, tree, plant_truth(session))
            verdict.plant = read_document(plant_file, PlantDocument).plant("linear")

        def static() -> None:
            tree = judged_static(steps["static"], session, logs["constant-velocity"], verdict.plant)
            write_document(friction_file, tree)
            verdict.offset = float(tree["static"]["offset"]["value"]) if "offset" in tree["static"] else 0.0

        def gms() -> None:
            records = [*logs["presliding-sine"], *logs["sliding-sine"]]
            known = friction_file.exists()
            forward, backward = read_document(friction_file, FrictionDocument).maps() if known else (None, None)
            fit = identify_gms(records, static=forward, negative=backward, plant=verdict.plant)
            _enter(steps["gms"], {"warnings": fit.warnings}, gms_tree(fit, records)["gms"], gms_truth(session))
            verdict.model = fit.model
            z = fit.curve.displacement
            half, expected = np.hypot(fit.curve.band, 1.96 * fit.curve.blur), virgin_truth(session, z)
            within = float(np.mean(np.abs(fit.curve.force - expected) <= half))
            steps["gms"].numbers["curve"] = Number(within, 0.0, within, INSIDE)

        for name, step in (("plant", plant), ("static", static), ("gms", gms)):
            _try(steps[name], step)
    return verdict


def judged_static(
    step: Step, session: Session, records: Sequence[Log], plant: Plant | None, **options: Any
) -> dict[str, Any]:
    """Identify the static map of strokes, enter what was found into a step, and return its document."""
    tree = static_tree(identify_static(records, Asked(plant=plant, **options)), records)
    each = tree.get("static_negative")
    damping = plant.damping if plant is not None else 0.0
    _enter(step, tree, tree["static"], static_truth(session, damping, 1 if each else 0))
    if each:
        _enter(step, tree, each, static_truth(session, damping, -1), " (-)")
    return tree


def _try(step: Step, action: Callable[[], None]) -> None:
    try:
        action()
    except FricError as error:
        step.failure = str(error)
    except Exception as error:  # a bug of fric: it is told as one, and the other steps go on
        step.crash = f"{type(error).__name__}: {error} ({format_exc().splitlines()[-3].strip()})"


def _enter(
    step: Step, tree: Mapping[str, Any], section: Mapping[str, Any], truth: Mapping[str, float], of: str = ""
) -> None:
    """Enter the numbers of a document's section that have a truth, and its warnings."""
    coded = tree.get("warnings_coded") or [Notice.of(text).as_dict() for text in tree["warnings"]]
    step.notices = [Notice(one["text"], one["code"], one["severity"]) for one in coded]
    for name, expected in truth.items():
        given = section.get(name)
        if not isinstance(given, dict):
            continue
        low, high = given.get("ci95") or (given["value"], given["value"])
        limits = (-np.inf if low is None else low, np.inf if high is None else high)
        if not given.get("assumed"):
            step.numbers[name + of] = Number(given["value"], *limits, expected)
