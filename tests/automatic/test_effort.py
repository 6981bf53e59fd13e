"""Logs with one effort alone, as nearly every drive logs it: the drive's input, with a force constant of 1."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.automatic.run import gains_of
from fric.automatic.sources import MOTION, Source, Sources, find_sources
from fric.automatic.steps import Session, axis_steps, identify_axes, take_efforts
from fric.circles.measured import AxisTrace, MeasuredCircle
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import read_machine
from fric.documents.plant import PlantDocument
from fric.documents.yaml import dump, read_document
from fric.errors import FricError
from fric.friction.stribeck import StaticMap
from fric.identify.plant.identify import identify_motion
from fric.io.circle import read_circles, write_circles
from fric.io.hdf5 import read_logs, write_logs
from fric.log import Log
from fric.results.given_models import friction_of
from fric.units import MOTIONS, SI_UNITS, Motion, factor, is_effort, of_effort, of_force, parse, si_unit

DATA = Path(__file__).parents[2] / "data"
AXIS = read_machine("virtual-rig").axis("x")
M, F_v, F_c = 2.5, 9.0, 1.8  # [A·s²/m], [A·s/m], [A]


def motion(unit: str = "linear/A", **more) -> Log:
    t = np.arange(0.0, 8.0, 1e-3)
    w = 2 * np.pi * np.array([0.5, 1.3, 2.9])[:, None]
    a = np.array([20e-3, 8e-3, 4e-3])[:, None]
    z, v, acceleration = ((a * d).sum(0) for d in (np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t)))
    force = M * acceleration + F_v * v + F_c * np.sign(v) + np.random.default_rng(1).normal(0, 0.02, len(t))
    return Log(t, position=z, force=force, kind="motion", motion=unit, **more)


def test_the_input_has_the_unit_of_the_force():
    for name in filter(is_effort, MOTIONS):
        assert si_unit("input", name) == si_unit("force", name)
        assert si_unit("force per input", name) == "1"
        assert of_effort(name) == of_effort(of_force(name)) == name
        assert all(factor(si_unit(dimension, name), dimension, name) == 1.0 for dimension in SI_UNITS)
    assert si_unit("velocity gain", "linear/A/A") == "A*s/m"
    assert not any(map(is_effort, MOTIONS[: MOTIONS.index("linear/N/N")]))


def test_a_plant_from_the_effort_alone_has_a_force_constant_of_1():
    log = motion("linear/A/A")
    assert log.input is log.force
    found = fric.identify_plant(log, method="motion")
    assert (float(found.K_f), found.K_f.unit, found.K_f.fixed) == (1.0, "1", True)
    assert float(found.B) == pytest.approx(1 / M, rel=0.01)
    assert (float(found.A), found.A.fixed) == (0.0, True)  # what is viscous is friction
    assert float(found.F_v) == pytest.approx(F_v, rel=0.02)
    assert found.T_d.assumed
    assert "a current loop of 500 Hz is assumed" in " ".join(map(str, found.warnings))
    volts = Log(log.time, position=log.position, input=log.force, motion="linear/V/V", kind="motion")
    assert float(fric.identify_plant(volts, method="motion").B) == pytest.approx(float(found.B), rel=1e-9)


@pytest.mark.long(3)
def test_auto_designs_for_the_effort_where_no_log_holds_another(tmp_path: Path):
    def made(step):
        if step.command not in {"ingest", "identify plant", "design controller"}:
            raise FricError("not here: it takes long")
        return step.make()

    def found(folder: str, **channels) -> fric.automatic.steps.AxisOutcome:
        (tmp_path / folder).mkdir()
        log = motion()
        write_logs(
            tmp_path / folder / "log.h5", [Log(**{**log.channels(), **channels}, kind="motion", motion=log.motion)]
        )
        session = Session(tmp_path / f"{folder}-out", made, lambda _: None)
        take_efforts(sources := find_sources([tmp_path / folder]))
        return identify_axes(session, sources, lambda _: None)["x"]

    outcome = found("one")
    assert {"plant", "controller"} <= {*outcome.done}
    assert outcome.motion == "linear/A/A"
    assert pytest.approx(M, rel=0.01) == read_document(outcome.files["plant"], PlantDocument).plant("linear/A/A").M
    assert read_document(outcome.files["controller"], fric.documents.controller.ControllerDocument).K_p.unit == "A*s/m"
    both = found("both", input=motion().force / 3.0)
    assert both.motion == "linear/A"  # its drive takes volts


def test_efforts_of_rotary_axes_are_inputs_too():
    of_joint = Source(Path("q.h5"), "q", "rotary/A", frozenset({"motion"}), frozenset(), efforts=frozenset({"force"}))
    take_efforts(found := Sources([of_joint]))
    assert (found.logs[0].motion, found.logs[0].driven) == ("rotary/A/A", True)


def falling(level: float, seconds: float, more: float = 0.0) -> Log:
    t, late = np.arange(0.0, seconds, 8e-3), 4e-3
    w = 2 * np.pi * np.array([0.3, 0.7, 1.3])[:, None]
    a = np.array([40e-3, 15e-3, 6e-3])[:, None]
    v, acceleration = ((a * d).sum(0) for d in (w * np.cos(w * (t - late)), -(w**2) * np.sin(w * (t - late))))
    coulomb = level * F_c * (1.0 + 0.3 * np.exp(-np.abs(v) / 0.01)) * np.sign(v)
    noise = np.random.default_rng(abs(round(100 * level) - 99)).normal(0, 0.02, len(t))
    force = (M + more) * acceleration + F_v * v + coulomb + noise
    return Log(t, position=(a * np.sin(w * t)).sum(0), force=force, kind="motion", motion="linear/A", name=f"{level}")


def test_a_motion_tells_the_lag_of_its_force_within_a_sample_and_friction_that_falls():
    """F_v was 6.6 % off under ±2 %: the whole force is late. Where friction falls, a rigid axis' F_c is 4 % off."""
    log = falling(1.0, 24.0)
    found, rigid = fric.identify_plant(log).fit.estimates, identify_motion([log]).estimates
    for name, true, width in (("M", M, 0.02), ("F_v", F_v, 0.06), ("F_c", F_c, 0.06)):
        low, high = found[name].ci95
        assert low < true < high < low + width * true, name
    assert rigid["F_c"].ci95[0] > 1.03 * F_c


