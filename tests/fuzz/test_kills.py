"""A few kills of a command that writes HDF5, one that writes text and a figure, and the judge of what is left."""

import pytest

from tests.fuzz.kills import drafts, halves, run_kills


@pytest.mark.long
def test_a_killed_command_leaves_no_half_file_and_the_next_run_works(tmp_path):
    found = list(run_kills(4, 5, tmp_path, frozenset({"ingest", "identify"})))
    assert len(found) == 4
    assert not [one for one in found if one[3]]


def test_the_judge_tells_half_files_and_drafts(tmp_path):
    (tmp_path / "a.h5").write_bytes(b"\x89HDF\r\n\x1a\n and no more")
    (tmp_path / "a.yaml").write_text("fric: plant/1\nA: [")
    (tmp_path / "a.png").write_bytes(b"\x89PNG")
    (tmp_path / "a.html").write_text("<html>")
    (tmp_path / "whole.yaml").write_text("fric: plant/1\n")
    (tmp_path / ".a-0123abcd.h5").write_bytes(b"")
    assert len(list(halves(tmp_path))) == 4
    assert drafts(tmp_path) == [".a-0123abcd.h5"]
