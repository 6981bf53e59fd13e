"""What hangs on counts of an encoder is told with its chance."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtr

from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.io.circle import read_runs, write_runs
from fric.simulate import contour_run
from fric.simulate.contour_run import ACCURACY, FEWER, PLACES, Chance, Circle, PointPath, run_circle, run_path
from fric.simulate.machine import Machine
from fric.verdict import Candidate, Evidence, candidates_of, decide, difference
from tests.turns import in_turns

TABLE = read_machine(Path("configs/xy-table.yaml"))
SMALL = Circle(radius=3e-3, feed=0.01)
UM = 1e-6


def changed(machine: Machine, runs: int) -> Iterator[Machine]:
    """Yield the machine with A, B, K_f and T_d changed by shares of 1e-15 to 1e-9."""
    rng = np.random.default_rng(11)
    for _ in range(runs):
        axes = {}
        for name, axis in machine.axes.items():
            A, B, K_f, T_d = 1 + 10 ** rng.uniform(-15, -9, 4) * rng.choice([-1, 1], 4)
            plant = axis.plant
            new = replace(plant, A=A * plant.A, B=B * plant.B, K_f=K_f * plant.K_f, T_d=T_d * plant.T_d)
            axes[name] = replace(axis, plant=new)
        yield replace(machine, axes=axes)


def held(machine: Machine, scheme: str, test: Circle, runs: int) -> float:
    """Return the share of runs, of a machine whose inputs change by nothing, within the chance that is shown."""
    shown = run_circle(machine, PAPER_SCHEMES[scheme], test).chance()
    found = [
        run_circle(one, PAPER_SCHEMES[scheme], test, accuracy=ACCURACY, places=1).circularity.glitch
        for one in changed(machine, runs)
    ]
    assert np.ptp(found) > 0.0  # else there is nothing to hold
    return float(np.mean([shown.low <= one <= shown.high for one in found]))


def coarse() -> Machine:
    """Return a machine on which (f) leaves less than a count at 100 mm/s: exact friction, and counts of 1 µm."""
    exact = read_machine(Path("configs/xy-table.yaml"), gain=1.0)
    return replace(exact, axes={name: replace(axis, encoder=Encoder(1 * UM)) for name, axis in exact.axes.items()})


@pytest.mark.parametrize(("places", "mean"), in_turns([(PLACES, 0.981), (FEWER, 0.973)], [(FEWER, 0.973)], 2))
def test_nine_of_ten_intervals_of_normal_values_hold_95_per_cent_of_further_ones(places: int, mean: float) -> None:
    """0.901; the standard error of 20,000 is 0.002, so that less than 0.893 is no chance (1e-4)."""
    shown = [Chance(tuple(values)) for values in np.random.default_rng(0).standard_normal((20_000, places))]
    content = np.array([ndtr(one.high) - ndtr(one.low) for one in shown])
    assert np.mean(content >= 0.95) > 0.893
    assert abs(content.mean() - mean) < 0.003


def test_the_chance_that_is_shown_holds_runs_whose_inputs_change_by_nothing() -> None:
    """Of 72 runs 54 or more: three intervals, of what scatters normally, hold fewer by a chance of 1e-3."""
    assert np.mean([held(TABLE, scheme, SMALL, 24) for scheme in "acf"]) >= 0.75


@pytest.mark.long(60)
def test_the_chance_that_is_shown_holds_95_per_cent_over_80_circles() -> None:
    """98 % are expected of what scatters normally; 80 intervals hold less than 95 % of 800 runs by a chance of 7e-4."""
    rng, shares = np.random.default_rng(5), []
    for n in range(80):
        test = Circle(radius=rng.uniform(2e-3, 4e-3), feed=rng.uniform(0.008, 0.025))
        shares.append(held(TABLE, "abcdef"[n % 6], test, 10))
    assert np.mean(shares) >= 0.95


@pytest.mark.long(400)
def test_the_chance_that_is_shown_holds_200_runs_of_each_scheme_at_10_mm_s_and_of_less_than_a_count() -> None:
    """Each of the seven held 95 % and more when this was written; less than 86 % of all come by a chance of 1e-3."""
    shares = [held(TABLE, scheme, Circle(feed=0.01), 200) for scheme in "abcdef"]
    assert np.mean([*shares, held(coarse(), "f", Circle(), 200)]) >= 0.86


def test_what_does_not_hang_on_counts_is_run_once() -> None:
    """At 100 mm/s where counts are a tenth of the glitch, and at any feed without an encoder."""
    smooth = replace(TABLE, axes={name: replace(axis, encoder=Encoder()) for name, axis in TABLE.axes.items()})
    for machine, test in ((TABLE, Circle(revolutions=1)), (smooth, SMALL)):
        run = run_circle(machine, PAPER_SCHEMES["a"], test)
        assert not run.places
        assert run.chance() == Chance((run.circularity.glitch,), 0.0)


@pytest.mark.parametrize(("machine", "test"), [(TABLE, SMALL), (coarse(), Circle(revolutions=1))])
def test_the_run_that_is_kept_is_that_of_the_median_glitch(machine: Machine, test: Circle) -> None:
    run = run_circle(machine, PAPER_SCHEMES["f"], test)
    assert len(run.places) == PLACES
    assert run.circularity.glitch == run.chance().median == sorted(run.chance().values)[PLACES // 2]
    assert len(set(run.chance().values)) == PLACES
    again = run_circle(machine, PAPER_SCHEMES["f"], test)
    assert again.places == run.places


def test_a_very_long_circle_is_run_at_three_places(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its interval is wider, its median is one of its runs."""
    five = run_circle(TABLE, PAPER_SCHEMES["f"], SMALL)
    monkeypatch.setattr(contour_run, "LONG", 10_000)
    run = run_circle(TABLE, PAPER_SCHEMES["f"], SMALL)
    assert len(run.places) == FEWER
    assert run.places[0] == five.places[0]
    assert run.circularity.glitch == run.chance().median
    assert run.chance().half == 6.9 * np.std(run.chance().values, ddof=1)


