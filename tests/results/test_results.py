"""Results: what they print is what the command prints, and they plot, tabulate, save and are believed."""

from __future__ import annotations

import ast
import importlib
import inspect as introspection
import json
import pickle
import re
import textwrap
from copy import deepcopy
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import fric
from fric.cli.main import app
from fric.columns import CHANNELS
from fric.documents import document_types
from fric.documents.yaml import dump, plain, read_tree
from fric.errors import FricError
from fric.estimate import as_filed

ROOT = Path(__file__).parents[2]
DATA = ROOT / "data"
RUN = CliRunner()
STROKES, SINES, RESPONSE = DATA / "constant-velocity.h5", DATA / "presliding-sine.h5", DATA / "frequency-response.h5"


@pytest.fixture(scope="module")
def plant(rig_plant):
    return rig_plant


@pytest.fixture(scope="module")
def static(rig_static):
    return rig_static


@pytest.fixture(scope="module")
def gms(plant, static):
    return fric.identify_gms(SINES, static=static, plant=plant, blocks=3)


def said(*words: object) -> str:
    """Return what a command prints, without the line that tells what was written."""
    done = RUN.invoke(app, [*map(str, words)])
    assert done.exit_code == 0, done.output
    return "\n".join(line.rstrip() for line in done.stdout.splitlines() if not line.startswith("wrote "))


def without_warnings(result: fric.Result) -> str:
    return "\n".join(line for line in repr(result).splitlines() if not line.startswith(("warning: ", "note: ")))


@pytest.fixture(scope="module")
def commanded(tmp_path_factory):
    """Return where the commands wrote plant and static map, and what they printed."""
    files = {name: tmp_path_factory.mktemp("commanded") / f"{name}.yaml" for name in ("plant", "static")}
    printed = {"plant": said("identify", "plant", RESPONSE, "-o", files["plant"])}
    words = ("--plant", files["plant"], "-o", files["static"])
    return files, printed | {"static": said("identify", "static", STROKES, *words)}


def test_the_command_prints_the_very_same(plant, static, commanded):
    _, printed = commanded
    assert printed == {"plant": without_warnings(plant), "static": without_warnings(static)}
    assert said("inspect", STROKES) == without_warnings(fric.inspect(STROKES))


@pytest.mark.long(3)
def test_the_command_prints_the_very_same_of_blocks(plant, static, gms, tmp_path):
    files = {name: tmp_path / f"{name}.yaml" for name in ("plant", "static", "gms")}
    plant.save(files["plant"])
    static.save(files["static"])
    words = ("--plant", files["plant"], "--static", files["static"], "--blocks", "3", "-o", files["gms"])
    assert said("identify", "gms", SINES, *words) == without_warnings(gms)


def test_what_is_saved_is_what_the_command_writes(static, plant, commanded, tmp_path):
    files, _ = commanded
    static.save(tmp_path / "saved.yaml")
    plant.save(tmp_path / "plant.yaml")
    saved, written = (plain(read_tree(path)) for path in (tmp_path / "plant.yaml", files["plant"]))
    assert {name: saved[name] for name in ("A", "B", "T_d")} == {name: written[name] for name in ("A", "B", "T_d")}
    saved, written = (plain(read_tree(path)) for path in (tmp_path / "saved.yaml", files["static"]))
    assert saved["static"].keys() == written["static"].keys()
    for name, entry in saved["static"].items():
        assert entry["value"] == pytest.approx(written["static"][name]["value"], rel=1e-4), name
    with pytest.raises(fric.FricError, match="the output exists"):
        static.save(tmp_path / "saved.yaml")
    static.save(tmp_path / "saved.yaml", force=True)


def test_tables_hold_values_and_intervals_in_SI(static, gms):
    frame = static.to_frame()
    told = static.fit.static.estimates["F_c"]
    assert frame.loc[("static", "F_c"), "value"] == float(told)
    assert tuple(static.conf_int().loc[("static", "F_c")]) == told.ci95
    held = fric.identify_static(fric.read(STROKES)[::3], delta=1.0)
    assert ("static", "delta") not in held.conf_int().index  # it was fixed: there is no interval
    alpha = gms.to_frame().loc["gms"].filter(like="alpha", axis=0)
    np.testing.assert_allclose(alpha["value"], gms.fit.alpha.value)


