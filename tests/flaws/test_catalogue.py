"""Each flaw of the catalogue is found at 1.5 times its threshold, and not at 0.67 times it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from string import Formatter
from tempfile import TemporaryDirectory
from types import SimpleNamespace as N
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

import fric
from fric import verdict
from fric.circles import diagnose, gains, revolutions, tune, tune_fit
from fric.circles.measured import AxisTrace, MeasuredCircle
from fric.control.scheme import PAPER_SCHEMES, Scheme
from fric.design import observer
from fric.documents.mapping import MappingDocument
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws import CATALOGUE, entry
from fric.flaws.base import HALF_WIDTHS, SMALL, by_size
from fric.flaws.drift import RECORDS_VARY
from fric.flaws.files import GAINS_DESIGNED
from fric.flaws.response import FALSE, RESPONSE_MISFIT, UNSURE
from fric.flaws.static_map import FORCE_OVER_POSITION, FRICTION_OVER_POSITION
from fric.flaws.unit import BOUNDS, UNUSUAL
from fric.identify.gms import identify as gms
from fric.identify.plant import identify as plant_fit
from fric.identify.plant.frequency_response import measure_response
from fric.identify.plant.identify import described
from fric.identify.replay.replay_fit import Solved
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import RISES, Asked, Strokes, table_points
from fric.io import roles
from fric.io.pairs import TOGETHER, with_joined
from fric.io.propose import Guess, Guessed
from fric.io.readers import tables
from fric.io.readers.base import Column, Memory
from fric.log import ForceVelocity, FrequencyResponse, Log
from fric.notice import Notice
from fric.plausibility import Finding, lifted, settled
from fric.records import flaws, holding, inspection, modes, resolution
from fric.simulate.contour_run import Chance, run_warnings
from fric.verdict import Candidate, Evidence
from tests.io.readers.test_optimize import WHOLE as LOOP

Show = Callable[[float], Iterable[Notice | None]]
"""Gives the notices of a record whose flaw is so many times its threshold."""
RNG = np.random.default_rng(0)
USUAL = {"friction": 0.5, "speed": 5e-4, "sampling": 3.0}


def implausible(name: str, size: float) -> list[Notice]:
    with lifted():
        return settled([Finding(name, size * BOUNDS[name].linear[1], "linear")])


def energies(change: float = 0.0, off: float = 0.0) -> list[Notice]:
    found = 1.0 + change * np.linspace(-0.5, 0.5, 20)
    found[5:8] += off
    return inspection.energy_warnings(found, np.arange(21.0), "linear")


def of_force(values: np.ndarray, **more: np.ndarray) -> Log:
    return Log(time=np.arange(len(values)) / 1e3, position=np.linspace(0.0, 1.0, len(values)), force=values, **more)


def forces(values: np.ndarray, purpose: flaws.Purpose = "static", **more: np.ndarray) -> list[Notice]:
    log = of_force(values, **more)
    return [*flaws.record_flaws([log], purpose), *flaws._coarse_force([log])]


def cut(size: float) -> np.ndarray:
    wave = np.sin(np.linspace(0.0, 20.0, 400)) * np.linspace(1.0, 0.9, 400)
    top = np.argsort(wave)[-round(size * resolution.STUCK) :]
    wave[top.min() : top.min() + round(size * resolution.STUCK)] = wave.max()
    return wave


def uneven(size: float) -> list[Notice]:
    time = np.arange(100) * 1e-3
    time[40] += size * flaws.JITTER / 100 * 1e-3
    return flaws.evened(Log(time=time, position=np.arange(100.0)))[1]


def coarse(size: float) -> list[Notice]:
    z = np.tile([0.0, 2.0 * inspection.STEPS / size], 6)
    record = N(motion=N(position=z, step=1.0), reversals=np.arange(len(z)), slides=False, log=N(name="a"))
    return inspection.too_coarse([record])


def two_modes(size: float) -> list[Notice | None]:
    t = np.arange(12_000) / 500.0
    reference, since = 1e-3 * np.sin(np.pi * t), (t + 0.5) % 1.0  # since a reversal
    bump = np.sign(np.cos(np.pi * t)) * np.exp(-(((since - 0.02) / 0.01) ** 2))
    behind = 20e-6 * np.where(t < 12.2, modes.ERRORS_APART**size, 1.0) * bump + 1e-8 * RNG.standard_normal(len(t))
    return [modes.switched(Log(t, reference - behind, reference=reference))]


def held(size: float) -> list[Notice | None]:
    z = np.concatenate([np.arange(20.0), np.arange(20.0)[::-1] + holding.SAME * size])
    time = np.cumsum(1.0 + RNG.uniform(0.0, 2.0, 40))
    return [holding.holds(Log(time, z, force=np.repeat([1.0, -1.0], 20) + 0.1 * RNG.standard_normal(40)))]


def two_encoders(size: float) -> list[Notice | None]:
    z = np.sin(np.arange(400.0) / 20.0)
    return [flaws.two_encoders(Log(np.arange(400.0), z, load_position=0.9 * z if is_so(size) else None))]


def dead(size: float) -> list[Notice | None]:
    u = RNG.uniform(-1.0, 1.0, 8192)
    zone = size * plant_fit.DEAD * np.sqrt(np.mean(u**2))
    force = 80.0 * np.sign(u) * np.maximum(np.abs(u) - zone, 0.0)
    log = Log(time=np.arange(len(u)) / 1e3, position=u, input=u, force=force)
    return [plant_fit._dead_zone(log, 0.0, 0.0)]


def mass(size: float) -> list[Notice]:
    known = {"K_f": Estimate.around(100.0, "N/V", 0.0), "B": Estimate.around(10.0, "m/(s²V)", 0.0)}
    return plant_fit.against_mass(known, 10.0 / (1.0 + size * plant_fit.DIFFERS), "linear")


def response(size: float = 0.5, **more: object) -> list[Notice]:
    """Give the warnings of a fit of eq. (1) in which nothing is amiss but what is given."""
    given = {"misfit": 0.0, "stand_off": (), "A": 2.0, "T_d": 1e-3, "K_f": True, "mode": None, "friction": {}} | more
    f = np.array([1.0, 100.0])
    table = N(name="a", frequency=f)
    measured = N(table=table, warnings=(), response=np.ones(2, complex))
    used = np.ones(2, bool)
    fit = N(
        measured=measured, used=used, stand_off=given["stand_off"], solution=N(misfit=given["misfit"]),
        model=lambda f: np.array([1.0, 0.9]),
    )  # fmt: skip
    solution = N(form=N(resonance=lambda values: given["mode"]), values=None, half_widths=lambda: [1.0])
    usual = {"gains": np.zeros(1), "differs": False, "coulomb": None, "compared": True, "seen": np.ones(2)}
    estimates = {"A": Estimate(given["A"], "1/s"), "B": Estimate(2.0, "m/(s²V)"), "T_d": Estimate(given["T_d"], "s")}
    estimates |= {"K_f": Estimate(1.0, "N/V")} if given["K_f"] else {}
    return list(described([fit], solution, N(**usual | given["friction"]), estimates, 1000.0))


def rigid(hidden: float = 0.0, F_c: float = 1.0, half: float = 0.1, **more: object) -> list[Notice]:
    record = N(used=np.arange(1000) >= round(1000 * hidden), log=N(motion="linear"))
    given = {"K_f": Estimate(1.0, "N/V"), "assumed": False} | more
    estimates = {"M": Estimate.around(1.0, "kg", half), "F_c": Estimate(F_c, "N")}
    return list(plant_fit._warnings([record], 0, estimates, **given))


def hysteresis(**more: object) -> list[Notice]:
    """Give the warnings of a GMS fit in which nothing is amiss but what is given."""
    given = {
        "static_given": True, "asked": None, "first": 1.0, "share": 0.0, "assumed": False, "level": 1.0,
        "mismatch": 0.0, "hollow": 0.0, "cycles": 5, "saturates": True, "plant": True,
        "loaded": False,
    } | more  # fmt: skip
    record = N(log=N(name="a"), motion=N(step=1e-6), done=N(inertia_share=given["share"]))

    class Rate(float):
        assumed = given["assumed"]

    curve = N(
        saturates=given["saturates"], mismatch=given["mismatch"], mismatch_half=0.0, hollow=(1e-5, given["hollow"]),
        cycles=[0] * given["cycles"], displacement=np.array([0.0, 1e-5]), force=np.array([0.0, 50.0]),
    )  # fmt: skip
    fit = N(
        motion="linear", static_given=given["static_given"], static=N(F_s=100.0), curve=curve, asked=given["asked"],
        blocks=[N(), N()], reason="the data show two.",
        hysteresis=[N(record=record, loaded=given["loaded"])],
        model=N(slip_displacements=np.array([given["first"] * 4e-6, 1.0])), C=Rate(1e4), refined=True,
        alpha_sum=Estimate(given["level"], "1"), records=[],
    )  # fmt: skip
    return list(gms.notices_of(fit, sliding_logged=True, plant_given=given["plant"]))


def leaves(name: str, glitch: float, *drawn: float, oscillation: float = 0.0) -> Candidate:
    return Candidate(
        scheme=PAPER_SCHEMES[name], glitches=(glitch,) * 4, glitch=glitch, drawn=drawn, oscillation=oscillation
    )


def distrust(**more: object) -> list[Notice]:
    drawn = (leaves("a", 9e-6, *[9e-6] * 30), leaves("f", 3e-6, *[3e-6] * 30))
    return list(verdict.distrust(Evidence(**{"candidates": drawn, "compared": True} | more)))


def against(glitch: float = 3e-6, **more: object) -> list[Notice]:
    one, other = leaves("f", glitch, *more.pop("drawn", ()), **more), leaves("a", 9e-6)
    return verdict.reasons_against(one, Evidence(candidates=(other, one), resolution=0.1e-6))


def decided(*bare: float) -> list[Notice]:
    return list(verdict.decide(Evidence(candidates=(leaves("a", *bare),), compared=True)).why)


def measured(size: float) -> list[Notice]:
    given = Evidence(
        candidates=(leaves("a", 9e-6), leaves("f", 3e-6)), tolerance=5e-6, measured={"f": 5e-6 * size}, compared=True
    )
    return list(verdict.decide(given).why)


def next_circles(size: float) -> list[Notice]:
    glitch = size * tune.DIFFERS * 1e-6
    other = tune._exceeds(Chance((glitch,) * 5), Chance((1e-6,) * 5))
    one = N(glitch=glitch, alone=1e-6, scheme="f", feed=0.1, ci95=(glitch, glitch), other_law=other)
    return tune.law_warnings([one])


def tuned(feeds: tuple[float, ...] = (0.01, 0.1), x: float = 0.0, rms: float = 1.0, **more: bool) -> list[Notice]:
    """Give what circles at these feeds leave open of a tuned axis."""
    names = ["side" if more.get("side") else "level"]
    coordinates = N(sides=lambda x: 0.05, names=names, bounds=np.ones(1), T_d=1e-3)
    found = N(noise=lambda: 1.0, rms=rms, x=np.array([x]), balance=N(coordinates=coordinates))
    tests = [N(feed=feed) for feed in feeds]
    as_noise = patch.object(tune_fit, "explained", lambda _: 1.0)
    with patch.object(tune_fit, "_drifts", lambda *_: ()), as_noise:
        return list(tune_fit.identifiability_warnings(N(name="x", motion="linear"), tests, found))


def timed(size: float) -> list[Notice]:
    T_d = Estimate.around(1e-3 * (1.0 + size * tune_fit.LATE), "s", 1e-6)
    found = N(balance=N(coordinates=N(T_d=1e-3)))
    return list(tune_fit.timing_warnings(N(name="x"), found, T_d))


def near_an_end(size: float, scale: str, seen: bool = True) -> list[Notice]:
    """Give what is said of a parameter that ends so near to an end of its search, 0 where it has a bound, and 1."""
    near = 1e-6 / size
    parameter = N(label="sigma", lower=0.0, upper=1.0, scale=scale, block=None, parameter=N(lower=0.0, at_least=None))
    coordinates = N(free=[parameter], lower=np.zeros(1), upper=np.ones(1))
    x = near if scale == "linear" else 1.0 - near if seen else 0.5
    return list(Solved(coordinates, np.array([x]), np.array([seen]), np.zeros((1, 1)), 2.0).edges())


def shaped(size: float) -> list[Notice]:
    learned = Scheme(tune.LEARNED, tune.LEARNED, friction=tune.LEARNED)
    return tune.wrong_shape([(learned, tune.CLEARLY * 1e-6 / size), (PAPER_SCHEMES["c"], 1e-6)])


def perturbation(first: float = 1.0, last: float = 1e3, radius: float = 1.0) -> tuple[Notice, ...]:
    return observer._warnings(
        N(measured=True, frequency=np.array([first, last]), radius=np.full(2, radius)), N(bandwidth=10.0)
    )


def table(velocity: np.ndarray) -> Iterable[Notice]:
    return inspection.inspect_table(
        ForceVelocity(velocity=velocity, force=velocity, name="a", axis="x", motion="linear", source="a.csv")
    ).warnings


def one_circle(radius: float = 0.03, encoder: str = "table", seen: float = 1e-5, runs: bool = True) -> list[Notice]:
    """Give why no prediction of a circle of 30 mm is trusted, by one that was measured."""

    def run(*_: object) -> N:
        if not runs:
            raise FricError("axis x saturates")
        return N(glitches=[N(median=1e-5)] * 4)

    test = N(
        names=("x",), instrument="encoders", radius=radius, feed=0.1, scheme="a", direction="ccw", where="a.h5",
        is_ball_bar=False,
    )  # fmt: skip
    machine = N(axes={"x": N(second_mass=N(encoder=encoder))})
    with patch.multiple(tune, run_circle=run, measured_quadrants=lambda _: (seen,) * 4):
        return list(tune._of_circles(machine, [test], (), N(feed=0.1, radius=0.03)))


def taken_apart(both: bool = True, **more: object) -> Iterable[Notice]:
    """Give what measured circles leave open."""
    given = {"instrument": "grid", "backlash": 0.0, "revolutions": 2, "angle": 0.1} | more
    test = N(names=("x",), instrument=given["instrument"], is_ball_bar=given["instrument"] == "ball-bar")
    zero = Estimate.around(0.0, "m", 1e-7)
    geometry = {"mismatch": zero, "backlash.x": Estimate.around(given["backlash"], "m", 1e-6)}
    circles = [N(count=given["revolutions"], errors={}, test=test)] * (1 + both)
    return diagnose.identifiability_warnings(circles, geometry, [{"+x": given["angle"]}])


def kicked_circle(size: float) -> list[Notice]:
    """Return a circle that is 10 um outside behind its reversals, and before that inside."""
    t = np.arange(20_000) / 4e3
    theta = 0.1 / 0.03 * t + 0.7
    since = ((theta + np.pi / 4) % (np.pi / 2) - np.pi / 4) * 0.3  # [s]
    shape = 10e-6 * np.exp(-(((since - 0.06) / 0.02) ** 2))
    shape -= size * revolutions.KICK * 10e-6 * np.exp(-(((since - 0.01) / 0.003) ** 2))
    x, y = (0.03 + shape) * np.cos(theta), (0.03 + shape) * np.sin(theta)
    traces = {"x": AxisTrace(t, x), "y": AxisTrace(t, y)}
    return list(diagnose.diagnose([MeasuredCircle(0.03, 0.1, 1, traces, instrument="grid")]).warnings)


def is_so(size: float) -> bool:
    """Of what is there or not, without a size."""
    return size > 1


def guess(size: float) -> Guessed:
    """Return what is guessed of a log whose force is so far from being sure."""
    sure = 1.0 - size * (1.0 - roles.SURE)
    chosen = {
        channel: roles.Role(channel, n, unit, sure if channel == "force" else 1.0, 1.0, "")
        for n, (channel, unit) in enumerate((("time", "s"), ("position", "m"), ("force", "N")))
    }
    table = Memory(Path("log.csv"), tuple(map(Column, "abc")), [])
    return Guessed((Guess((table.path,), table, roles.AxisColumns("x", "linear", 1.0, chosen), named=False),))


def resting(off: float) -> Log:
    """Return a motion behind a rest for which the drive is off [s]."""
    t = np.arange(2000) / 1e3
    moves = np.maximum(t - off, 0.0)
    force = np.where(moves > 0.0, 10.0 + RNG.normal(size=len(t)), 0.0)
    return Log(time=t, position=moves, force=force, name="a")


def of_voltage(scale: float) -> list[Notice]:
    """Return the flaws of a sine whose force is so many times 100 N/V times its voltage."""
    u = 0.5 * np.sin(np.arange(4000) / 300.0)
    log = Log(time=np.arange(4000) / 1e3, position=1e-5 * u, input=u, force=100.0 * scale * u + RNG.normal(size=4000))
    return flaws.record_flaws([log], "gms", Plant(1.0, 2.0, 1e-3, 100.0))


def test_where_all_records_agree_the_response_that_gave_K_f_is_of_another_scale() -> None:
    """Fifteen records were blamed for the voltage of one."""
    u = 0.5 * np.sin(np.arange(4000) / 300.0)
    noise = iter(RNG.normal(size=(3, 4000)))
    logs = [Log(np.arange(4000) / 1e3, 1e-5 * u, input=u, force=100.0 * u + next(noise), name=name) for name in "abc"]
    every, half = (
        next(n for n in flaws.record_flaws(of, "gms", Plant(1.0, 2.0, 1e-3, 200.0)) if n.code == "force-scale-differs")
        for of in (logs, [*logs[:2], replace(logs[2], force=2.0 * logs[2].force)])
    )
    assert every.says.startswith("K_f is 2 times what a, b, c show: the response has another scale.")
    assert half.says.startswith("The force of a, b is 0.5 times what K_f makes of its voltage")


def compensated(lead: float) -> Log:
    """Return a sine whose axis is off by 1 µm between reversals, and kicked by a lead after each [m]."""
    t = np.arange(12_000) / 1e3
    after = (t - 1.0) % 2.0  # since the last reversal [s]
    sense = np.where((t - 1.0) // 2.0 % 2 == 0, -1.0, 1.0)
    reference = 1e-3 * np.sin(0.5 * np.pi * t)
    off = 1e-6 * np.exp(-(((after - 1.0) / 0.2) ** 2)) + lead * sense * np.exp(-after / 0.05) * (t >= 1.0)
    return Log(time=t, position=reference + off, reference=reference, name="a")


def uneven_motion(by: float) -> Log:
    """Return a motion whose viscous friction differs from its mean by a share, up and down with the direction."""
    t = np.arange(8000) / 1e3
    v = 0.2 * np.cos(3.0 * t) + 0.1 * np.cos(11.0 * t)
    position = 0.2 / 3.0 * np.sin(3.0 * t) + 0.1 / 11.0 * np.sin(11.0 * t)
    a = -0.6 * np.sin(3.0 * t) - 1.1 * np.sin(11.0 * t)
    force = 10.0 * a + 500.0 * (v + by * np.abs(v)) + 20.0 * np.sign(v)
    return Log(time=t, position=position, force=force + np.random.default_rng(1).normal(scale=0.2, size=len(t)))


def strokes(level: float, number: int) -> ForceVelocity:
    v = np.outer([-1.0, 1.0], np.geomspace(1e-4, 0.05, 8)).ravel()
    force = np.sign(v) * level * (50.0 + 30.0 * np.exp(-np.abs(v) / 2e-3)) + 100.0 * v
    noise = np.random.default_rng(number).normal(scale=0.2, size=len(v))
    return ForceVelocity(v, force + noise, error=np.full(len(v), 0.2), name=f"run {number + 1}")


def ended_early(rises: float) -> Iterable[Notice]:
    """Return what is said of strokes, the slowest of either direction rising by a share in their second half."""
    logs, rng = [], np.random.default_rng(1)
    for v in np.outer([-1.0, 1.0], [1e-4, 1e-3, 3e-3, 1e-2]).ravel():
        t = np.arange(0.0, 2.0, 2e-3)
        force = 50.0 * (1.0 + (rises * (t - 2.0) if abs(v) < 5e-4 else 0.0)) + 0.02 * rng.standard_normal(len(t))
        logs.append(Log(t, v * t, force=np.sign(v) * force, kind="constant-velocity", name=f"{1e3 * v:g}"))
    return Strokes.of(logs, Asked()).notices


def of_loop(s: float) -> Sequence[Notice]:
    """Return what is said of a response of a speed loop, or of one over a voltage."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "response.xml"
        path.write_text(LOOP if is_so(s) else "frequency [Hz],magnitude [m/V],phase [rad]\n1,1,0\n2,1,0\n3,1,0\n")
        return next(tables(path)).notices


