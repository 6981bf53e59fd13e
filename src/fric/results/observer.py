"""A designed disturbance observer."""

from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

from fric.control.inverse_model import DisturbanceObserver
from fric.control.q_filter import QFilter
from fric.design.cascade import design_cascade
from fric.design.observer import ObserverDesign
from fric.design.observer import design_observer as find_observer
from fric.design.perturbation import Perturbation, StructuralMode, model_perturbation, robust_limit
from fric.documents.controller import ObserverDocument, observer_parts
from fric.documents.plant import PlantDocument
from fric.errors import FricError
from fric.flaws.response import CONTROLLER_BY_DEFAULT, OBSERVER_ASSUMED
from fric.log import ForceVelocity, FrequencyResponse, Log
from fric.notice import Notice
from fric.results.base import Figure
from fric.results.design import Design, perturbation_of
from fric.results.given import in_si, quantity, records_of
from fric.results.given_models import cascade_of, document_of
from fric.results.kinds import ControllerLike, Count, LogLike, PlantLike, Quantity, RecordName, ResonancesLike
from fric.results.text import Piece, Table
from fric.units import Motion, parse_gain
from fric.verb import verb

FIRST_MODE = 50.0
"""Assumed lowest structural mode of an axis without a measured response [Hz]: that of a slow machine."""
MODE_DAMPING = 0.01
"""Its assumed damping."""
Filter = Literal["binomial2", "binomial3", "binomial4", "butterworth2", "butterworth3", "umeno-hori"]


@dataclass(frozen=True, eq=False, repr=False)
class ObserverResult(Design, schema=ObserverDocument, of="content"):
    """A designed disturbance observer."""

    design: ObserverDesign  # The observer, its limits and its loops
    asked: float | str = "6 dB"  # The allowed peak sensitivity, as it was given

    @property
    def belief(self) -> DisturbanceObserver:
        """The observer."""
        return self.design.observer

    def parts(self) -> dict[str, Any]:
        """Return filter and nominal plant of the observer, and its limits."""
        return observer_parts(self.design, self.motion)

    def report(self) -> list[Piece]:
        """Return Q, its limits, and the margins."""
        tree = self.document
        titles = {"robust": "|T·Delta| ≤ 1, eq. (8)", "sensitive": f"Ms ≤ {self.asked} of the whole loop"}
        rows = [
            [titles[name], *(_hertz(found.get(key)) for key in ("cutoff", "bandwidth"))]
            for name, found in tree["limits"].items()
        ]
        return [
            f"Q  {tree['filter']}, cutoff {_hertz(tree['cutoff'])}, −3 dB at {_hertz(tree['bandwidth'])}",
            f"   {tree['reason']}",
            Table(["limit", "cutoff", "bandwidth"], rows),
            self.margins(),
        ]

    def brief(self) -> str:
        """Return the bandwidth of Q."""
        return f"Q to {_hertz(self.document['bandwidth'])}"

    def figure(self) -> Figure:
        """Return Q with what limits it, or the loops."""
        from fric.figures.loops import q_filter_figure

        return q_filter_figure(self.design) if self.view == "q" else self.loops_figure(self.design.cascade.sampling / 2)


def _hertz(quantity: dict[str, Any] | None) -> str:
    return "–" if quantity is None else f"{quantity['value']:.4g} Hz"


