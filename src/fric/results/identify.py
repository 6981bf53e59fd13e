"""Identification: plant, controller, static map, GMS by its virgin curve, any friction model by replay."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property, partial
from itertools import chain
from math import hypot, inf, log
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from fric.arrays import Real
from fric.circles.gains import FoundController, controller_of, controller_of_logs
from fric.control.cascade import Cascade
from fric.documents.controller import ControllerDocument, ControllerPart
from fric.documents.friction import FrictionDocument, gms_tree, replay_tree, static_tree
from fric.documents.machine_files import nominal_models
from fric.documents.plant import PlantDocument, plant_tree
from fric.drive.plant import Plant
from fric.errors import FricError, require_known
from fric.estimate import NORMAL_97_5, Covariance, Estimate, estimate_rows
from fric.friction import FrictionModel, models
from fric.identify.gms.identify import GMSFit, Replay
from fric.identify.gms.identify import identify_gms as fit_gms
from fric.identify.gms.virgin_curve import MOST_BLOCKS
from fric.identify.plant.identify import MotionFit, PlantFit, identify_motion, plant_records
from fric.identify.plant.identify import identify_plant as fit_plant
from fric.identify.replay.replay_fit import ReplayFit, axis_in_motion, fitted_model, identify_by_replay
from fric.identify.static_map.identify import StaticFit
from fric.identify.static_map.identify import identify_static as fit_static
from fric.identify.static_map.points import Asked, ShapeFactor
from fric.input import reading
from fric.log import ForceVelocity, FrequencyResponse, Log, Record
from fric.notice import Notice
from fric.plausibility import Finding, of_amplitudes, of_friction, of_level, of_logs, of_strokes, settled
from fric.records.flaws import evened
from fric.records.prepared import of_shares, prepared, without_loaded
from fric.records.recognition import kind_of
from fric.records.resolution import without_clipped
from fric.results.base import Identified, Piece, Table, in_si, logs_of, named, parameters, quantity, records_of, several
from fric.results.given_models import circles_of, document_of, friction_of, plant_of, where_of
from fric.results.kinds import (
    AxisName,
    Blocks,
    CircleLike,
    Count,
    EncoderName,
    FrictionLike,
    LogLike,
    PlantLike,
    Quantity,
    SchemeName,
    Seed,
)
from fric.series import doubles, require_plausible
from fric.simulate.spread import closed_intervals, draw_friction, friction_intervals
from fric.units import Motion, is_effort, known_digits, readable, short_of_1, si_unit
from fric.verb import Kind, refused, useless, verb


class IdentifiedFriction(Identified):
    """The common part of friction results: the models that a controller can use."""

    fit: Any

    @property
    def axis(self) -> str:
        """Name of the axis."""
        return str(self.document["axis"])

    @property
    def belief(self) -> dict[str, FrictionModel]:
        """The models that a controller can feed forward, by name."""
        return nominal_models(FrictionDocument.model_validate(self.document))

    def sections(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return the parameters by section of the friction file and by name."""
        wanted = {"static", "static_negative", "at_speed", *models()}
        return {name: self.document[name] for name in self.document if name in wanted}


DRAWS = 64  # Models drawn for a band of 95 %: its half-width is then sure to 9 %


class IdentifiedModel(IdentifiedFriction):
    """The common part of models with memory: the force over a motion."""

    def predict(
        self, velocity: ArrayLike | str | None = None, *,
        time: ArrayLike | None = None, position: ArrayLike | None = None,
    ) -> tuple[Real, Real]:  # fmt: skip
        """Return the friction force [N, A, …] with the offset, and the half-width of its 95 % band, each of shape (n,).

        Of velocities alone it is the force after a long time at each; along a motion the model starts relaxed. The band
        is of models that are drawn from the intervals of the parameters and their covariance.

        velocity: Velocities [m/s], shape (n,), or a text as "1 mm/s, 10 mm/s"; of a motion with time.
        time: Times of the motion [s], shape (n,), rising.
        position: Positions of the motion [m], shape (n,), in place of its velocity or with it.
        Raises FricError: When there is neither a velocity nor a motion.
        """
        given = {"velocity": velocity, "time": time, "position": position}
        v, t, z = (None if x is None else _numbers(x, name, self.fit.motion) for name, x in given.items())
        if (v is None and z is None) or (t is None and z is not None):
            raise FricError("there is no motion", hint="Give `time` and `position` or `velocity`, or velocities alone.")
        if t is not None:
            if len(t) < 3 or (np.diff(t) <= 0).any() or any(x is not None and len(x) != len(t) for x in (v, z)):
                raise FricError("time, position and velocity are unequal", hint="Give as many of each, times rising.")
            if z is None and v is not None:
                z = np.append(0.0, np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t)))
        document = FrictionDocument.model_validate(self.document)
        model, load = document.found_with(self.fit.model.name)
        sections = {name: document.estimates(name) for name in document.sections()}
        intervals, _ = friction_intervals(model, sections)
        if "offset" in sections.get("static", {}):
            intervals |= closed_intervals("offset", sections["static"]["offset"])[0]
        drawn = [draw_friction(model, load, n, intervals, [*document.covariances()]) for n in range(DRAWS)]
        force, *others = (
            offset + np.asarray(law.steady_state(v) if t is None else law.replay(t, z, v))  # type: ignore[arg-type]
            for law, offset in ((model, load), *drawn)
        )
        return force, NORMAL_97_5 * np.sqrt(np.mean((np.array(others) - force) ** 2, axis=0))


