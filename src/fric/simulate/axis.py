"""One axis in closed loop along a reference, and the blocks of its scheme: packed for its nominal models."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log10
from typing import Any, TypeVar

import numpy as np

from fric.arrays import Real
from fric.control import ControlBlock, Setting, block_type
from fric.control.feedforward import friction_feedforward, inverse_model
from fric.control.scheme import NONE, OBSERVER, Scheme
from fric.design.blocks import design_block, design_jointly
from fric.design.loop import SampledLoop, learned_share
from fric.design.observer import PEAK_SENSITIVITY
from fric.errors import FricError
from fric.friction import FrictionModel, models
from fric.kernels.block import Commands
from fric.kernels.loop import Block, Board, closed_loop
from fric.kernels.plant import PlantConstants, velocity_tolerance
from fric.kernels.sensing import reading
from fric.kernels.signatures import Step
from fric.process import one_blas_thread, tried
from fric.reference import Reference
from fric.simulate.machine import Axis
from fric.simulate.reality.motion import sensing_of, true_axis

Design = TypeVar("Design")
_DESIGNED: dict[tuple[object, ...], Any] = {}
GAINS = np.geomspace(0.95, 1e-3, 140)  # Gains at which a loop that is not stable is tried anew, 0.43 dB apart
EDGE = 1.0 + 1e-7  # Largest eigenvalue let pass: an axis left alone drifts at 1, and rounding decides on which side


def setting_of(axis: Axis, scheme: Scheme, reference: Reference) -> Setting:
    """Return the data that the blocks of a scheme are packed for on an axis that starts at rest."""
    nominal, start = axis.nominal or axis.plant, float(reference.position[0])
    return Setting(
        nominal, axis.cascade, friction=_friction(axis, scheme), models=axis.nominal_friction.models,
        gain=axis.nominal_friction.gain if scheme.gain is None else scheme.gain, lead=axis.lead(scheme.lead),
        K_f=nominal.K_f, reference=reference, position=start,
        seen=reading(start, axis.encoder.resolution, sensing_of(axis)), resolution=axis.encoder.resolution,
    )  # fmt: skip


def blocks_of(axis: Axis, scheme: Scheme, setting: Setting) -> list[ControlBlock]:
    """Return the blocks of a scheme on an axis, the controller first: as its files give them, or else as designed."""
    found: list[ControlBlock] = []
    for name in (scheme.controller, *scheme.blocks):
        if name == OBSERVER and axis.observer is None:
            what = f"scheme {scheme.name} needs a disturbance observer, and axis {axis.name} has none"
            raise FricError(what, hint="Add 'observer: {cutoff: 60 Hz}' to the axis.")
        standard = {axis.cascade.name: axis.cascade, OBSERVER: axis.observer}.get(name)
        found.append(standard or _block(name, axis.blocks.get(name, {}), setting, scheme))
    return found


def _block(name: str, values: Mapping[str, float], setting: Setting, scheme: Scheme) -> ControlBlock:
    """Return a block with values from a file, its tuned parameter from the design where the file does not give it."""
    if not (kind := block_type(name)).tuned or kind.tuned in values:
        return kind.from_values(values, setting)
    return kind.from_values(vars(_once(design_block, kind, setting, scheme).block) | dict(values), setting)


def jointly_designed(axis: Axis, scheme: Scheme, reference: Reference) -> Axis:
    """Return the axis with the cascade and the block of a scheme that designs them together; else unchanged."""
    if not scheme.joint:
        return axis
    (kind,) = scheme.designed
    if kind.tuned in axis.blocks.get(kind.name, {}):
        what = f"scheme {scheme.name} designs '{kind.name}' together with the cascade, and axis {axis.name} gives both"
        raise FricError(what, hint=f"Leave '{kind.tuned}' of the block out of the axis, or 'joint' out of the scheme.")
    found = _once(design_jointly, kind, setting_of(axis, scheme, reference), scheme)
    return replace(axis, cascade=found.cascade, blocks={**axis.blocks, kind.name: vars(found.block.block)})


def _once(design: Callable[..., Design], kind: type[ControlBlock], setting: Setting, scheme: Scheme) -> Design:
    """Return what a design makes for the nominal models of a controller, which many machines and schemes share."""
    friction = setting.friction or setting.models.get("gms")
    key = (design, kind, setting.plant, setting.cascade, friction, setting.K_f, scheme.peak_sensitivity)
    if key not in _DESIGNED:
        _DESIGNED[key] = design(kind, setting, peak_sensitivity=scheme.peak_sensitivity or PEAK_SENSITIVITY)
    return _DESIGNED[key]


def _friction(axis: Axis, scheme: Scheme) -> FrictionModel | None:
    if scheme.friction is None:
        return None
    nominal_friction = axis.nominal_friction
    if scheme.friction not in nominal_friction.models:
        what = f"scheme {scheme.name} feeds '{scheme.friction}' friction forward, "
        what += f"and the controller of axis {axis.name} believes in {', '.join(nominal_friction.models) or 'none'}"
        hint = f"There is no such model; there are {', '.join(models())}."
        hint = f"Identify it: fric identify {scheme.friction}." if scheme.friction in models() else hint
        raise FricError(what, hint=hint)
    return nominal_friction.models[scheme.friction]


@dataclass(frozen=True)
class Trace:
    """What a run of one axis recorded, one value a controller sample."""

    time: Real  # Sample instants [s], shape (n,)
    reference: Real  # reference, position, measured: position requested, true, and by the encoder [m], shape (n,)
    position: Real
    measured: Real
    velocity: Real  # True velocity [m/s], shape (n,)
    input: Real  # Control voltage [V], shape (n,)
    friction: Real  # True friction force [N], shape (n,)
    feedforward: Real  # Friction feedforward [V], shape (n,)
    disturbance: Real  # The observers' estimate d̂ [V], shape (n,)
    saturated: int  # Samples at which the voltage was limited
    sensed: Real | None = None  # True position of the encoder's body [m], shape (n,); None where that is `position`


@one_blas_thread()
def run_axis(
    axis: Axis, reference: Reference, scheme: Scheme = NONE, *, excitation: Real | None = None,
    against: Real | None = None, halvings: int = 0, accuracy: float = 0.0, began: float = 0.0,
) -> Trace:  # fmt: skip
    """Return the traces of one axis that starts at rest and follows a reference in closed loop.

    excitation: Voltage added to the control voltage [V], shape (n,).
    against: Voltage fed forward against friction in place of that of the scheme's model [V], shape (n,).
    halvings: How often every step of the plant is halved, to see that this changes nothing.
    accuracy: Largest error of the position by the integration of the plant [m]; 0 for the last digits.
    began: Time since the machine was switched on, for what drifts [s].
    """
    tried()
    arguments = _loop_arguments(axis, reference, scheme, excitation, accuracy, began, against)
    traces, saturated = closed_loop(*arguments, halvings, sensing_of(axis))
    if not np.isfinite(traces.position).all():
        why = f"the motion of axis {axis.name} grows beyond all numbers, or a contact is too stiff to be integrated"
        raise FricError(why, hint="Look at its values: mass, damping, and stiffness before sliding.")
    return Trace(time=reference.time, reference=reference.position, saturated=saturated, **traces._asdict())


def _loop_arguments(
    axis: Axis, reference: Reference, scheme: Scheme, excitation: Real | None = None, accuracy: float = 0.0,
    began: float = 0.0, against: Real | None = None,
) -> tuple[Step, Real, Real, PlantConstants, Board, list[Block], Commands]:  # fmt: skip
    """Check what is asked of an axis, and return it as the compiled loop reads it."""
    axis = jointly_designed(axis, scheme, reference)
    plant, cascade = axis.plant, axis.cascade
    if reference.sampling != cascade.sampling:
        other = f"the controller of axis {axis.name} at {cascade.sampling:g} Hz"
        raise FricError(f"the reference is sampled at {reference.sampling:g} Hz, {other}")
    setting = setting_of(axis, scheme, reference)
    controller, *others = blocks_of(axis, scheme, setting)
    require_stable(axis, setting, controller, others)
    step, state, parameters, constants = true_axis(axis, float(reference.position[0]), began)
    ahead = reference.ahead(setting.lead)
    model = cascade.model_share * inverse_model(setting.plant, ahead)
    tolerance = velocity_tolerance(accuracy, cascade.K_v * cascade.K_p * plant.B, cascade.T_s)
    if against is not None:
        against = np.ascontiguousarray(against, float)
    elif setting.friction is not None:
        against = friction_feedforward(setting.friction, ahead, setting.K_f, setting.gain)
    else:
        against = np.zeros(len(reference))
    return (
        step, state, parameters, constants._replace(tolerance=max(constants.tolerance, tolerance)),
        Board(cascade.T_s, cascade.limit, axis.encoder.resolution),
        [block.ready(setting) for block in (controller, *others)],
        Commands(
            reference.position, reference.velocity, reference.acceleration,
            model if excitation is None else model + excitation, against, ahead.position, ahead.velocity,
        ),
    )  # fmt: skip


def require_stable(axis: Axis, setting: Setting, controller: ControlBlock, blocks: Sequence[ControlBlock] = ()) -> None:
    """Raise a `FricError` with the gain margin where the loop of an axis, without friction, is not stable.

    A force constant that rises while the machine runs raises the gain of the loop.

    controller, blocks: The blocks of its scheme. Where one is not linear the loop has no poles, and is not judged.
    """
    inside = tuple(block for block in blocks if block.in_loop() and not block.repeats)
    if not all(block.linear for block in (controller, *inside)):
        return
    risen = max(drift.amount, 0.0) if (drift := axis.reality.force_constant) else 0.0
    plant = replace(axis.plant, B=axis.plant.B * (1.0 + risen))
    loop = SampledLoop(plant, axis.cascade, inside, controller, setting)
    if (largest := float(abs(loop.poles()[0]))) < EDGE:
        for block in (block for block in blocks if block.repeats):
            share, frequency = learned_share(block, loop, setting)
            if share >= 1.0:
                by = f"by {share:.3g} at {frequency:.4g} Hz"
                what = f"what '{block.name}' learns on axis {axis.name} grows from period to period, {by}"
                hint = "Lower its cutoff, or identify the plant again: the nominal one is not the axis' own."
                raise FricError(what, hint=hint)
        return
    parts = ["its observer"] if any(block.kind == "observer" for block in blocks) else []
    parts += [f"{risen:.0%} more force per volt"] if risen else []
    part = f"with {' and '.join(parts)} " if parts else ""
    gain = next((gain for gain in GAINS if replace(loop, plant=replace(plant, B=plant.B * gain)).stable), None)
    margin = f"its gain margin is {20 * log10(gain):.1f} dB" if gain else "no gain makes it so"
    what = f"the loop of axis {axis.name} {part}is not stable: {margin} (largest eigenvalue {largest:.4f} a sample)"
    hint = "Lower the gains or the observer's cutoff; fric design finds values that hold."
    if not gain and (bandwidth := axis.cascade.K_p * plant.B) < axis.cascade.K_v:
        hint = f"K_p·B is {bandwidth:.3g} 1/s, and K_v larger: is the force logged as the input, or a unit wrong?"
    raise FricError(what, hint=hint)