def test_motions_tell_what_one_does_though_level_and_mass_differ():
    """F_c by 4 % and M by 1 %: of several the rigid axis stayed, with F_v 5 % off under ±6 %."""
    logs = [falling(1.0 + 0.04 * u, 6.0, 0.01 * w * M) for u, w in ((1, 0), (-1, 1), (0, -1))]
    found = fric.identify_plant(logs).fit.estimates
    for name, true, width in (("M", M, 0.06), ("F_v", F_v, 0.04), ("F_c", F_c, 0.25)):
        low, high = found[name].ci95
        assert low < true < high < low + width * true, name


def test_gains_are_in_the_unit_of_the_effort():
    tree = gains_of("K_v=40 1/s, K_p=500 A*s/m, K_i=15000 A/m", "x", "linear/A/A")
    assert (tree["K_p"]["unit"], tree["K_i"]["unit"]) == ("A*s/m", "A/m")
    with pytest.raises(FricError, match=r"K_p: .* cannot be in 'V.s/m'.*: no voltage is in its logs") as refused:
        gains_of("K_v=40 1/s, K_p=500 V*s/m, K_i=15000 V/m", "x", "linear/A/A")
    assert "K_p=… A*s/m" in refused.value.hint


def test_friction_of_one_unit_serves_an_axis_of_volts_and_gains_do_not():
    document = friction_of(StaticMap(F_c=2.0, F_s=2.5, v_s=1e-3), "x", "linear/N/N")
    assert isinstance(document, FrictionDocument)
    assert document.belongs("x", "linear")
    assert not document.belongs("x", "linear/A")
    plant = PlantDocument.model_validate(
        {"fric": "plant/1", "axis": "x", "motion": "linear/A/A", "A": {"value": 1, "unit": "1/s"},
         "T_d": {"value": 1e-3, "unit": "s"}}
    )  # fmt: skip
    assert plant.belongs("x", "linear/A/A")
    assert not plant.belongs("x", "linear/A")


def test_the_current_of_a_circle_is_its_input_where_it_is_the_drives():
    t = np.linspace(0.0, 4.0, 4001)
    axes = {
        name: AxisTrace(t, 0.03 * f(np.pi * t), 0.03 * f(np.pi * t), force=f(np.pi * t), unit="A")
        for name, f in (("x", np.cos), ("y", np.sin))
    }
    test = MeasuredCircle(0.03, 0.03 * np.pi, 1, axes)
    of = test.of_effort({"x": "linear/A/A", "y": "linear"}).axes
    assert of["x"].input is of["x"].force
    assert of["y"].input is None


