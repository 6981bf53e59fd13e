"""What a comparison of golden outputs tells, and what it leaves to rounding."""

import json

import pytest

from tests.golden.compare import differences

DOCUMENT = {
    "F_c": {"value": 60.0, "ci95": [59.0, None]},
    "matrix": [[1.0, 1e-12]],
    "codes": [["one-speed", "doubt"], ["fall-open", "doubt"]],
}


@pytest.fixture
def compared(tmp_path):
    def compare(changed, name="static.json"):
        for folder, document, file in (("before", DOCUMENT, "static.json"), ("after", changed, name)):
            (tmp_path / folder).mkdir()
            (tmp_path / folder / file).write_text(json.dumps(document))
        return list(differences(tmp_path / "before", tmp_path / "after", 1e-9))

    return compare


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"F_c": {"value": 60.0 * (1 + 2e-9), "ci95": [59.0, None]}}, [".F_c.value"]),
        ({"F_c": {"value": 60.0 * (1 + 5e-10), "ci95": [59.0, None]}}, []),
        ({"F_c": {"value": 60.0, "ci95": [59.0, 61.0]}}, [".F_c.ci95[1]"]),
        ({"F_c": {"value": 60.0}}, [".F_c.ci95"]),
        ({"matrix": [[1.0, 2e-12]]}, []),  # beside the largest number of its row it is rounding
        ({"matrix": [[1.0]]}, [".matrix[0]"]),
        ({"codes": [["fall-open", "doubt"], ["one-speed", "doubt"]]}, []),
        ({"codes": [["one-speed", "doubt"], ["fall-open", "wrong"]]}, [".codes[0][1]"]),
    ],
)
def test_each_difference_beyond_rounding_is_told(compared, changed, told):
    lines = compared(DOCUMENT | changed)
    assert [line.split(": ")[1] for line in lines] == told


def test_a_document_that_is_missing_is_told(compared):
    assert len(compared(DOCUMENT, "other.json")) == 2
