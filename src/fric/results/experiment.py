"""Records of a virtual drive."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from fric.documents.fields import known
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.results.base import Advance, in_si, quantity, several, silent
from fric.results.given_models import document_of, machine_of
from fric.results.kinds import AxisName, MachineLike, PlanLike, Quantities, Quantity, Seed
from fric.results.records import Records
from fric.simulate.experiment import Trial, logs_of
from fric.simulate.experiment import experiment as run_experiment
from fric.simulate.machine import Axis
from fric.verb import Kind, verb


@verb
def experiment(
    machine: MachineLike,
    kind: Annotated[str | None, Kind(metavar="KIND", complete="fric.simulate.experiment:EXPERIMENTS")] = None,
    axis: AxisName = "x", *, plan: PlanLike | None = None, seed: Seed = 0,
    samples: Annotated[int | None, Kind(least=100, most=10**9)] = None, speeds: Quantities | None = None,
    amplitudes: Quantities | None = None, frequency: Annotated[Quantity | None, "frequency"] = None,
    step: Annotated[Quantity | None, "position"] = None, steps: Annotated[int | None, Kind(least=3, most=1000)] = None,
    mean: Annotated[Quantity | None, "velocity"] = None, peaks: Quantities | None = None,
    encoder: Annotated[Quantity | None, "position"] = None, noise: Annotated[Quantity | None, "force"] = None,
    advance: Advance = silent,
) -> Records:  # fmt: skip
    """Run an identification experiment on a virtual axis, logged as by a real drive.

    kind: constant-velocity, presliding-sine, micro-steps, sliding-sine, frequency-response, or all. Left out with a
        plan; all is all but micro-steps.
    plan: The records of a plan: plan.yaml, or its folder. It defines the whole motion.
    seed: Seed of all random numbers, except those of a plan's excitation.
    samples: Largest number of samples in a record.
    speeds: Speeds, as "0.1 mm/s, 1 mm/s"; the paper's 17 where not given.
    amplitudes: Amplitudes of the pre-sliding sines, as "15 um, 450 um".
    frequency: Frequency of the sines, as "0.1 Hz".
    step: Size of a micro-step, as "1 um".
    steps: Micro-steps from one end to the other; 30 where not given.
    mean: Mean speed of sliding-sine and frequency-response; of the latter "0 mm/s" is rest.
    peaks: Peak speeds of the multisine, a record each, as "5 mm/s, 15 mm/s"; else mean/2.
    encoder: Encoder step instead of the machine's; "0 um" for none.
    noise: Force noise (rms) instead of the machine's; "0 N" for none.
    Raises FricError: When there is no such axis or kind, or the axis cannot follow.
    """
    named = str(machine) if isinstance(machine, str | Path) else machine_of(machine).name
    subject = machine_of(machine).axis(axis)
    motion = subject.motion
    if encoder is not None:
        subject = replace(subject, encoder=Encoder(in_si(encoder, "small length", motion)))
    if noise is not None:
        subject = replace(subject, force_noise=in_si(noise, "force", motion))
    given = known(
        samples=samples, speeds=several(speeds, "velocity", motion),
        amplitudes=several(amplitudes, "small length", motion), frequency=quantity(frequency, "frequency"),
        step=None if step is None else in_si(step, "small length", motion), steps=steps,
        mean=None if mean is None else in_si(mean, "velocity", motion), peaks=several(peaks, "velocity", motion),
    )  # fmt: skip
    if (plan is None) == (kind is None):
        raise FricError("an experiment is of a kind or of a plan", hint="Give `kind=`, or `plan=`.")
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


def _trials(plan: Any, axis: Axis) -> Iterator[Trial]:
    if isinstance(plan, str | Path) and Path(plan).is_dir():
        plan = Path(plan) / "plan.yaml"
    from fric.documents.plan import PlanDocument  # it loads what plans and simulates

    document = document_of(PlanDocument, plan, (axis.name, axis.motion), "machine")
    return (trial for record in document.planned() for trial in record.trials(axis))