def test_a_figure_shows_what_was_found(static, tmp_path):
    figure = static.plot(tmp_path / "map.svg")
    assert (tmp_path / "map.svg").read_text().startswith("<?xml")
    drawn = np.concatenate([line.get_ydata() for line in figure.axes[0].get_lines() if len(line.get_ydata()) > 20])
    forces = np.array([abs(point.force) for point in static.fit.points])
    assert np.ptp(drawn) > 0.5 * (forces.max() - forces.min()) * (1e-3 if "kN" in figure.axes[0].get_ylabel() else 1)


def test_a_machine_believes_a_result_as_it_believes_its_file(gms, tmp_path):
    gms.save(tmp_path / "friction.yaml")
    machine = fric.read_machine("virtual-rig")
    by_result = fric.circle(machine.with_belief(x=gms), "a,c,f", revolutions=1)
    by_file = fric.circle(
        fric.read_machine("virtual-rig", nominal_files=[f"x={tmp_path / 'friction.yaml'}"]), "a,c,f", revolutions=1
    )
    assert list(by_result.to_frame().index) == ["a", "c", "f"]
    # a file holds six digits, and with them an encoder count falls here or there
    np.testing.assert_allclose(by_result.to_frame()["glitch"], by_file.to_frame()["glitch"], atol=5e-8)
    unsure = fric.circle(machine, "c", revolutions=1).to_frame()["glitch"]["c"]
    assert abs(by_result.to_frame()["glitch"]["c"] - unsure) > 2e-7  # it believes something else now
    assert machine.axis("x").friction is machine.with_belief(x=gms).axis("x").friction


def test_a_machine_believes_models_plants_and_designs(plant):
    machine = fric.read_machine("virtual-rig")
    axis = machine.with_belief(x=[fric.LuGre.typical(), plant, fric.design_controller(plant)]).axis("x")
    assert list(axis.nominal_friction.models) == ["lugre"]
    assert axis.nominal == as_filed(plant.belief)  # to the digits of a file, whether there is one between or not
    assert axis.cascade != machine.axis("x").cascade


@pytest.mark.parametrize(
    ("call", "said_so"),
    [
        (lambda r: fric.identify_gms("x.yaml"), "there is no such file"),
        (lambda r: fric.identify_gms(ROOT / "configs/xy-table.yaml"), "is a machine file, and a log file is needed"),
        (lambda r: fric.identify_gms(42), "identify_gms takes log files, or records that fric.read returns.*an int"),
        (lambda r: fric.identify_gms(None), "was given None"),
        (lambda r: fric.identify_gms(), "no record was given"),
        (lambda r: fric.identify_static(STROKES, plant=r), "takes plant as a plant file.*a StaticResult"),
        (lambda r: fric.identify_gms(SINES, static=3.0), "takes static as a friction file.*a float"),
        (lambda r: fric.identify_gms(SINES, blocks="six"), "'six' is not a number of blocks"),
        (lambda r: fric.identify_model("lugr", SINES), "no friction model 'lugr'.*"),
        (lambda r: fric.compare(SINES, models="lugr"), "no friction model 'lugr'"),
        (lambda r: fric.identify_static(STROKES, plant=3), "takes plant as a plant file, or a result"),
        (lambda r: fric.circle(r), "circle takes a machine, or its file, and was given a StaticResult"),
        (lambda r: fric.circle("xy-tabel"), "Is it xy-table, which comes with fric"),
        (lambda r: fric.circle("xy-table", 3), "takes schemes as names of schemes"),
        (lambda r: fric.circle("xy-table", radius=None), "takes radius as a number or a text, and was given None"),
        (lambda r: fric.circle("xy-table", radius="30"), "has no unit"),
        (lambda r: fric.read_machine("virtual-rig").with_belief(y=r), "axis y was given what is known of axis x"),
        (lambda r: fric.read_machine("virtual-rig").with_belief(x="f.yaml"), "model or plant, and no str"),
        (lambda r: fric.validate(STROKES, plant=None), "was given None"),
        (lambda r: r.save(3), "save takes path as a path or a text, and was given an int"),
        (lambda r: fric.read(STROKES).save(None), "save takes path as a path or a text, and was given None"),
        (lambda r: r.plot(b"x"), "plot takes path as a path or a text, and was given a bytes"),
        (lambda r: r.plot(view=3), "plot takes view as a text, and was given an int"),
        (lambda r: fric.read_machine("xy-table").axis(3), "the machine has no axis '3'"),
    ],
)
def test_what_does_not_fit_ends_in_a_sentence(call, said_so, static):
    with pytest.raises(fric.FricError, match=re.compile(said_so, re.DOTALL)):
        call(static)


