"""Channels on several clocks, put on one."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fric import FricError
from fric.io.readers import base
from fric.io.readers.base import Column, Memory
from fric.io.readers.joined import Joined, SharedClock


def part(time, values, name, factor=1.0, label=""):
    table = Memory(Path("a.log"), (Column("t"), Column(name)), [np.asarray(time, float), np.asarray(values, float)])
    return SharedClock(table, 0, factor=factor, label=label)


def read(table, wanted=None):
    blocks = list(table.blocks(wanted if wanted is not None else range(len(table.columns))))
    return [np.concatenate(columns) for columns in zip(*(block.columns for block in blocks), strict=True)]


@settings(max_examples=60, deadline=None)
@given(
    lead=st.floats(20.0, 5000.0), other=st.floats(20.0, 5000.0), shift=st.floats(-0.5, 0.5), block=st.integers(3, 400)
)
def test_a_straight_line_stays_one_on_any_clock_whatever_the_blocks(lead, other, shift, block):
    a, b = np.arange(0.0, 1.5, 1 / lead), shift + np.arange(0.0, 1.5, 1 / other)
    before, base.BLOCK = base.BLOCK, block
    try:
        x, time, y = read(
            Joined(Path("a.log"), [part(a, 3 * a + 1, "x"), part(b * 1e3, 2 * b - 1, "y", 1e-3)]), [1, 0, 2]
        )
    finally:
        base.BLOCK = before
    every = max(int(np.ceil(lead / other - 0.05)), 1)
    clock, slack = a[(round(shift * lead) if every > 1 else 0) % every :: every], 2e-3 / lead
    inside = clock[(clock >= b[0] - slack) & (clock <= b[-1] + slack)]
    assert abs(len(time) - len(inside)) <= 2  # an instant at an end may fall a digit beside
    assert np.isin(time, clock).all()
    np.testing.assert_allclose(x, 3 * time + 1, rtol=1e-12)
    np.testing.assert_allclose(y, 2 * time - 1, rtol=0, atol=2.1e-3 / lead)  # held over the slack at the ends


def test_the_shift_is_told_and_no_channel_is_carried_beyond_its_samples():
    time = np.arange(4000) * 1e-3
    late = part(0.0104 + np.arange(1600) * 2e-3, np.arange(1600.0), "force")
    table = Joined(Path("a.log"), [part(time, time, "position"), late])
    position, found, force = read(table, [1, 0, 2])
    assert found[0] == 0.012
    np.testing.assert_allclose(np.diff(found), 2e-3)
    assert found[-1] == 3.208  # the last sample of the force is at 3.2084 s
    np.testing.assert_allclose(force, (found - 0.0104) / 2e-3)
    np.testing.assert_array_equal(position, found)
    assert [note.code for note in table.notices] == ["joined-in-part", "joined-thinned", "joined-moved"]
    assert "'position': one sample in 2 is taken" in table.notices[1]
    assert "'force' (sampled at 500 Hz, 1000 Hz there) moved by -0.4 ms" in table.notices[2].replace("400 µs", "0.4 ms")


def test_a_gap_of_another_channel_is_not_bridged():
    time = np.arange(100) * 1.0
    kept = (time < 40) | (time > 50)
    table = Joined(Path("a.log"), [part(time, time, "x"), part(time[kept], time[kept], "y")])
    _, found, _ = read(table, [1, 0, 2])
    np.testing.assert_array_equal(found, time[(time < 40) | (time > 50)])
    assert [one.values["holes"] for one in table.notices if one.code == "joined-in-part"] == [11]


def test_channels_of_one_clock_are_given_as_they_are_and_nothing_is_told():
    time = np.arange(1000) * 1e-3
    rng = np.random.default_rng(3)
    values = rng.normal(size=(2, 1000))
    table = Joined(Path("a.log"), [part(time, values[0], "position"), part(time, values[1], "force")])
    found = read(table)
    np.testing.assert_array_equal(found[1:], values)
    assert not table.notices


def test_a_slow_channel_repeated_until_its_next_sample_is_no_error_and_other_repeats_are():
    fast = part(np.arange(8), np.arange(8), "x")
    filled = part([0, 0, 4, 4, 8, 8, np.nan, np.nan], [1, 1, 5, 5, 9, 9, np.nan, np.nan], "y")
    assert list(read(Joined(Path("a"), [filled, fast]), [1, 2])[1]) == [0, 4]
    assert list(read(Joined(Path("a"), [fast, filled]), [1, 2])[1]) == [1, 5]  # 8 is beyond the last of the fast one
    for time, values, what in (
        ([0, 0, 4], [1, 2, 5], "0 s is repeated with another value"),
        ([0, 4, 2], [1, 2, 5], "2 s runs backwards"),
        ([0, np.nan, 4], [1, 2, 5], "a value and no time"),
    ):
        with pytest.raises(FricError, match=what):
            read(Joined(Path("a"), [fast, part(time, values, "y")]))


def test_names_that_two_parts_have_are_told_apart_and_no_common_time_is_an_error():
    x = part([0, 1], [0, 1], "x", label="A")
    assert [c.name for c in Joined(Path("a"), [x, part([0, 1], [0, 1], "x", label="B")]).columns] == [
        "time",
        "A.x",
        "B.x",
    ]
    with pytest.raises(FricError, match="no time in common: 'x' from 0 s to 1 s; 'y' from 5 s to 6 s"):
        read(Joined(Path("a"), [x, part([5, 6], [0, 1], "y")]))
