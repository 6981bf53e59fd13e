"""Records of a virtual drive."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.results.given import Advance, in_si, quantity, several, silent
from fric.results.given_models import document_of
from fric.results.machine import machine_of
from fric.results.records import Records
from fric.simulate.experiment import experiment as run_experiment
from fric.simulate.machine import Axis
from fric.simulate.trial import Trial, logs_of
from fric.verb import verb


@verb
def experiment(
    machine: Any,
    kind: str | None = None,
    axis: str = "x",
    *,
    plan: Any = None,
    seed: int = 0,
    samples: int | None = None,
    speeds: Sequence[float] | str | None = None,
    amplitudes: Sequence[float] | str | None = None,
    frequency: float | str | None = None,
    mean: float | str | None = None,
    peaks: Sequence[float] | str | None = None,
    encoder: float | str | None = None,
    noise: float | str | None = None,
    advance: Advance = silent,
) -> Records:
    """Make an identification experiment on a virtual axis, logged as a real drive logs it.

    Parameters
    ----------
    machine
        The machine, its file, or the name of a bundled one.
    kind
        ``constant-velocity``, ``presliding-sine``, ``sliding-sine``, ``frequency-response``, or ``all``; left out
        with a plan.
    axis
        The axis that is moved.
    plan
        A plan, its file or its folder: its records are made, and nothing else is to be said of the motion.
    seed
        Seed of all that is random; a plan's excitation is that of the plan.
    samples
        Samples that the drive's trace holds, for each record.
    speeds, amplitudes, frequency, mean, peaks
        Of the motion [m/s], [m], [Hz], [m/s], [m/s]; lists also as texts with commas. The paper's where not given.
    encoder, noise
        Encoder step [m] and force noise, rms [N], instead of the machine's.
    advance
        Is told of each record that is made.

    Raises
    ------
    FricError
        When there is no such axis or kind, or the axis cannot follow.
    """
    named = str(machine) if isinstance(machine, str | Path) else machine_of("experiment", machine).name
    subject = machine_of("experiment", machine).axis(axis)
    motion = subject.motion
    if encoder is not None:
        subject = replace(subject, encoder=Encoder(in_si(encoder, "position", motion)))
    if noise is not None:
        subject = replace(subject, force_noise=in_si(noise, "force", motion))
    settings: dict[str, Any] = {
        "samples": samples,
        "speeds": several(speeds, "velocity", motion),
        "amplitudes": several(amplitudes, "position", motion),
        "frequency": quantity(frequency, "frequency"),
        "mean": None if mean is None else in_si(mean, "velocity", motion),
        "peaks": several(peaks, "velocity", motion),
    }
    given = {name: value for name, value in settings.items() if value is not None}
    if (plan is None) == (kind is None):
        raise FricError("an experiment is of a kind or of a plan", hint="Give --kind, or --plan.")
    if plan is None:
        logs = run_experiment(subject, str(kind), seed=seed, **given)
    elif given:
        raise FricError(f"a plan says its motions, and {', '.join(given)} was given too", hint="Change the plan.")
    else:
        logs = logs_of(subject, _trials(plan, subject), seed)
    made = []
    for log in logs:
        made.append(replace(log, source=Path(named).name))
        advance()
    return Records(made)


def _trials(plan: Any, axis: Axis) -> list[Trial]:
    """Return what a plan asks of an axis."""
    if isinstance(plan, str | Path) and Path(plan).is_dir():
        plan = Path(plan) / "plan.yaml"
    from fric.documents.plan import PlanDocument  # it loads what plans and simulates

    document = document_of("experiment", PlanDocument, plan, (axis.name, axis.motion), "machine")
    return [trial for one in document.planned() for trial in one.trials(axis)]
