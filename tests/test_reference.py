import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fric.errors import FricError
from fric.reference import circle, multisine, sine, sliding_sine, strokes
from fric.simulate.contour_run import Circle

RNG = np.random.default_rng(1)
MOTIONS = {
    "strokes": strokes(5e-3, 1e-3, 4000.0),
    "sine": sine(15e-6, 2.0, 3, 4000.0),
    "sliding sine": sliding_sine(2e-3, 1.5e-3, 4.0, 5, 4000.0),
    "circle x": circle(0.03, 0.1, 1, 4000.0)[0],
    "circle y": circle(0.03, 0.1, 1, 4000.0, direction=-1)[1],
}


@pytest.mark.parametrize("name", MOTIONS)
def test_velocity_and_acceleration_are_the_derivatives(name: str) -> None:
    motion = MOTIONS[name]
    for integral, derivative in ((motion.position, motion.velocity), (motion.velocity, motion.acceleration)):
        slope = np.diff(integral) * motion.sampling
        middle = (derivative[1:] + derivative[:-1]) / 2
        np.testing.assert_allclose(slope, middle, atol=2e-4 * np.abs(derivative).max())


@pytest.mark.parametrize("name", MOTIONS)
def test_every_motion_begins_at_rest_and_never_jumps(name: str) -> None:
    motion = MOTIONS[name]
    assert abs(motion.velocity[0]) < 1e-12
    assert abs(motion.acceleration[0]) < 1e-9
    assert np.abs(np.diff(motion.acceleration)).max() < 0.06 * np.abs(motion.acceleration).max()


@given(st.floats(1e-5, 0.1), st.floats(1e-4, 0.05), st.sampled_from([1, -1]))
@settings(max_examples=20)
def test_a_stroke_covers_its_distance_at_speed_and_comes_back(speed: float, distance: float, direction: int) -> None:
    motion = strokes(direction * speed, distance, 1000.0)
    assert motion.position[-1] == pytest.approx(0.0, abs=1e-12)
    assert np.ptp(motion.position) == pytest.approx(distance + 0.1 * speed, rel=1e-3)
    at_speed = np.count_nonzero(np.abs(motion.velocity) >= speed * (1 - 1e-9))
    assert at_speed / 1000.0 == pytest.approx(2 * distance / speed, abs=0.02)


@given(st.floats(0.001, 0.1), st.floats(0.005, 0.5), st.sampled_from([1, -1]))
@settings(max_examples=20)
def test_a_circle_stays_on_its_radius_at_its_feed(radius: float, feed: float, direction: int) -> None:
    x, y = circle(radius, feed, 1, 500.0, direction=direction)
    np.testing.assert_allclose(np.hypot(x.position, y.position), radius, rtol=1e-12)
    turning = x.position * y.velocity - y.position * x.velocity
    steady = slice(int(np.pi * radius / feed * 500.0) + 1, None)
    np.testing.assert_allclose(turning[steady], direction * radius * feed, rtol=1e-9)


def test_multisine_holds_its_lines_alone_at_one_velocity() -> None:
    f = np.array([2.0, 6.0, 50.0])
    motion = multisine(f, 0.01, 2000, 4000.0, RNG)
    assert np.abs(motion.velocity).max() == pytest.approx(0.01)
    spectrum = np.abs(np.fft.rfft(motion.velocity))
    lines = (f * 0.5).astype(int)
    np.testing.assert_allclose(spectrum[lines], spectrum[1])
    assert np.delete(spectrum, lines).max() < 1e-9 * spectrum[1]


def test_motions_that_cannot_be_are_refused() -> None:
    for make in (
        lambda: strokes(0.0, 1.0, 100.0),
        lambda: sine(0.0, 1.0, 1, 100.0),
        lambda: sliding_sine(1e-3, 2e-3, 1.0, 1, 100.0),
        lambda: sine(1.0, 60.0, 1, 100.0),
        lambda: sliding_sine(2e-3, 1e-3, 1e5, 1, 100.0),
        lambda: Circle(0.0, 0.1, 1),
        lambda: Circle(0.03, -0.1, 1),
    ):
        with pytest.raises(FricError):
            make()