def test_a_plant_that_is_wrong_is_left_out_and_friction_goes_on(tmp_path: Path):
    """A of 6628 1/s from a sine before sliding was shown, and friction was identified beside it."""
    folder = tmp_path / "logs"
    folder.mkdir()
    write_logs(folder / "log.h5", [motion()])
    tried = []

    def made(step):
        tried.append((step.command, {*step.options}))
        raise FricError("a mass that is not seen" if step.command == "identify plant" else "not here")

    session = Session(tmp_path / "out", lambda step: step.make() if step.command == "ingest" else made(step), print)
    take_efforts(sources := find_sources([folder]))
    outcome = identify_axes(session, sources, lambda _: None)["x"]
    assert [(name, "plant" in options) for name, options in tried] == [
        ("identify plant", False),
        ("identify lugre", False),
    ]
    assert "x: plant" in session.failed
    assert not outcome.whole


@pytest.mark.long(30)
def test_the_effort_alone_decides_as_effort_and_voltage_do(tmp_path: Path):
    """The example as a drive logs it that knows its force alone: the circle is predicted, and (c) leaves as much."""
    folder = tmp_path / "logs"
    folder.mkdir()
    K_f = 150.0
    fric.circle("virtual-rig", "a", velocity=0.15, axis="x").save(tmp_path / "fast.h5")
    trace = read_circles(tmp_path / "fast.h5")[0].axes["x"]
    move = Log(trace.time, trace.position, input=trace.input, reference=trace.reference, kind="motion", name="move")
    for name in ("constant-velocity", "presliding-sine", "sliding-sine", "move"):
        logs = [move] if name == "move" else read_logs(DATA / f"{name}.h5")
        write_logs(folder / f"{name}.h5", [replace(log, force=K_f * log.input, input=None) for log in logs])
    (test,) = read_circles(DATA / "circle.h5")
    axes = {name: replace(trace, force=K_f * trace.input, input=None) for name, trace in test.axes.items()}
    write_circles(folder / "circle.h5", [replace(test, axes=axes)])
    counted = []
    found = fric.auto(
        folder, output=tmp_path / "out", workers=1, advance=lambda n=1, **of: counted.append((n, of.get("total")))
    )
    assert found.steps <= sum(n for n, _ in counted) <= counted[0][1]
    assert found.axes["x"].motion == "linear/N/N"
    predicted, measured = found.verdict.compared
    assert predicted == pytest.approx(measured, rel=0.05)
    gains = fric.read_machine(tmp_path / "out/machine.yaml").axis("x").cascade
    true = fric.read_machine("virtual-rig").axis("x").cascade
    assert gains.K_v == pytest.approx(true.K_v, rel=0.05)
    assert gains.K_p == pytest.approx(K_f * true.K_p, rel=0.05)
    friction = read_document(tmp_path / "out/x/friction.yaml", FrictionDocument)
    left = fric.circle(fric.read_machine("virtual-rig"), "a", axis="x").runs[0].circularity.glitch
    assert measured == pytest.approx(left, rel=0.05)
    assert friction.section("gms")
    assert found.verdict.choice.scheme.name == "c"


def test_a_voltage_alone_identifies_the_friction_in_volts(tmp_path: Path) -> None:
    """Static map, GMS and circle were "missing … no force was logged", and no log of such a drive has any."""
    for name in ("constant-velocity", "presliding-sine", "sliding-sine", "frequency-response"):
        write_logs(tmp_path / f"{name}.h5", [replace(log, force=None) for log in read_logs(DATA / f"{name}.h5")])
    take_efforts(found := find_sources([tmp_path]))
    assert {log.motion for log in found.logs} == {"linear/V/V"}
    taken = axis_steps(found.logs, tmp_path / "out")
    commands = [step.command for step in taken.steps]
    assert {f"identify {what}" for what in ("plant", "static", "gms")} | {"design observer"} <= {*commands}
    assert taken.missing == []
    strokes = [replace(log, force=None, motion="linear/V/V") for log in read_logs(DATA / "constant-velocity.h5")]
    friction = fric.identify_static(strokes)
    low, high = friction.F_c.ci95
    mean = 0.5 * (AXIS.friction.model.static.F_c + AXIS.friction.negative.F_c)
    assert low < mean / AXIS.plant.K_f < high < 1.1 * low
    write_logs(tmp_path / "sliding-sine.h5", read_logs(DATA / "sliding-sine.h5"), force=True)  # K_f is in it
    take_efforts(found := find_sources([tmp_path]))
    assert {log.motion for log in found.logs} == {"linear"}