@pytest.mark.parametrize("name", [name for name in fric.__all__ if name[0].islower()])
def test_no_verb_takes_what_is_of_no_type(name):
    function = getattr(fric, name)
    needed = [one for one in introspection.signature(function).parameters.values() if one.default is one.empty]
    words = {one.name: "somewhere" for one in needed if one.kind is one.KEYWORD_ONLY}
    places = [one for one in needed if one.kind is not one.KEYWORD_ONLY and one.kind is not one.VAR_KEYWORD]
    for given in (None, 3, b"x", {"a": 1}, [1, 2], object()) if places else ():
        with pytest.raises(fric.FricError, match=r"was given|no "):
            function(*[given] * len(places), **words)


@pytest.mark.parametrize("given", ["105", None, [1.0, 2.0], {"a": 1}, True])
@pytest.mark.parametrize("name", ["StaticMap", "GMS", "LuGre", "Dahl", "Leuven", "MaxwellSlip", "Plant", "Cascade"])
def test_no_model_takes_what_is_no_number(name, given):
    made = getattr(fric, name)
    fields = dict.fromkeys(introspection.signature(made).parameters, given)
    fields |= {"static": fric.StaticMap(50.0, 75.0, 1e-3)} if "static" in fields else {}
    with pytest.raises(fric.FricError, match=rf"{name} takes \w+ as (a number|numbers), and was given|one of each"):
        made(**fields)


@pytest.mark.parametrize("given", [None, 3, b"x", {"a": 1}, object(), [[1.0]], [1j]])
@pytest.mark.parametrize("name", ["Log", "FrequencyResponse", "ForceVelocity", "Scheme", "Axis", "Machine"])
def test_no_record_scheme_or_machine_takes_what_is_of_no_type(name, given):
    made = getattr(fric, name)
    needed = [one.name for one in introspection.signature(made).parameters.values() if one.default is one.empty]
    with pytest.raises(
        fric.FricError, match=rf"{name} takes \w+ as .*, and was given|there is no (time|frequency|velocity)"
    ):
        made(**dict.fromkeys(needed, given))


def test_a_record_takes_lists_and_series_as_arrays():
    t = np.arange(5.0)
    log = fric.Log(pd.Series(t, index=t + 7), position=[0, 1, 2, 3, 4], force=np.ones(5, np.float32))
    assert [type(one) for one in log.channels().values()] == [np.ndarray] * 3
    assert {one.dtype for one in log.channels().values()} == {np.dtype(float)}
    assert "5 samples in 4 s" in repr(log)


def test_every_document_says_its_type_and_is_of_it(static, tmp_path):
    """What is printed as what is written: `fric schema` describes it."""
    out = tmp_path / "out"
    run = fric.circle("xy-table", "a,f", radius=0.005, revolutions=1)
    run.save(tmp_path / "run.h5")
    made = fric.export_axis("c", "xy-table", axis="x")
    made.save(out, force=True)
    table = fric.learn(tmp_path / "run.h5", scheme="f", machine="xy-table")
    results = [made, table, fric.formats(), fric.example("tribometer", output=out), fric.read(STROKES), run, static]
    for one in [json.loads((out / "manifest.json").read_text()), *(result.document for result in results)]:
        document_types()[one["fric"].partition("/")[0]].model_validate(one)


def test_a_machine_is_a_line_an_axis(gms):
    shown = repr(fric.read_machine("xy-table").with_belief(x=gms))
    name, x, y = shown.splitlines()
    assert name == "xy feed table of the paper"
    wanted = "  axis x: plant A 28.57, B 4.526, T_d 0.00065, K_f 548 (SI); friction gms, nominal friction static, gms"
    assert (x, y.startswith("  axis y: ")) == (wanted, True)


def test_no_result_is_told_by_its_arrays(plant, static, gms):
    records = fric.read(SINES)
    told = [plant, static, gms, records, records[0], fric.inspect(SINES), fric.circle("xy-table", "a", revolutions=1)]
    for one in [*told, fric.read(RESPONSE)[0], fric.design_controller(plant), fric.design_observer(plant)]:
        assert len(repr(one)) < 4000, type(one)
        assert "array(" not in repr(one), type(one)


