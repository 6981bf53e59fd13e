"""Arguments that are missing, unknown or of a wrong type end in a sentence that names them."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import fric
from fric.errors import FricError
from fric.verb import SHARED, documented

RING: list[object] = []
RING.append(RING)
FRAME = {"time": [0.0, 1e-3, 2e-3], "position": [0.0, 1.0, 2.0]}


@pytest.mark.parametrize(("call", "words"), [
    (lambda: fric.DisturbanceObserver(), "needs q, A, B"),
    (lambda: fric.DisturbanceObserver("binomial2", 1.0, 2.0), "takes q as a QFilter, and was given a str"),
    (lambda: fric.DisturbanceObserver(fric.QFilter(), a=1.0, B=2.0), "has no argument 'a'.*Is it A"),
    (lambda: fric.QFilter("binomial2", "50 Hz"), "takes cutoff as a number, and was given a str"),
    (lambda: fric.PointPath(), "needs x, y, feed"),
    (lambda: fric.PointPath(np.zeros(5), np.arange(5.0), "100 mm/s"), "takes feed as a number, and was given a str"),
    (lambda: fric.Spread(0.8), "needs high"),
    (lambda: fric.Spread(10**400, 1), "takes low as a number"),
    (lambda: fric.Spread(0.0, 1.0), "low of the spread is 0\nlow must be at least 1e-09"),
    (lambda: fric.Spread(1.0, 1.2, np.zeros(2)), "takes distribution as"),
    (lambda: fric.StaticResult(1, []), "StaticResult takes fit as StaticFit, and was given an int"),
    (lambda: fric.CirclesResult(1.0), "CirclesResult takes done as IngestedCircles, and was given a float"),
    (lambda: fric.MeasuredCircle(0.03, 0.05, 1, source=pd.Series([1, 2])), "takes source as a text"),
    (lambda: fric.MaxwellSlip(W=np.zeros(0), k=np.ones(2)), "has 0 W and 2 k"),
    (lambda: fric.circle("virtual-rig", RING), "names of schemes"),
    (lambda: fric.inspect(RING), "log files, or records that fric.read returns"),
    (lambda: fric.design_observer("plant.yaml", resonances=10.0), "takes resonances as a list"),
    (lambda: fric.Spread("a", "b"), "takes low as a number, and was given a str"),
    (lambda: fric.MeasuredCircle(0.1, 0.03), "needs direction"),
    (lambda: fric.Cascade(K_v=100.0, K_p=130.0, Ki=4000.0), "has no argument 'Ki'.*Is it K_i"),
    (lambda: fric.Plant("a", 1, 1, 1), "takes A as a number, and was given a str"),
    (lambda: fric.StaticMap(F_c=60.0), "needs F_s, v_s"),
    (lambda: fric.GMS(1, 2, 3, 4), "takes alpha as numbers, and was given an int"),
    (lambda: fric.Encoder("1 um"), "takes resolution as a number, and was given a str"),
    (lambda: fric.Scheme("x"), "needs title"),
    (lambda: fric.Log(), "needs time"),
    (lambda: fric.Machine("m"), "needs axes"),
    (lambda: fric.Estimate(1.0), "needs unit"),
    (lambda: fric.Estimate(1.0, "N", source=np.zeros(2)), "takes source as a text, and was given a ndarray"),
    (lambda: fric.Estimate(1.0, "N", fixed=np.zeros(2)), "takes fixed as True or False, and was given a ndarray"),
    (lambda: fric.read_machine("x" * 5000), "File name too long\nGive a shorter path"),
    (lambda: fric.ingest("log.csv", output="o.h5", mapping=0.001), "takes mapping as a mapping.*given a float"),
    (lambda: fric.circle("xy-table", "all", known={}), "there is no scheme to run"),
    (lambda: fric.circle("xy-table", []), "`schemes=` of circle is empty"),
    (lambda: fric.circle(), "needs machine"),
    (lambda: fric.circle("xy-table", sped="50 mm/s"), "has no argument 'sped'"),
    (lambda: fric.circle("xy-table", "a", 3), "takes 2 arguments by their place, and was given 3"),
    (lambda: fric.export_axis("c", "xy-table"), "needs axis"),
    (lambda: fric.ingest("log.csv"), "needs output"),
    (lambda: fric.plan(stroke=0.3), "needs feed"),
    (lambda: fric.Log(time=[0.0, 2.0, 1.0]), "an array|does not run forward"),
    (lambda: fric.Log(time=np.array([0.0, 2.0, 1.0]), position=np.zeros(3)), "time does not run forward at sample 2"),
    (lambda: fric.Log(time=1e9 + 1.67e-7 * np.arange(1, 300), position=np.arange(299.0)), "run forward by 4.8e-07 s"),
    (lambda: fric.Log(time=np.array([0.0, 1.0, np.nan]), position=np.zeros(3)), "time is not a number at sample 2"),
    (lambda: fric.Log.from_frame([1, 2]), "takes a data frame, or columns by name, and was given a list"),
    (lambda: fric.Log.from_frame(FRAME, units={"positon": "mm"}), "`units=` names 'positon'.*Is it position"),
    (lambda: fric.Log.from_frame({"time": [0.0, 1.0], "pos": [0.0, 1.0]}), "columns are time, pos. Rename them"),
    (lambda: fric.Log.from_frame(FRAME, units={"position": "N"}), "position cannot be in 'N'"),
    (lambda: fric.Log.from_frame(pd.DataFrame(FRAME | {"force": ["a"] * 3})), "the column 'force' as numbers"),
    (lambda: fric.read_machine("xy-table").save("machine.h5"), "what is written is YAML.*machine.yaml"),
    (lambda: fric.circle("xy-table", "a", radius="-30 mm"), "'-30 mm' is not positive"),
    (lambda: fric.read_machine("xy-table", nominal_files=np.array(None)), "nominal_files as a list, of a text each"),
    (lambda: fric.read_machine("xy-table", nominal_files=["f.yaml"]), "Write it as x=f.yaml"),
    (lambda: fric.design_controller("p.yaml", view="bod"), "and was given 'bod'.*Is it bode"),
    (lambda: fric.circle("xy-table", "a", machines=1, spread={"level": 1}),
     "level as a Spread, and was given an int"),
    (lambda: fric.diagnose(), "no circle was given"),
    (lambda: fric.ingest(output="log.h5"), "there is no file to read"),
    (lambda: fric.tune("xy-table"), "no circle was given"),
    (lambda: fric.identify_gms("data/presliding-sine.h5", knots=[]), "`knots=` of identify_gms is empty.*'auto'"),
    (lambda: fric.identify_model("dahl", "data/presliding-sine.h5", fix=["n"]), "'n' is fixed at nothing"),
    (lambda: fric.design_block("kalmann", "p.yaml"), "there is no control block 'kalmann'.*Is it kalman"),
    (lambda: fric.circle("xy-table", feed="100 mm/s"), "Is it velocity"),
    (lambda: fric.export_axis("cc", "xy-table", axis="x"), "there is no target 'cc'.*Is it c.*linuxcnc"),
    (lambda: fric.export_axis("Siemens", "xy-table", axis="x"), "'Siemens' is not a target.*fric export sinumerik"),
    (lambda: fric.read(pd.DataFrame(FRAME)), "a data frame is no record yet.*Log.from_frame"),
    (lambda: fric.identify_static([pd.DataFrame(FRAME)]), "a data frame is no record yet.*Log.from_frame"),
])  # fmt: skip
def test_an_argument_that_does_not_fit_is_named(call, words):
    with pytest.raises(FricError, match=f"(?s){words}"):
        call()


def test_what_fits_is_as_before():
    watch = fric.DisturbanceObserver(q=fric.QFilter("binomial2", 50.0), A=1.0, B=2.0)
    assert (watch.q.cutoff, watch.A, watch.B) == (50.0, 1.0, 2.0)
    log = fric.Log.from_frame(pd.DataFrame(FRAME), units={"position": "mm"})
    assert log.position == pytest.approx([0.0, 1e-3, 2e-3])


def test_shared_arguments_are_described_in_each_verb():
    told = fric.circle_map.__doc__
    assert "machine\n    A machine file, or a bundled machine such as xy-table." in told
    assert told.index("feeds\n") < told.index("machine\n") < told.index("\nRaises\n")
    assert "    Predict the circle too." in fric.diagnose.__doc__  # its own description stays
    assert (
        documented("Do.", ["seed", "other"], SHARED)
        == "Do.\n\nParameters\n----------\nseed\n    Seed of the coarse search."
    )
    assert documented("Do.", ["other"], SHARED) == "Do."
    assert "\nRaises\n------\nFricError" in str(fric.Machine.with_belief.__doc__)  # of methods, too


def test_a_plant_is_taken_where_its_file_is():
    plant = fric.Plant(A=10.0, B=2.0, T_d=1e-3, K_f=100.0)
    assert fric.design_controller(plant).belief.K_p > 0


def test_a_path_is_run_on_a_machine_of_one_axis():
    machine = fric.read_machine("xy-table")
    t = np.linspace(0.0, 2 * np.pi, 200)
    points = fric.PointPath(0.03 * np.cos(t), 0.03 * np.sin(t), 0.05)
    found = fric.path(replace(machine, axes={"x": machine.axis("x")}), points, "a")
    assert "x turns at -30.0" in repr(found)
    assert {one["axis"] for one in found.document["schemes"]["a"]["reversals"]} == {"x", "y"}


def test_forces_are_predicted_at_velocities():
    static = fric.identify_static(fric.read("data/constant-velocity.h5")[::3])
    force, half = static.predict("10 mm/s")
    assert force == pytest.approx(static.predict(0.01)[0])
    assert half > 0
    for velocity in (None, ["a"], [0.1, np.nan]):
        with pytest.raises(FricError, match="velocity"):
            static.predict(velocity)


def test_a_name_that_is_not_there_is_answered_with_the_like_one():
    with pytest.raises(AttributeError, match="Is it identify_static"):
        fric.idenfity_static  # noqa: B018


def test_a_list_where_a_document_has_one_number_is_named(tmp_path):
    file = tmp_path / "schemes.yaml"
    file.write_text("fric: schemes/1\nschemes:\n  a:\n    lead: {value: [1, 2], unit: ms}\n")
    with pytest.raises(FricError, match=r"schemes\.yaml.*schemes\.a: a list of 2 where one value is expected"):
        fric.read_schemes(file)


def test_what_would_not_be_looked_at_is_refused():
    """As ``--cutoff x`` with a response, or ``--before`` of a file that is not there with rounds."""
    response = "data/frequency-response.h5"
    for given in ({"cutoff": "x"}, {"delay": " "}, {"delay": "0.6 ms"}, {"border": 0}):
        with pytest.raises(FricError, match="other method"):
            fric.identify_plant(response, **given)
    with pytest.raises(FricError, match="other method"):
        fric.identify_plant("data/constant-velocity.h5", method="motion", lowest="5 Hz")
    for given in ({"before": "none.h5"}, {"machine": "virtual-rig"}, {"scheme": "x"}):
        with pytest.raises(FricError, match="recorded circle"):
            fric.learn("xy-table", rounds=1, **given)
    for bandwidth in ("1e9 Hz", "1e-7 Hz"):  # the second was a singular matrix
        with pytest.raises(FricError, match="half its sampling"):
            fric.learn("xy-table", rounds=1, bandwidth=bandwidth, radius="5 mm")