def in_two_files(share: float) -> Sequence[Notice]:
    """Return what is said of two files whose force goes as much with the motion."""
    with TemporaryDirectory() as folder, patch("fric.io.pairs.follows", return_value=share):
        for name, head in (("pos", "position [mm]"), ("force", "force [N]")):
            (Path(folder) / f"{name}.csv").write_text(f"time [s],{head}\n0,1\n1,2\n2,3\n")
        return with_joined(sorted(Path(folder).iterdir()), Path(folder) / "joined", None, assume=False)[1]


def of_mapping(parts: float) -> Sequence[Notice]:
    """Return what is said of a file of which a mapping has as many axes."""
    columns = {"time": {"period": "1 ms"}, "position": {"column": 0, "unit": "mm"}}
    mapped = [{"axis": axis, "columns": columns} for axis in "xyz"[: round(parts)]]
    with TemporaryDirectory() as folder:
        (Path(folder) / "log.csv").write_text("a,b\n1,2\n2,4\n3,6\n")
        mapping = MappingDocument.model_validate({"fric": "mapping/1", "parts": mapped})
        return fric.ingest(Path(folder) / "log.csv", output=Path(folder) / "log.h5", mapping=mapping).warnings


def for_drive(s: float) -> Sequence[Notice]:
    """Return what is said of an export to a drive that holds a pulse, or a list of the scheme's map."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("fric.results.export.trust_of", lambda *given, **known: ([], []))
        patched.setattr("fric.export.sinumerik.glitches_of", lambda *given: lambda *run: 1e-6)
        found = fric.export_axis("sinumerik" if is_so(s) else "twincat", "xy-table", axis="x", scheme="b")
    return found.warnings


SHOWN: dict[str, Show] = {
    "mapping-assumed": lambda s: guess(s).notices(),
    "response-of-loop": of_loop,
    "files-joined": lambda s: in_two_files(s * TOGETHER),
    "axes-left-out": lambda s: of_mapping(1.5 * s),
    "mapping-open": lambda s: [] if guess(s).sure else guess(s).asked(),
    **{f"implausible-{name}": lambda s, name=name: implausible(name, s) for name in BOUNDS},
    **{
        f"unusual-{name}": lambda s, name=name: settled([Finding(name, USUAL[name] / s, "linear", "", USUAL[name])])
        for name in UNUSUAL
    },
    "energy-drifts": lambda s: energies(change=s * inspection.CHANGES),
    "energy-in-one-segment": lambda s: energies(off=s * inspection.STANDS_OFF),
    "force-coarse": lambda s: forces(np.arange(1000) % (round(flaws.COARSE / s) + 1) * 0.1),
    "drive-off": lambda s: flaws.record_flaws([resting(s * resolution.OFF)], "gms"),
    "foreign-compensation": lambda s: [flaws.foreign_compensation(compensated(s * flaws.KICKED * 1e-6))],
    "holding-map": lambda s: held(1 / s),
    "modes-switch": two_modes,
    "two-encoders": two_encoders,
    "force-scale-differs": lambda s: of_voltage(1.0 + s * flaws.OTHER_SCALE),
    "force-clipped": lambda s: forces(cut(s)),
    "input-clipped": lambda s: forces(np.linspace(0.0, 1.0, 400), "plant", input=cut(s)),
    "clipped-unused": lambda s: resolution.without_clipped([of_force(np.arange(400.0)), of_force(cut(s))], 0.0)[1],
    "sampling-uneven": uneven,
    "sampling-differs": lambda s: flaws.clock_flaws(
        [Log(by * np.arange(4.0), position=np.arange(4.0)) for by in (1.0, s * flaws.OTHER_UNIT, 1.0)], "static"
    ),
    "encoder-too-coarse": coarse,
    "dead-zone": dead,
    "mass-differs": mass,
    "loop-lags": lambda s: gains.lags(N(K_v=50.0, velocity_feedforward=1.0), s * gains.LAGS / 50.0),
    "force-lags": lambda s: plant_fit._lag_described(
        Estimate.around(s * plant_fit.DESCRIBED / 1e3, "s", 0.0), None, 1e3
    ),
    "parameter-at-bound": lambda s: near_an_end(s, "linear"),
    "parameter-at-edge": lambda s: near_an_end(s, "log"),
    "parameter-untold": lambda s: near_an_end(s, "log", seen=not is_so(s)),
    "no-coherence": lambda s: (
        measure_response(
            FrequencyResponse(np.arange(1.0, 9.0), np.ones(8), np.zeros(8), None if is_so(s) else np.full(8, 0.9))
        ).warnings
    ),
    "rows-at-rest": lambda s: table_points(
        [ForceVelocity(np.array([-1.0, 1.0, not is_so(s)], float), np.ones(3), error=np.ones(3))], None
    )[1],
    "one-direction": lambda s: table(np.array([-1.0, 1.0, 2.0])[is_so(s) :]),
    "response-misfit": lambda s: [one for one in response(misfit=s * UNSURE) if one.severity != "note"],
    "lines-stand-off": lambda s: response(stand_off=(3.0,) * is_so(s)),
    "A-open": lambda s: response(A=1.0 / s),
    "T_d-at-bound": lambda s: response(T_d=0.5e-3 / s),
    "K_f-missing": lambda s: [*response(K_f=not is_so(s)), *rigid(K_f=None if is_so(s) else Estimate(1.0, "N/V"))],
    "second-mass": lambda s: response(mode=N(encoder="table", ratio=0.5, frequency=80.0) if is_so(s) else None),
    "spring-in-series": lambda s: response(mode=N(encoder="motor" if is_so(s) else "table", ratio=0.5, frequency=80.0)),
    "amplitudes-disagree": lambda s: response(friction={"differs": is_so(s), "coulomb": Estimate(-1.0, "m/s²")}),
    "friction-in-response": lambda s: response(friction={"differs": is_so(s), "coulomb": Estimate(1.0, "m/s²")}),
    "viscous-by-direction": lambda s: plant_fit.identify_motion([uneven_motion(s * plant_fit.UNEVEN)]).warnings,
    "changes-between": lambda s: rigid(hidden=0.1 * is_so(s)),
    "not-physical": lambda s: rigid(F_c=1.0 - 1.0 * s),
    "mass-not-shown": lambda s: rigid(half=s),
    "T_d-assumed": lambda s: rigid(assumed=is_so(s)),
    "response-ends": lambda s: perturbation(last=40.0 / s),
    "response-begins": lambda s: perturbation(first=10.0 * s),
    "response-without-confidence": lambda s: perturbation(radius=0.0 if is_so(s) else 1.0),
    "no-static-map": lambda s: hysteresis(static_given=not is_so(s)),
    "fewer-blocks": lambda s: hysteresis(asked=4 if is_so(s) else 2),
    "first-block-unresolved": lambda s: hysteresis(first=1.0 / s),
    "sine-too-fast": lambda s: hysteresis(share=s * gms.INERTIA),
    "C-assumed": lambda s: hysteresis(assumed=is_so(s)),
    "C-without-plant": lambda s: hysteresis(plant=not is_so(s)),
    "level-of-another": lambda s: hysteresis(level=1.0 + s * (gms.OTHER - 1.0)),
    "level-differs": lambda s: hysteresis(level=1.0 + s * gms.LEVEL),
    "rest-raises-friction": lambda s: hysteresis(mismatch=s * gms.LEVEL * 100.0),
    "records-vary": lambda s: (
        identify_static(
            [strokes(level, n) for n, level in enumerate((0.97, 1.02, 1.01) if is_so(s) else (1.0, 1.0, 1.0))], Asked()
        ).warnings
    ),
    "strokes-in-presliding": lambda s: ended_early(s * RISES),
    "friction-differs": lambda s: hysteresis(mismatch=-s * gms.LEVEL * 100.0),
    "lost-motion": lambda s: hysteresis(hollow=s * gms.HOLLOW * 100.0),
    "begins-loaded": lambda s: hysteresis(loaded=is_so(s)),
    "one-cycle": lambda s: hysteresis(cycles=1 if is_so(s) else 2),
    "never-saturates": lambda s: hysteresis(saturates=not is_so(s)),
    "never-slides": lambda s: hysteresis(saturates=not is_so(s), static_given=False),
    "model-shape": shaped,
    "law-differs": next_circles,
    "one-feed": lambda s: tuned(feeds=(0.1, 0.1 * tune_fit.FEEDS_APART / s)),
    "circle-misfit": lambda s: tuned(rms=s * tune_fit.MISFIT),
    "direction": lambda s: tuned(side=is_so(s)),
    "tuned-at-bound": lambda s: tuned(x=0.97 * s),
    "position-late": timed,
    "position-early": lambda s: timed(-s),
    "circle-elsewhere": lambda s: one_circle(radius=0.03 * tune.OTHER_FEED * s),
    "table-unseen": lambda s: one_circle(encoder="motor" if is_so(s) else "table"),
    "circle-cannot-run": lambda s: one_circle(runs=not is_so(s)),
    "completed-disagrees": lambda s: one_circle(seen=1e-5 + s * (tune.GLITCH_APART + tune.SHARE_APART * 1e-5)),
    "compensation-kicks": kicked_circle,
    "squareness-unseen": lambda s: taken_apart(instrument="encoders" if is_so(s) else "grid"),
    "mismatch-or-squareness": lambda s: taken_apart(both=not is_so(s)),
    "lost-motion-cause": lambda s: taken_apart(backlash=s * 1e-6),
    "ball-bar-length": lambda s: taken_apart(instrument="ball-bar" if is_so(s) else "grid"),
    "one-revolution": lambda s: taken_apart(revolutions=2 - is_so(s)),
    "glitch-does-not-end": lambda s: taken_apart(angle=s * float(diagnose.LARGEST)),
    "limit-cycle": lambda s: against(oscillation=s * verdict.CYCLE),
    "cannot-run": lambda s: against(drawn=[np.nan if is_so(s) else 3e-6] * 30),
    "scheme-spoils": lambda s: against(9e-6 + s * 0.2e-6),
    "glitch-open": lambda s: decided(9e-6, *[9e-6] * 25, *[9e-6 * verdict.LOOSE * s] * 5),
    "few-machines": lambda s: distrust(
        candidates=[leaves(name, 3e-6, *[3e-6] * round(verdict.ENOUGH_MACHINES / s)) for name in "af"]
    ),
    "one-machine": lambda s: distrust(candidates=[leaves(name, 3e-6, *[3e-6] * 30 * (not is_so(s))) for name in "af"]),
    "belief-is-truth": lambda s: distrust(candidates=[leaves("f", 3e-6)], exact=is_so(s)),
    "nothing-simulated": lambda s: distrust(**{"candidates": ()} if is_so(s) else {}),
    "gains-unknown": lambda s: tune.unknown_gains(
        [GAINS_DESIGNED.found("axis x")], [N(axes={"x": N(input=None if is_so(s) else 1)})]
    ),
    "no-measured-circle": lambda s: distrust(compared=not is_so(s)),
    "measured-beyond": measured,
    "saturates": lambda s: run_warnings(N(not_linear=()), {"x": N(saturated=is_so(s), time=[0.0])}),
    "held-as-pulse": for_drive,
    "not-linear": lambda s: run_warnings(N(not_linear=("sliding-mode",) * is_so(s)), {}),
}


@pytest.mark.parametrize("code", SHOWN)
def test_a_flaw_is_found_at_half_more_than_its_threshold_and_not_at_a_third_less(code: str) -> None:
    found = {one.code: one for one in SHOWN[code](1.5) if one is not None}
    assert code in found
    assert found[code].severity in ("note", "doubt", "wrong")
    assert not re.search(r"[{}]|\bNone\b", found[code])
    assert code not in {one.code for one in SHOWN[code](0.67) if one is not None}


def test_flaws_without_a_record_here_only_become_fewer() -> None:
    """Those are held by tests of their detectors, most of them without a bracket; a new flaw has its record above."""
    assert CATALOGUE.keys() - SHOWN.keys() == set(WITHOUT.split())


WITHOUT = """
    samples-lost sampling-jitters force-late force-late-open force-turned K_f-differs
    force-not-proportional stiffness-unresolved force-over-position friction-over-position
    force-along-axis force-drifts friction-ages directions-differ offset-shared fall-not-seen fall-open
    F_s-extrapolated F_c-at-bound strokes-stand-off strokes-scatter
    strokes-settling strokes-swing residuals-follow-speed damping-too-large sigma-in-A one-speed
    records-without-stroke errors-of-means loop-feeds-back few-periods A-holds-friction
    A-holds-viscous controller-by-default observer-assumed
    explains-little prediction-without-interval model-disagrees delay-differs controller-differs feedforward-found
    added-voltage-found learning-diverges learning-gains-nothing learned-for-one-circle learned-from-one-circle
    nothing-fed-before circle-drifts loop-designed falling-friction tuned-in-part tuning-refused
    tuning-no-better circle-unused prediction-widened presliding-unknown interval-open not-drawn
    scheme-unstable not-as-predicted
    scheme-saturates no-reversal scheme-failed drive-saturates spread-unused interrupted T_d-below-hold
    inverse-left-out library-warns samples-without-value line-cut joined-in-part joined-thinned joined-moved
    channels-without-time scope-scale cycle-assumed there-already radius-assumed no-reference columns-by-content
    columns-left-out cells-dropped samples-missing unit-failed no-log file-copies file-left-out file-unused
    mapping-bundled mapping-proposed mapping-ambiguous mapping-beside step-failed record-left-out folders-together
    position-unit-differs effort-smoothed force-by-file
    gains-designed circle-failed plan-typical plan-not-enough
    plan-left-over plan-plant-unsure plan-friction-alone plan-accuracy
