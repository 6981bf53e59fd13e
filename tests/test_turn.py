"""How many long tests a session begins, and in which order: the suite's own conftest, in a folder of its own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.conftest import in_turn

TESTS = """
import pytest
def test_quick(): pass
@pytest.mark.long(1)
def test_short(): pass
@pytest.mark.long(1000)
def test_longer_than_the_time_that_is_left(): pass
@pytest.mark.long
def test_which_says_nothing(): pass
"""


@pytest.mark.parametrize(
    ("minutes", "words", "told"),
    [
        ("0", ["-p", "no:xdist"], "long tests: 0 begun, 6 had no time left"),
        ("10", ["-n", "2", "--dist", "worksteal"], "long tests: 4 begun (test_"),
    ],
)
def test_long_tests_are_begun_while_there_is_time(tmp_path, minutes, words, told):
    shutil.copy(Path(__file__).parent / "conftest.py", tmp_path)
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = long\n")
    for name in ("test_one.py", "test_other.py"):
        (tmp_path / name).write_text(TESTS)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *words], cwd=tmp_path, env=os.environ | {"FRIC_LONG_MINUTES": minutes},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert told in done.stdout


def test_each_day_another_file_comes_first():
    def item(path, late):
        return SimpleNamespace(path=path, get_closest_marker=lambda _: late or None)

    items = [item(path, late) for path in "abc" for late in (True, False, True)]
    for day, first in enumerate("abca"):
        turned = in_turn(items, day)
        assert [one.path for one in turned[:3]] == ["a", "b", "c"]
        assert not any(one.get_closest_marker("long") for one in turned[:3])
        late = [one.path for one in turned[3:]]
        assert late[0] == first
        assert "".join(late) in "aabbccaabbcc"
