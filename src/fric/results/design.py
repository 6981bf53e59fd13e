"""Designs of one axis, with their margins: the controller, a disturbance observer, any control block."""

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import inf, log10
from typing import Annotated, Any, Literal

from fric.control import ControlBlock, Setting, block_type
from fric.control.cascade import Cascade
from fric.control.inverse_model import DisturbanceObserver
from fric.control.q_filter import QFilter
from fric.design import observer
from fric.design.blocks import BlockDesign, JointDesign, design_jointly
from fric.design.blocks import design_block as find_block
from fric.design.cascade import CascadeDesign, Requirement, check_cascade, design_cascade
from fric.design.observer import ObserverDesign, Perturbation, StructuralMode
from fric.documents.base import in_units
from fric.documents.controller import BlockDocument, ControllerDocument, ControllerPart, ObserverDocument, ObserverPart
from fric.documents.machine_files import nominal_models
from fric.documents.plant import PlantDocument
from fric.drive.plant import hold_delay
from fric.errors import FricError
from fric.estimate import Estimate, elements
from fric.flaws.response import CONTROLLER_BY_DEFAULT, OBSERVER_ASSUMED
from fric.friction import FrictionModel
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.notice import Notice, once
from fric.records.flaws import evened
from fric.records.recognition import kind_of
from fric.results.base import Figure, Piece, Result, Table, in_si, named, plain_names, positive, quantity, records_of
from fric.results.given_models import cascade_of, document_of, friction_of
from fric.results.kinds import ControllerLike, Count, FrictionLike, LogLike, PlantLike, Quantity, RecordName
from fric.series import doubles
from fric.units import LARGEST_PEAK, Motion, parse_gain, readable
from fric.verb import Kind, useless, verb

HERTZ = "{:.4g} Hz"
MARGINS = (
    ("phase_margin", "phase margin", "{:.1f}°"), ("gain_margin", "gain margin", "{:.1f} dB"),
    ("peak_sensitivity", "Ms", "{:.1f} dB"), ("crossover", "crossover", HERTZ), ("bandwidth", "bandwidth", HERTZ),
)  # fmt: skip
FIRST_MODE = 50.0  # Assumed lowest structural mode of an axis without a measured response [Hz]: that of a slow machine
MODE_DAMPING = 0.01  # Its assumed damping
Filter = Literal["binomial2", "binomial3", "binomial4", "butterworth2", "butterworth3", "umeno-hori"]


def perturbation_of(
    record: Log | FrequencyResponse, document: PlantDocument, averages: int = 1
) -> tuple[Perturbation, tuple[Notice, ...]]:
    """Return the perturbation of a plant from a measured response or a record, and its warnings.

    Frequencies below the lowest line that the plant was identified from, and lines that deviate as friction does, are
    left out: they do not show the plant.
    """
    from fric.identify.plant.frequency_response import measure_response  # with SciPy's signal processing

    plant, (lowest, deviating) = document.linear(document.motion), document.lines(record.name)
    if isinstance(record, FrequencyResponse):
        return observer.measured_perturbation(record, plant, averages, None, lowest, deviating), ()
    response = measure_response(record)
    found = observer.measured_perturbation(response.table, plant, 1, response.sampling, lowest, deviating)
    return found, tuple(response.warnings)


class Design(Result):
    """A design of one axis, with its loops and their margins; `document` is its file."""

    design: Any  # What was designed, with its loops
    axis: str  # Name of the axis
    motion: Motion  # Whether it is linear or rotary
    description: Sequence[Notice] = ()  # What else the user should know, and what the plant's file warns of
    logs: Sequence[Record] = ()  # The record of the response, where there is one
    view: str = "bode"  # What the figure shows: ``bode``, ``nyquist`` or ``nichols``; of an observer also ``q``, Fig. 7

    @abstractmethod
    def parts(self) -> dict[str, Any]:
        """Return what was designed, by key of the file."""

    @property
    def content(self) -> dict[str, Any]:
        """The content of the file."""
        margins = {name: loop.margins.as_dict() for name, loop in self.design.loops().items()}
        return {"axis": self.axis, "motion": self.motion, **self.parts(), "margins": margins}

    @property
    def warnings(self) -> Sequence[Notice]:
        """What the plant's file and the response cannot tell."""
        return once(self.description)

    def margins(self) -> Table:
        """Return the margins, a line for each loop."""
        titles = {name: loop.title for name, loop in self.design.loops().items()}
        rows = [
            [titles[name], *(_described(found.get(key), form) for key, _, form in MARGINS)]
            for name, found in self.document["margins"].items()
        ]
        return Table(["loop", *(title for _, title, _ in MARGINS)], rows)

    def loops_figure(self) -> Figure:
        """Return the figure of the loops up to half the sampling rate: Bode, Nyquist or Nichols."""
        from fric.figures.loops import bode_figure, nichols_figure, nyquist_figure

        draw = {"bode": bode_figure, "nyquist": nyquist_figure, "nichols": nichols_figure}[self.view]
        return draw(self.design.loops().values(), self.design.cascade.sampling / 2)

    def by_row(self) -> dict[str, dict[str, Any]]:
        """Return the margins by loop: °, dB and Hz, as in the file."""
        return {
            name: {key: found[key]["value"] if found.get(key) else float("nan") for key, *_ in MARGINS}
            for name, found in self.document["margins"].items()
        }


