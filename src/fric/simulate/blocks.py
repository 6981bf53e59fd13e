"""The blocks of a scheme on an axis: packed for what its controller believes, designed where no file gives them."""

from collections.abc import Mapping
from dataclasses import replace

from fric.control import ControlBlock, Setting, block_type
from fric.control.scheme import OBSERVER, Scheme
from fric.design.blocks import JointDesign, design_block, design_jointly
from fric.design.observer import PEAK_SENSITIVITY
from fric.errors import FricError
from fric.friction import FrictionModel, models
from fric.kernels.sensing import reading
from fric.reference import Reference
from fric.simulate.machine import Axis
from fric.simulate.reality.motion import sensing_of


def setting_of(axis: Axis, scheme: Scheme, reference: Reference) -> Setting:
    """Return what the blocks of a scheme are packed for on an axis that starts at rest.

    Raises FricError: When the scheme feeds friction forward that the axis' controller does not believe in.
    """
    nominal, start = axis.nominal or axis.plant, float(reference.position[0])
    return Setting(
        nominal,
        axis.cascade,
        friction=_friction(axis, scheme),
        models=axis.nominal_friction.models,
        gain=axis.nominal_friction.gain if scheme.gain is None else scheme.gain,
        lead=axis.lead(scheme.lead),
        K_f=nominal.K_f,
        reference=reference,
        position=start,
        seen=reading(start, axis.encoder.resolution, sensing_of(axis)),
        resolution=axis.encoder.resolution,
    )


def blocks_of(axis: Axis, scheme: Scheme, setting: Setting) -> list[ControlBlock]:
    """Return the blocks of a scheme on an axis, the controller first: as its files give them, or else as designed.

    Raises FricError: When the scheme asks for the inverse-model observer, and the axis has none.
    """
    found: list[ControlBlock] = []
    for name in (scheme.controller, *scheme.blocks):
        if name == OBSERVER and axis.observer is None:
            raise FricError(
                f"scheme {scheme.name} needs a disturbance observer, and axis {axis.name} has none",
                hint="Add 'observer: {cutoff: 60 Hz}' to the axis.",
            )
        own = {axis.cascade.name: axis.cascade, OBSERVER: axis.observer}.get(name)
        found.append(own or _block(name, axis.blocks.get(name, {}), setting, scheme))
    return found


def _block(name: str, values: Mapping[str, float], setting: Setting, scheme: Scheme) -> ControlBlock:
    """Return a block with values from a file, its tuned parameter as designed where they do not give it."""
    kind = block_type(name)
    if not kind.tuned or kind.tuned in values:
        return kind.from_values(values, setting)
    key = _key(kind, setting, scheme)
    if key not in _DESIGNED:
        _DESIGNED[key] = design_block(kind, setting, peak_sensitivity=scheme.peak_sensitivity or PEAK_SENSITIVITY).block
    own = {one.name: getattr(_DESIGNED[key], one.name) for one in kind.parameters}
    return kind.from_values(own | dict(values), setting)


def jointly_designed(axis: Axis, scheme: Scheme, reference: Reference) -> Axis:
    """Return the axis with the cascade and the block of a scheme that designs them together; else as it is.

    Raises FricError: When the axis' files give already what is to be designed.
    """
    if not scheme.joint:
        return axis
    (kind,) = scheme.designed
    if kind.tuned in axis.blocks.get(kind.name, {}):
        raise FricError(
            f"scheme {scheme.name} designs '{kind.name}' together with the cascade, and axis {axis.name} gives both",
            hint=f"Leave '{kind.tuned}' of the block out of the axis, or 'joint' out of the scheme.",
        )
    setting = setting_of(axis, scheme, reference)
    key = _key(kind, setting, scheme)
    if key not in _JOINT:
        _JOINT[key] = design_jointly(kind, setting, peak_sensitivity=scheme.peak_sensitivity or PEAK_SENSITIVITY)
    found = _JOINT[key]
    own = {one.name: getattr(found.block.block, one.name) for one in kind.parameters}
    return replace(axis, cascade=found.cascade, blocks={**axis.blocks, kind.name: own})


def _key(kind: type[ControlBlock], setting: Setting, scheme: Scheme) -> tuple[object, ...]:
    friction = setting.friction or setting.models.get("gms")
    return (kind, setting.plant, setting.cascade, friction, setting.K_f, scheme.peak_sensitivity)


_DESIGNED: dict[tuple[object, ...], ControlBlock] = {}
"""Blocks that were designed for what a controller believes, which many machines and schemes share."""
_JOINT: dict[tuple[object, ...], JointDesign] = {}
"""Blocks that were designed with their cascade, by the same."""


def _friction(axis: Axis, scheme: Scheme) -> FrictionModel | None:
    """Return the friction that a scheme feeds forward on an axis."""
    if scheme.friction is None:
        return None
    nominal_friction = axis.nominal_friction
    if scheme.friction not in nominal_friction.models:
        raise FricError(
            f"scheme {scheme.name} feeds '{scheme.friction}' friction forward, "
            f"and the controller of axis {axis.name} believes in {', '.join(nominal_friction.models) or 'none'}",
            hint=f"Identify it: fric identify {scheme.friction}."
            if scheme.friction in models()
            else f"There is no such model; there are {', '.join(models())}.",
        )
    return nominal_friction.models[scheme.friction]
