"""The EMPS benchmark in closed loop: no worse than published (Janot, Gautier, Brunot 2019)."""

import json
from pathlib import Path

import pytest

from tests.command import fric

ROOT = Path(__file__).parents[2]
RECORD = ROOT / "../shared/data/emps/DATA_EMPS.mat"
PUBLISHED = {"position": 0.01375e-2, "velocity": 0.229e-2, "acceleration": 8.60e-2, "force": 5.85e-2}

pytestmark = [pytest.mark.real, pytest.mark.skipif(not RECORD.exists(), reason="the EMPS record is not here")]


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """Its log, its plant, and what was told of that."""
    folder = tmp_path_factory.mktemp("emps")
    log, plant = folder / "emps.h5", folder / "plant.yaml"
    fric("ingest", RECORD, "--map", ROOT / "configs/mappings/emps.yaml", "-o", log)
    return log, plant, json.loads(fric("identify", "plant", log, "-o", plant, "--json").stdout)


@pytest.fixture
def files(identified):
    return identified[:2]


def test_the_published_benchmark_from_file_to_plant(identified):
    told = identified[-1]
    parameters = told["fit"]["parameters"]
    assert {name: round(p["value"], 4) for name, p in parameters.items()} == {
        "M": 95.1089, "F_v": 203.5034, "F_c": 20.3935, "offset": -3.1648,
    }  # fmt: skip
    assert {name: round(p["deviation"], 4) for name, p in parameters.items()} == {
        "M": 0.1085, "F_v": 1.1460, "F_c": 0.1012, "offset": 0.0444,
    }  # fmt: skip
    assert told["K_f"]["value"] == pytest.approx(35.15065, rel=1e-6)
    assert told["B"]["value"] == pytest.approx(35.15065 / 95.1089, rel=1e-6)


def closed_loop(log, plant, *words):
    controller = ROOT / "configs/controllers/emps.yaml"
    found = json.loads(fric("validate", log, "--plant", plant, "--controller", controller, "--json", *words).stdout)
    return {name: signal["relative"] for name, signal in found["validations"][0]["signals"].items()}


def test_coulomb_friction_is_no_worse_than_published(files, tmp_path):
    figure = tmp_path / "worst-second.png"
    found = closed_loop(*files, "--plot", figure)
    assert all(found[name] <= most for name, most in PUBLISHED.items()), found
    assert figure.stat().st_size > 10_000


def test_the_gains_are_those_of_the_record_s_file(files, tmp_path):
    """Position P and velocity P, without an integral: kp 160.18, kv 243.45 in the file that was published.

    They are found 0.4 % below and 0.3 % above. The intervals were 0.7 % wide; with what a single log leaves,
    by which the gains of slower logs are off, they are 3 %.
    """
    gains = json.loads(fric("identify", "controller", files[0], "-o", tmp_path / "gains.yaml", "--json").stdout)
    for name, published in {"K_v": 160.18, "K_p": 243.45, "K_i": 0.0}.items():
        low, high = gains[name]["ci95"]
        assert low <= published <= 1.001 * high
        assert high - low < 0.033 * max(published, 1.0)
    assert gains["K_i"]["value"] == gains["velocity_feedforward"]["value"] == 0.0


def test_friction_of_either_direction_lowers_the_force_error(files, tmp_path):
    """Its F_v was dropped, which made the error 7.0 % of the force for 4.45."""
    log, plant = files
    each = tmp_path / "plant.yaml"
    fric("identify", "plant", log, "--direction", "each", "-o", each)
    assert closed_loop(log, each)["force"] < 0.9 * closed_loop(log, plant)["force"]


@pytest.mark.parametrize("model", [pytest.param("static", marks=pytest.mark.long(3)), "gms"])
def test_other_friction_is_no_worse_and_blocks_lower_the_force_error(files, tmp_path, model):
    log, plant = files
    friction = tmp_path / "friction.yaml"
    words = ["--plant", plant, "--blocks", 2, "-o", friction]
    fric("identify", "replay", "--model", model, log, *words)
    # a map found by replay is that of Coulomb and viscous friction here, which the plant's own fit has too
    most = 1.002 if model == "static" else 1.0
    assert closed_loop(log, plant, "--friction", friction)["force"] < most * closed_loop(log, plant)["force"]


def test_the_force_of_emps_by_its_own_parameters_is_that_of_its_identification(files):
    log, plant = files
    found = json.loads(fric("validate", log, "--plant", plant, "--json").stdout)
    inverse = next(one for one in found["validations"] if one["loop"] == "inverse")
    assert 100 * inverse["signals"]["force"]["relative"] == pytest.approx(4.0834, abs=5e-4)


def test_half_of_the_gain_of_emps_is_told(files, tmp_path):
    log, plant = files
    half = tmp_path / "half.yaml"
    text = (ROOT / "configs/controllers/emps.yaml").read_text(encoding="utf-8")
    half.write_text(text.replace("value: 243.45", "value: 121.725"), encoding="utf-8")
    for controller, told in ((ROOT / "configs/controllers/emps.yaml", False), (half, True)):
        words = ("validate", log, "--plant", plant, "--controller", controller, "--json")
        coded = json.loads(fric(*words).stdout)["warnings_coded"]
        assert ("controller-differs" in {one["code"] for one in coded}) is told


def test_a_lag_that_is_not_found_again_is_not_told(files, tmp_path):
    """Once its force was moved, no lag of EMPS can be told: nothing was told as "the force is logged later: ;"."""
    log, plant = files
    words = ["--plant", plant, "-o", tmp_path / "gms.yaml", "--json"]
    coded = json.loads(fric("identify", "gms", log, *words).stdout)["warnings_coded"]
    assert not {"force-late", "force-late-open"} & {one["code"] for one in coded}
