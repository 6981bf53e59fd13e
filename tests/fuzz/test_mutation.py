"""A few mutated inputs a day, another seed each; and every input that ever failed."""

import os
import time
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.fuzz.mutation import READ, judged, run

COUNTS = [60, pytest.param(int(os.environ.get("FUZZ_COUNT", "600")), marks=pytest.mark.long(60))]
SEED = int(os.environ.get("FUZZ_SEED", datetime.now(UTC).strftime("%Y%m%d")))
CORPUS = sorted((Path(__file__).parent / "corpus").glob("*-*"))


@pytest.mark.parametrize("count", COUNTS)
def test_mutated_files_end_well_or_in_a_sentence(count):
    print(f"seed {SEED}")
    failed = [(kind, source.name, n, told) for kind, source, n, told in run(count, SEED) if told]
    assert not failed, f"seed {SEED}: {failed[:3]}"


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: path.name)
def test_what_failed_once_does_not_again(path, tmp_path):
    kind = path.name.partition("-")[0]
    copy = tmp_path / path.name
    copy.write_bytes(path.read_bytes())
    assert kind in READ
    assert not judged(kind, copy)


def test_the_judge_tells_failures(tmp_path, monkeypatch):
    def broken(path: Path) -> None:
        raise ValueError(path)

    monkeypatch.setitem(READ, "yaml", broken)
    assert judged("yaml", tmp_path / "a").startswith("traceback")
    monkeypatch.setitem(READ, "yaml", lambda path: time.sleep(3))
    monkeypatch.setattr("tests.fuzz.mutation.SECONDS", 1)
    assert judged("yaml", tmp_path / "a").startswith("slow")
