"""A step is made again when, and only when, something that it depends on has changed."""

from pathlib import Path

import pytest

from fric.errors import FricError
from fric.reproduce.step_cache import StepCache


@pytest.fixture
def bench(tmp_path):
    source, product, calls = tmp_path / "source", tmp_path / "shop" / "product", []
    source.write_text("1")

    def step(**settings):
        def make():
            calls.append(settings)
            product.write_text(source.read_text() + str(settings))

        return StepCache(tmp_path / "shop").step("step", make, reads=[source], leaves=[product], settings=settings)

    return source, product, calls, step


def test_unchanged_is_not_made_again(bench):
    _, _, calls, step = bench
    assert step(seed=1)
    assert not step(seed=1)
    assert len(calls) == 1


@pytest.mark.parametrize("change", ["input", "setting", "product edited", "product gone", "ledger broken"])
def test_any_change_makes_it_again(bench, change):
    source, product, calls, step = bench
    step(seed=1)
    if change == "input":
        source.write_text("2")
    elif change == "product edited":
        product.write_text("by hand")
    elif change == "product gone":
        product.unlink()
    elif change == "ledger broken":
        (product.parent / ".steps.json").write_text("{")
    assert step(seed=2 if change == "setting" else 1)
    assert len(calls) == 2


def test_a_step_that_failed_is_made_again(tmp_path):
    def fail():
        raise FricError("no")

    shop = StepCache(tmp_path)
    with pytest.raises(FricError):
        shop.step("step", fail, reads=[], leaves=[tmp_path / "x"])
    assert StepCache(tmp_path).step("step", lambda: None, reads=[], leaves=[tmp_path / "x"])


def test_a_folder_that_cannot_be_is_an_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FricError, match="cannot be made"):
        StepCache(Path(tmp_path / "file" / "folder"))
