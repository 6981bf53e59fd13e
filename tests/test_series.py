"""What a function remembers of records is what it would find."""

from dataclasses import replace

import numpy as np

from fric.log import Log
from fric.records.motion import find_reversals
from fric.records.segments import segments_and_rests
from fric.series import REMEMBERED, remembered


def test_a_content_is_looked_at_once_and_another_anew():
    """Arrays may be written to, and a record of the same samples may be stated to be of another kind."""
    looked = []

    @remembered
    def total(values, by=1.0):
        looked.append(by)
        return np.array([by * values.sum()])

    values = np.arange(4.0)
    assert [float(total(values)[0]), float(total(values.copy())[0]), len(looked)] == [6.0, 6.0, 1]
    total(values)[0] = 7.0  # what was given is the caller's
    assert float(total(values)[0]) == 6.0
    values[0] = 1.0
    assert [float(total(values)[0]), float(total(values, 2.0)[0]), float(total(values, by=2.0)[0])] == [7.0, 14.0, 14.0]
    assert float(total(values.reshape(2, 2).T)[0]) == 7.0
    assert len(looked) == 5
    for n in range(REMEMBERED):
        total(np.full(1, n))
    total(values)
    assert len(looked) == 6 + REMEMBERED


def test_a_record_of_another_kind_has_other_segments():
    t = np.arange(2000) * 1e-3
    log = Log(time=t, position=0.02 * np.abs(t - 1.0), force=np.sign(t - 1.0))
    assert len(segments_and_rests(log)[0]) == 2
    assert segments_and_rests(replace(log, kind="presliding-sine")) == ([], [])
    first, _ = segments_and_rests(log)
    first.clear()
    assert len(segments_and_rests(log)[0]) == 2
    assert len(segments_and_rests(replace(log, force=None))[0]) == 2
    assert list(find_reversals(log.position)) == [1000]
    log.position[:] = t
    assert not len(find_reversals(log.position))
    assert len(segments_and_rests(log)[0]) == 1
