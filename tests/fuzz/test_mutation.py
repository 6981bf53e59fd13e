"""A few mutated inputs, or many, of another seed each day; and every input that ever failed."""

import os
from datetime import UTC, datetime
from itertools import count
from pathlib import Path

import pytest

from tests.fuzz.mutation import READ, judged, run

SEED = int(os.environ.get("FUZZ_SEED", datetime.now(UTC).strftime("%Y%m%d")))
COUNTS = [(12, 1), pytest.param(int(os.environ.get("FUZZ_COUNT", "600")), SEED, marks=pytest.mark.long(60), id="today")]
CORPUS = sorted((Path(__file__).parent / "corpus").glob("*-*"))


@pytest.mark.parametrize(("files", "seed"), COUNTS)
def test_mutated_files_end_well_or_in_a_sentence(files, seed):
    print(f"seed {seed}")
    failed = [(kind, source.name, n, told) for kind, source, n, told in run(files, seed) if told]
    assert not failed, f"seed {seed}: {failed[:3]}"


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
    monkeypatch.setitem(READ, "yaml", lambda path: all(n >= 0 for n in count()))
    monkeypatch.setattr("tests.fuzz.mutation.SECONDS", 0.3)
    assert judged("yaml", tmp_path / "a").startswith("slow")
