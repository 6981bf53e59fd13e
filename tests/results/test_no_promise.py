"""What no verb would take is said where a log is read, and where it is looked at; nothing is promised of it."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fric
from fric.log import Log

T = np.arange(4000) / 1000


def strokes(speed: float, swing: float = 0.0) -> Log:
    """Strokes of one second there and back, whose velocity swings at 20 Hz by a share of its mean (rms)."""
    turn = np.where(T % 2 < 1, 1.0, -1.0)
    velocity = speed * turn * (1 + np.sqrt(2) * swing * np.sin(2 * np.pi * 20 * T))
    force = 60 * turn + np.random.default_rng(4).normal(size=len(T))
    return Log(time=T, position=np.cumsum(velocity) / 1000, force=force)


@pytest.mark.parametrize(("speed", "plausible"), [(2.0, True), (20.0, True), (30.0, False), (4000.0, False)])
def test_a_speed_beyond_all_drives_is_said_by_ingest_and_inspect(tmp_path: Path, speed: float, plausible: bool) -> None:
    log = strokes(speed)
    rows = np.c_[log.time, log.position, log.force]
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header="time [s],position [m],force [N]", comments="")
    read = fric.ingest(tmp_path / "a.csv", output=tmp_path / "a.h5")
    assert ("implausible-speed" in [notice.code for notice in read.warnings]) is not plausible
    found = fric.inspect(tmp_path / "a.h5")
    assert ("implausible-speed" in [notice.code for notice in found.warnings]) is not plausible
    good = {use.purpose for use in found.found[0].uses if use.good}
    assert good == ({"static"} if plausible else set())


@pytest.mark.parametrize("share", [0.0, 0.1, 0.2])
def test_inspect_shows_how_far_the_velocity_of_strokes_swings(share: float) -> None:
    found = fric.inspect(strokes(0.05, share))
    assert_allclose(found.found[0].swing, share, rtol=0.1)
    assert ("swing" in str(found)) is (share > 0)


def test_an_axis_at_rest_is_not_implausible() -> None:
    """Steps of the encoder and noise of the velocity are of no common motion: their ratio was called wrong."""
    rng = np.random.default_rng(5)
    position = 1e-6 * np.round(0.6 * rng.normal(size=len(T)))
    found = fric.inspect(Log(time=T, position=position, velocity=1e-6 * rng.normal(size=len(T)), force=0 * T + 5))
    assert not any(notice.code.startswith("implausible") for notice in found.warnings)
