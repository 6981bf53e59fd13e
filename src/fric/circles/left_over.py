"""What a measured circle shows of friction beside a machine's model: every drawn machine is made to agree with it.

The balance of voltages along the measured motion leaves a force, whatever the parameters of the model are. Told over
the travel since the last reversal it is part of the machine: a level that has changed, the friction at the reversals of
this very circle, cogging, directions that differ. What then differs from machine to machine is how friction changes
from the motion that was measured to that of another scheme.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp
from zlib import crc32

import numpy as np

from fric.arrays import Real
from fric.circles.measured import MeasuredCircle
from fric.circles.stated import stated_voltage
from fric.circles.voltage import VoltageRecord, refined, voltage_record
from fric.estimate import as_filed
from fric.friction import FrictionModel
from fric.friction.completed import Completed, since_reversal, travels
from fric.simulate.machine import Axis, Machine

SHARE = 0.2
"""Share of what is left over, 95 %, by which another motion may meet more or less of it."""


@dataclass(frozen=True)
class LeftOver:
    """Measured circles, to which machines are completed."""

    records: Mapping[str, tuple[VoltageRecord, ...]]  # By axis, the circles as balances of voltages
    tests: tuple[MeasuredCircle, ...]  # The circle tests
    seed: int = 0  # Of by how much another motion meets more or less of what is left over

    @classmethod
    def of(cls, tests: Sequence[MeasuredCircle], machine: Machine, axes: Sequence[str], seed: int = 0) -> LeftOver:
        """Return what circle tests hold of some axes of a machine, with reference and position of each.

        Where the voltage was not recorded, and no compensation was on, it is what the machine's controller gives along
        the recorded motion.

        Raises FricError: When a test lacks a channel.
        """
        records = {
            name: tuple(voltage_record(_with_voltage(test, machine.axes[name]), name) for test in tests)
            for name in axes
        }
        return cls(records, tuple(tests), seed)

    def __call__(self, machine: Machine, index: int | None = None) -> Machine:
        """Return a machine completed by what its model leaves over of the circles.

        machine: The machine: its plants and friction as they were identified, or drawn.
        index: Its number among those drawn, each of which meets another share of what is left over; exactly as much as
            was measured where it is not given.
        """
        axes = {
            name: replace(machine.axes[name], friction=self._completed(machine.axes[name], index))
            for name in self.records
        }
        return replace(machine, axes={**machine.axes, **axes})

    def _completed(self, axis: Axis, index: int | None) -> Completed:
        share = 1.0
        if index is not None:
            key = np.random.SeedSequence(self.seed, spawn_key=(index, crc32(f"left over {axis.name}".encode())))
            share = exp(SHARE / 1.96 * np.random.default_rng(key).standard_normal())
        return completed(axis.friction, [_left(record, axis) for record in self.records[axis.name]], share)


def completed(friction: FrictionModel, left: Sequence[tuple[VoltageRecord, Real]], share: float = 1.0) -> Completed:
    """Return a friction model with the mean of what it leaves of records, over the travel since the last reversal.

    friction: The model.
    left: Records, each with the force that the model leaves of it at the samples used [N].
    share: Share of it that is taken.
    """
    grid = travels(2 * max(record.radius for record, _ in left))
    sums, counts = np.zeros((2, len(grid))), np.zeros((2, len(grid)))
    for record, force in left:
        whole = record.revolution[record.used] >= 0
        motion = np.array(since_reversal(record.position))[:, record.used]
        _gather(motion[:, whole], force[whole], grid, sums, counts)
    forwards, backwards = (share * _filled(grid, *one) for one in zip(sums, counts, strict=True))
    return as_filed(Completed(friction, tuple(forwards), tuple(backwards)))


def _with_voltage(test: MeasuredCircle, axis: Axis) -> MeasuredCircle:
    trace = test.axes.get(axis.name)
    if trace is None or trace.input is not None or trace.reference is None or test.scheme not in ("", "a"):
        return test
    rate = (len(trace.time) - 1) / float(trace.time[-1] - trace.time[0])
    given, *_ = stated_voltage(
        axis.cascade, axis.nominal or axis.plant, trace.reference, trace.position, rate, ahead=True
    )
    return replace(test, axes={**test.axes, axis.name: replace(trace, input=given)})


def _left(record: VoltageRecord, axis: Axis) -> tuple[VoltageRecord, Real]:
    """Return a record along its refined motion, and the force that a machine leaves of it [N], at the samples used."""
    plant = axis.plant
    m, a = 1.0 / plant.B, plant.A / plant.B
    own = refined(record, axis.friction, plant.T_d, (m, a, axis.constant_load / plant.K_f), plant.K_f)
    used = own.used
    voltage = own.delayed(plant.T_d) - m * own.inertia[used] - a * own.damping[used]
    return own, plant.K_f * voltage - own.friction(axis.friction) - axis.constant_load


def _gather(motion: Real, force: Real, grid: Real, sums: Real, counts: Real) -> None:
    """Add forces to their nearest travels, row 0 forwards and row 1 backwards."""
    direction, travel = motion
    nearest = np.searchsorted(0.5 * (grid[1:] + grid[:-1]), travel)
    for row, sign in enumerate((1.0, -1.0)):
        own = direction == sign
        sums[row] += np.bincount(nearest[own], force[own], len(grid))
        counts[row] += np.bincount(nearest[own], minlength=len(grid))


def _filled(grid: Real, sums: Real, counts: Real) -> Real:
    """Return means, and between their travels what time tells: near a reversal of a circle it goes with the root."""
    met = counts > 0
    if not met.any():
        return np.zeros(len(grid))
    return np.interp(np.sqrt(grid), np.sqrt(grid[met]), sums[met] / counts[met])