def _numbers(given: ArrayLike | str, dimension: str, motion: Motion = "linear") -> Real:
    """Return plausible numbers, shape (n,); also those of a text."""
    found = doubles(several(given, dimension, motion) if isinstance(given, str) else given)
    if found is None or found.ndim > 1:
        raise refused("predict", f"{dimension} as numbers, shape (n,), or a text with units", given)
    require_plausible(dimension, found, dimension, "predict", motion=motion)
    return np.atleast_1d(found)


class PlantResult(Identified, tree=plant_tree):
    """An identified plant, eq. (1)."""

    fit: PlantFit | MotionFit  # The fit, to frequency responses or to motions
    records: Sequence[Record]  # The records that it was identified from

    @property
    def axis(self) -> str:
        """Name of the axis."""
        return self.fit.axis

    @property
    def belief(self) -> Plant:
        """The plant in SI; raises a `FricError` where B or K_f is not known."""
        return PlantDocument.model_validate(self.document).plant(self.fit.motion)

    def sections(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return A, B, T_d and K_f, and the further parameters of a motion."""
        given = self.document
        second = {name: entry for name, entry in given.get("second_mass", {}).items() if name != "encoder"}
        found = {"plant": {name: given[name] for name in PlantDocument.dimensions if name in given}}
        found |= {"second_mass": second} if second else {}
        return found | ({"motion": given["fit"]["parameters"]} if given["fit"].get("parameters") else {})

    def report(self) -> list[Piece]:
        """Return A, B, T_d and K_f, and their records."""
        fit, found = self.document["fit"], self.sections()
        pieces: list[Piece] = [parameters(found["plant"], notices=self.warnings)]
        if "second_mass" in found:
            pieces.append(parameters(found["second_mass"], "second mass"))
        if "parameters" in fit:
            rows = [(*row, f"{fit['parameters'][row[0]]['deviation']:.4g}") for row in estimate_rows(fit["parameters"])]
            pieces += [
                named(("", "value", "95 % interval", "unit", "deviation"), rows),
                f"{fit['points']} points, relative error {100 * fit['relative_error']['value']:.5g} %, "
                f"condition number {fit['condition_number']:.4f}",
            ]
            return pieces
        pieces += [
            f"{response['record']}: {response['estimate']}; {response['lines']} lines used, "
            f"{readable(response['lowest']['value'], 'Hz')} to {readable(response['highest']['value'], 'Hz')}"
            for response in fit["responses"]
        ]
        delay = f"transport delay {readable(fit['transport_delay']['value'], 's')}"
        if "hold_delay" in fit:
            delay += f", hold {readable(fit['hold_delay']['value'], 's')} (half a sample): together T_d"
        return [*pieces, delay]


@verb
def identify_plant(
    *logs: LogLike, method: Literal["auto", "response", "motion"] = "auto",
    force_constant: Annotated[Quantity | None, "force per input"] = None,
    mass: Annotated[Quantity | None, "mass"] = None, coherence: Annotated[float, Kind(least=0, most=1)] = 0.5,
    lowest: Annotated[Quantity | None, "frequency"] = None, highest: Annotated[Quantity | None, "frequency"] = None,
    period: Annotated[Quantity | None, "time"] = None, segment: Annotated[Quantity | None, "time"] = None,
    hold: Annotated[Quantity, Kind(metavar="RATE|auto|none")] = "auto", direction: Literal["both", "each"] = "both",
    delay: Annotated[Quantity | None, "time"] = None, cutoff: Annotated[Quantity | None, "frequency"] = None,
    decimation: Count | None = None, border: Annotated[int | None, Kind(least=0, most=10**9)] = None,
    encoder: EncoderName = "motor",
) -> PlantResult:  # fmt: skip
    """Identify the plant A, B, T_d (eq. 1) and K_f, from frequency responses or from an ordinary motion.

    method: Use frequency responses, or a motion. ``auto`` uses responses if there are any.
    force_constant: Force constant, as "548 N/V", where no force was logged.
    mass: Moving mass if known, as "85 kg": it is compared with K_f/B.
    coherence: Least coherence of a frequency.
    lowest: Lowest frequency, as "5 Hz".
    highest: Highest frequency, as "300 Hz".
    period: Period of the excitation; by default found from the data.
    segment: Length of Welch's segments, without a period.
    hold: Rate of the hold before the plant, as "4 kHz"; auto: the rate of a record, none for a table.
    direction: Common friction and an offset, or friction for each direction.
    delay: T_d, which neither a motion nor a logged current shows, as "0.65 ms": delay of the force behind its log.
    cutoff: Corner of the zero-phase filter.
    decimation: Keep every N-th sample.
    border: Samples left out at the start.
    Raises FricError: When no record is usable, too few lines are certain, or a motion does not separate the terms.
    """
    given = records_of(logs, encoder=encoder)
    wanted, records = plant_records(given, None if method == "auto" else method)
    of_motion = {"delay": delay, "cutoff": cutoff, "decimation": decimation, "border": border}
    of_response = {"lowest": lowest, "highest": highest, "period": period, "segment": segment}
    motion, in_time = records[0].motion, [record for record in records if isinstance(record, Log)]
    of_motion = {name: given for name, given in of_motion.items() if name != "delay" or not is_effort(motion)}
    useless(f"the other method, and this is by {wanted}", **(of_response if wanted == "motion" else of_motion))
    doubtful = settled(of_logs(in_time))
    K_f, weight = quantity(force_constant, "force per input", motion), quantity(mass, "mass", motion)
    if wanted == "motion":
        found = identify_motion(
            in_time, direction=direction, force_constant=K_f, delay=quantity(delay, "time"),
            cutoff=quantity(cutoff, "frequency"), decimation=decimation, border=border, mass=weight,
            replayed=axis_in_motion,
        )  # fmt: skip
        return _plausible(PlantResult(found, records), doubtful)
    fit = fit_plant(
        records, hold=None if hold in {"auto", "none"} else quantity(hold, "frequency"), continuous=hold == "none",
        coherence=coherence,
        band=(quantity(lowest, "frequency") or 0.0, quantity(highest, "frequency") or float("inf")),
        period=quantity(period, "time"), segment=quantity(segment, "time"), given_force_constant=K_f, mass=weight,
        strokes=[log for log in given if isinstance(log, Log) and kind_of(log) == "constant-velocity"],
        delay=quantity(delay, "time"),
    )  # fmt: skip
    return _plausible(PlantResult(fit, records), doubtful)


def _plausible(result: PlantResult, doubtful: list[Notice]) -> PlantResult:
    """Return a result with plausible values, or with warnings where bounds are lifted."""
    document, motion = PlantDocument.model_validate(result.document), result.records[0].motion
    known = document.estimates(motion)
    if "B" in known and float(known["B"]) <= 0 < known["B"].limits[1]:
        what = "the records hardly accelerate: their force shows friction, and not the mass"
        raise FricError(what, where=result.records[0].source, hint="Log a motion that accelerates, or a response.")
    values = {name: float(estimate) for name, estimate in known.items() if name in {"A", "B", "T_d"}}
    if {"B", "K_f"} <= known.keys():
        values["mass"] = float(known["K_f"]) / values["B"]
    falls = "Log strokes at constant velocity, which show how; then look at signs and units" if values["A"] < 0 else ""
    found = settled((Finding(name, value, motion, result.records[0].where) for name, value in values.items()), falls)
    return replace(result, fit=replace(result.fit, warnings=(*result.fit.warnings, *doubtful, *found)))


class GainsResult(Identified):
    """The cascade identified from a recorded voltage."""

    found: FoundController  # The controller, and the intervals of its gains
    axis: str  # axis, motion: of the gains
    motion: Motion = "linear"

    @property
    def belief(self) -> Cascade:
        """The cascade."""
        return ControllerDocument.model_validate(self.document).in_si(self.motion)

    @cached_property
    def document(self) -> dict[str, Any]:
        """The controller file."""
        content: dict[str, Any] = {"axis": self.axis, "motion": self.motion}
        content |= {**ControllerPart.of(self.found.cascade, self.motion), **self.found.estimates}
        notices = (notice.at(f"axis {self.axis}") for notice in self.found.lags)
        return ControllerDocument.made(content, notices=notices).tree()

    def sections(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Return the gains as the file holds them."""
        return {"controller": {name: self.document[name] for name in self.found.estimates}}

    def report(self) -> list[Piece]:
        """Return the gains, and how much of the voltage, or other effort, they explain."""
        given = "input" if is_effort(self.motion) else "voltage"
        how = "as it says" if self.found.explained is None else f"{self.found.explained:.2%} of the {given} explained"
        how += "; K_v and K_i/K_p may be exchanged: the loop is the same" * self.found.swapped
        if self.found.late:
            how += f"; it answers {readable(self.found.late, 's')} after it measures: add that to T_d"
        return [parameters(self.sections()["controller"]), f"{self.found.where}: {how}"]


@verb
def identify_controller(
    *records: Annotated[LogLike | CircleLike, Kind(Path, "FILE")], axis: AxisName = "x",
    scheme: SchemeName | None = None, position_gain: Annotated[Quantity | None, "rate"] = None,
    motion: Annotated[Motion, Kind(metavar="linear|rotary[/UNIT]")] = "linear",
    sampling: Annotated[Quantity | None, "frequency"] = None,
) -> GainsResult:  # fmt: skip
    """Identify the gains of an axis' controller from a circle, or a log in closed loop.

    It needs reference, position and voltage. Of circles the first is used, of logs the one that determines the gains
    best.

    records: A circle test without compensation of friction, or log files; or an auto-tuning result of SINUMERIK, whose
        gains are read.
    position_gain: K_v of an auto-tuning result, which holds the speed loop alone.
    motion: Motion of the axis of a circle; linear/A/A takes its force, in A, for the drive's input.
    sampling: Rate of the controller, where its record is slower.
    Raises FricError: When a channel is missing, or no cascade reproduces the recorded voltage.
    """
    if len(records) == 1 and isinstance(records[0], str | Path) and Path(records[0]).suffix.lower() == ".xml":
        from fric.io.readers import HEAD
        from fric.io.readers.optimize import cascade_of, recognises

        with reading(Path(records[0])) as file:
            if not recognises(Path(records[0]), file.read(HEAD)):
                raise FricError("is not an auto-tuning result of SINUMERIK", where=str(records[0]),
                                hint="Read a log with `fric ingest` first, and give what it writes.")  # fmt: skip
        useless("a circle or a log", sampling=sampling)
        tuned = cascade_of(Path(records[0]), quantity(position_gain, "rate"))
        gains = ControllerPart.of(tuned[2], tuned[1])
        return GainsResult(FoundController(tuned[2], gains, None, str(records[0])), *tuned[:2])
    useless("an auto-tuning result", position_gain=position_gain)
    rate = None if sampling is None else quantity(sampling, "frequency")
    logs, circles = list[Any](), list[Any]()
    for given in records:
        (logs if _is_log(given) else circles).append(given)
    if tests := circles_of(circles, scheme):
        found = controller_of(tests[0], axis, motion)
        return GainsResult(found if rate is None else found.at(rate), axis, motion)
    if not logs:
        raise FricError("there is no circle test", hint="Record one with reference, position and voltage.")
    given = logs_of(logs)
    if not (of_axis := [log for log in given if log.axis == axis]):
        axes = " and ".join(sorted({log.axis for log in given}))
        raise FricError(f"no log is of axis {axis}", hint=f"The logs are of axis {axes} (`axis=`).")
    found = controller_of_logs(of_axis)
    return GainsResult(found if rate is None else found.at(rate), axis, of_axis[0].motion)


def _is_log(given: Any) -> bool:
    """Return whether records of a log are given, or their file."""
    if isinstance(given, str | Path):
        from fric.io.recognise import recognise  # with HDF5, which records need not

        return recognise(Path(given)) == "log/1"
    first: Any = given
    for _ in range(3):  # a list may hold itself
        if isinstance(first, Iterable) and getattr(first, "ndim", True) and not isinstance(first, str):
            first = next(iter(first), None)
    return isinstance(first, Log)


class StaticResult(IdentifiedFriction, tree=static_tree):
    """An identified static map, eq. (2)."""

    fit: StaticFit  # The fit: points, map, intervals
    logs: Sequence[Log | ForceVelocity]  # The records that it was identified from

    def predict(self, velocity: ArrayLike | str) -> tuple[Real, Real]:
        """Return the force [N, A, …] at velocities [m/s] including the offset, and the half-width of its 95 % band.

        velocity: Numbers, or a text as "1 mm/s, 10 mm/s".
        Raises FricError: When only one speed was logged.
        """
        fit, v = self.fit, _numbers(velocity, "velocity", self.fit.motion)
        if fit.static is None:
            raise FricError("only one speed was logged, which gives no map", hint="Log strokes at ten speeds.")
        force, half = fit.static.predict(v)
        if fit.negative is not None:
            mirrored, wide = fit.negative.predict(-v)
            force, half = np.where(v < 0, -mirrored, force), np.where(v < 0, wide, half)
        return force, half

    def report(self) -> list[Piece]:
        """Return the map, and how well it fits."""
        fit, unit = self.fit, si_unit("force", self.fit.motion)
        maps = {"": fit.static, "negative direction": fit.negative}
        text: list[Piece] = [
            parameters(fit.estimates, title, self.warnings) for title, fit in maps.items() if fit is not None
        ]
        text += [parameters(fit.at_speed, "at one speed")] if fit.at_speed else []
        quality = f", rmse {readable(fit.static.rmse, unit)}, R² {short_of_1(fit.static.r2)}" if fit.static else ""
        return [*text, f"{len(fit.points)} strokes{quality}"]


@verb
def identify_static(
    *logs: LogLike, plant: PlantLike | None = None,
    delta: Annotated[float | str, Kind(metavar="VALUE|free|auto")] = "auto",
    direction: Literal["auto", "both", "each"] = "auto", over_position: Literal["auto", "off", "on"] = "auto",
    weights: Literal["error", "equal"] = "error", average: Literal["robust", "median"] = "robust",
    form: Literal["auto", "coulomb", "stribeck"] = "auto", load: Annotated[Quantity | None, "force"] = None,
    encoder: EncoderName = "motor",
) -> StaticResult:  # fmt: skip
    """Identify the static friction map F_c, F_s, v_s, delta, sigma (eq. 2) from constant-velocity strokes.

    logs: Log files of one axis. Or records: strokes, one or many a record, and tables of mean forces at velocities.
    plant: The plant, whose linear damping is subtracted. Its file or its result: ``K_f·(A/B)·v`` is subtracted first.
    delta: Stribeck shape factor, fixed or free; auto: free if that predicts held-out strokes better than 1.
    direction: Common map and offset, a map for each direction, or whichever predicts held-out strokes better.
    over_position: Whether to subtract forces that depend on position; auto: if that predicts better.
    weights: Weigh strokes by their errors and scatter, or all equally.
    average: Force of a stroke: Huber's robust mean, or the median.
    form: Coulomb plus viscous friction, eq. (2), or whichever predicts held-out strokes better.
    load: Constant load if known, as "60 N" or "0 N": the offset is then equal to it. As the weight of a vertical axis.
    Raises FricError: When there is no steady stroke, or there are too few speeds for the parameters.
    """
    records = [log for log in records_of(logs, encoder=encoder) if not isinstance(log, FrequencyResponse)]
    if not records:
        what = "the logs hold frequency responses alone, no strokes and no table of forces and velocities"
        raise FricError(what, hint="Give strokes at constant velocity too; `fric identify plant` takes a response.")
    given = None if plant is None or isinstance(plant, Plant) else document_of(PlantDocument, plant)
    known = plant_of(plant, records[0].axis, records[0].motion)
    in_time = [record for record in records if isinstance(record, Log)]
    doubtful = settled([*of_logs(in_time, known), *of_strokes(in_time)])
    asked = Asked(
        records[0].motion, known, _shape_factor(delta), direction, over_position, weights, average, form,
        load=None if load is None else in_si(load, "force", records[0].motion),
        damping_error=0.0 if given is None else given.damping_error(records[0].motion),
    )  # fmt: skip
    found = fit_static(records, asked)
    greatest = max(abs(point.force) for point in found.points)
    both = len({point.velocity > 0 for point in found.points}) == 2  # the load is then half way between their forces
    if asked.load is not None and abs(asked.load) > (2 if both else 100) * greatest:
        unit = si_unit("force", found.motion)
        what = f"a load of {asked.load:g} {unit} is far beyond the strokes' forces (at most {greatest:.3g} {unit})"
        raise FricError(what, where=records[0].source, hint="Give `load=` in its unit, as `load='60 N'`.")
    if known is not None:
        fastest = max(found.points, key=lambda point: abs(point.velocity))
        taken_off = known.damping * fastest.velocity
        share = abs(taken_off / (fastest.force + taken_off or 1e-300))
        doubtful += settled([Finding("damping", share, found.motion, records[0].source)])
    for fit in (found.static, found.negative):
        mass = known.M if known else None
        doubtful += settled(of_friction(fit.static_map, found.motion, mass, records[0].source)) if fit else []
    return StaticResult(replace(found, warnings=(*found.warnings, *doubtful)), records)


def _shape_factor(given: float | str) -> ShapeFactor:
    if given in {"free", "auto"}:
        return given  # type: ignore[return-value]
    if (value := doubles(given)) is None or not 0.1 <= value <= 4.0:
        raise FricError(f"delta '{given}' is not a shape factor", hint="Give a number from 0.1 to 4, 'free' or 'auto'.")
    return float(value)


class GMSResult(IdentifiedModel, tree=gms_tree):
    """An identified GMS model."""

    fit: GMSFit  # The fit: parameters, virgin curve, replayed records
    logs: Sequence[Log]  # The records that it was identified from
    given: FrictionDocument | None = None  # The file of the static map that it builds upon, which is carried over

    def brief(self) -> str:
        """Return the number of blocks, and C."""
        fit = self.fit
        count = len(fit.alpha.value) if isinstance(fit.alpha.value, tuple) else 1
        C = readable(float(fit.C), fit.C.unit, known_digits(float(fit.C), fit.C.limits))
        return f"{count} block{'s' * (count != 1)}, C {C}{' (assumed)' * fit.C.assumed}"

    def report(self) -> list[Piece]:
        """Return alpha, k and C, the reason for the number of blocks, and the residual of each record in replay."""
        fit = self.fit
        pieces: list[Piece] = [parameters({"alpha": fit.alpha, "k": fit.k, "C": fit.C}), fit.reason]
        pieces += [_replayed(record, si_unit("force", fit.motion)) for record in fit.records]
        if "assumed" in self.document["static"]["F_c"]:
            plateau = parameters({"F_s": self.document["static"]["F_s"]})
            return [*pieces, Table(("plateau", *plateau.columns[1:]), plateau.rows)]
        return [*pieces, f"alpha summed to {float(fit.alpha_sum):.4f} before it was normalised"]


def _replayed(record: Replay, force: str) -> str:
    text = f"{record.name}: replayed force misses by {readable(record.rmse, force)}"
    if record.rmse_held_out is not None:
        text += f", {readable(record.rmse_held_out, force)} over the cycles held out"
    if record.energy is not None:
        ((_, value, interval, unit),) = estimate_rows({"": record.energy})
        text += f"; energy lost per cycle {value} ({interval}) {unit}"
    done = record.record.done
    if done.inertia_share is not None:
        text += f"; inertia {done.inertia_share:.1%}, damping {done.damping_share:.1%} of the force"
    return text


@verb
def identify_gms(
    *logs: LogLike, static: FrictionLike | None = None,
    blocks: Annotated[int | str, Kind(metavar="N|auto|auto:N")] = "auto",
    knots: Annotated[Sequence[float] | str, Kind(str, "LIST|auto"), "small length"] = "auto",
    cycles: Annotated[tuple[int, int] | str | None, Kind(str, "FIRST:LAST")] = None, refine: bool = True,
    plant: PlantLike | None = None, encoder: EncoderName = "motor",
) -> GMSResult:  # fmt: skip
    """Identify alpha, k and C of the GMS model (eqs. 3 to 6) from pre-sliding cycles, and C from sliding.

    logs: Log files of one axis. Records of kind ``presliding-sine`` and, for C, ``sliding-sine``.
    static: Static map, from `fric identify static`; carried over. Its F_s is the unit of alpha: a `StaticMap`, its
        file, or its result. Without it the plateau of the cycles gives F_c = F_s.
    blocks: Slip blocks: N, or up to N (6) by an information criterion.
    knots: Knots of the virgin curve, as in '0.9 um, 26 um, 54 um'. Or as numbers [m]; the paper does so.
    cycles: Cycles to fit, from 1; the later ones are held out and replayed.
    refine: Refine alpha, k and C by replay along the measured motion.
    Raises FricError: When no record has whole cycles, an amplitude is under three encoder steps, or the knots do not
        suit the curve.
    """
    records = logs_of(logs, encoder)
    axis, motion = records[0].axis, records[0].motion
    kept = friction_of(static, axis, motion)
    forward, backward = (None, None) if kept is None else kept.maps()
    count, most = _blocks(blocks)
    known = plant_of(plant, axis, motion)
    doubtful = settled([*of_logs(records, known), *of_amplitudes(records)])
    if forward is not None:
        doubtful += settled(of_friction(forward, motion, known.M if known else None, where_of(static)))
        doubtful += settled(of_level(records, forward.F_s))
    at = None if knots == "auto" else several(knots, "small length", motion)
    if at is not None and blocks not in {"auto", len(at), str(len(at))}:
        raise FricError(f"{len(at)} knots give {len(at)} blocks, not {blocks}", hint="Leave `blocks=` out.")
    fit = partial(
        fit_gms, records, static=forward, negative=backward, blocks=count, knots=at, refined=refine,
        cycles=_cycles(cycles), most_blocks=most,
    )  # fmt: skip
    found = fit(plant=known)
    given = None if plant is None or isinstance(plant, Plant) else document_of(PlantDocument, plant).estimates(motion)
    unsure = given["B"].half_width / float(given["B"]) if given else 0.0
    if known and LEAST_UNSURE < unsure < inf and not found.C.assumed and any(of.record.slides for of in found.records):
        with suppress(FricError):  # no model is found at the limit
            found = _with_inertia(found, fit(plant=replace(known, B=known.B * (1.0 + unsure))))
    doubtful += settled(of_gms(found))
    return GMSResult(replace(found, warnings=(*found.warnings, *doubtful)), records, kept)


LEAST_UNSURE = 0.03  # Half the interval of B over B, above which the interval of C allows for it


def _with_inertia(fit: GMSFit, other: GMSFit) -> GMSFit:
    """Return a fit whose C allows for the interval of the plant's B, by a fit at its limit: inertia moves C."""
    moved = inf if other.C.assumed else log(float(other.C) / float(fit.C))  # at the limit nothing determines it
    low, high = fit.C.limits
    half = hypot(0.5 * log(high / low), moved) if 0.0 < low < high < inf else inf
    wider = replace(fit, C=Estimate.around_log(float(fit.C), fit.C.unit, half))
    if fit.covariance is None or "C" not in fit.covariance.names:
        return wider
    matrix, n = np.array(fit.covariance.matrix), fit.covariance.names.index("C")
    matrix[n, n] += (moved / NORMAL_97_5) ** 2 * (1.0 if fit.covariance.scales[n] == "log" else float(fit.C) ** 2)
    return replace(wider, covariance=Covariance.of(fit.covariance.names, matrix, fit.covariance.scales))


def of_gms(fit: GMSFit) -> Iterator[Finding]:
    """Yield the quantities of a fit with physical bounds: level, travel up to sliding, stiffness, inertia."""
    where = fit.hysteresis[0].record.log.where
    if fit.curve.saturates:
        yield Finding("level", float(fit.alpha_sum), fit.motion, where)
    yield Finding("slip", float(fit.model.slip_displacements.max()), fit.motion, where)
    yield Finding("stiffness", float(np.sum(fit.k.value)), fit.motion, where)
    yield from of_friction(fit.model.static, fit.motion, None, where)


def _blocks(given: int | str) -> tuple[int | None, int]:
    """Return the number of blocks, or None and the largest number that the criterion may choose."""
    word, _, most = (f"auto:{MOST_BLOCKS}" if given == "auto" else str(given)).partition(":")
    number = most if word == "auto" else str(given)
    if not number.isdigit() or not 1 <= int(number) <= 12:
        raise FricError(f"'{given}' is not a number of blocks", hint="Give 1 to 12, auto, or auto:8 for 8 at most.")
    return (None, int(number)) if word == "auto" else (int(number), MOST_BLOCKS)


def _cycles(given: tuple[int, int] | str | None) -> tuple[int, int] | None:
    if given is None:
        return None
    first, _, last = (given if isinstance(given, str) else ":".join(map(str, given))).partition(":")
    if not (first.isdigit() and last.isdigit() and 1 <= int(first) <= int(last)):
        raise FricError(f"'{given}' is not a range of cycles", hint="Write the first and the last, as in 1:5.")
    return int(first), int(last)


CLIPPED = 0.1  # Share of a record whose force may be clipped: those samples are not compared


class ModelResult(IdentifiedModel, tree=replay_tree):
    """Any friction model, identified by replay."""

    fit: ReplayFit  # What was found
    kept: FrictionDocument | None = None  # The friction file whose static map was kept

    def report(self) -> list[Piece]:
        """Return the parameters, and the residuals of a replay."""
        fit, sections = self.fit, self.sections()
        names = dict.fromkeys(("static", fit.model.name))
        text: list[Piece] = [parameters(sections[name], name) for name in names if name in sections]
        samples = sum(int(record.used.sum()) for record in fit.records)
        error = readable(fit.rmse, si_unit("force", fit.motion))
        return [*text, f"{samples} samples, rmse {error}, R² {short_of_1(fit.r2)}"]


@verb
def identify_model(
    model: Annotated[str, Kind(metavar="NAME", complete="fric.identify.replay.replay_fit:fitted_models")],
    *logs: LogLike, static: FrictionLike | None = None, plant: PlantLike | None = None, blocks: Blocks = 4,
    fix: Annotated[Iterable[str] | Mapping[str, float | str], Kind(list[str], "NAME=VALUE")] = (),
    free: Annotated[Sequence[str], Kind(list[str], "NAME")] = (), seed: Seed = 0, encoder: EncoderName = "motor",
) -> ModelResult:  # fmt: skip
    """Fit any friction model to any records by replay along the measured motion.

    model: Name of the model: lugre, dahl, gms, ….
    fix: A parameter that is not fitted: 'n=1'. Several in a list, or by name.
    free: Fit a parameter that is held by default: delta of LuGre and other models with a static map, n of Dahl.
    Raises FricError: When there is no such model or parameter, or no sample to compare.
    """
    fitted_model(model)
    records = logs_of(logs, encoder)
    axis, motion = records[0].axis, records[0].motion
    kept = friction_of(static, axis, motion)
    taken_off = plant_of(plant, axis, motion)
    doubtful = settled([*of_logs(records, taken_off), *of_amplitudes(records)])
    records, cut = without_clipped(records, CLIPPED)
    even = [evened(record) if kind_of(record) == "motion" else (record, []) for record in records]  # for its mass
    records, doubtful = [record for record, _ in even], [*doubtful, *cut, *chain(*(notices for _, notices in even))]
    if kept is not None:
        doubtful += settled(of_level(records, float(kept.estimates("static")["F_s"])))
    ready, loaded = without_loaded(prepared(records, taken_off))
    doubtful += settled(of_shares(ready))
    found = identify_by_replay(
        model, ready, static=kept.estimates("static") if kept else None, negative=kept.backward() if kept else None,
        blocks=blocks, fix=_fixed(model, fix, motion), free=free, seed=seed,
    )  # fmt: skip
    _refuse_hidden(found, records)
    static = getattr(found.model, "static", None)
    if static is not None:
        doubtful += settled(of_friction(static, motion, taken_off.M if taken_off else None, records[0].where))
    return ModelResult(replace(found, warnings=(*found.warnings, *loaded, *doubtful)), kept)


def _refuse_hidden(found: ReplayFit, records: Sequence[Log]) -> None:
    """Raise where Coulomb friction is not determined; before sliding the force that is seen bounds it from below."""
    slid = all(kind_of(record) in {"motion", "constant-velocity"} for record in records)
    for level in (estimates["F_c"] for estimates in found.estimates.values() if "F_c" in estimates):
        low, high = np.ravel(level.ci95 or (1.0, 1.0))
        if (slid and (high == inf or (low == 0.0 and high > 3.0 * float(level)))) or (low, high) == (0.0, inf):
            upper = "open" if high == inf else readable(float(high), level.unit)
            raise FricError(
                f"these records do not determine Coulomb friction: its interval is {low:g} to {upper}",
                where=records[0].where,
                hint="Log strokes in both directions at several speeds; a load that changes on the way (gravity, a "
                "spring) hides it.",
            )


def _fixed(model: str, given: Iterable[str] | Mapping[str, float | str], motion: Motion) -> dict[str, float]:
    """Return parameters given by name, or as ``NAME=VALUE``, in SI."""
    pairs = given.items() if isinstance(given, Mapping) else (text.partition("=")[::2] for text in given)
    numbers: dict[str, float] = {}
    declared = {p.name: p for parameters in models()[model].declared().values() for p in parameters}
    for name, value in pairs:
        require_known(name, declared, f"{model} has no parameter", "It has")
        if value == "":
            raise FricError(f"'{name}' is fixed at nothing", hint=f"Write its value, as in {name}=VALUE.")
        numbers[name] = in_si(value, declared[name].dimension, motion)
    return numbers
