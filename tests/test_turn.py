"""How many long tests a session runs, and which: the suite's conftest, in another folder."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from tests.conftest import Turn, in_turn
from tests.legs import LEGS, NUMERIC, NUMERICS, PARTS, commits, files, whose_turn

ROOT = Path(__file__).parents[1]

TESTS = """
import pytest
def test_quick(): pass
@pytest.mark.long(1)
def test_short(): pass
@pytest.mark.long(1000)
def test_longer_than_the_part_of_a_day(): pass
@pytest.mark.long
def test_which_says_nothing(): pass
"""


@pytest.mark.parametrize(
    ("seconds", "words", "told"),
    [
        pytest.param("0", ["-p", "no:xdist"], "long tests: 0 run, 6 have", marks=pytest.mark.long(1)),
        ("122", ["-p", "no:xdist"], "long tests: 4 run, 2 have"),
        pytest.param("122", ["-n", "2", "--dist", "worksteal"], "long tests: 4 run, 2 have", marks=pytest.mark.long(4)),
    ],
)
def test_so_many_seconds_of_long_tests_are_run(tmp_path, seconds, words, told):
    shutil.copy(Path(__file__).parent / "conftest.py", tmp_path)
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = long\n")
    for name in ("test_one.py", "test_other.py"):
        (tmp_path / name).write_text(TESTS)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *words], cwd=tmp_path, env=os.environ | {"FRIC_LONG_SECONDS": seconds},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert told in done.stdout


def test_each_long_test_has_its_turn():
    lengths = [20.0, 5.0, 40.0, 300.0, 15.0, 15.0, 5.0, 20.0]  # 120 in all, without what no day has room for
    days = [in_turn(lengths, Turn(40.0, day)) for day in range(739_000, 739_003)]
    assert [sum(ran) for ran in zip(*days, strict=True)] == [1, 1, 1, 0, 1, 1, 1, 1]
    assert not any(in_turn(lengths, Turn(0.0, 739_000)))
    assert not in_turn([], Turn(40.0, 739_000))


def test_each_leg_has_its_turn():
    begin = commits()
    assert begin > 0 or not (ROOT / ".git").exists()
    assert {whose_turn(begin + n)[0] for n in range(len(NUMERICS))} == set(NUMERICS)
    assert {whose_turn(begin + n) for n in range(PARTS * len(NUMERICS))} == {
        (leg, n) for leg in NUMERICS for n in range(PARTS)
    }
    chosen = [file for part in range(PARTS) for file in files(NUMERIC, part)]
    assert len(chosen) == len(set(chosen))
    assert {str(file.relative_to(ROOT)) for file in ROOT.glob("tests/identify/**/test_*.py")} < set(chosen)


@pytest.mark.parametrize(
    ("given", "runs"),
    [
        ({"CI": "true"}, ["test []", "legs LEGS=turn []"]),
        ({"CI": "true", "FRIC_TURN_WITHIN": "0"}, ["test []"]),
        ({"CI": "true", "FRIC_LEGS": "old"}, ["test [old]"]),
        ({}, ["test []"]),
    ],
)
def test_ci_runs_the_leg_whose_turn_it_is_where_there_is_time(tmp_path, given, runs):
    """`.ci/run` beside a `make` that prints what it is asked for; nothing is installed."""
    for name in ("make", "chromedriver", "halcompile"):
        (tmp_path / name).write_text('#!/bin/sh\necho "$* [$FRIC_LEGS]"\n')
        (tmp_path / name).chmod(0o755)
    kept = {name: value for name, value in os.environ.items() if name not in {"CI", "FRIC_LEGS", "FRIC_TURN_WITHIN"}}
    environment = kept | {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"} | given
    done = subprocess.run(["bash", ROOT / ".ci/run"], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == runs


def test_the_weekly_workflow_runs_every_leg():
    jobs = YAML(typ="safe").load(ROOT / ".github" / "workflows" / "legs.yml")["jobs"]
    assert jobs["leg"]["strategy"]["matrix"]["leg"] == list(LEGS)