def test_a_notebook_shows_tables_and_escapes_what_files_say(static):
    told = static._repr_html_()
    assert told.count("<table>") == 1
    assert "<td>F_c</td>" in told
    assert (
        "<script"
        not in fric.circle(
            fric.Machine("<script>", fric.read_machine("xy-table").axes), "a", revolutions=1
        )._repr_html_()
    )


def test_each_verb_tells_every_argument():
    """A public docstring has one sentence, and a word on each argument."""
    stub = ast.parse((ROOT / "src/fric/__init__.pyi").read_text())
    for node in (node for node in stub.body if isinstance(node, ast.ImportFrom)):
        for alias in node.names:
            found = getattr(importlib.import_module(f"fric.{node.module}"), alias.name)
            told = textwrap.dedent(introspection.getdoc(found) or "")
            assert told.split("\n")[0].endswith((".", "``.")), alias.name
            if introspection.isfunction(found) and len(introspection.signature(found).parameters) > 1:
                for name in introspection.signature(found).parameters:
                    assert re.search(rf"^(\w+, )*{name}(, \w+)*$", told, re.MULTILINE), f"{alias.name}: {name}"


def test_the_public_names_are_the_subject():
    plumbing = ("keep_freed_memory", "refuse_existing", "sizes", "draw_", "_tree", "write_document", "save_figure")
    assert not [name for name in fric.__all__ if any(word in name for word in plumbing)]
    vocabulary = {"GMS", "StaticMap", "LuGre", "Plant", "Machine", "Axis", "Log", "read", "identify_gms", "circle"}
    assert vocabulary <= set(fric.__all__)


def test_the_range_of_a_short_motion_far_from_zero_is_seen():
    t = np.arange(4000) / 1e3
    log = fric.Log(t, position=-0.3 + 15e-6 * np.sin(2 * np.pi * t), force=10.0 * np.sin(2 * np.pi * t + 0.3))
    printed = repr(fric.inspect(log))
    assert "-300.015 mm  -299.985 mm" in printed
    assert not re.search(r"\d\.\d{8}", printed)  # however sure a number is, it is not printed to its last digit


def test_parameters_are_attributes_and_a_map_predicts(static):
    F_c, entry = static.F_c, static.document["static"]["F_c"]
    assert (float(F_c), F_c.unit, list(F_c.ci95)) == (entry["value"], "N", entry["ci95"])
    with pytest.raises(AttributeError, match="has no 'F_d'"):
        static.F_d  # noqa: B018
    assert pickle.loads(pickle.dumps(static)).F_s.value == static.F_s.value
    force, half = static.predict([-0.02, 0.02])
    assert force[0] < 0 < force[1]
    assert np.all(half > 0)
    level = static.F_c.value + 0.02 * static.sigma.value + static.offset.value
    assert static.predict(0.02)[0][0] == pytest.approx(level, rel=0.02)


def test_a_model_is_replaced_by_one_with_another_value(static, gms):
    """`dataclasses.replace` of the model in it was the only way, in SI and without a word of what does not fit."""
    other = static.replace(F_c="0.06 kN", v_s=2e-3)["static"]
    assert (other.F_c, other.v_s, other.F_s) == (60.0, 2e-3, static.belief["static"].F_s)
    assert static.F_c.value == pytest.approx(63.3, abs=0.1)  # the result itself is as it was
    changed = gms.replace(C="5 kN/s", F_c=other.F_c)
    assert (changed["gms"].C, changed["gms"].static.F_c) == (5e3, 60.0)
    assert fric.read_machine("xy-table").with_belief(x=changed).axes["x"].nominal_friction.models["gms"].C == 5e3
    for value, told in ((-5.0, "-5"), ("60 mm", "cannot be in 'mm'"), (None, "as nothing"), ("x", "not a quantity")):
        with pytest.raises(FricError, match=told):
            static.replace(F_c=value)
    with pytest.raises(FricError, match=r"has no 'F_q'\nIs it F_s"):
        static.replace(F_q=1.0)


def test_a_record_goes_into_a_frame_and_back_also_with_its_time_as_index():
    log = fric.read(DATA / "presliding-sine.h5")[0]
    frame = log.to_frame()
    assert list(frame)[:2] == ["time [s]", "position [m]"]
    for given in (frame, frame.set_index("time [s]")):
        back = fric.Log.from_frame(given, name=log.name, kind=log.kind)
        for channel, values in log.channels().items():
            np.testing.assert_array_equal(back.channels()[channel], values)


