import copy
import pickle

import pytest

from fric.errors import FricError
from fric.notice import Notice


def test_a_notice_reads_as_its_text_and_keeps_code_and_severity_in_copies_and_other_processes() -> None:
    notice = Notice("the logged force lags by 2 samples", "force-lags", "wrong")
    for one in (notice, copy.deepcopy(notice), pickle.loads(pickle.dumps(notice))):
        assert one == "the logged force lags by 2 samples"
        assert one.as_dict() == {"code": "force-lags", "severity": "wrong", "text": str(notice)}


def test_a_plain_text_becomes_a_doubt_and_a_notice_stays_itself() -> None:
    notice = Notice("x", "some-code", "note")
    assert Notice.of(notice) is notice
    assert Notice.of("x").severity == "doubt"


def test_no_other_severity_is_taken() -> None:
    with pytest.raises(FricError, match="note, doubt, wrong"):
        Notice("x", "c", "terrible")  # type: ignore[arg-type]
