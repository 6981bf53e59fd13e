"""Selection of the exported part of a machine: one axis under one scheme, as a `Part`."""

from dataclasses import replace

import numpy as np

from fric.arrays import Real
from fric.control.base import ControlBlock, Setting
from fric.control.scheme import Scheme
from fric.errors import FricError
from fric.export.base import BlockPart, Part
from fric.export.rendering import remark
from fric.friction.stribeck import StaticMap
from fric.reference import Reference
from fric.simulate.axis import blocks_of, setting_of
from fric.simulate.machine import Machine


def compensation_of(machine: Machine, name: str, scheme: Scheme) -> Part:
    """Return the controller of an axis under a scheme, with its nominal models.

    Raises FricError: When the scheme needs something that the axis does not have, or there is no such axis.
    """
    axis = machine.axis(name)
    if scheme.joint:
        raise FricError(
            f"scheme {scheme.name} designs the cascade of axis {name} anew, and a cascade is not exported",
            hint="Take the gains of 'fric design block --joint' into the machine file, and 'joint' out of the scheme.",
        )
    rest = Reference(axis.cascade.sampling, *np.zeros((3, 1)))
    setting = setting_of(axis, scheme, rest)
    controller, *others = blocks_of(axis, scheme, setting)
    if controller.name != axis.cascade.name:
        raise FricError(
            f"scheme {scheme.name} puts '{controller.name}' in place of the controller, and fric exports what is added "
            "to a controller",
            hint="Choose a scheme whose controller is the cascade.",
        )
    nominal, cascade = axis.nominal or axis.plant, axis.cascade
    friction = setting.friction
    if friction is None and others:
        friction = StaticMap(F_c=0.0, F_s=0.0, v_s=1.0)  # nothing is fed forward; the blocks are
    return Part(
        "compensation", machine.name, name, axis.motion, remark(scheme.name), friction, nominal.K_f, nominal.A,
        nominal.B, cascade.sampling, cascade.limit, axis.encoder.resolution, setting.gain, setting.lead,
        K_p=cascade.K_p, K_i=cascade.K_i, blocks=tuple(_block(block, setting) for block in others),
    )  # fmt: skip


def machine_of(machine: Machine, name: str) -> Part:
    """Return an axis with its true friction, as a plant to try a controller on."""
    axis = machine.axis(name)
    plant, cascade = axis.plant, axis.cascade
    return Part(
        "machine", machine.name, name, axis.motion, "", axis.friction, plant.K_f, plant.A, plant.B, cascade.sampling,
        cascade.limit, axis.encoder.resolution, delay=plant.transport_delay(cascade.sampling), load=axis.load,
        velocity_filter=cascade.velocity_filter,
    )  # fmt: skip


def _block(block: ControlBlock, setting: Setting) -> BlockPart:
    def at(position: float, seen: float) -> Real:
        return block.initial_state(replace(setting, position=position, seen=seen))

    rest = at(0.0, 0.0)
    return BlockPart(
        block.name, block.kind, type(block).step, block.packed(setting), rest, at(1.0, 0.0) - rest, at(0.0, 1.0) - rest
    )