def test_every_axis_lies_at_every_place_and_no_two_at_the_same() -> None:
    pairs = [[axis.encoder.place for axis in TABLE.placed(n / PLACES).axes.values()] for n in range(PLACES)]
    for places in np.array(pairs).T:
        np.testing.assert_allclose(np.sort(places), np.arange(PLACES) / PLACES, atol=1e-12)
    assert all(x != y for x, y in pairs[1:])


def test_a_path_and_a_run_file_keep_the_chance(tmp_path: Path) -> None:
    angle = np.linspace(0, 2 * np.pi, 200)
    path = PointPath(3e-3 * np.cos(angle), 3e-3 * np.sin(angle), 0.01)
    runs = [run_circle(TABLE, PAPER_SCHEMES["f"], SMALL), run_path(TABLE, PAPER_SCHEMES["c"], path)]
    for run in runs:
        file = tmp_path / f"{run.scheme.name}.h5"
        write_runs(file, [run])
        (again,) = read_runs(file)
        assert again.places == run.places
        assert [one.interval for one in candidates_of([again])] == [(run.chance().low, run.chance().high)]


def leaves(name: str, *glitches: float) -> Candidate:
    values = tuple(one * UM for one in glitches)
    middle = float(np.median(values))
    return Candidate(scheme=PAPER_SCHEMES[name], glitches=(middle,) * 4, glitch=middle, places=values)


def test_schemes_whose_difference_is_within_chance_are_ties_and_the_simpler_wins() -> None:
    """(f) leaves 0.4 µm less than (c) by its median, and more at one place; then less at every place by as much."""
    bare = leaves("a", 5.0, 5.1, 4.9, 5.0, 5.0)
    tie = [bare, leaves("c", 1.5, 1.4, 1.6, 1.5, 1.2), leaves("f", 1.1, 1.0, 1.1, 1.2, 1.3)]
    sure = [*tie[:2], leaves("f", 1.1, 1.0, 1.2, 1.1, 0.8)]
    for candidates, best in ((tie, "c"), (sure, "f")):
        found = decide(Evidence(candidates=candidates, axes=("x", "y"), resolution=0.1 * UM))
        assert found.choice is not None
        assert found.choice.scheme.name == best
    assert difference(*tie[1:])[0] < 0 < difference(*sure[1:])[0]


def test_half_of_the_interval_is_written_where_it_is_more_than_the_last_digit() -> None:
    assert Chance((1.5 * UM,)).text() == "1.5"
    assert Chance((1.5 * UM, 1.51 * UM, 1.5 * UM, 1.5 * UM, 1.5 * UM)).text() == "1.5"
    assert Chance((1.5 * UM, 1.55 * UM, 1.45 * UM, 1.5 * UM, 1.5 * UM)).text() == "1.5±0.1"
    assert Chance((0.0, 0.3 * UM, 0.0, 0.0, 0.0), 0.0).low == 0.0
    four = (1.0 * UM, 1.1 * UM, 1.2 * UM, 1.3 * UM)  # of a run file that something else wrote
    assert Chance(four).half == 6.9 * np.std(four, ddof=1)


def test_a_peak_of_one_size_that_points_either_way_is_written_by_its_size() -> None:
    """Five runs that leave 5.7 to 5.9 µm, outwards or inwards, were 5.7±26.7."""
    either = tuple(one * UM for one in (5.8, -5.9, 5.7, 5.8, -5.8))
    assert Chance(either).text().startswith("±5.8±0.")
    assert Chance(tuple(map(abs, either))).text() == Chance(either).text().removeprefix("±")
    for around in ((0.1, -0.2, 0.05, 0.3, -0.1), (0.0, 0.1, -0.1, 0.0, 0.0)):  # the size is as open
        assert not Chance(tuple(one * UM for one in around)).text().startswith("±")


def test_an_axis_that_makes_no_circle_of_the_machine_is_run_alone() -> None:
    """The third linear axis ended in a KeyError; one that turns is refused."""
    more = {"z": replace(TABLE.axes["x"], name="z"), "c": replace(TABLE.axes["x"], name="c", motion="rotary")}
    three = replace(TABLE, axes={**TABLE.axes, **more})
    run = run_circle(three, PAPER_SCHEMES["a"], only="z")
    assert [*run.traces] == ["z"]
    assert run.circularity.quadrants == run_circle(TABLE, PAPER_SCHEMES["a"], only="x").circularity.quadrants
    with pytest.raises(FricError, match="axis c turns"):
        run_circle(three, PAPER_SCHEMES["a"], only="c")