def _described(quantity: Mapping[str, Any] | None, form: str = HERTZ) -> str:
    return "–" if quantity is None else form.format(quantity["value"])


class ControllerResult(Design, schema=ControllerDocument, of="content"):
    """A designed, or checked, cascade."""

    design: CascadeDesign  # The cascade and its loops

    @property
    def belief(self) -> Cascade:
        """The cascade."""
        return self.design.cascade

    def parts(self) -> dict[str, Any]:
        """Return the gains of the cascade."""
        return ControllerPart.of(self.design.cascade, self.motion)

    def report(self) -> list[Piece]:
        """Return gains and margins."""
        names, given = ("K_p", "K_i", "K_v"), self.parts()
        gains = (
            f"{name}  {readable(float(given[name]), given[name].unit, 4)}  {plain}"
            for name, plain in zip(names, plain_names(names), strict=True)
        )
        return [*gains, self.margins()]

    def brief(self) -> str:
        """Return the gains."""
        given = self.parts()
        return ", ".join(f"{name} {readable(float(given[name]), given[name].unit)}" for name in ("K_v", "K_p", "K_i"))

    figure = Design.loops_figure


@verb
def design_controller(
    plant: PlantLike, *, phase_margin: Annotated[Quantity, "angle"] = "60 deg",
    gain_margin: Annotated[Quantity, "gain"] = "13.8 dB", sampling: Annotated[Quantity, "frequency"] = "4 kHz",
    velocity_filter: Annotated[Quantity, "frequency"] = "500 Hz", limit: Annotated[Quantity | None, "input"] = None,
    corner_ratio: float = 10.0, separation: float = 3.0, crossover: Annotated[Quantity | None, "frequency"] = None,
    K_p: Annotated[Quantity | None, "velocity gain"] = None, K_i: Annotated[Quantity | None, "position gain"] = None,
    K_v: Annotated[Quantity | None, "rate"] = None, view: Literal["bode", "nyquist", "nichols"] = "bode",
) -> ControllerResult:  # fmt: skip
    """Design the cascade P/PI of an axis by gain and phase margin of its sampled loops.

    The velocity loop's crossover is the highest at which it has both margins; the corner of its PI is 1/10 of it, and
    K_v/2π a third, or less where the position loop needs it. A design that is unstable or misses its margins is
    refused, with the nearest valid design.

    plant: The plant, eq. (1): A, B, T_d. Its file or its result.
    phase_margin: Least phase margin of velocity and position loop.
    gain_margin: Least gain margin of velocity and position loop. A number is a factor.
    sampling: Sampling rate of the controller.
    velocity_filter: Corner of the low-pass on the velocity.
    limit: Saturation of the control voltage.
    corner_ratio: Ratio of the velocity loop's crossover to the corner of its PI.
    separation: Least ratio of the velocity loop's crossover to K_v/2π.
    crossover: Crossover of the velocity loop; by default the highest possible.
    K_p: Velocity gain: given with K_i and K_v, the gains are checked, not designed.
    K_i: Integral gain of the velocity loop, as '3156 V/m'.
    K_v: Position gain, as '126 1/s'.
    view: What the figure shows.
    Raises FricError: When a design is unstable or misses its margins; the message has the nearest valid design.
    """
    document = document_of(PlantDocument, plant)
    motion, linear = document.motion, document.linear(document.motion)
    asked = Requirement(in_si(phase_margin, "angle"), parse_gain(gain_margin))
    rate, low_pass = positive(sampling, "frequency"), positive(velocity_filter, "frequency")
    if document.T_d.assumed:  # as that of a machine, it holds the half sample of the controller
        linear = replace(linear, T_d=max(linear.T_d, hold_delay(rate)))
    largest = inf if limit is None else in_si(limit, "input")
    gains = {"rate": K_v, "velocity gain": K_p, "position gain": K_i}
    if any(gain is not None for gain in gains.values()):
        if None in gains.values() or crossover is not None:
            raise FricError("gains are checked all together", hint="Give `K_p=`, `K_i=`, `K_v=`, and no `crossover=`.")
        v, p, i = (in_si(gain or 0.0, kind, motion) for kind, gain in gains.items())
        design = check_cascade(linear, Cascade(v, p, i, low_pass, rate, largest), asked)
    else:
        design = design_cascade(
            linear, asked, sampling=rate, velocity_filter=low_pass, limit=largest, corner_ratio=corner_ratio,
            separation=separation, crossover=quantity(crossover, "frequency"),
        )  # fmt: skip
    return ControllerResult(design, document.axis, motion, document.passed_on(), view=view)


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
        design, q, robust = self.design, self.design.observer.q, self.design.robust
        peak = Estimate(20 * log10(design.peak_sensitivity), "dB")
        limits = {"robust": _reach(robust.q), "sensitive": {"peak_sensitivity": peak} | _reach(design.sensitive)}
        if robust.q is not None:
            limits["robust"] |= {"frequency": Estimate(robust.frequency, "Hz"), "Delta": Estimate(robust.size, "1")}
        found = ObserverPart.of(design.observer, self.motion) | {"filter": q.name} | _reach(q, assumed=design.assumed)
        return found | {"reason": design.reason, "limits": limits}

    def report(self) -> list[Piece]:
        """Return Q, its limits, and the margins."""
        tree = self.document
        titles = {"robust": "|T·Delta| ≤ 1, eq. (8)", "sensitive": f"Ms ≤ {self.asked} of the whole loop"}
        limits = ((titles[name], found.get("cutoff"), found.get("bandwidth")) for name, found in tree["limits"].items())
        rows = [[title, *map(_described, reach)] for title, *reach in limits]
        q = f"Q  {tree['filter']}, cutoff {_described(tree['cutoff'])}, -3 dB at {_described(tree['bandwidth'])}"
        return [q, f"   {tree['reason']}", Table(["limit", "cutoff", "bandwidth"], rows), self.margins()]

    def brief(self) -> str:
        """Return the cutoff of Q."""
        return f"Q cutoff {_described(self.document['cutoff'])}"

    def figure(self) -> Figure:
        """Return Q with what limits it, or the loops."""
        from fric.figures.loops import q_filter_figure

        return q_filter_figure(self.design) if self.view == "q" else self.loops_figure()


