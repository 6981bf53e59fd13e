"""The derivatives of a force by its blocks, from few replays: GMS blocks lie side by side, and none feels another.

The load F_i of a block depends on its own alpha_i and k_i, on C and on the level s(v). Two blocks of half the share and
stiffness bear as much as one, and in another unit of force it is the same block: F_i is homogeneous twice (Euler),

``F_i = alpha_i·∂F_i/∂alpha_i + k_i·∂F_i/∂k_i`` and ``s·∂F_i/∂s = alpha_i·∂F_i/∂alpha_i - C·∂F_i/∂C``.

So one replay with each block put in again, a little softer, and one with another C tell the derivatives over all.
"""

from dataclasses import replace

import numpy as np

from fric.arrays import Real
from fric.friction import FrictionModel
from fric.friction.directed import Directed
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.replay.coordinates import LEVEL, Coordinates
from fric.kernels.replay import replay_loads
from fric.records.prepared import Prepared

STEP = 1e-4
"""Step of the difference quotients, in the logarithm of alpha or k."""


def block_slopes(coordinates: Coordinates, x: Real, record: Prepared, *, both: bool) -> dict[int, Real]:
    """Return the derivatives of a replayed force [N], shape (n,), over the coordinates of blocks, by their number.

    coordinates: The coordinates; only the GMS model has slopes, any other gives an empty mapping.
    x: Values of the coordinates, shape (p,).
    record: What is replayed.
    both: Whether by central differences; else by backward ones.
    """
    if coordinates.model is not GMS:
        return {}
    model = coordinates.build(x)
    one = model.model if isinstance(model, Directed) else model
    assert isinstance(one, GMS)
    alpha, k, C = np.array(one.alpha), np.array(one.k), one.C
    factors = np.exp([-STEP, STEP] if both else [-STEP])
    loads = side_by_side(model, np.tile(alpha, (len(factors) + 1, 1)), np.outer([1.0, *factors], k), C, record)
    here = loads[:, 0]

    def slope(moved: list[Real]) -> Real:
        return (moved[1] - moved[0]) / (2 * STEP) if both else (here - moved[0]) / STEP

    by_k = slope([loads[:, n] for n in range(1, loads.shape[1])])
    by_alpha, by_C = here - by_k, np.zeros(len(here))
    if any(c.block is None for c in coordinates.free):
        by_C = slope([side_by_side(model, alpha[None], k[None], C * factor, record)[:, 0] for factor in factors]).sum(
            axis=1
        )
    found: dict[int, Real] = {}
    for n, c in enumerate(coordinates.free):
        if c.parameter is LEVEL:
            found[n] = by_alpha.sum(axis=1) - by_C
        elif c.section != GMS.name:
            continue
        elif c.block is None:
            found[n] = by_C / (1.0 if c.scale == "log" else C)
        elif c.scale == "share":
            found[n] = by_alpha[:, c.block] - alpha[c.block] * by_alpha.sum(axis=1)
        else:
            found[n] = by_k[:, c.block] / (1.0 if c.scale == "log" else k[c.block])
    return found


def side_by_side(model: FrictionModel, alpha: Real, k: Real, C: float, record: Prepared) -> Real:
    """Return the loads [N], shape (n, m, blocks), of blocks at the level of a GMS model, of any shares and stiffnesses.

    All of them lie side by side in one model. Its shares sum to 1: they are divided by their sum, and the level and C
    multiplied by it.

    model: The GMS model, on a guideway or not.
    alpha, k: Shares [1] and stiffnesses [N/m], shape (m, blocks).
    C: Attraction parameter [N/s].
    record: What is replayed.
    """
    total, motion = float(alpha.sum()), record.motion

    def wide(one: FrictionModel) -> FrictionModel:
        if isinstance(one, Directed):
            return Directed(wide(one.model), times(one.negative, total))
        assert isinstance(one, GMS)
        return GMS(times(one.static, total), tuple(alpha.ravel() / total), tuple(k.ravel()), C * total)

    moved = wide(model)
    z, v, t = (np.ascontiguousarray(one, float) for one in (motion.position, motion.velocity, motion.time))
    loads = replay_loads(type(moved).step, z, v, t, moved.initial_state(), moved.packed(), k.size)
    return loads.reshape(-1, *k.shape)


def times(static: StaticMap, factor: float) -> StaticMap:
    """Return a static map whose level is so many times as high; what is viscous enters no block."""
    return replace(static, F_c=factor * static.F_c, F_s=factor * static.F_s)
