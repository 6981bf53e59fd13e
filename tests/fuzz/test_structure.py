"""Whole commands on inputs whose fields, shapes, types and values are changed: a sentence, or what can be believed."""

from datetime import UTC, datetime
from pathlib import Path
from time import monotonic

import pytest

from tests.fuzz import structure

MINUTES = 5.0


@pytest.fixture(scope="module", autouse=True)
def imported() -> None:
    structure.ready()


def wrong(count: int, place: Path, minutes: float, seed: int) -> list[str]:
    """Return the cases that end as none may."""
    begun, found = monotonic(), list[str]()
    for case, _, what in structure.run(seed, range(count), place):
        found += [f"seed {seed}, case {case.n}: {case.words}: {what}"] if what else []
        if monotonic() - begun > 60.0 * minutes:
            break
    return found


def test_a_few_cases(tmp_path: Path) -> None:
    assert wrong(20, tmp_path, 10.0, 20261123) == []


@pytest.mark.long(300)
def test_five_minutes_of_cases(tmp_path: Path) -> None:
    """Each day has other cases."""
    assert wrong(100_000, tmp_path, MINUTES, int(datetime.now(UTC).strftime("%Y%m%d"))) == []


@pytest.mark.parametrize(
    ("code", "what"),
    [
        ("raise ValueError", "traceback"),
        ("import os; os.kill(os.getpid(), 11)", "status -11"),
        ("print('a.py:1: RuntimeWarning: overflow')", "warning"),
        ("print('\\x1b[2J')", "unprintable"),
        ("open('out.yaml', 'w').write('a: .nan')", "silent"),
    ],
)
def test_the_judge_tells_what_must_not_be(
    code: str, what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fric.cli.main.main", lambda: exec(code))
    assert structure.judged([], tmp_path).startswith(what)
