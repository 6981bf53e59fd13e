"""Where a force has settled: also in stretches of a few dozen samples, and where it varies over position."""

import numpy as np
import pytest

from fric.log import Log
from fric.records.segments import settled_from, steady_segments
from tests.records.kinematics import strokes


@pytest.mark.parametrize("samples", [32, 40, 48, 60, 64, 200])
def test_a_force_that_falls_throughout_loses_up_to_half_and_no_more(samples):
    rng = np.random.default_rng(samples)
    force = 10.0 * np.exp(-2.0 * np.arange(samples) / samples) + 0.01 * rng.standard_normal(samples)
    start, _ = settled_from(force)
    assert 0 < start <= samples // 2


@pytest.mark.parametrize("samples", [32, 40, 64, 200])
def test_a_force_that_is_steady_is_left_whole(samples):
    rng = np.random.default_rng(samples)
    assert settled_from(100.0 + rng.standard_normal(samples)) == (0, True)


@pytest.mark.parametrize("gravity", [0.0, 60.0])
@pytest.mark.parametrize("settling", [0.0, 0.1])
def test_a_force_over_position_is_no_settling_where_the_way_back_shows_it(gravity, settling):
    """A load that turns with the joint: half of each stroke was given up, and not one of them counted as settled."""
    made = strokes([(0.05, 4.0), (-0.05, 4.0)], dwell=0.3)
    starts = np.array([begin - abs(v) for begin, _, v in made.plateaus])  # the ramps are of 1 m/s²
    since = made.time - starts[np.searchsorted(starts, made.time).clip(1) - 1]
    built = 1.0 - np.exp(-since.clip(0.0) / settling) if settling else 1.0
    friction = 20.0 * np.sign(made.velocity) * built
    noise = np.random.default_rng(3).standard_normal(len(made.time))
    log = Log(made.time, position=made.position, force=gravity * np.sin(8.0 * made.position) + friction + noise)
    segments = steady_segments(log)
    assert len(segments) == 2
    for segment in segments:
        cut = log.time[segment.start] - log.time[segment.onset]
        assert segment.settled
        assert cut <= 8.0 * settling
        assert gravity or cut >= 2.5 * settling  # beside a large load a part of it may pass for the load


@pytest.mark.parametrize("back", ["constant", "shorter"])
def test_a_way_back_that_shows_nothing_changes_nothing(back):
    """A force of zero on the way back, or places that it did not visit: NumPy warned, or they counted as zero."""
    made = strokes([(0.05, 4.0), (-0.05, 4.0 if back == "constant" else 3.5)], dwell=0.3)
    friction = 20.0 * (1.0 - np.exp(-(made.time - 0.3).clip(0.0) / 0.1)) + 5.0 * np.sin(8.0 * made.position)
    force = np.where(made.velocity > 0.0, friction, 0.0 if back == "constant" else friction - 40.0)
    noise = np.where(force != 0.0, np.random.default_rng(5).standard_normal(len(force)), 0.0)
    one = made.time < made.plateaus[0][1] + 0.1
    both, alone = (
        steady_segments(Log(made.time[cut], position=made.position[cut], force=(force + noise)[cut]))[0]
        for cut in (slice(None), one)
    )
    assert (both.start, both.settled) == (alone.start, alone.settled)
