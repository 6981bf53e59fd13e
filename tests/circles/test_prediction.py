"""A prediction that knows what it does not: completed by a circle, widened by misfit, not trusted where told."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fric
from fric.circles.measured import measured_from_run
from fric.circles.prediction import predicted as predicted_of
from fric.circles.tune import LeftOver, distrusts
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.contours import prediction_of, prediction_tree
from fric.documents.friction import FrictionDocument
from fric.documents.machine_files import FORM, IdentifiedMachine, discrepancies
from fric.documents.plant import PlantDocument
from fric.flaws import CATALOGUE
from fric.friction.directed import PLAY, since_reversal
from fric.notice import Notice
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.spread import draw_machine
from fric.verdict import evidence_of

CIRCLE = Circle(0.03, 0.1)


@pytest.fixture(scope="module")
def identified():
    """Return the bundled table as it is believed to be: no flaw, exact belief, no gain."""
    machine = fric.read_machine("xy-table", gain=1.0)
    axes = {name: replace(axis, friction=axis.nominal_friction.models["gms"]) for name, axis in machine.axes.items()}
    return replace(machine, axes=axes)


def risen(machine, level=1.2, stiffness=0.8):
    """Return a machine whose friction is another than its controllers believe: higher, softer, and uneven."""
    axes = {}
    for n, (name, axis) in enumerate(machine.axes.items()):
        model, up = axis.friction, level + 0.1 * n
        static = replace(model.static, F_c=model.static.F_c * up, F_s=model.static.F_s * up)
        friction = replace(model, static=static, k=tuple(stiffness * k for k in model.k))
        axes[name] = replace(axis, friction=friction, load=5.0)
    return replace(machine, axes=axes)


def quadrants(machine, scheme):
    return np.array(run_circle(machine, PAPER_SCHEMES[scheme], CIRCLE).circularity.quadrants)


@pytest.fixture(scope="module")
def test_of_risen(identified):
    return measured_from_run(run_circle(risen(identified), PAPER_SCHEMES["a"], CIRCLE))


def test_a_record_without_a_whole_turn_completes_nothing(identified, test_of_risen):
    """It ended in a traceback, on one sort of processor alone."""
    left = LeftOver.of([test_of_risen], identified, ["x", "y"])
    none = {
        name: tuple(replace(record, revolution=np.full_like(record.revolution, -1)) for record in records)
        for name, records in left.records.items()
    }
    friction = replace(left, records=none)(identified).axes["x"].friction
    assert not np.any([friction.forwards, friction.backwards])


def test_noise_of_a_voltage_is_no_friction_that_makes_the_loop_swing(identified):
    """Counts of an encoder in an aliased voltage, as residual friction, were an observer's limit cycle."""
    rng = np.random.default_rng(0)
    run = measured_from_run(run_circle(risen(identified), PAPER_SCHEMES["a"], replace(CIRCLE, revolutions=3)))
    axes = {
        name: replace(trace, input=trace.input + rng.normal(0.0, 0.15, len(trace.input)))
        for name, trace in run.axes.items()
    }
    noisy = LeftOver.of([replace(run, axes=axes)], identified, ["x", "y"])(identified)
    exact = LeftOver.of([run], identified, ["x", "y"])(identified)
    swings = [run_circle(machine, PAPER_SCHEMES["d"], CIRCLE).circularity.oscillation for machine in (noisy, exact)]
    assert swings[0] < swings[1] + 0.3e-6
    assert np.allclose(quadrants(noisy, "a"), quadrants(exact, "a"), rtol=0, atol=2e-6)


def test_travel_begins_anew_where_the_motion_has_come_back_by_the_play():
    way = np.concatenate([np.linspace(0, 1e-4, 101), np.linspace(1e-4, 5e-5, 51)[1:]])
    direction, travel = since_reversal(way)
    assert direction[1] == 1.0
    assert direction[-1] == -1.0
    assert travel[100] == pytest.approx(1e-4)
    assert travel[-1] == pytest.approx(5e-5)
    # counts of an encoder, less than the play, are no reversal
    rippled = np.linspace(0, 1e-4, 2001) + 0.2 * PLAY * np.tile([0.0, 1.0, 0.0], 667)[:2001]
    assert np.all(since_reversal(rippled)[0][1:] == 1.0)