def test_strokes_give_the_plant_where_another_motion_gives_none(tmp_path: Path) -> None:
    """A sine below the Stribeck velocity, whose friction falls with speed, ended a session without a decision."""
    kinds = {"strokes": "constant-velocity", "sine": "sliding-sine"}
    for name in kinds:
        (tmp_path / f"{name}.h5").touch()
    logs = [
        Source(tmp_path / f"{name}.h5", "x", "linear/A/A", frozenset({kind}), frozenset({"motion", "static"}),
               driven=True, strokes=20)
        for name, kind in kinds.items()
    ]  # fmt: skip

    def made(step) -> None:
        if [path.stem for path in step.given] == ["sine"]:
            raise FricError("F_v is -25 A·s/m, which no axis has")
        step.output.touch()

    said: list[str] = []
    session = Session(tmp_path / "out", made, said.append)
    axis = identify_axes(session, Sources(logs=logs))["x"]
    assert axis.done[:2] == ["plant", "static"]
    assert (axis.missing[1:], session.failed) == ([], {})
    assert "which no axis has" not in "".join(said)


def test_strokes_of_an_effort_are_beside_a_motion_that_shows_its_mass(tmp_path: Path) -> None:
    """Of a motion alone cogging passed for mass: B was 1.38 (1.35 … 1.41) for 1.56 m/(s²·A)."""
    uses = frozenset({"motion", "static"})
    logs = [
        Source(tmp_path / f"{kind}.h5", "x", "linear/A/A", frozenset({kind}), uses, driven=True, strokes=20)
        for kind in ("constant-velocity", "motion")
    ]  # fmt: skip
    plant = axis_steps(logs, tmp_path / "out").steps[0]
    assert (plant.command, {path.stem for path in plant.given}) == ("identify plant", {"motion", "constant-velocity"})
    in_volts = [replace(log, motion="linear", driven=False) for log in logs]
    assert [path.stem for path in axis_steps(in_volts, tmp_path / "out").steps[0].given] == ["motion"]


def multisine(motion: Motion = "linear/A", late: float = 0.0) -> Log:
    """Return the motion of a rigid axis that slides, by a periodic force that acts some time after it was logged."""
    t, rng = np.arange(0.0, 8.0, 1e-3), np.random.default_rng(4)
    w, phase = 2 * np.pi * np.arange(4.0, 180.0, 2.0)[:, None], rng.uniform(0, 2 * np.pi, (88, 1))

    def force(at):
        return 0.3 * np.sin(w * at + phase)

    z = 0.05 * t - (force(t - late) / (M * w**2)).sum(0)
    v = 0.05 - (0.3 * np.cos(w * (t - late) + phase) / (M * w)).sum(0)
    noise = rng.normal(0, 0.02, len(t))
    return Log(t, position=z, force=force(t).sum(0) + F_v * (0 * v + 0.05) + F_c + noise, motion=motion)


@pytest.mark.parametrize("late", [0.0, 3e-3])
def test_a_response_to_the_effort_alone_shows_the_mass(late: float) -> None:
    """A hold was taken for granted, and the phase of a force that acts at once left 23 % unexplained."""
    found = fric.identify_plant(multisine("linear/A/A", late))
    assert (float(found.K_f), float(found.A)) == (1.0, 0.0)
    lag = float(found.fit.estimates.get("force_lag", 0.0))  # the force acts so much later than it was logged
    assert float(found.T_d) - lag == pytest.approx(late, abs=20e-6)
    low, high = found.B.ci95
    assert low < 1 / M < high < low * 1.02
    assert found.T_d.assumed == (late == 0.0)
    assert float(found.T_d) == pytest.approx(late or 443e-6, abs=20e-6)
    assert ("T_d-assumed" in {notice.code for notice in found.warnings}) == (late == 0.0)
    assert not {"response-misfit", "A-open", "A-holds-viscous", "K_f-missing"} & {n.code for n in found.warnings}


