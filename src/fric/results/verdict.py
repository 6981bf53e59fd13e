"""What a verdict rests on, from runs: what each scheme left of one machine, and of the machines drawn around it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from fric.documents.bundled import bundled
from fric.documents.provenance import provenance
from fric.flaws import flaw_of
from fric.flaws.prediction import NO_MEASURED_CIRCLE
from fric.notice import Notice
from fric.simulate.contour_run import ContourRun
from fric.simulate.machine import Machine
from fric.simulate.prediction import Prediction
from fric.verdict.evidence import Candidate, Evidence

Runs = Sequence[ContourRun[Any, Any]]


def facts(machine: Machine, runs: Runs) -> dict[str, Any]:
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

    Parameters
    ----------
    made
        The facts.
    candidates
        What was run.
    prediction
        What the machines drawn from what was identified say. Where they were made to agree with measured circles, what
        such a circle shows beside the machine file is explained by that, and what even they do not show stands against
        it.
    compared
        As in `Evidence`.
    disagreements
        By file of a measured circle, where it is not as the machine file predicts. That of a circle that all machines
        were made to agree with is settled.
    more
        Further fields of `Evidence`.
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