@verb
def design_observer(
    plant: PlantLike,
    log: LogLike | None = None,
    *,
    filter: Filter = "binomial2",
    controller: ControllerLike | None = None,
    cutoff: Annotated[Quantity | None, "frequency"] = None,
    bandwidth: Annotated[Quantity | None, "frequency"] = None,
    peak_sensitivity: Annotated[Quantity, "gain"] = "6 dB",
    resonances: ResonancesLike = (),
    first_mode: Annotated[Quantity | None, "frequency"] = None,
    record: RecordName | None = None,
    averages: Count = 1,
    view: Literal["q", "bode", "nyquist", "nichols"] = "q",
) -> ObserverResult:
    """Design the disturbance observer of an axis: the largest bandwidth of its filter Q.

    There are two limits: |T·Delta| ≤ 1 at every frequency (eq. (8)), with the confidence of the response, and the peak
    sensitivity of the whole loop. The smaller applies. Without a measured response no bandwidth is recommended: Q stays
    below the first mode, given by `first_mode=` or assumed.

    Parameters
    ----------
    plant
        The plant, eq. (1): A, B, T_d. Its file or its result.
    log
        A frequency response, or a record to take it from; without it Q stays below `first_mode=`. No bandwidth is
        recommended then, since the mode is only stated or assumed.
    filter
        The shape of Q.
    cutoff
        Corner of Q, 1/(2πτ); by default the largest allowed.
    bandwidth
        Bandwidth of Q (−3 dB), instead of its corner.
    resonances
        A mode that the plant does not have, as in '280 Hz, 0.02, 0.1'; repeatable. Frequency, damping, share.
    first_mode
        The lowest structural mode, as '80 Hz', if no response was measured. By default `FIRST_MODE`.
    averages
        Records that a table's coherence was averaged over, for its confidence.
    view
        What the figure shows; q is Fig. 7.

    Raises
    ------
    FricError
        When no Q meets the limits, or the log has no frequency response.
    """
    document = document_of(PlantDocument, plant)
    axis, motion, linear = document.axis, document.motion, document.linear(document.motion)
    warnings: list[Notice] = [*document.passed_on()]
    cascade = cascade_of(controller, axis, motion, "plant")
    if cascade is None:
        cascade = design_cascade(linear).cascade
        warnings.append(CONTROLLER_BY_DEFAULT.found())
    modes = [_resonance(resonance) if isinstance(resonance, str) else resonance for resonance in resonances]
    if log is None:
        logs, Delta = [], model_perturbation(linear, cascade.sampling / 2, modes)
        if not modes:
            warnings.append(_unseen(first_mode, cutoff or bandwidth))
    else:
        if modes or first_mode:
            raise FricError(
                "a measured response has its resonances", hint="Leave the log, or `resonances=` and `first_mode=`, out."
            )
        logs = [measured_record(log, record, (axis, motion))]
        Delta, seen = perturbation_of(logs[0], document, averages)
        warnings += seen
    if cutoff and bandwidth:
        raise FricError("cutoff and bandwidth are two names of one choice", hint="Give one of them.")
    wanted = quantity(cutoff, "frequency")
    if bandwidth:
        wanted = QFilter.of_bandwidth(filter, in_si(bandwidth, "frequency")).cutoff
    allowed = parse_gain(peak_sensitivity)
    try:
        design = find_observer(linear, cascade, filter, cutoff=wanted, peak_sensitivity=allowed, perturbation=Delta)
    except FricError as error:
        default = [warning for warning in warnings if warning.code == CONTROLLER_BY_DEFAULT.code]
        if not default:
            raise
        hint = f"{error.hint} {default[0]}"  # which the user is not to blame for
        raise FricError(error.what, where=error.where, hint=hint) from None
    if log is None and not modes and wanted is None:
        design = _below_a_mode(design, quantity(first_mode, "frequency") or FIRST_MODE, Delta)
    return ObserverResult(design, axis, motion, [*warnings, *design.warnings], logs, view, peak_sensitivity)


def _unseen(first_mode: float | str | None, given: float | str | None) -> Notice:
    """Return the remark on an observer that no measured response supports."""
    if first_mode:
        taken = f"Q is held below a first mode at {first_mode}, as stated, with a damping that is assumed"
    elif given:
        taken = "Q is as given, and the axis' dynamics beyond its delay are unknown"
    else:
        taken = f"Q is held below a first mode that is assumed at {FIRST_MODE:g} Hz: a guess, and no recommendation"
    return OBSERVER_ASSUMED.found(taken=taken, given=bool(first_mode))


def _below_a_mode(design: ObserverDesign, frequency: float, Delta: Perturbation) -> ObserverDesign:
    """Return the design with Q below a structural mode of which only the frequency is known, by eq. (8)."""
    nyquist, filter = design.cascade.sampling / 2, design.observer.q.name
    mode = model_perturbation(design.plant, nyquist, [StructuralMode(frequency, MODE_DAMPING)])
    limit = robust_limit(mode, filter)
    if limit.q is None or limit.q.cutoff >= design.observer.q.cutoff:
        return replace(design, assumed=True)
    held = find_observer(
        design.plant, design.cascade, filter, cutoff=limit.q.cutoff, peak_sensitivity=design.peak_sensitivity,
        perturbation=Delta,
    )  # fmt: skip
    reason = (
        f"held below a mode at {frequency:.4g} Hz with a damping of {MODE_DAMPING:g}, by eq. (8): none was measured"
    )
    return replace(held, reason=reason, assumed=True)


def measured_record(given: Any, name: str | None, of: tuple[str, Motion]) -> Log | FrequencyResponse:
    """Return the record with the measured response or its excitation, by name where there are several."""
    records = records_of([given])
    where = str(given) if isinstance(given, str) or hasattr(given, "suffix") else records[0].source
    if (records[0].axis, records[0].motion) != of:
        raise FricError(
            f"is the log of the {records[0].motion} axis {records[0].axis}, "
            f"and the plant is of the {of[1]} axis {of[0]}",
            where=where,
            hint="Give the log of the axis that is designed for.",
        )
    found = [
        record
        for record in records
        if not isinstance(record, ForceVelocity)
        and (
            record.name == name
            if name
            else isinstance(record, FrequencyResponse) or record.kind == "frequency-response"
        )
    ]
    if len(found) != 1:
        text = f"{len(found)} records " + (f"of the name '{name}'" if name else "of a frequency response")
        raise FricError(
            f"there are {text}, where one is asked", where=where, hint="Name the one with `record=`, or ingest it."
        )
    return found[0]


def _resonance(text: str) -> StructuralMode:
    """Parse ``FREQUENCY,DAMPING[,SHARE]``."""
    frequency, *rest = (part.strip() for part in text.split(","))
    try:
        numbers = [float(part) for part in rest]
    except ValueError:
        numbers = []
    if not 1 <= len(numbers) <= 2:
        raise FricError(
            f"'{text}' is no resonance", hint="Write frequency, damping and share, as in '280 Hz, 0.02, 0.1'."
        )
    return StructuralMode(in_si(frequency, "frequency"), *numbers)