def _reach(q: QFilter | None, *, assumed: bool = False) -> dict[str, Estimate]:
    """Return cutoff and bandwidth of a filter; nothing without a filter."""
    names = () if q is None else ("cutoff", "bandwidth")
    return {name: Estimate(getattr(q, name), "Hz", assumed=assumed) for name in names}


@verb
def design_observer(
    plant: PlantLike, log: LogLike | None = None, *, filter: Filter = "binomial2",
    controller: ControllerLike | None = None, cutoff: Annotated[Quantity | None, "frequency"] = None,
    bandwidth: Annotated[Quantity | None, "frequency"] = None, peak_sensitivity: Annotated[Quantity, "gain"] = "6 dB",
    resonances: Annotated[Iterable["str | StructuralMode"], Kind(list[str], "FREQUENCY,DAMPING[,SHARE]")] = (),
    first_mode: Annotated[Quantity | None, "frequency"] = None, record: RecordName | None = None, averages: Count = 1,
    view: Literal["q", "bode", "nyquist", "nichols"] = "q",
) -> ObserverResult:  # fmt: skip
    """Design the disturbance observer of an axis: the largest bandwidth of its filter Q.

    There are two limits: |T·Delta| ≤ 1 at every frequency (eq. (8)), with the confidence of the response, and the peak
    sensitivity of the whole loop. The smaller applies. Without a measured response no bandwidth is recommended: Q stays
    below the first mode, given by `first_mode=` or assumed.

    plant: The plant, eq. (1): A, B, T_d. Its file or its result.
    log: A frequency response, or a record to take it from; without it Q stays below `first_mode=`. No bandwidth is
        recommended then, since the mode is only stated or assumed.
    filter: The shape of Q.
    cutoff: Corner of Q, 1/(2πτ); by default the largest allowed.
    bandwidth: Bandwidth of Q (−3 dB), instead of its cutoff.
    resonances: A mode that the plant does not have, as in '280 Hz, 0.02, 0.1'; repeatable. Frequency, damping, share.
    first_mode: The lowest structural mode, as '80 Hz', if no response was measured. By default `FIRST_MODE`.
    averages: Records that a table's coherence was averaged over, for its confidence.
    view: What the figure shows; q is Fig. 7.
    Raises FricError: When no Q meets the limits, or the log has no frequency response.
    """
    document = document_of(PlantDocument, plant)
    axis, motion, linear = document.axis, document.motion, document.linear(document.motion)
    known = cascade_of(controller, axis, motion, "plant")
    warnings = [*document.passed_on(), *([] if known else [CONTROLLER_BY_DEFAULT.found()])]
    cascade = known or design_cascade(linear).cascade
    modes = [mode if isinstance(mode, StructuralMode) else _resonance(str(mode)) for mode in resonances]
    mode, given = quantity(first_mode, "frequency"), cutoff or bandwidth
    if modes or given:
        useless("no resonance, cutoff or bandwidth", first_mode=first_mode)
    if log is None:
        useless("a log", record=record)
        logs, Delta = [], observer.model_perturbation(linear, cascade.sampling / 2, modes)
        if not modes:
            warnings.append(_unseen(first_mode, given))
    else:
        useless("no log, which has its resonances", resonances=modes or None, first_mode=first_mode)
        logs = [measured_record(log, record, (axis, motion))]
        Delta, seen = perturbation_of(logs[0], document, averages)
        warnings += seen
    if cutoff and bandwidth:
        raise FricError("cutoff and bandwidth are two names of one choice", hint="Give one of them.")
    wanted = quantity(cutoff, "frequency")
    if bandwidth:
        wanted = in_si(bandwidth, "frequency") / QFilter(filter, 1.0).bandwidth
    allowed = parse_gain(peak_sensitivity, 1.0, LARGEST_PEAK)
    try:
        design = observer.design_observer(
            linear, cascade, filter, cutoff=wanted, peak_sensitivity=allowed, perturbation=Delta
        )
    except FricError as error:
        if not (default := [warning for warning in warnings if warning.code == CONTROLLER_BY_DEFAULT.code]):
            raise
        hint = f"{error.hint} {default[0]}"  # which the user is not to blame for
        raise FricError(error.what, where=error.where, hint=hint) from None
    if log is None and not modes and wanted is None:
        design = _below_a_mode(design, mode or FIRST_MODE, Delta)
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
    mode = observer.model_perturbation(design.plant, nyquist, [StructuralMode(frequency, MODE_DAMPING)])
    if (limit := observer.robust_limit(mode, filter)).q is None or limit.q.cutoff >= design.observer.q.cutoff:
        return replace(design, assumed=True)
    held = observer.design_observer(
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
    first = records[0]
    where = str(given) if isinstance(given, str) or hasattr(given, "suffix") else first.source
    if (first.axis, first.motion) != of:
        what = f"is the log of the {first.motion} axis {first.axis}, and the plant is of the {of[1]} axis {of[0]}"
        raise FricError(what, where=where, hint="Give the log of the axis that is designed for.")
    usable = [record for record in records if not isinstance(record, ForceVelocity)]
    stated = [record for record in usable if (record.name == name if name else record.kind == "frequency-response")]
    shown = (log for log in usable if isinstance(log, Log) and not (stated or name))  # a container of all records
    found = stated or [log for log in shown if kind_of(log) == "frequency-response"]
    if len(found) != 1:
        text = f"{len(found)} records " + (f"of the name '{name}'" if name else "of a frequency response")
        hint = "Name the one with `record=`, or ingest it."
        raise FricError(f"there are {text}, and one is needed", where=where, hint=hint)
    return evened(found[0])[0] if isinstance(found[0], Log) else found[0]  # the plant says what was resampled


def _resonance(text: str) -> StructuralMode:
    """Parse ``FREQUENCY,DAMPING[,SHARE]``."""
    frequency, *rest = (part.strip() for part in text.split(","))
    if (numbers := doubles(rest)) is None or not 1 <= len(numbers) <= 2:
        hint = "Write frequency, damping and share, as in '280 Hz, 0.02, 0.1'."
        raise FricError(f"'{text}' is not a resonance", hint=hint)
    return StructuralMode(in_si(frequency, "frequency"), *map(float, numbers))


class BlockResult(Design, schema=BlockDocument, of="content"):
    """A designed control block."""

    design: BlockDesign  # The block, and its loop
    joint: JointDesign | None = None  # The cascade, if it was designed together with the block

    @property
    def belief(self) -> ControlBlock:
        """The block."""
        return self.design.block

    def parts(self) -> dict[str, Any]:
        """Return the parameters of the block, and the cascade that it was designed with."""
        block = self.design.block
        dimensions = {parameter.name: parameter.dimension for parameter in block.parameters}
        parameters = in_units(vars(block), dimensions, self.motion)
        found = {"block": block.name, "parameters": parameters, "reason": self.design.reason}
        if self.joint is not None:
            found["controller"] = ControllerPart.of(self.joint.cascade, self.motion)
        return found

    def report(self) -> list[Piece]:
        """Return the parameters, the margins, and what the block requires of a controller."""
        block, tree = self.design.block, self.document
        rows = [
            (parameter.name, readable(float(given["value"]), given["unit"]), parameter.doc)
            for parameter in block.parameters if (given := tree["parameters"].get(parameter.name))
        ]  # fmt: skip
        table = Table(["parameter", "value", "what it is"], rows)
        found: list[Piece] = [f"{block.name}  of the kind {block.kind}, {self.design.reason}", table]
        return [*found, *self._cascade(), *([self.margins()] if tree["margins"] else []), f"it asks for: {block.asks}"]

    def _cascade(self) -> list[Piece]:
        if self.joint is None:
            return []
        after, before = self.joint.compliance
        rows = [
            (name, readable(float(given["value"]), given["unit"]))
            for name, given in self.document["controller"].items() if name not in {"sampling", "limit"}
        ]  # fmt: skip
        text = f"with this cascade a step of friction moves the axis {before / after:.1f} times less than without both"
        return [named(["cascade", "value"], rows), text]


@verb
def design_block(
    name: Annotated[str, Kind(metavar="NAME", complete="fric.control:blocks")], plant: PlantLike,
    log: LogLike | None = None, *, friction: FrictionLike | None = None, controller: ControllerLike | None = None,
    peak_sensitivity: Annotated[Quantity, "gain"] = "6 dB", record: RecordName | None = None, joint: bool = False,
) -> BlockResult:  # fmt: skip
    """Design a control block of an axis from its plant, its friction and a measured response.

    A block that feeds back is made as fast as the peak sensitivity of the whole loop allows, with the measured
    response; a nonlinear block is linearised around rest. A feedforward block is fitted to the friction.

    name: The control block, by its name in schemes; list shows all.
    plant: The plant, eq. (1): A, B, T_d. Its file or its result.
    log: A frequency response, or a record to take it from. Without it only the plant's delay limits the block.
    friction: The friction that was identified. Its file or its result.
    joint: Design the gains of the cascade together with the block. The stiffest loop within the peak sensitivity is
        sought.
    Raises FricError: When there is no such block, or the loop exceeds the peak sensitivity even with the block at its
        slowest.
    """
    kind = block_type(name)
    if name in {"cascade", "inverse-model"}:
        other = "controller" if name == "cascade" else "observer"
        raise FricError(f"'{name}' is designed by another command", hint=f"Use fric design {other}.")
    document = document_of(PlantDocument, plant)
    axis, motion, linear = document.axis, document.motion, document.linear(document.motion)
    known = cascade_of(controller, axis, motion, "plant")
    warnings = [] if known else [CONTROLLER_BY_DEFAULT.found()]
    cascade = known or design_cascade(linear).cascade
    models: Mapping[str, FrictionModel] = {}
    K_f, spans = float("nan"), dict[str, tuple[float, float]]()
    if (given := friction_of(friction, axis, motion)) is not None:
        models, K_f = nominal_models(given), document.plant(motion).K_f
        spans = _spans(given.tree())
    logs, Delta = [], None
    useless("a log", record=record if log is None else None)
    if log is not None:
        logs = [measured_record(log, record, (axis, motion))]
        Delta, seen = perturbation_of(logs[0], document)
        warnings += seen
    allowed = parse_gain(peak_sensitivity, 1.0, LARGEST_PEAK)
    setting = Setting(linear, cascade, friction=models.get("gms"), models=models, K_f=K_f, spans=spans)
    if joint:
        both = design_jointly(kind, setting, peak_sensitivity=allowed, perturbation=Delta)
        return BlockResult(both.block, axis, motion, warnings, logs, joint=both)
    design = find_block(kind, setting, peak_sensitivity=allowed, perturbation=Delta)
    return BlockResult(design, axis, motion, warnings, logs)


def _spans(friction: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Return the closed 95 % intervals of what was identified, over their values, by name."""
    spans = {}
    for name, estimate in elements({**friction.get("static", {}), **friction.get("gms", {})}):
        (low, high), value = estimate.limits, float(estimate)
        if low > 0 and high < inf and value > 0:
            spans[name] = (low / value, high / value)
    return spans
