import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fric.cli.main import app
from fric.control.q_filter import Q_FILTERS
from fric.documents.controller import ControllerDocument, ObserverDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.hdf5 import write_logs
from fric.log import FrequencyResponse
from tests.design.plants import X
from tests.turns import in_turns

RUN = CliRunner()
GIVEN = ["--K_p", "83.7 V*s/m", "--K_i", "3156 V/m", "--K_v", "126 1/s", "--gain-margin", "13.7 dB"]


@pytest.fixture
def plant(tmp_path: Path) -> str:
    path = tmp_path / "plant.yaml"
    path.write_text("fric: plant/1\naxis: x\nA: 28.57 1/s\nB: 4.526 m/(s^2*V)\nT_d: 0.65 ms\n")
    return str(path)


@pytest.fixture
def controller(plant: str, tmp_path: Path) -> str:
    path = str(tmp_path / "controller.yaml")
    done = RUN.invoke(app, ["design", "controller", plant, *GIVEN, "-o", path])
    assert done.exit_code == 0, done.output
    return path


def told(words: list[str]) -> dict:
    done = RUN.invoke(app, [*words, "--json"])
    assert done.exit_code == 0, (done.output, done.exception)
    return json.loads(done.stdout)


def refused(words: list[str]) -> FricError:
    error = RUN.invoke(app, words).exception
    assert isinstance(error, FricError)
    return error


def test_the_table_of_the_x_axis(plant: str, controller: str) -> None:
    """What fric design tells of x, next to the values of the notes: 2 % on gains, 1° and 0.2 dB on margins."""
    designed = told(["design", "controller", plant])
    for gain, noted in (("K_p", 83.7), ("K_i", 3156.0), ("K_v", 126.0)):
        assert designed[gain]["value"] == pytest.approx(noted, rel=0.02)
    given = told(["design", "controller", plant, *GIVEN])["margins"]
    observed = told(["design", "observer", plant, "--controller", controller, "--cutoff", "60 Hz"])["margins"]
    for found, phase, gain in (
        (given["velocity"], 68, 13.9),
        (given["position"], 73, 19.1),
        (observed["input"], 32, 10.5),
    ):
        assert found["phase_margin"]["value"] == pytest.approx(phase, abs=1)
        assert found["gain_margin"]["value"] == pytest.approx(gain, abs=0.2)
    assert observed["input"]["peak_sensitivity"]["value"] == pytest.approx(5.8, abs=0.2)


def test_the_controller_file_is_the_json_and_can_be_read(plant: str, tmp_path: Path) -> None:
    path = tmp_path / "c.yaml"
    tree = told(["design", "controller", plant, "-o", str(path), "--limit", "10 V"])
    document = read_document(path, ControllerDocument)
    cascade = document.in_si("linear")
    assert cascade.K_p == pytest.approx(tree["K_p"]["value"], rel=1e-5)
    assert cascade.limit == 10.0
    assert document.margins["velocity"].gain_margin.value == pytest.approx(13.8, abs=1e-3)
    assert "exists" in str(refused(["design", "controller", plant, "-o", str(path)]))
    assert RUN.invoke(app, ["design", "controller", plant, "-o", str(path), "--force"]).exit_code == 0


@pytest.mark.parametrize("name", Q_FILTERS)
def test_the_observer_file_holds_both_limits(plant: str, controller: str, tmp_path: Path, name: str) -> None:
    path = tmp_path / "o.yaml"
    words = ["design", "observer", plant, "--controller", controller, "--filter", name, "-o", str(path), "--force"]
    tree = told([*words, "--first-mode", "50 kHz"])
    assert 355 < tree["limits"]["robust"]["bandwidth"]["value"] < 385
    assert tree["limits"]["sensitive"]["cutoff"]["value"] == tree["cutoff"]["value"]
    assert "peak sensitivity" in tree["reason"]
    document = read_document(path, ObserverDocument)
    observer = document.observer("linear", 0.0, 1.0)
    assert pytest.approx(28.57) == observer.A
    assert observer.q.bandwidth == pytest.approx(tree["bandwidth"]["value"], rel=1e-5)


