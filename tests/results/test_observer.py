"""An observer without a measured response: no bandwidth is recommended, what is assumed is marked."""

from dataclasses import replace

import numpy as np
import pytest

import fric
from fric.documents.plant import PlantDocument
from fric.io.hdf5 import write_logs
from fric.log import FrequencyResponse


def plant(**more):
    told = {"A": "28.57 1/s", "B": "4.526 m/(s^2*V)", "T_d": "0.65 ms", "K_f": "548 N/V"}
    return PlantDocument.model_validate({"fric": "plant/1", "axis": "x", **told, **more})


def cascade():
    return fric.read_machine("xy-table").axis("x").cascade


def codes(result):
    return {one["code"] for one in result.document["warnings_coded"]}


def test_without_a_response_q_is_held_below_an_assumed_mode_and_says_so():
    """Without delay, binomial2 below a mode f with damping ζ has f/√(1/(2ζ) - 1), by hand: 7.1 Hz of 50 Hz."""
    guessed = fric.design_observer(plant(), controller=cascade())
    tree = guessed.document
    assert tree["cutoff"]["assumed"] is True
    assert "observer-assumed" in codes(guessed)
    assert tree["cutoff"]["value"] == pytest.approx(50 / np.sqrt(1 / 0.02 - 1), rel=0.06)
    stated = fric.design_observer(plant(), controller=cascade(), first_mode="80 Hz")
    assert stated.document["cutoff"]["value"] == pytest.approx(1.6 * tree["cutoff"]["value"], rel=0.03)
    assert "as stated" in str(stated.document["warnings"])
    assert "--first-mode" not in str(stated.document["warnings"])


def test_a_stiff_machine_is_limited_by_its_loop_as_before():
    stiff = fric.design_observer(plant(), controller=cascade(), first_mode=5000.0)
    assert stiff.document["cutoff"]["value"] == pytest.approx(63, abs=4)
    assert stiff.document["cutoff"]["assumed"] is True


def test_a_response_and_a_stated_mode_do_not_go_together():
    with pytest.raises(fric.FricError, match="has its resonances"):
        fric.design_observer(plant(), "data/frequency-response.h5", controller=cascade(), first_mode="80 Hz")


@pytest.mark.parametrize("given", [{"cutoff": 50.0}, {"bandwidth": "50 Hz"}, {"resonances": ["280Hz,0.02,0.1"]}])
def test_a_stated_mode_without_effect_is_refused(given):
    """Beside a cutoff, 'nan mm' was printed as the mode that Q is held below."""
    with pytest.raises(fric.FricError, match="`first_mode=` goes with no resonance, cutoff or bandwidth"):
        fric.design_observer(plant(), controller=cascade(), first_mode="80 Hz", **given)
    with pytest.raises(fric.FricError, match="nan mm"):
        fric.design_observer(plant(), controller=cascade(), first_mode="nan mm", **given)


def test_a_controller_that_fric_took_by_itself_is_not_blamed_on_the_user():
    for given, blamed in ((cascade(), False), (None, True)):
        with pytest.raises(fric.FricError, match="without any observer") as refused:
            fric.design_observer(plant(), controller=given, peak_sensitivity="2 dB")
        assert ("no controller was given" in refused.value.hint.lower()) is blamed


def test_the_response_is_found_among_all_records_and_if_its_samples_are_uneven(rig_plant, tmp_path):
    """Of a file of all records, whose kinds nobody stated, there were "0 records"; a lost sample ended the design."""
    (stroke, *_), (response,) = fric.read("data/constant-velocity.h5"), fric.read("data/frequency-response.h5")
    lost = np.delete(np.arange(len(response)), np.arange(500, len(response), 997))
    channels = {name: values[lost] for name, values in response.channels().items()}
    uneven = replace(response, kind=None, **channels)
    write_logs(tmp_path / "all.h5", [replace(stroke, kind=None), uneven])
    known = fric.read_machine("virtual-rig").axis("x").cascade
    whole, found = (
        fric.design_observer(rig_plant, log, controller=known).document["cutoff"]["value"]
        for log in ("data/frequency-response.h5", tmp_path / "all.h5")
    )
    assert found == pytest.approx(whole, rel=0.05)


@pytest.mark.long(3)
def test_observer_and_controller_see_one_loop_where_friction_hides_a_low_line():
    """A line at 3 Hz answers as friction does, and is left out of the plant: so it is of the observer's response."""
    known = plant().plant("linear")
    f = np.array([3.0, *np.geomspace(12.0, 500.0, 40)])
    answer = known.response(f)
    loop = fric.design_controller(plant()).design.loops()["input"].response
    answer[0] *= -0.9 / loop(f[:1])[0]  # near -1, were it of the loop
    values = {"magnitude": np.abs(answer), "phase": np.unwrap(np.angle(answer)), "deviation": np.full(f.size, 2e-3)}
    log = FrequencyResponse(f, **values, coherence=np.full(f.size, 0.999))
    found = fric.identify_plant(log)
    assert found.document["fit"]["responses"][0]["left_out"] == 1
    controller = fric.design_controller(found)
    without = fric.design_observer(found, log, controller=controller).document["margins"]["without"]
    alone = controller.document["margins"]["input"]
    assert without["peak_sensitivity"]["value"] == pytest.approx(alone["peak_sensitivity"]["value"], abs=0.3)
