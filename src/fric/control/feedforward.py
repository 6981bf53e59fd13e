"""Feedforward along the reference: the inverse model of the plant, and friction."""

from functools import lru_cache

from fric.arrays import Real
from fric.drive.plant import LinearPlant
from fric.friction import FrictionModel
from fric.reference import Reference


def inverse_model(plant: LinearPlant, reference: Reference) -> Real:
    """Return the voltage ``(z̈_r + A·ż_r)/B`` that moves a plant without friction along the reference [V], (n,)."""
    return (reference.acceleration + plant.A * reference.velocity) / plant.B


def friction_feedforward(model: FrictionModel, reference: Reference, K_f: float, gain: float = 1.0) -> Real:
    """Return the voltage ``gain·F(reference)/K_f`` that compensates friction [V], shape (n,).

    K_f: Force constant [N/V].
    gain: Share of the nominal friction that is fed forward.
    """
    return gain / K_f * _along(model, reference)


@lru_cache(maxsize=8)
def _along(model: FrictionModel, reference: Reference) -> Real:
    """Return the friction force along a reference [N], (n,): the same for all machines of one controller."""
    force = model.replay(reference.time, reference.position, reference.velocity)
    force.flags.writeable = False
    return force
