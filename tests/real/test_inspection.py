"""Logs of real drives: what they are, and where they move steadily."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.io

from fric.log import Log
from fric.records.inspection import inspect
from fric.records.segments import steady_segments

SHARED = Path(__file__).parents[3] / "shared/data"
pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(not SHARED.is_dir(), reason="the folder ../shared/data with the real logs is not here"),
]


def screwdrive(path):
    lines = path.read_text("latin-1").splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("ms;")) + 1
    table = np.array([[float(cell) for cell in line.split(";")] for line in lines[first:] if line.strip()])
    time, rpm, percent = table.T
    return Log(
        time=1e-3 * time, velocity=-rpm * 2 * np.pi / 60, force=-percent * 9.84e-5, motion="rotary", name=path.stem
    )


@pytest.mark.parametrize("sign", ["", "n"])
@pytest.mark.parametrize("rpm", [2, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 120, 140, 160, 180, 200])
def test_screwdrive_records_are_one_stretch_each(rpm, sign):
    log = screwdrive(SHARED / f"screwdrive1/steady_state/0.096kg/{sign}{rpm}.csv")
    (segment,) = steady_segments(log)
    assert len(segment) > 0.95 * len(log)
    true = rpm * 2 * np.pi / 60 * (-1 if sign else 1)
    assert abs(segment.velocity - true) < max(4 * segment.velocity_se, 0.006 * abs(true))
    assert inspect(log).kind == "constant-velocity"


@pytest.mark.parametrize("rpm", [50, 200])
def test_screwdrive_start_and_stop_gives_two_strokes(rpm):
    log = screwdrive(SHARED / f"screwdrive1/start_stop/{rpm}.csv")
    segments = steady_segments(log)
    assert [round(s.velocity * 60 / (2 * np.pi)) for s in segments] == [rpm, -rpm]
    for segment in segments:
        spread = np.ptp(log.velocity[segment.start : segment.stop]) * 60 / (2 * np.pi)
        assert spread < 0.25 * rpm  # no sample of the ramps, which go through all speeds


def test_emps_is_a_motion_at_one_kilohertz_with_seven_reversals():
    table = scipy.io.loadmat(SHARED / "emps/DATA_EMPS.mat")
    time, position, voltage = (table[name].ravel() for name in ("t", "qm", "vir"))
    log = Log(time=time, position=position, input=voltage, force=float(table["gtau"].item()) * voltage)
    found = inspect(log)
    assert found.kind == "motion"
    assert found.sampling == pytest.approx(1000.0, rel=1e-4)
    assert len(found.reversals) == 7
    assert len(found.stretches) == 32
    assert len(found.speeds) == 6
    acceleration = np.gradient(np.gradient(table["qg"].ravel(), time), time)
    for segment in found.stretches:
        # the reference asks for no acceleration anywhere in a stretch, but where the axis lags behind it at the end
        inside = acceleration[segment.onset : segment.stop - 5]
        assert np.mean(np.abs(inside) > 0.1) < 0.02
        mean = log.force[segment.start : segment.stop].mean()
        assert 20.0 < mean * np.sign(segment.velocity) < 60.0


def test_tribometer_is_no_sine_and_is_known_by_its_loops():
    table = np.loadtxt(SHARED / "tribometer/reciprocating-first-75s.txt", skiprows=1)
    found = inspect(Log(time=table[:, 0], position=1e-3 * table[:, 2], force=-1e-6 * table[:, 3]))
    assert (found.kind, found.sine) == ("presliding-sine", None)
    assert found.encoder_step == pytest.approx(1e-7)
    assert len(found.reversals) == 33
    assert len(found.gaps) == 179
    good = {use.purpose: use.good for use in found.uses}
    assert good == {"static": False, "gms": True, "plant": False}