def test_a_measured_response_with_its_confidence_sets_the_limit(plant: str, controller: str, tmp_path: Path) -> None:
    f = np.arange(2.0, 1500.0, 2.0)
    G = X.response(f)
    path = tmp_path / "log.h5"
    write_logs(path, [FrequencyResponse(f, np.abs(G), np.unwrap(np.angle(G)), np.full(f.size, 0.9), name="frf")])
    words = ["design", "observer", plant, str(path), "--controller", controller]
    limits = [told([*words, "--averages", n])["limits"]["robust"]["cutoff"]["value"] for n in ("4", "400")]
    assert limits[0] < 0.95 * limits[1]
    assert limits[1] == pytest.approx(585.5, rel=0.1)
    tree = told([*words, "--record", "frf"])
    assert tree["provenance"]["logs"][0]["record"] == "frf"
    assert "0 records of the name 'other'" in str(refused([*words, "--record", "other"]))
    assert "--resonance" in str(refused([*words, "--resonance", "300 Hz, 0.02, 0.1"]))


@pytest.mark.parametrize("view", in_turns(["bode", "nyquist", "nichols", "q"], ["nyquist", "q"]))
def test_figures_are_drawn(plant: str, controller: str, tmp_path: Path, view: str) -> None:
    figure = tmp_path / "figure.svg"
    if view != "q":
        RUN.invoke(app, ["design", "controller", plant, "--plot", str(figure), "--view", view])
        text = figure.read_text()
        assert len(text) > 10_000
        assert "exists" in str(refused(["design", "controller", plant, "--plot", str(figure)]))
        figure.unlink()
    done = RUN.invoke(
        app, ["design", "observer", plant, "--controller", controller, "--plot", str(figure), "--view", view]
    )
    assert done.exit_code == 0, done.output
    assert figure.stat().st_size > 10_000


def test_people_read_gains_limits_and_margins(plant: str) -> None:
    out = RUN.invoke(app, ["design", "controller", plant]).stdout
    assert "83.09 V·s/m" in out
    assert "67.5°" in out
    out = RUN.invoke(app, ["design", "observer", plant, "--first-mode", "50 kHz"]).stdout
    assert "|T·Delta| ≤ 1" in out
    assert "376.8 Hz" in out
    assert "limited by the peak sensitivity" in out


def test_what_cannot_be_designed_is_refused(plant: str, controller: str) -> None:
    assert "nearest that holds is K_p" in refused(["design", "controller", plant, "--crossover", "100 Hz"]).hint
    assert "all together" in str(refused(["design", "controller", plant, "--K_p", "83.7 V*s/m"]))
    assert "no unit" in str(refused(["design", "controller", plant, "--phase-margin", "60"]))
    assert "is not a gain" in str(refused(["design", "controller", plant, "--gain-margin", "12 m"]))
    observer = ["design", "observer", plant, "--controller", controller]
    assert "nearest that holds is 65" in refused([*observer, "--cutoff", "200 Hz"]).hint
    assert "nearest that holds is 65" in refused([*observer, "--bandwidth", "60 Hz"]).hint
    assert "two names" in str(refused([*observer, "--bandwidth", "30 Hz", "--cutoff", "60 Hz"]))
    other = Path(controller).with_name("y.yaml")
    other.write_text(Path(controller).read_text().replace("axis: x", "axis: y"))
    assert "of the linear axis y" in str(refused(["design", "observer", plant, "--controller", str(other)]))
    assert "is not a resonance" in str(refused([*observer, "--resonance", "300 Hz"]))
    assert "--resonance" not in str(refused([*observer, "--resonance", "300 Hz, 0, 0.1"]))


def test_a_record_in_time_serves_as_well_as_a_measured_table(tmp_path: Path) -> None:
    """From an experiment on the paper's table to its observer: the limits are those of the model it was made with."""
    machine = str(Path("configs/xy-table.yaml").resolve())
    log, plant, controller = (str(tmp_path / name) for name in ("log.h5", "plant.yaml", "controller.yaml"))
    for words in (
        ["simulate", "experiment", machine, "--kind", "frequency-response", "-o", log],
        ["identify", "plant", log, "-o", plant],
        ["design", "controller", plant, "-o", controller],
    ):
        assert RUN.invoke(app, words).exit_code == 0
    tree = told(["design", "observer", plant, log, "--controller", controller])
    assert tree["limits"]["robust"]["bandwidth"]["value"] == pytest.approx(377, rel=0.03)
    assert tree["limits"]["sensitive"]["cutoff"]["value"] == pytest.approx(66, rel=0.03)
    assert tree["provenance"]["logs"][0]["record"] == "frequency-response"
