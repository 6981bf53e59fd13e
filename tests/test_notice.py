import copy
import pickle

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.base import Flaw
from fric.notice import Notice, enumerated

LATE = Flaw(
    "force-lags",
    lambda f: "wrong" if float(f.lag) > 1e-3 else "note",
    "The force is logged {lag:2} {late:later|earlier} than the input{channels:, in {channels}|}.",
    "Log both at one instant.",
)


def test_a_notice_reads_as_its_text_and_keeps_code_and_severity_in_copies_and_other_processes() -> None:
    notice = LATE.found("record 'a'", lag=Estimate(2.04e-3, "s"), late=1.5, channels=["one", "two"])
    for one in (notice, copy.deepcopy(notice), pickle.loads(pickle.dumps(notice)), Notice.of(notice.as_dict())):
        assert one == "record 'a': The force is logged 2 ms later than the input, in one, two. Log both at one instant."
        assert one.as_dict() == {
            "code": "force-lags",
            "severity": "wrong",
            "text": str(notice),
            "values": {"lag": {"value": 2.04e-3, "unit": "s"}, "late": 1.5, "channels": ["one", "two"]},
            "where": "record 'a'",
        }


def test_severity_and_sentence_follow_the_values() -> None:
    notice = LATE.found(lag=Estimate(1e-4, "s"), late=-1, channels=[])
    assert notice == "The force is logged 100 µs earlier than the input. Log both at one instant."
    assert notice.severity == "note"


def test_places_are_put_before_each_other_and_the_sentence_stays() -> None:
    notice = Notice("it lags", "force-lags", "wrong").at("record 'a'").at("plant of axis x", carried=True)
    assert notice == "plant of axis x: record 'a': it lags"
    assert (notice.says, notice.carried, notice.at("y").carried) == ("it lags", True, True)


def test_a_plain_text_becomes_a_doubt_and_a_notice_stays_itself() -> None:
    notice = Notice("x", "some-code", "note")
    assert Notice.of(notice) is notice
    assert Notice.of("x").severity == "doubt"


@pytest.mark.parametrize("severity", ["terrible", np.ones(2), ["note"]])
def test_no_other_severity_is_taken(severity: object) -> None:
    with pytest.raises(FricError, match="note, doubt, wrong"):
        Notice("x", "c", severity)  # type: ignore[arg-type]


@given(st.lists(st.text("abc-", min_size=1, max_size=20), min_size=1, max_size=99), st.integers(15, 80))
@example(["a" * 40, "b"], 15)  # one name is whole, however long
def test_names_are_enumerated_in_their_order_as_many_as_fit_and_none_is_lost(names: list[str], width: int) -> None:
    told = enumerated(names, width)
    shown, _, rest = told.partition(" and ")
    listed = shown.split(", ")
    assert listed == names[: len(listed)]
    assert len(listed) + int(rest.removesuffix(" more") or 0) == len(names)
    assert len(told) <= width or len(listed) == 1
    if rest:  # with one more name it would be too long
        longer = ", ".join(names[: len(listed) + 1])
        assert len(longer) > width - len(" and 99 more")