def test_a_fraction_is_a_number_and_what_no_document_is_has_no_examples():
    """Numba's error on an array of objects was the answer."""
    assert fric.Dahl(Fraction(1, 3), 3e7, 1.0, 10.0).F_c == 1 / 3
    with pytest.raises(FricError, match="no type of document 'nosuch'"):
        fric.bundled("nosuch")
    with pytest.raises(AttributeError, match="Is it circle"):
        fric.simulate_circle  # noqa: B018


@pytest.mark.parametrize("given", ["", "5 mm/s, x", ["x"]])
def test_an_error_in_a_list_of_quantities_names_its_argument(given):
    for argument in ("speeds", "peaks"):
        with pytest.raises(FricError, match="not a quantity") as error:
            fric.experiment("virtual-rig", "constant-velocity", **{argument: given})
        assert error.value.where == f"`{argument}=`" or isinstance(given, list)
    with pytest.raises(FricError, match="not a quantity"):
        fric.circle_map("xy-table", feeds=given)


def test_a_model_predicts_the_force_over_a_motion(static, gms):
    """A GMS result had the force of its map at a velocity nowhere, nor the cycle that it was identified from."""
    speeds = [-0.02, 1e-3, 0.02]
    np.testing.assert_allclose(gms.predict(speeds)[0], static.predict(speeds)[0], rtol=1e-3)
    assert np.all(gms.predict("1 mm/s")[1] > 0)
    (log,) = (log for log in fric.read(SINES) if log.name.endswith("02"))
    force, half = gms.predict(time=log.time, position=log.position)
    slid = slice(len(log) // 4, None)  # the record does not start relaxed
    assert np.sqrt(np.mean((force - log.force)[slid] ** 2)) < 0.05 * np.abs(log.force).max()
    assert 0.0 < np.median(half) < 5.0
    velocity = np.gradient(log.position, log.time)
    along = gms.predict(velocity, time=log.time)[0]
    assert np.sqrt(np.mean((along - force) ** 2)) < 1.0
    for wrong in ({}, {"position": log.position}, {"time": [0.0, 2.0, 1.0], "position": [0.0, 1.0, 2.0]}):
        with pytest.raises(fric.FricError, match=r"no motion|are unequal"):
            gms.predict(**wrong)


@pytest.mark.parametrize("motion", ["linear", "rotary", "linear/A/A", "rotary/%/%"])
def test_a_record_is_a_frame_and_a_record_again(motion):
    values = {channel: np.linspace(0.0, 1.0, 5) for channel in CHANNELS}
    log = fric.Log(**values | {"mode": np.array([0.0, 0.0, 1.0, 1.0, 0.0])}, motion=motion)
    again = fric.Log.from_frame(pd.DataFrame(log.channels()), motion=motion)
    assert all(np.array_equal(getattr(again, channel), getattr(log, channel)) for channel in CHANNELS)


def test_circles_of_a_frame_need_no_file():
    t = np.arange(8000) / 2000.0
    angle = 2 * np.pi * t / 1.9
    columns = {"time [s]": t, "x_ref [mm]": 30 * np.cos(angle), "y_ref [mm]": 30 * np.sin(angle)}
    lag = {name.replace("ref", "pos"): np.roll(values, 2) for name, values in columns.items() if "ref" in name}
    circles = fric.circles_from_frame(pd.DataFrame({**columns, **lag}), scheme="a")
    assert [(circle.radius, circle.scheme, circle.names) for circle in circles] == [(0.03, "a", ("x", "y"))]
    assert fric.diagnose(*circles).document["radius"]["value"] == 0.03
    with pytest.raises(fric.FricError, match="no whole circle"):
        fric.circles_from_frame({name: values[:3000] for name, values in {**columns, **lag}.items()})
    with pytest.raises(fric.FricError, match="a circle test takes two axes"):
        fric.circles_from_frame({name: values for name, values in columns.items() if "y" not in name})


def test_a_frame_is_a_record_and_a_run_is_a_circle():
    (log, *_) = fric.read(STROKES)
    frame = pd.DataFrame({"time [ms]": 1e3 * log.time, "position": 1e6 * log.position, "force [N]": log.force, "x": 0})
    made = fric.Log.from_frame(frame, {"position": "um"}, kind="constant-velocity")
    np.testing.assert_allclose(made.position, log.position, rtol=1e-12)
    np.testing.assert_allclose(made.time, log.time, rtol=1e-12)
    for broken, why in ((frame.drop(columns="time [ms]"), "no column is named time"), (frame[::-1], "time")):
        with pytest.raises(fric.FricError, match=why):
            fric.Log.from_frame(broken, {"position": "um"})
    with pytest.raises(fric.FricError, match="no column is named force or input") as refused:  # was left out unsaid
        fric.Log.from_frame(frame.rename(columns={"force [N]": "torque [N]"}), {"position": "um"})
    assert "leave out torque [N], x." in refused.value.hint
    driven = fric.Log.from_frame(frame.assign(**{"voltage [mV]": 1e3 * log.force}))
    np.testing.assert_allclose(driven.input, log.force, rtol=1e-12)  # as `fric ingest` reads it; it was left out
    run = fric.circle("virtual-rig", "a,b")
    with pytest.raises(fric.FricError, match="holds 2 circles") as refused:
        fric.diagnose(run)
    assert "`scheme='a'`" in refused.value.hint
    found = fric.diagnose(run, scheme="a")
    assert found.found.glitches["+x"].value == pytest.approx(40e-6, rel=0.1)
    assert float(fric.identify_controller(run, scheme="a").K_p) == pytest.approx(130.9, rel=0.01)


def test_results_take_the_place_of_their_files(gms, tmp_path):
    """A report of results tells what that of their files does; a machine is taken as itself."""
    gms.save(tmp_path / "friction-x.yaml")
    alone, of_file = fric.make_report(gms, fric.read(STROKES)), fric.make_report(tmp_path / "friction-x.yaml", STROKES)
    axes, of_files = (one.document["axes"] for one in (alone, of_file))
    assert axes == of_files == ["x"]
    assert alone.inputs.items[0].sections() == of_file.inputs.items[0].sections()
    model = fric.read_friction(tmp_path / "friction-x.yaml")
    assert isinstance(model, fric.GMS)
    assert model.static == fric.read_friction(tmp_path / "friction-x.yaml", "static")
    with pytest.raises(fric.FricError, match="dahl"):
        fric.read_friction(tmp_path / "friction-x.yaml", "dahl")
    machine = fric.read_machine("xy-table")
    run = fric.circle(machine, "a")
    assert fric.diagnose(run, machine=machine).brief() == fric.diagnose(run, machine="xy-table").brief()
    assert fric.make_report(run, machine).inputs.machine == "machine.yaml"
    nameless = object.__new__(fric.TuneResult)
    object.__setattr__(nameless, "source", "")
    with pytest.raises(fric.FricError, match="has no file"):
        nameless.save(tmp_path / "tuned")


def test_what_a_tuple_holds_may_be_of_several_types() -> None:
    """Once `fric.FormatsResult` was touched, as completion in a notebook does, `fric.formats()` was refused."""
    for name in fric.__all__:
        getattr(fric, name)
    found = fric.formats()
    assert len(found.rows) > 9
    for rows in ((found.rows[0][:4],), (("Text", ".txt", "", "", ""),)):
        with pytest.raises(fric.FricError, match="FormatsResult takes rows"):
            type(found)(rows)


def test_a_load_beyond_all_forces_is_refused() -> None:
    """A load of -2e8 N made a map with a covariance of 1e17."""
    with pytest.raises(
        fric.FricError, match=r"a load of -2e\+08 N is far beyond the strokes' forces \(at most 97.6 N\)"
    ):
        fric.identify_static(DATA / "constant-velocity.h5", load="-2e8 N")


def test_the_interval_of_C_allows_for_that_of_the_mass(plant, static, tmp_path):
    """C was 245 (228 … 264) for 300, where B was known to ± 27 %: the inertia of the sine in sliding moves it."""
    tree, widths = deepcopy(plant.document), []
    sines = fric.read(SINES)[1], *fric.read(DATA / "sliding-sine.h5")
    for share in (0.02, 0.2):
        tree["B"]["ci95"] = [tree["B"]["value"] * (1.0 + side * share) for side in (-1, 1)]
        (tmp_path / "plant.yaml").write_text(dump(tree))
        low, high = fric.identify_gms(*sines, static=static, plant=tmp_path / "plant.yaml", blocks=2).C.ci95
        widths.append(high / low)
    assert widths[1] > 1.1 * widths[0]
