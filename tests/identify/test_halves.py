"""Halves of records, each identified alone: they agree where intervals hold, and not where friction changed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.identify.halves import halves
from tests.chance import fewest
from tests.identify.test_rigid_body import motion

DATA = Path(__file__).parents[2] / "data"


def test_halves_of_the_bundled_strokes_agree_and_the_command_says_so() -> None:
    result = fric.compare(fric.read(DATA / "constant-velocity.h5"), halves=True)
    assert {one.by for one in result.halves.found} >= {"alternation", "record", "direction"}
    assert result.halves.within > 0.8
    assert "half-widths apart" in repr(result)
    assert result.document["fric"] == "halves/1"
    assert set(result.halves.untold) <= {"time", "place"}  # its speeds rise, and fast strokes go further


def test_halves_of_motions_agree_as_often_as_intervals_claim() -> None:
    """Chance of failing: below one in a thousand (`tests/chance.py`)."""
    found = [halves([motion(4.0, 1000.0, noise=3.0, rho=0.5, seed=seed)]).found for seed in range(6)]
    agree = [one.half_widths <= 1.0 for some in found for one in some if one.by == "time"]
    assert len(agree) == 24
    assert sum(agree) >= fewest(24)


def test_a_mass_that_changed_stands_out() -> None:
    log = motion(4.0, 1000.0, noise=1.0)
    t = log.time
    acceleration = -0.05 * np.pi**2 * np.sin(np.pi * t) - 0.01 * (3.4 * np.pi) ** 2 * np.sin(3.4 * np.pi * t)
    late = replace(log, force=log.force + 12.0 * acceleration * (t > 2.0))
    apart = {one.parameter: one.half_widths for one in halves([late]).found if one.by == "time"}
    assert apart["M"] > 3.0
    assert "M, halved by " in halves([late]).conclusion


def test_what_has_no_halves_is_said() -> None:
    with pytest.raises(fric.FricError, match="no halves can be compared"):
        fric.compare(DATA / "presliding-sine.h5", halves=True)