def test_a_command_is_held_and_a_measured_effort_is_not() -> None:
    """B was 6 to 10 % low of a command, which a response took for an effort that acts when it is logged."""
    rate, late, rng = 1000.0, 3, np.random.default_rng(6)
    t = np.arange(8000) / rate
    w, phase = 2 * np.pi * np.arange(4.0, 200.0, 2.0)[:, None], rng.uniform(0, 2 * np.pi, (98, 1))
    asked = 0.3 * np.sin(w * t + phase).sum(0)
    a = np.concatenate([asked[-late:], asked[:-late]]) / M  # periodic; constant from sample to sample
    v = np.concatenate([[0.0], np.cumsum(a)[:-1]]) / rate
    v -= v.mean()
    z = np.concatenate([[0.0], np.cumsum(v + 0.5 * a / rate)[:-1]]) / rate
    log = Log(t, position=z + 0.05 * t, force=asked + F_c + F_v * 0.05, motion="linear/A/A")
    found = fric.identify_plant(log)
    assert float(found.B) == pytest.approx(1.0 / M, rel=2e-3)
    assert float(found.T_d) == pytest.approx((late + 0.5) / rate, rel=1e-2)


def test_the_delay_of_a_logged_effort_can_be_given() -> None:
    """`--delay` was refused beside a response, and the hint was to give it."""
    given = fric.identify_plant(multisine("linear/A/A"), delay="0.65 ms")
    assert float(given.T_d) == pytest.approx(0.65e-3)
    assert float(given.fit.estimates["force_lag"]) == pytest.approx(0.65e-3, abs=20e-6)
    assert not given.T_d.assumed
    assert "T_d-assumed" not in {notice.code for notice in given.warnings}
    with pytest.raises(FricError, match="goes with the other method"):  # which shows it, in volts
        fric.identify_plant("data/frequency-response.h5", delay="0.65 ms")


def test_a_force_alone_is_the_input_of_a_response(tmp_path: Path) -> None:
    """A multisine of the current alone passed for strokes at constant velocity."""
    write_logs(tmp_path / "log.h5", [multisine()])
    take_efforts(found := find_sources([tmp_path]))
    (source,) = found.logs
    assert (source.kinds, source.motion, source.driven) == (frozenset({"frequency-response"}), "linear/A/A", True)
    assert "plant" in source.uses
    steps = axis_steps([source], tmp_path / "out").steps
    assert [step.command for step in steps] == ["identify plant", "design controller"]
    beside = replace(source, driven=False, motion="linear/A")  # another log has the voltage: it takes its response
    assert not axis_steps([beside], tmp_path / "out").steps


def test_a_response_gives_the_plant_before_the_motion_in_it_does(tmp_path: Path) -> None:
    """Tried as a motion alone, a chirp around rest "does not show the mass", and no circle was predicted."""
    write_logs(tmp_path / "log.h5", [multisine()])
    uses, taken = frozenset({"plant", MOTION}), []
    source = Source(
        tmp_path / "log.h5", "x", "linear/A/A", frozenset({"frequency-response"}), uses, driven=True,
        efforts=frozenset({"force"}),
    )  # fmt: skip

    def made(step):
        taken.append(step)
        raise FricError("nothing is shown")

    identify_axes(Session(tmp_path / "out", made, lambda _: None), Sources(logs=[source]), lambda _: None)
    methods = [step.options.get("method") for step in taken if step.command == "identify plant"]
    assert methods == [None, "motion"]


def test_controllers_of_a_machine_have_one_sampling(tmp_path):
    """A controller found at 1 kHz and one designed at 4 kHz made no machine, and `auto` ended without its table."""
    sources = []
    for axis in "xy":
        write_logs(tmp_path / f"{axis}.h5", [replace(motion("linear/A/A"), axis=axis)])
        uses = frozenset({"plant"})
        sources.append(
            Source(tmp_path / f"{axis}.h5", axis, "linear/A/A", frozenset({"frequency-response"}), uses, driven=True)
        )
    known, taken = tmp_path / "known.yaml", []
    text = "K_v=40 1/s, K_p=30 A*s/m, K_i=1000 A/m"
    known.write_text(dump(gains_of(text, "y", "linear/A/A") | {"sampling": {"value": 1000.0, "unit": "Hz"}}))
    plant = fric.identify_plant(motion("linear/A/A"), method="motion")  # whose delay is assumed: 443 µs

    def made(step):
        taken.append(step)
        plant.save(step.output, force=True) if step.command == "identify plant" else step.output.touch()

    session = Session(tmp_path / "out", made, lambda _: None)
    identify_axes(session, Sources(logs=sources), lambda logs: known if logs[0].axis == "y" else None)
    (designed,) = [step for step in taken if step.command == "design controller"]
    assert designed.name == "x: controller"
    assert parse(designed.options["sampling"], "frequency") == 1000.0
    assert fric.design_controller(plant, sampling="1 kHz").design.cascade.sampling == 1000.0
