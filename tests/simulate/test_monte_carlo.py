import multiprocessing
import os
import pickle
import signal
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from time import sleep

import numpy as np
import pytest
from scipy.stats import spearmanr

import fric
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.contours import MonteCarloPart
from fric.documents.machine_files import read_machine
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.results.base import Table
from fric.results.simulate import CircleResult
from fric.simulate import processes
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.processes import MonteCarlo, Outcome, Study, outcomes
from fric.simulate.spread import Spread
from tests.studies import monte_carlo

MACHINE = read_machine(Path("configs/xy-table.yaml"))
SMALL = Circle(0.005, 0.05, 1)
PAPER = tuple(PAPER_SCHEMES.values())
AC = (PAPER[0], PAPER[2])


def test_a_machine_that_is_not_spread_gives_the_nominal_table_to_the_last_digit():
    """Without an encoder; with it counts lie elsewhere on every machine, for all schemes alike."""
    smooth = replace(MACHINE, axes={name: replace(axis, encoder=Encoder()) for name, axis in MACHINE.axes.items()})
    found = monte_carlo(Study(smooth, PAPER, SMALL, spreads={}, accuracy=0.0), 2)
    nominal = [run_circle(smooth, scheme, SMALL).circularity.quadrants for scheme in PAPER]
    assert np.array_equal(found.quadrants, [nominal, nominal])
    counted = monte_carlo(Study(MACHINE, AC, SMALL, spreads={}), 2).quadrants
    assert np.all(counted[0] != counted[1])
    places = [[axis.encoder.place for axis in Study(MACHINE, AC).drawn(n)[0].axes.values()] for n in range(200)]
    assert len(np.unique(places)) == 400
    assert np.abs(np.mean(places, axis=0) - 0.5).max() < 0.08  # 4 standard errors
    ones = {name: Spread(1.0, 1.0) for name in ("level", "stiffness", "C", "K_f", "T_d")}
    drawn = monte_carlo(Study(smooth, PAPER, SMALL, spreads=ones, accuracy=0.0), 1)
    assert np.array_equal(drawn.quadrants[0], nominal)


def test_digits_do_not_depend_on_workers_repetition_or_how_many_machines_there_are():
    study = Study(MACHINE, AC, SMALL, seed=2)
    one, two, three = (monte_carlo(study, n, workers=w) for n, w in ((5, 1), (5, 2), (3, 3)))
    assert np.array_equal(one.quadrants, two.quadrants)
    assert np.array_equal(one.quadrants[:3], three.quadrants)
    assert [outcome.drawn for outcome in one.outcomes] == [outcome.drawn for outcome in two.outcomes]
    elsewhere = pickle.loads(pickle.dumps(study))  # as it goes to another process
    assert np.array_equal(elsewhere(4).quadrants, one.quadrants[4])
    assert not np.array_equal(monte_carlo(replace(study, seed=3), 1).quadrants, one.quadrants[:1])


class Killed:
    """A study on whose first machine the memory ends."""

    def __call__(self, index: int) -> Outcome:
        os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError


@pytest.mark.long(2)
def test_a_process_that_is_killed_is_told():
    with (
        pytest.raises(FricError, match=r"(?s)was killed.*Was there memory enough"),
        outcomes(Killed(), 4, workers=2) as ran,
    ):
        list(ran)


@pytest.mark.parametrize("module", ["__main__", __name__])
def test_workers_know_the_script_where_the_study_is_of_it_alone(monkeypatch, module):
    script = sys.modules["__main__"]
    monkeypatch.setattr(script, "Mine", type("Mine", (), {"__module__": "__main__"}), raising=False)
    study = script.Mine() if module == "__main__" else 1
    with processes._apart(study):
        assert (sys.modules["__main__"] is script) == (module == "__main__")
    assert sys.modules["__main__"] is script


def test_processes_that_were_begun_end_with_the_block():
    with outcomes(Study(MACHINE, AC, SMALL), 10_000, workers=2) as ran:
        assert next(ran).index == 0
    assert not multiprocessing.active_children()


@dataclass(frozen=True)
class Slow:
    """Returns the number 0 at once, and the others after it has written a file."""

    folder: Path

    def __call__(self, index: int) -> int:
        if index:
            (self.folder / "begun").touch()
            sleep(20.0)
            (self.folder / "done").touch()
        return index


def test_an_error_in_the_block_leaves_what_is_running(tmp_path):
    """Ctrl-C of a robot whose axes are identified waited for those that were running, for fourteen seconds."""

    def interrupted() -> None:
        with outcomes(Slow(tmp_path), 2, workers=2) as ran:
            assert next(ran) == 0
            while not (tmp_path / "begun").exists():
                sleep(0.01)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert not multiprocessing.active_children()
    assert not (tmp_path / "done").exists()