@pytest.mark.parametrize("scheme", ["a", "b", "c", "d", "f"])
def test_a_machine_that_a_circle_completes_does_what_the_true_one_does(identified, test_of_risen, scheme):
    """The circle without compensation tells what the others leave, though friction is a fifth to a third higher."""
    completed = LeftOver.of([test_of_risen], identified, ["x", "y"])(identified)
    true = quadrants(risen(identified), scheme)
    assert np.abs(quadrants(completed, scheme) - true).max() < 0.8e-6
    if scheme == "c":
        assert np.abs(quadrants(identified, scheme) - true).max() > 3e-6  # what no interval of the logs could hold


def test_machines_of_other_parameters_are_completed_to_the_same_circle(identified, test_of_risen):
    left = LeftOver.of([test_of_risen], identified, ["x", "y"])
    softer = risen(identified, level=0.7, stiffness=1.5)
    one, other = (quadrants(left(machine), "a") for machine in (identified, softer))
    assert np.abs(quadrants(identified, "a") - quadrants(softer, "a")).max() > 3e-6
    assert np.abs(one - other).max() < 0.4e-6
    assert np.abs(one - quadrants(risen(identified), "a")).max() < 0.4e-6


def test_a_voltage_that_was_not_recorded_is_what_the_controller_gives(identified, test_of_risen):
    bare = {name: replace(trace, input=None) for name, trace in test_of_risen.axes.items()}
    without = LeftOver.of([replace(test_of_risen, axes=bare)], identified, ["x", "y"])
    with_it = LeftOver.of([test_of_risen], identified, ["x", "y"])
    assert np.abs(quadrants(with_it(identified), "c") - quadrants(without(identified), "c")).max() < 0.1e-6


def test_a_current_that_was_recorded_as_force_is_the_input_of_an_axis_in_amperes(identified, test_of_risen):
    """Else it was what the controller gives: with K_v 4 % off its integral rose to 21 A, and friction with it."""
    axes = {name: replace(trace, input=None, force=trace.input, unit="A") for name, trace in test_of_risen.axes.items()}
    in_amperes = {name: replace(axis, motion="linear/A/A") for name, axis in identified.axes.items()}
    found = LeftOver.of([replace(test_of_risen, axes=axes)], replace(identified, axes=in_amperes), ["x", "y"])
    for name, (record,) in found.records.items():
        np.testing.assert_array_equal(record.raw[3], axes[name].force)


@pytest.fixture(scope="module")
def predicted(identified, test_of_risen):
    """Return what is predicted with intervals of a hundredth, about a machine whose friction is a fifth higher."""
    intervals = {
        name: {key: (0.99 * value, 1.01 * value) for key, value in
               (("F_c", axis.friction.static.F_c), ("F_s", axis.friction.static.F_s), ("B", axis.plant.B))}
        for name, axis in identified.axes.items()
    }  # fmt: skip
    known = IdentifiedMachine(
        identified, intervals, {}, {}, {"x": (Notice("k ± 0.1", "prediction-widened", "note"),)}, ()
    )
    given = {"velocity": 0.1, "machines": 8, "workers": 1, "spread": {}}
    axes = {
        name: replace(trace, **{key: values[::20] for key, values in trace.channels().items()})
        for name, trace in test_of_risen.axes.items()
    }
    slow = replace(test_of_risen, axes=axes, name="slow")  # at 200 Hz: it judges nothing, and takes no trust away
    held = fric.circle(known, "a,c,f", measured=[slow, test_of_risen], **given)
    assert "circle-unused" in {notice.code for notice in held.warnings}
    return {"alone": fric.circle(known, "a,c,f", **given).prediction, "held": held.prediction}


