"""A step is made again when, and only when, something that it depends on has changed."""

from pathlib import Path

import pytest

from fric.documents.yaml import read_tree
from fric.errors import FricError
from fric.reproduce.paper import AxisFiles, _identified_machine
from fric.reproduce.step_cache import StepCache

ROOT = Path(__file__).parents[2]


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
    with pytest.raises(FricError, match="cannot be written: Not a directory"):
        StepCache(Path(tmp_path / "file" / "folder"))


def test_a_machine_that_is_like_another_is_written_with_all_its_axes(tmp_path: Path) -> None:
    """As `KeyError: 'y'` of a machine that states one axis anew."""
    given, made = tmp_path / "given.yaml", tmp_path / "machine.yaml"
    given.write_text(f"fric: machine/1\nlike: {ROOT / 'configs/xy-table.yaml'}\naxes: {{x: {{encoder: null}}}}\n")
    files = {name: AxisFiles(tmp_path / name) for name in "xy"}
    for name, file in files.items():
        (tmp_path / name).mkdir()
        for key in ("plant", "controller", "observer", "friction"):
            before = ROOT / f"tests/documents/before/{key.replace('friction', 'gms')}.yaml"
            getattr(file, key).write_text(before.read_text().replace("axis: x", f"axis: {name}"))
    _identified_machine(given, files, made)
    tree = read_tree(made)
    assert [tree["axes"][name]["nominal"] for name in "xy"] == ["x/plant.yaml", "y/plant.yaml"]
    assert "like" not in tree