def test_more_friction_leaves_more_and_a_false_belief_costs_the_feedforward_alone():
    exact = {
        name: replace(axis, nominal_friction=replace(axis.nominal_friction, gain=1.0))
        for name, axis in MACHINE.axes.items()
    }
    study = Study(replace(MACHINE, axes=exact), AC, SMALL, spreads={"level": Spread(0.7, 1.3)}, only="x")
    found = monte_carlo(study, 12)
    level = np.array([outcome.drawn["x.level"] for outcome in found.outcomes])
    bare, fed = found.glitches.T
    assert spearmanr(level, bare).statistic > 0.99
    for side in (level > 1, level < 1):
        assert side.sum() > 3
        assert spearmanr(np.abs(level - 1)[side], fed[side]).statistic > 0.99
    assert np.all(fed < bare)


def _outcome(n: int, glitches: list[float]) -> Outcome:
    quadrants = np.array([[g, -g / 2, 0.0, 0.0] for g in glitches])
    failures = {PAPER[i].name: "not stable" for i, g in enumerate(glitches) if np.isnan(g)}
    none = np.zeros(len(glitches))
    return Outcome(n, {"x.level": 1.0}, quadrants, none.astype(bool), none, failures)


def test_quantiles_and_the_best_of_known_glitches():
    table = [[float(n), -100.0 + n, 50.0] for n in range(1, 101)]
    found = MonteCarlo(Study(MACHINE, PAPER[:3]), 100, tuple(_outcome(n, row) for n, row in enumerate(table)))
    told = found.distributions()
    assert told["a"].quantiles["median"] == pytest.approx(50.5)
    assert told["a"].quantiles["p05"] == pytest.approx(5.95)
    assert told["b"].quantiles["p95"] == pytest.approx(94.05)  # the magnitude counts: an inward spike is one too
    # a < b up to 49, at 50 all three are equal, above b is less
    assert [told[name].best for name in "abc"] == pytest.approx([(49 + 1 / 3) / 100, (50 + 1 / 3) / 100, 1 / 300])


def test_a_scheme_that_cannot_run_is_never_the_best_and_is_told():
    found = MonteCarlo(Study(MACHINE, PAPER[:2]), 2, (_outcome(0, [2.0, np.nan]), _outcome(1, [3.0, np.nan])))
    told = MonteCarloPart.model_validate(found).model_dump()["schemes"]
    assert (told["a"]["best"], told["b"]["best"], told["b"]["failed"]) == (1.0, 0.0, 2)
    assert told["b"]["median"] is None
    assert told["b"]["ci95"] == [None, None]
    runs = [run_circle(MACHINE, scheme, SMALL) for scheme in PAPER[:2]]
    table = CircleResult(MACHINE, runs, many=found).report()[0]
    assert isinstance(table, Table)
    assert [row[2:4] for row in table.rows] == [["2500000.0", "3000000.0"], ["–", "–"]]
    assert [(one.code, one.where, one.values["failed"]) for one in found.warnings()] == [
        ("scheme-failed", "scheme b", 2)
    ]


def test_machines_whose_loop_is_not_stable_are_left_out_and_counted():
    study = Study(MACHINE, (PAPER[0], PAPER[3]), SMALL, spreads={"T_d": Spread(1.0, 8.0)}, only="x")
    found = monte_carlo(study, 12)
    failed = found.distributions()["d"].failed
    assert 0 < failed < 12
    assert np.isfinite(found.distributions()["d"].quantiles["p95"])
    assert any("not stable" in warning for warning in found.warnings())
    too_short = monte_carlo(replace(study, spreads={"T_d": Spread(0.1, 0.15)}), 1)
    assert "shorter than half a sample" in too_short.outcomes[0].failures["a"]


def test_a_spread_without_effect_is_told():
    found = monte_carlo(Study(MACHINE, PAPER[:1], SMALL, spreads={"sigma_0": Spread(0.5, 2)}, only="x"), 1)
    assert any("sigma_0 has no effect" in warning for warning in found.warnings())


@pytest.mark.parametrize(("machines", "workers"), [(0, 1), (1, 0)])
def test_nothing_to_work_with_is_told(machines, workers):
    with pytest.raises(FricError, match="whole number"):
        fric.circle(MACHINE, "a", machines=machines, workers=workers)


@pytest.mark.long
def test_table_2_keeps_its_order_on_machines_around_the_paper_s():
    found = monte_carlo(Study(MACHINE, PAPER), 60)
    told = {name: one.quantiles["median"] for name, one in found.distributions().items()}
    assert told["a"] > told["b"] > told["c"] > told["e"] > told["f"]
    assert told["a"] > told["d"] > told["e"]
    assert found.distributions()["f"].best > 0.8
    assert sum(one.best for one in found.distributions().values()) == pytest.approx(1.0)