def test_the_interval_holds_the_true_machine_where_a_circle_was_measured(identified, predicted):
    held, alone = predicted["held"], predicted["alone"]
    for scheme in ("a", "c", "f"):
        true = np.abs(quadrants(risen(identified), scheme)).max()
        low, high = held.schemes[scheme].ci95
        assert low <= true <= high
        assert high - low < 3e-6
        assert held.trusted(scheme), held.schemes[scheme].why
    assert not alone.schemes["c"].ci95[0] <= true <= alone.schemes["c"].ci95[1]
    assert [why.code for why in alone.schemes["c"].why] == ["no-measured-circle"]


def test_a_prediction_reads_as_it_was_written(predicted):
    for one in predicted.values():
        assert prediction_of(prediction_tree(one)) == one
    assert predicted["held"].schemes["c"].under <= predicted["held"].schemes["c"].ci95[1]
    assert predicted["held"].measured
    assert predicted["held"].widened["x"]


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda axis: replace(axis, cascade=replace(axis.cascade, K_p=0.5 * axis.cascade.K_p)), "controller-differs"),
        (lambda axis: replace(axis, plant=replace(axis.plant, T_d=1.05e-3)), "delay-differs"),
        (lambda axis: replace(axis, nominal=replace(axis.plant, B=0.97 * axis.plant.B, A=1.1 * axis.plant.A)), None),
        (lambda axis: axis, None),
    ],
)
def test_what_the_circle_contradicts_is_not_trusted(identified, change, code):
    test = measured_from_run(run_circle(identified, PAPER_SCHEMES["a"], CIRCLE))
    assert _contradicted(replace(identified, axes={k: change(a) for k, a in identified.axes.items()}), test) == code


def test_friction_that_differs_is_no_contradiction(identified, test_of_risen):
    assert _contradicted(identified, test_of_risen) is None


def test_friction_that_has_fallen_is_no_other_delay(identified):
    """It reaches its level sooner, as of a shorter delay: without softer and stiffer friction beside it, a longer one
    left 2.3 times less of the circle's voltage."""
    fallen = measured_from_run(run_circle(risen(identified, level=0.85, stiffness=1.0), PAPER_SCHEMES["a"], CIRCLE))
    assert _contradicted(identified, fallen) != "delay-differs"


def test_what_a_circle_settles_does_not_speak_against_the_verdict(predicted):
    coded = [Notice("drifts", "force-drifts", "wrong").as_dict(), Notice("turned", "force-turned", "wrong").as_dict()]
    codes = {
        name: {one.code for one in evidence_of({"warnings_coded": coded}, (), one).notices}
        for name, one in predicted.items()
    }
    assert codes == {"held": {"force-turned"}, "alone": {"force-drifts", "force-turned"}}


def _contradicted(stated, test):
    left = LeftOver.of([test], stated, ["x", "y"])
    records = [one for own in left.records.values() for one in own]
    codes = [why.code for why in distrusts(left(stated), (), [test], records, CIRCLE)]
    return next((code for code in codes if not CATALOGUE[code].disagrees), codes[0] if codes else None)


def test_warnings_that_a_circle_settles_are_no_reason_and_others_are(identified, test_of_risen):
    settled, other = Notice("drifts", "force-drifts", "wrong"), Notice("turned", "force-turned", "wrong")
    left = LeftOver.of([test_of_risen], identified, ["x", "y"])(identified)
    assert distrusts(left, [settled, other], [test_of_risen], (), CIRCLE) == (other,)
    assert {why.code for why in distrusts(identified, [settled, other], (), (), CIRCLE)} == {
        "no-measured-circle", "force-drifts", "force-turned",
    }  # fmt: skip


def plant(**fit):
    told = {"A": "20 1/s", "B": "3 m/(s^2*V)", "T_d": "0.6 ms", "K_f": "210 N/V", "fit": fit}
    return PlantDocument.model_validate({"fric": "plant/1", "axis": "x", **told})


