"""Whole commands on inputs whose fields, shapes, types and values are changed: a sentence, or what can be believed."""

import re
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
    assert wrong(8, tmp_path, 10.0, 20261123) == []


@pytest.mark.long(300)
def test_five_minutes_of_cases(tmp_path: Path) -> None:
    """Each day has other cases."""
    assert wrong(100_000, tmp_path, MINUTES, int(datetime.now(UTC).strftime("%Y%m%d"))) == []


FILE = re.compile(r"\.(h5|yaml|csv)\b|^FILE|^LOGS|^PLAN$|AXIS=FILE")
"""What stands for a file that is read, in the help of a command."""


def places() -> dict[str, set[str]]:
    """Return, of each command, its options that name a file which is read; "" is an argument."""
    found: dict[str, set[str]] = {}
    for line in (structure.ROOT / "docs/commands.md").read_text().splitlines():
        if head := re.match(r"##+ `fric ([\w ]+)`", line):
            found[head[1]] = last = set[str]()
        elif (said := re.match(r"\* `(?:(-\S+)(?: --\w+)? )?([^`<]*?)(?: <[^>]*>)?`:", line)) and FILE.search(said[2]):
            last |= {(said[1] or "").rstrip(",")} - {"-o", "--propose"}
    return found


def test_every_file_that_a_command_takes_is_changed() -> None:
    asked, tried = places(), set()
    for line in (line for lines in structure.COMMANDS.values() for line in lines):
        words = line.replace("--with ", "--friction ").split()
        verb = next(text for text in (" ".join(words[:2]), words[0]) if text in asked)
        at = next(n for n, word in enumerate(words) if "FILE" in word or word.startswith("logs"))
        tried.add((verb, words[at - 1] if words[at - 1] in asked[verb] else ""))
    assert {(verb, flag) for verb, flags in asked.items() for flag in flags} - tried == set()


@pytest.mark.parametrize(
    ("code", "what"),
    [
        ("raise ValueError", "traceback"),
        ("import os; os.kill(os.getpid(), 11)", "status -11"),
        ("print('a.py:1: RuntimeWarning: overflow')", "warning"),
        ("print('\\x1b[2J')", "unprintable"),
        ("open('out.yaml', 'w').write('a: .nan')", "silent"),
        ("print('F_c = inf N')", "silent"),
        ("print('F_c = 1e+300 N')", "silent"),
        ("open('.a-0123abcd.h5', 'w')", "draft"),
    ],
)
def test_the_judge_tells_what_must_not_be(
    code: str, what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fric.cli.main.main", lambda: exec(code))
    assert structure.judged([], tmp_path).startswith(what)
