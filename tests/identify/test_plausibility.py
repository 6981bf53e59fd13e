"""Units that were taken for others end in an error where physics tells them; nothing real is called implausible."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import fric
from fric.cli.main import app
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.log import Log
from fric.plausibility import BOUNDS, Finding, lift, lifted, of_logs, of_strokes, settled

ROOT = Path(__file__).parents[2]
DATA, REAL = ROOT / "data", ROOT.parent / "shared" / "data"
PLANT = Plant(17.0, 2.4, 0.62e-3, 155.0)


@pytest.fixture(autouse=True)
def _as_ever():
    yield
    lift(False)


@cache
def bundled(name: str) -> list[Log]:
    return list(fric.read(DATA / f"{name}.h5"))


def strokes() -> list[Log]:
    return bundled("constant-velocity")[1::3]


def sines() -> list[Log]:
    return bundled("presliding-sine")


def scaled(logs: list[Log], channel: str, by: float) -> list[Log]:
    both = {"position": ("position", "reference")}.get(channel, (channel,))
    return [replace(log, **{name: by * getattr(log, name) for name in both}) for log in logs]


STATIC = fric.StaticMap(F_c=60.6, F_s=91.6, v_s=2.2e-3, sigma=1180.0)
VERBS = {
    "static": lambda change: fric.identify_static(*change(strokes())),
    "static-short": lambda change: fric.identify_static(*change(bundled("constant-velocity")[:7])),
    "static-plant": lambda change: fric.identify_static(*change(strokes()), plant=PLANT),
    "gms": lambda change: fric.identify_gms(*change(sines()), blocks=3, refine=False),
    "gms-static": lambda change: fric.identify_gms(*change(sines()), static=STATIC, blocks=3, refine=False),
    "gms-plant": lambda change: fric.identify_gms(*change(sines()), static=STATIC, plant=PLANT, blocks=3, refine=False),
    "dahl": lambda change: fric.identify_model("dahl", *change(sines()), fix={"n": 1.0}),
    "plant": lambda change: fric.identify_plant(*change(bundled("frequency-response"))),
}
SLIPS = [
    ("force", 1e3, "static", "force-per-input"),
    ("force", 1e3, "gms", "force-per-input"),
    ("force", 1e3, "gms-static", "force-per-input"),
    ("force", 1e3, "plant", "force-per-input"),
    ("force", 1e3, "dahl", "force-per-input"),
    ("force", 1e-3, "static-plant", "force-constant"),
    ("force", 1e-3, "gms-static", "level"),
    ("position", 1e3, "static", "speed"),
    ("position", 1e3, "gms", "amplitude"),
    ("position", 1e3, "gms-static", "amplitude"),
    ("position", 1e3, "dahl", "amplitude"),
    ("position", 1e3, "plant", "speed"),
    ("position", 1e-3, "static-short", "stroke"),
    ("position", 1e-3, "static-plant", "viscous-over-mass"),
    ("position", 1e-3, "gms", "stiffness"),
    ("time", 1e-3, "static", "speed"),
    ("time", 1e-3, "gms-plant", "inertia"),
    ("time", 1e-3, "plant", "sampling"),
    ("time", 1e3, "plant", "B"),
]


@pytest.mark.parametrize(("channel", "by", "verb", "bound"), SLIPS, ids=lambda one: str(one))
def test_a_unit_taken_for_another_is_an_error(channel: str, by: float, verb: str, bound: str) -> None:
    with pytest.raises(FricError) as error:
        VERBS[verb](lambda logs: scaled(logs, channel, by))
    assert BOUNDS[bound].what in error.value.what
    assert "`with fric.lifted():`" in error.value.hint


@pytest.mark.parametrize(
    ("channel", "by", "verb", "code"),
    [
        ("force", 1e-3, "static", "unusual-friction"),  # kN
        pytest.param("force", 1e-3, "gms", "unusual-friction", marks=pytest.mark.long(1)),
        ("position", 1e-3, "static", "unusual-speed"),  # m for mm
        pytest.param("time", 1e3, "static", "unusual-speed", marks=pytest.mark.long(1)),  # s for ms
        ("time", 1e3, "gms", "unusual-sampling"),
    ],
    ids=str,
)
def test_what_no_law_tells_and_few_machines_have_is_told(channel: str, by: float, verb: str, code: str) -> None:
    assert codes(verb, channel, by)[code] == "doubt"
    assert not [one for one in as_they_are(verb) if one.startswith("unusual")]
    with lifted():
        assert not [one for one in codes(verb, channel, by) if one.startswith("unusual")]


def test_a_negative_A_names_friction_that_falls_before_units():
    """Of a common friction the fall is taken off by a replay; by direction it is not, and is said."""
    t = np.arange(0.0, 8.0, 2e-3)
    z = 0.05 * np.sin(2.5 * t) + 0.01 * np.sin(8.2 * t)
    v = np.gradient(z, t)
    force = 20.0 * np.gradient(v, t) + (20.0 + 30.0 * np.exp(-np.abs(v) / 0.05)) * np.sign(v)
    log = fric.Log(t, position=z, force=force, input=force / 50.0, kind="motion")
    with pytest.raises(FricError, match=r"A is -.*friction falls with speed.*\nLog strokes.*units"):
        fric.identify_plant(log, method="motion", direction="each")
    found = fric.identify_plant(log, method="motion").fit.estimates
    assert float(found["M"]) == pytest.approx(20.0, rel=0.02)


def codes(verb: str, channel: str, by: float) -> dict[str, str]:
    found = VERBS[verb](lambda logs: scaled([replace(one, input=None) for one in logs], channel, by))
    return {one["code"]: one["severity"] for one in found.document["warnings_coded"]}


@cache
def as_they_are(verb: str) -> dict[str, str]:
    return codes(verb, "force", 1.0)


def test_force_that_is_984_times_the_static_map_stops_without_any_input() -> None:
    bare = [replace(log, input=None, force=984 * log.force) for log in sines()]
    with pytest.raises(FricError, match="over F_s of the static map is 1000"):
        fric.identify_gms(*bare, static=STATIC)
    with pytest.raises(FricError, match="friction is 91"):
        fric.identify_static(*[replace(log, input=None, force=1e3 * log.force) for log in strokes()])


def test_what_is_lifted_is_a_warning_that_says_wrong() -> None:
    with lifted():
        found = fric.identify_static(*scaled(strokes(), "force", 1e3))
    codes = {one["code"]: one["severity"] for one in found.document["warnings_coded"]}
    assert codes["implausible-force-per-input"] == codes["implausible-friction"] == "wrong"
    assert found.document["static"]["F_s"]["value"] == pytest.approx(91.6e3, rel=0.05)
    with pytest.raises(FricError):
        fric.identify_static(*scaled(strokes(), "force", 1e3))


def test_the_command_lifts_it(tmp_path: Path) -> None:
    log = tmp_path / "kilo.h5"
    fric.Records(scaled(strokes(), "force", 1e3)).save(log)
    words = ["identify", "static", str(log), "-o", str(tmp_path / "friction.yaml")]
    assert isinstance(CliRunner().invoke(app, words).exception, FricError)
    assert not (tmp_path / "friction.yaml").exists()
    assert CliRunner().invoke(app, [*words, "--implausible", "ok"]).exit_code == 0
    # and the machine that is built with such a friction
    believed = f"x={tmp_path / 'friction.yaml'}"
    circle = ["simulate", "circle", "xy-table", "--scheme", "a", "--friction", believed, "--radius", "5 mm"]
    done = CliRunner().invoke(app, circle)
    assert isinstance(done.exception, FricError)
    assert "friction is" in done.exception.what


def test_no_machine_of_ours_and_no_bundled_log_is_implausible() -> None:
    for path in sorted((ROOT / "configs").glob("**/*.yaml")):
        if path.read_text().startswith("fric: machine/1"):
            assert not [one for one in fric.read_machine(path).warnings if one.code.startswith("implausible")]
    for path in sorted(path for path in DATA.glob("*.h5") if path.stem != "circle"):
        assert not settled(of_logs([log for log in fric.read(path) if isinstance(log, Log)]))


@pytest.mark.real
@pytest.mark.skipif(not REAL.exists(), reason="the real logs are not here (../shared/data)")
def test_no_real_log_is_implausible(tmp_path: Path) -> None:
    maps = ROOT / "configs" / "mappings"
    screw = sorted((REAL / "screwdrive1").glob("**/*.csv"))
    for name, files in (
        ("screwdrive1", screw),
        ("emps", [REAL / "emps/DATA_EMPS.mat"]),
        ("tribometer", [REAL / "tribometer/reciprocating-first-75s.txt"]),
    ):
        log = tmp_path / f"{name}.h5"
        fric.ingest(*files, output=log, mapping=maps / f"{name}.yaml", kind="motion")
        found = [*of_logs(list(fric.read(log))), *of_strokes(list(fric.read(log)))]
        assert found
        for one in found:  # and not near: by a factor of three from each bound that is of a size
            bound = BOUNDS[one.name]
            low, high = bound.rotary if one.motion == "rotary" else bound.linear
            assert 3 * low < one.value < high / 3, one


@pytest.mark.parametrize("motion", ["linear", "rotary"])
def test_micro_contacts_and_axes_of_ten_tons_are_plausible(motion: str) -> None:
    """µN and rad at one end; 10 t, 30 kN and 1e9 N/m at the other."""
    small = {"friction": 5e-6, "stiffness": 1.0, "slip": 1e-9, "mass": 1e-6, "B": 1e3, "T_d": 1e-5, "A": 1e-3}
    large = {"friction": 3e4, "stiffness": 6e9, "slip": 1e-3, "mass": 3e4, "B": 1e-2, "T_d": 0.05, "A": 500.0}
    small |= {"stroke": 1e-5, "viscous-over-mass": 1e-3}
    large |= {"stroke": 10.0, "viscous-over-mass": 1e3}
    large |= {"speed": 5.0, "friction-over-mass": 100.0, "force-per-input": 2e4}
    for values in (small, large):
        found = settled(Finding(name, value, motion) for name, value in values.items())
        assert not [one for one in found if one.severity == "wrong"]
    assert not Finding("speed", np.nan, motion).beyond()


def test_a_velocity_of_counts_that_hides_a_slow_sine_is_in_its_unit() -> None:
    """Of 15 µm at 0.1 Hz, a quantised velocity is noise: the travel of both was compared over 8 ms."""
    time, rng = np.arange(30_000) / 1000.0, np.random.default_rng(4)
    position = 15e-6 * np.sin(2 * np.pi * 0.1 * time)
    counts = np.rint(rng.normal(0.0, 0.5, len(time))) * 0.4e-3  # a count of 0.1 µm in 0.25 ms
    log = Log(time, position=position, velocity=np.gradient(position, time) + counts)
    settled(of_logs([log]))
    for factor in (1e3, 1e-3, 60.0):
        with pytest.raises(FricError, match="travel by the position over that by the velocity"):
            settled(of_logs([replace(log, velocity=factor * log.velocity)]))


def test_every_bound_has_its_reason_and_is_wide() -> None:
    for name, bound in BOUNDS.items():
        assert bound.reason, name
        for low, high in (bound.linear, bound.rotary):
            assert high / max(low, 1e-9) >= 20


@pytest.mark.parametrize("factor", [57.3, 25.4, 1 / 25.4])
def test_a_position_in_another_unit_than_its_reference_is_refused(factor):
    """Degrees beside radians, inches beside millimetres: the position follows, and by a slope that no axis has."""
    time = np.arange(4000) / 1000.0
    asked = 0.02 * np.sin(2.0 * np.pi * 0.5 * time) + 0.3
    went = 0.3 + 0.98 * (np.interp(time - 0.01, time, asked) - 0.3)
    force = np.sign(np.gradient(went)) + 0.1
    good = Log(time=time, position=went, force=force, reference=asked)
    settled(of_logs([good]))
    with pytest.raises(FricError, match="over its reference"):
        settled(of_logs([replace(good, position=factor * went)]))
    settled(of_logs([replace(good, reference=0.3 + 1e-3 * time)]))  # shaken about a place


@pytest.mark.parametrize(
    ("verb", "given", "meant"),
    [
        (lambda: fric.circle("xy-table", "a", radius=30), "radius of the circle is 30", "'30 mm'"),
        (lambda: fric.circle("xy-table", "a", velocity=100), "speed is 100 m/s", "'100 mm/s'"),
        (lambda: fric.plan(stroke=300, feed=0.1), "stroke is 300", "'300 mm'"),
        (lambda: fric.circle("xy-table", "a", velocity="100"), "has no unit", "'100 mm/s'"),
        (lambda: fric.plan(stroke="300", feed=0.1), "has no unit", "'300 mm'"),
        (lambda: fric.plan(stroke=0.3, feed=0.1, encoder="0.25"), "has no unit", "'0.25 um'"),
        (lambda: fric.experiment("xy-table", "presliding-sine", amplitudes="15"), "has no unit", "'15 um'"),
        (lambda: fric.circle("xy-table", "a", accuracy="5"), "has no unit", "'5 um'"),
        (lambda: fric.make_report("configs/xy-table.yaml", tolerance="5"), "has no unit", "'5 um'"),
        (lambda: fric.make_report("configs/xy-table.yaml", tolerance=5e-3), "tolerance is 5 mm", "'0.005 mm'"),
        (lambda: fric.auto("data/circle.h5", output="found", tolerance="5"), "has no unit", "'5 um'"),
    ],
)
def test_options_are_held_against_what_machines_are_too(verb, given: str, meant: str) -> None:
    """The first of them ran for nine minutes, and a hint proposed 100 m/s."""
    with pytest.raises(FricError, match=given) as refused:
        verb()
    assert meant in refused.value.hint