def friction(notices=(), **fit):
    static = {"F_c": "80 N", "F_s": "100 N", "v_s": "2 mm/s", "sigma": "0 N*s/m"}
    tree = {"fric": "friction/1", "axis": "x", "static": static, "fit": fit}
    tree |= {"warnings_coded": notices, "warnings": [one["text"] for one in notices]}
    return FrictionDocument.model_validate(tree)


def test_misfit_scatter_and_warnings_widen_what_is_drawn():
    calm, why = discrepancies(friction(), plant())
    assert {name: round(spread.high - 1, 3) for name, spread in calm.items()} == FORM
    assert not why
    scattered, why = discrepancies(friction(between_strokes="2 N"), plant(misfit={"value": 0.3, "unit": "1"}), ["C"])
    assert scattered["level"].high == pytest.approx(1 + 1.96 * 2 / 80)
    assert scattered["B"].high > 1.29
    assert scattered["T_d"].high > 1.9
    assert scattered["C"].high == 2.0
    assert len(why) >= 4
    placed, (why,) = discrepancies(friction(over_position="3 N"), plant())
    assert placed["level"].high == pytest.approx(1 + 1.96 * 3 / 80)
    assert "place to place" in why
    coded = [{"code": "force-drifts", "severity": "doubt", "text": "the force drifts"}]
    told, why = discrepancies(friction(coded), plant())
    assert told["level"].high == pytest.approx(1.08)
    assert "the force drifts" in why[0]


def test_discrepancies_add_to_the_intervals(identified):
    spread = fric.Spread(0.5, 2.0, "log-normal")
    interval = {"x": {"F_c": (100.0, 110.0)}}
    drawn = [
        draw_machine(identified, n, spreads={}, intervals=interval, discrepancies=beyond)[0]
        .axes["x"]
        .friction.static.F_c
        for beyond in ({}, {"x": {"level": spread}})
        for n in range(60)
    ]
    alone, widened = np.log(drawn[:60]), np.log(drawn[60:])
    assert np.std(alone) < 0.03
    assert np.std(widened) == pytest.approx(np.log(2.0) / 1.96, rel=0.25)


def test_a_scheme_that_is_often_unstable_is_not_trusted():
    machine = fric.read_machine("xy-table")
    study = SimpleNamespace(machine=machine, only=None, schemes=[PAPER_SCHEMES["d"]], circle=CIRCLE, discrepancies={})
    signed = np.full((10, 1, 4), 5e-6)
    signed[:2] = np.nan

    class Many(SimpleNamespace):
        def __len__(self):
            return 10

    told = predicted_of(Many(study=study, quadrants=signed, glitches=np.abs(signed).max(axis=2)))
    assert told.schemes["d"].unstable == pytest.approx(0.2)
    assert [why.code for why in told.schemes["d"].why] == ["scheme-unstable"]


def test_the_interval_of_a_scheme_that_was_measured_holds_the_measured_glitch():
    """Of a session (a) was "at most 40.0 µm", and its circle had 41.6: no machine that is drawn is the real one."""
    machine = fric.read_machine("xy-table")
    study = SimpleNamespace(machine=machine, only=None, schemes=[PAPER_SCHEMES["a"]], circle=CIRCLE, discrepancies={})
    signed = np.full((10, 1, 4), 5e-6) * np.linspace(0.99, 1.01, 10)[:, None, None]

    class Many(SimpleNamespace):
        def __len__(self):
            return 10

    many = Many(study=study, quadrants=signed, glitches=np.abs(signed).max(axis=2))
    without = predicted_of(many).schemes["a"]
    seen = predicted_of(many, seen={"a": {"+x": 4e-6, "+y": 8e-6, "-x": 5e-6, "-y": 5e-6}}).schemes["a"]
    assert without.under < 6e-6
    assert seen.glitch == without.glitch
    assert seen.under == seen.ci95[1] == seen.axes["y"][1] == seen.quadrants["+y"][1] == 8e-6
    assert seen.axes["x"] == without.axes["x"]
    assert seen.quadrants["+x"][0] == 4e-6
