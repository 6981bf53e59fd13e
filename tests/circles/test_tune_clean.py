"""Machines that a simulator without code of fric gives circles of: nothing is wrong with them, and all are tuned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fric.circles.measured import AxisTrace, MeasuredCircle
from fric.circles.tune import tune
from fric.control.cascade import Cascade
from fric.control.inverse_model import DisturbanceObserver, QFilter
from fric.drive.plant import Plant
from fric.drive.sensing import Encoder
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.simulate.machine import Axis, Machine, NominalFriction
from tests.circles.plain_machine import Belief, PlainAxis, circle, drawn, glitch

FEEDS = (0.1, 0.01)


def as_axis(name: str, plain: PlainAxis) -> Axis:
    """What a machine file says of a plain axis: its controller, and what that believes."""
    told, f = plain.believed, plain.believed.friction
    blocks = (len(f) - 6) // 2
    gms = GMS(StaticMap(*f[:5]), tuple(f[6 : 6 + blocks]), tuple(f[6 + blocks :]), f[5])
    plant = Plant(told.A, told.B, told.T_d, told.K_f)
    cascade = Cascade(plain.K_v, plain.K_p, plain.K_i, plain.velocity_filter, 4000.0, 10.0)
    observer = DisturbanceObserver(QFilter("binomial2", plain.observer), told.A, told.B) if plain.observer else None
    believed = NominalFriction({"gms": gms, "static": gms.static}, told.gain, told.lead)
    return Axis(name, plant, cascade, gms, 0.0, believed, plant, observer, Encoder(plain.count))


def believing(plain: PlainAxis, axis: Axis) -> PlainAxis:
    """The plain axis, whose controller believes what that of a tuned axis does."""
    gms, nominal = axis.nominal_friction.models["gms"], axis.nominal
    s = gms.static
    friction = np.array([s.F_c, s.F_s, s.v_s, s.delta, s.sigma, gms.C, *gms.alpha, *gms.k])
    told = Belief(nominal.A, nominal.B, nominal.K_f, nominal.T_d, friction, axis.nominal_friction.gain, nominal.T_d)
    return replace(plain, believed=told)


def ran(axes: tuple[PlainAxis, PlainAxis], radius: float, feed: float, place: float = 0.0):
    return [
        circle(axis, quarter, radius, feed, place=(n * place) % 1.0)
        for n, (axis, quarter) in enumerate(zip(axes, (0.0, np.pi / 2), strict=True), 1)
    ]


def left(axes: tuple[PlainAxis, PlainAxis], radius: float, feed: float, place: float = 0.0) -> float:
    x, y = ran(axes, radius, feed, place)
    return glitch(x["true"], y["true"], radius, feed)


def tuned(seed: int):
    """Tune a clean machine from a fast and a slow circle; return what was found, its axes and the radius."""
    rng = np.random.default_rng(seed)
    first = drawn(rng)
    second = replace(drawn(rng), count=first.count, observer=first.observer)
    axes, radius = (first, second), float(rng.uniform(0.012, 0.03))
    if seed % 2:  # all that is wrong is that nothing is fed ahead: at 10 mm/s little is left
        axes = tuple(replace(axis, believed=replace(axis.believed, gain=1.0)) for axis in axes)
    machine = Machine("clean", {name: as_axis(name, axis) for name, axis in zip("xy", axes, strict=True)})
    tests = []
    for feed in FEEDS:
        traces = {
            name: AxisTrace(one["time"], one["position"], one["reference"], one["input"])
            for name, one in zip("xy", ran(axes, radius, feed), strict=True)
        }
        tests.append(MeasuredCircle(radius, feed, 1, traces, scheme="f" if first.observer else "c"))
    return tune(machine, tests), axes, radius


def better(found, axes, radius: float, feeds=FEEDS) -> list[tuple[float, float]]:
    """Return by feed what the plain machine leaves before and after, medians over three places [m]."""
    after = tuple(believing(axis, found.machine.axes[name]) for name, axis in zip("xy", axes, strict=True))
    return [
        tuple(float(np.median([left(which, radius, feed, n / 3) for n in range(3)])) for which in (axes, after))
        for feed in feeds
    ]


@pytest.mark.long(9)
def test_a_clean_machine_is_tuned():
    found, axes, radius = tuned(2)
    assert "tuning-refused" not in {warning.code for warning in found.warnings}
    assert all(one.improves for one in found.axes.values())
    ((before, after),) = better(found, axes, radius, FEEDS[:1])
    assert after < 0.3 * before


@pytest.mark.long(200)
def test_no_clean_machine_is_refused():
    """Of 20 machines, half of which leave little at 10 mm/s before they are tuned; their law is that of the model."""
    refused, helped, others = [], [], []
    for seed in range(20):
        found, axes, radius = tuned(seed)
        codes = {warning.code for warning in found.warnings}
        refused += [seed] if "tuning-refused" in codes else []
        others += [seed] if "law-differs" in codes else []
        (fast, fast_after), (slow, slow_after) = better(found, axes, radius)
        helped.append(fast_after < fast and slow_after < max(1.5 * slow, axes[0].count))
    assert not refused
    assert len(others) <= 1
    assert sum(helped) >= 18