"""


def test_how_bad_it_is_follows_the_size() -> None:
    sizes = [0.67 * SMALL, 1.5 * SMALL, 1.5 * HALF_WIDTHS * 0.05]
    assert [by_size(size, 1.0, 0.05) for size in sizes] == ["note", "doubt", "wrong"]
    sizes = [0.67 * UNSURE, 1.5 * UNSURE, 1.5 * FALSE]
    about = {"worst": 1.0, "edge": "highest", "limit": 1.0}
    found = [RESPONSE_MISFIT.found(misfit=size, wrong=size >= FALSE, **about).severity for size in sizes]
    assert found == ["note", "doubt", "wrong"]


def test_what_is_taken_off_is_not_wrong_until_it_is_taken_off() -> None:
    """Nothing is left to do up to 5 % of the friction; beyond, a prediction is widened by as much."""
    for varies, severity in ((1.2, "note"), (6.0, "doubt")):
        values = {"varies": Estimate(varies, "N"), "length": Estimate(0.031, "m"), "level": 64.0, "half_width": 0.1,
                  "share": varies / 64.0}  # fmt: skip
        for flaw in (FORCE_OVER_POSITION, FRICTION_OVER_POSITION):
            found = flaw.found(**values, either=False, taken_off=True)
            assert found.severity == severity
            assert found.endswith("Removed; nothing to do.") == (flaw is FORCE_OVER_POSITION)
            left = "wrong" if flaw is FORCE_OVER_POSITION else severity
            assert flaw.found(**values, either=False, taken_off=False).severity == left


def test_sentences_name_their_values_and_read_as_sentences() -> None:
    for code, flaw in CATALOGUE.items():
        for text in filter(None, (flaw.says, flaw.mend)):
            assert [name for _, name, *_ in Formatter().parse(text) if name and not name.isidentifier()] == [], code
            plain = re.sub(r"{[^{}]*}", "", re.sub(r"{[^{}]*}", "", text))
            assert not re.search(r"\b(told|tells|stands|so-manieth)\b", plain), code
            # an argument is named as Python has it, and the command line words it; but in a command to type
            named = re.sub(r"`fric [^`]*`|\(fric [^()]*\)|--implausible", "", text)
            assert "--" not in named, code


@pytest.mark.parametrize("code", CATALOGUE)
def test_the_page_of_a_flaw_has_no_gaps_of_a_template(code: str) -> None:
    """A value is its name in brackets, optional parts are left out, and no value leaves two blanks or a bare sign."""
    lines = entry(CATALOGUE[code]).split("\n\n")
    explained = "\n".join(line for line in lines[1:] if not line.startswith("A warning has values"))
    assert not re.search(r"[{}\[\]|…]|\*\w+\*|  |,,", re.sub(r"\[\w+\]", "5", explained).replace("=… ", "")), explained
    assert re.search(r"\w{2}", lines[1])
    assert ("Effect: " in explained, "To do: " in explained) == (True, bool(CATALOGUE[code].mend))


def test_the_page_of_a_flaw_says_both_ways_and_optional_sentences() -> None:
    assert "rises or falls by [change] % over" in entry(CATALOGUE["force-drifts"])
    assert "In some cases, each holds one speed" in entry(CATALOGUE["records-vary"])
    assert "larger values are missing." in entry(CATALOGUE["force-clipped"])
    assert "To do: Removed; nothing to do. Or log each speed" in entry(CATALOGUE["force-over-position"])
    assert "position and time" in entry(CATALOGUE["implausible-speed"])  # what to look at, which the error says


LISTED = ("files", "glitches", "how", "kept", "lines", "names", "quadrants", "why")
"""Values of a sentence that are lists or reasons."""


def test_the_joint_of_two_records_that_differ_is_no_backlash() -> None:
    """ "Remove the backlash" was said of a sound axis, whose curves differed by 540 mA where they meet."""
    for mismatch, code in ((-40.0, "friction-differs"), (40.0, "rest-raises-friction")):
        assert {notice.code for notice in hysteresis(hollow=20.0, mismatch=mismatch)} == {code}
    assert "lost-motion" in {notice.code for notice in hysteresis(hollow=60.0, mismatch=-40.0)}


def test_a_sentence_has_a_hundred_characters_at_most() -> None:
    """Without what to do; a value with its unit has seven of them, a list or a reason twenty. Errors give a reason."""

    def usual(field: re.Match[str]) -> str:
        name, _, form = field[1].partition(":")
        return max(form.split("|"), key=len) if "|" in form else "~" * (20 if name in LISTED else 7)

    long = {}
    for code in (code for code in CATALOGUE if not code.startswith("implausible-")):
        says = CATALOGUE[code].says
        while re.search(inner := r"\{([^{}]*)\}", says):
            says = re.sub(inner, usual, says)
        if len(says) > 100:
            long[code] = says
    assert not long


def said(code: Any) -> Iterator[str]:
    """Give the names and the texts of compiled code."""
    yield from (*code.co_names, *code.co_varnames)
    for one in code.co_consts:
        if hasattr(one, "co_consts"):
            yield from said(one)
        for text in one if isinstance(one, tuple | frozenset) else [one]:
            if isinstance(text, str):
                yield text


def test_every_flaw_is_found_somewhere() -> None:
    """By its name, or by its code."""
    root = Path(verdict.__file__).parent
    files = [path for path in root.rglob("*.py") if path.parent.name != "flaws"]
    names = {word for path in files for word in said(compile(path.read_bytes(), path, "exec"))}
    for code in CATALOGUE:
        if not code.startswith(("implausible-", "unusual-")):
            found = names & {code, code.replace("-", "_").upper(), RENAMED.get(code, code)}
            assert found, code


RENAMED = {"parameter-untold": "PARAMETER_UNSEEN"}
"""Codes whose constants have another name."""


def test_what_is_said_of_a_flaw_elsewhere_is_asked_of_the_catalogue() -> None:
    """The level of friction is what a measured circle settles, and nothing else is."""
    settled_by_it = {code for code, flaw in CATALOGUE.items() if flaw.circle_settles}
    assert {"force-over-position", "level-differs", "F_c-at-bound"} <= settled_by_it
    assert not {"force-turned", "A-holds-friction", "samples-lost"} & settled_by_it
    assert {code for code, flaw in CATALOGUE.items() if flaw.no_response} == {"T_d-assumed", "observer-assumed"}
    widened = [(flaw, share) for flaw in CATALOGUE.values() for share in flaw.widens.values()]
    assert all(share in flaw.says if isinstance(share, str) else 0 < share <= 2.0 for flaw, share in widened)


@pytest.mark.parametrize(
    ("scatter", "motions", "severity"), [(0.003, True, "note"), (0.003, False, "doubt"), (0.02, True, "doubt")]
)
def test_a_slight_difference_of_unlike_motions_is_a_note(scatter: float, motions: bool, severity: str) -> None:
    """Half of the sessions of a machine that keeps its friction had a doubt, of 0.3 % between two amplitudes."""
    found = RECORDS_VARY.found(
        by=["friction by 0.3%"], order=["1.0"], one_speed=False, within=False, motions=motions, scatter=scatter
    )
    assert found.severity == severity
