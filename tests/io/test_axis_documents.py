from pathlib import Path

import pytest

from fric.control.inverse_model import QFilter
from fric.documents.controller import ControllerDocument, ObserverDocument
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document
from fric.errors import FricError

PLANT = 'fric: plant/1\naxis: x\nA: 28.57 1/s\nB: {value: 4.526, unit: m/(s^2*V)}\nT_d: 0.65 ms\nK_f: "548 N/V"\n'
CONTROLLER = """\
fric: controller/1
axis: x
K_v: 126 1/s
K_p: {value: 83.7, unit: V*s/m}
K_i: 3156 V/m
velocity_filter: 0.5 kHz
sampling: 4 kHz
"""
OBSERVER = "fric: observer/1\naxis: x\nfilter: binomial2\ncutoff: 60 Hz\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "document.yaml"
    path.write_text(text)
    return path


def test_documents_of_an_axis_read_as_types_in_si(tmp_path: Path) -> None:
    plant = read_document(written(tmp_path, PLANT), PlantDocument).plant("linear")
    assert (plant.A, plant.B, plant.K_f) == (28.57, 4.526, 548.0)
    assert plant.T_d == pytest.approx(0.65e-3)
    cascade = read_document(written(tmp_path, CONTROLLER), ControllerDocument).in_si("linear")
    assert (cascade.velocity_filter, cascade.sampling, cascade.limit) == (500.0, 4000.0, float("inf"))
    observer = read_document(written(tmp_path, OBSERVER), ObserverDocument).observer("linear", plant.A, plant.B)
    assert (observer.q, observer.A, observer.B) == (QFilter("binomial2", 60.0), 28.57, 4.526)


@pytest.mark.parametrize(
    ("was", "now", "told"),
    [
        ("unit: m/(s^2*V)", "unit: N", r"line 4: B: acceleration per input cannot be in 'N'"),
        ("0.65 ms", "0.65", r"line 5: T_d: time cannot be in '1'"),
        ("A: 28.57 1/s\n", "", "A: is missing"),
        ("axis: x", "axis: x\nmass: 3 kg", r"line 3: mass: is not a known key here\n.*fric schema plant"),
        ("T_d: 0.65 ms", "T_d: 0.65 ms\nprovenance: me", r"line 6: provenance: takes keys.*\n.*fric schema plant"),
        ("fric: plant/1\n", "", r"does not say what it is\nStart it with 'fric: plant/1'"),
        ("value: 4.526", "value: [4.5, 4.6]", "line 4: B: a list of 2 where one value"),
    ],
)
def test_what_does_not_fit_is_told_with_its_line(tmp_path: Path, was: str, now: str, told: str) -> None:
    with pytest.raises(FricError, match=told):
        read_document(written(tmp_path, PLANT.replace(was, now)), PlantDocument)


def test_a_plant_without_force_constant_is_read_but_cannot_be_simulated(tmp_path: Path) -> None:
    document = read_document(written(tmp_path, PLANT.replace('K_f: "548 N/V"\n', "")), PlantDocument)
    with pytest.raises(FricError, match="K_f"):
        document.plant("linear")


def test_an_unknown_filter_is_told(tmp_path: Path) -> None:
    with pytest.raises(FricError, match="'chebyshev' is no Q-filter"):
        read_document(written(tmp_path, OBSERVER.replace("binomial2", "chebyshev")), ObserverDocument)
