"""Results of a ball bar in the form of `.b5r` files, beside those of `fric diagnose`."""

import numpy as np
import pytest

from fric.errors import FricError
from fric.io.readers.ball_bar import figures
from fric.results.circles import diagnose
from fric.results.ingest import ingest
from tests.circles.synthetic_circles import QUADRANTS, circle, drawn_faults

FEATURES = (
    ("AF_REVERSAL_SPIKES_A_POS", "UT_LENGTH_UM", "-4,5"), ("AF_BACKLASH_B_NEG", "UT_LENGTH_UM", "2.0"),
    ("AF_SQUARENESS", "UT_SQUARENESS", "12.5"), ("AF_SERVO_MISMATCH", "UT_SERVO_MISMATCH", "0.25"),
    ("AF_CIRCULARITY", "UT_LENGTH_UM", " 9.1 "), ("AF_CYCLIC_ERROR_B_FWD", "UT_LENGTH_UM", "0.7"),
    ("AF_RANK", "UT_RANKING", "3"), ("AF_STRAIGHTNESS_A", "UT_LENGTH_UM", "n/a"),
)  # fmt: skip


def result(plane: str = "XY", features=FEATURES) -> str:
    lines = [f'<FEATURE DT="{kind}" NAME="{name}">{text}</FEATURE>' for name, kind, text in features]
    return (f'<?xml version="1.0"?><BB5><OPERATOR>a</OPERATOR><ANALYSIS>{"".join(lines)}</ANALYSIS>'
            f'<PLANE OTHER="1" TEST_PLANE="{plane}"/></BB5>')  # fmt: skip


def test_figures_are_in_si_by_axis_and_direction(tmp_path):
    path = tmp_path / "a.b5r"
    path.write_text(result("YZ"))
    plane, found = figures(path)
    assert plane == ("y", "z")
    assert {name: float(value) for name, value in found.items()} == pytest.approx({
        "reversal spikes +y": -4.5e-6, "backlash -z": 2e-6, "squareness": 12.5e-6, "servo mismatch": 0.25e-3,
        "circularity": 9.1e-6, "cyclic error fwd z": 0.7e-6,
    })  # fmt: skip


@pytest.mark.long(4)
def test_they_stand_beside_those_of_the_circle(tmp_path):
    """The figures of the software, by its definitions, beside what is found of a circle with these faults."""
    rng = np.random.default_rng(4)
    faults = drawn_faults(rng)
    tests = [circle(faults, rng, direction=s) for s in (1, -1)]
    lag, scale, radius = np.subtract(*faults.lag), np.subtract(*faults.scale), tests[0].radius
    features = [
        ("AF_SQUARENESS", "UT_SQUARENESS", 1e6 * faults.squareness),
        ("AF_SERVO_MISMATCH", "UT_SERVO_MISMATCH", 1e3 * lag),
        ("AF_SCALE_MISMATCH", "UT_LENGTH_UM", 2e6 * radius * scale),
        ("AF_NEW", "UT_LENGTH_MM", 0.001),
        ("AF_BACKLASH_A_POS", "UT_SCALE_ERROR", 3.0),
        ("AF_REVERSAL_SPIKES_A_POS", "UT_LENGTH_UM", 1e6 * faults.glitch[QUADRANTS.index("+x")]),
        ("AF_BACKLASH_B_POS", "UT_LENGTH_UM", 1e6 * faults.backlash[1]),
    ]
    path = tmp_path / "a.b5r"
    path.write_text(result(features=features))
    found = diagnose(*tests, reported=path)
    table = found.report()[-1]
    rows = {name: (said, here) for name, said, here in table.rows}
    assert rows.pop("new") == ("1 µm", "")
    assert rows.pop("backlash +x")[1] == ""  # of another unit it is no length, which was shown in the unit of the file
    for name, (said, here) in rows.items():
        value, unit = said.split()
        assert unit == here.split()[1], name
        assert float(here.split()[0]) == pytest.approx(float(value), rel=0.05), name
    assert found.document["reported"]["squareness"]["unit"] == "rad"
    assert "reported" not in diagnose(*tests).document
    path.write_text(result("YZ"))
    with pytest.raises(FricError, match="of the plane y and z, and the circle of x and y"):
        diagnose(*tests, reported=path)


@pytest.mark.parametrize(("text", "says"), [
    (result()[:90], "not complete XML"),
    (result(""), "has the test plane ''"), (result("XX"), "has the test plane 'xx'"),
    (result(features=FEATURES[-2:]), "holds no figure"),
    (result().replace("<BB5>", "<!DOCTYPE a><BB5>"), "declares a document type"),
])  # fmt: skip
def test_what_cannot_be_read_ends_in_a_sentence(tmp_path, text, says):
    path = tmp_path / "a.b5r"
    path.write_text(text)
    with pytest.raises(FricError, match=says) as caught:
        figures(path)
    assert "a.b5r" in str(caught.value)


def test_it_is_no_log(tmp_path):
    path = tmp_path / "a.b5r"
    path.write_text(result())
    with pytest.raises(FricError, match="no trace"):
        ingest(path, output=tmp_path / "log.h5")
