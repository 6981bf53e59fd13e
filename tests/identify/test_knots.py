"""Slip blocks from the virgin curve."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fric import FricError
from fric.identify.gms.virgin_curve import STRONG, Blocks, VirginCurve, blocks_from_knots, choose_blocks, fit_blocks
from tests.identify.presliding import APART, TABLE_1

BLOCKS = st.integers(1, 7).flatmap(
    lambda n: st.tuples(
        st.lists(st.floats(0.05, 20.0), min_size=n, max_size=n), st.lists(st.floats(0.1, 5.0), min_size=n, max_size=n)
    )
)


def exact(blocks, reach, noise=0.0, seed=0, count=400):
    """Return a curve of four cycles of exact blocks, with noise."""
    z = np.geomspace(1e-3 * reach, reach, count)
    cycles = blocks(z) + noise * np.random.default_rng(seed).standard_normal((4, count))
    band = np.full(count, 3.18 * noise / 2)
    level = float(blocks.limit.sum())
    return VirginCurve(z, cycles.mean(axis=0), band, cycles, (("exact", reach),), level)


@given(BLOCKS)
def test_eq_6_gives_back_the_blocks_that_a_curve_was_made_of(drawn):
    steps, stiffness = drawn
    blocks = Blocks(1e6 * np.array(stiffness), 1e-6 * np.cumsum(steps))
    found = blocks_from_knots(blocks.displacement, blocks(blocks.displacement))
    assert found.k == pytest.approx(blocks.k, rel=1e-6)
    assert found.limit.sum() == pytest.approx(blocks(blocks.displacement[-1]), rel=1e-9)


def test_eq_6_as_printed_for_four():
    # K_o = k1+k2+k3+k4, K_a = k2+k3+k4 (the row that was lost), K_b = k3+k4, K_c = k4
    slopes = np.array([100.0, 9.0, 4.0, 1.0]) * 1e6
    knots = np.array([1.0, 5.0, 20.0, 80.0]) * 1e-6
    force = np.cumsum(slopes * np.diff(knots, prepend=0.0))
    assert blocks_from_knots(knots, force).k == pytest.approx([91e6, 5e6, 3e6, 1e6])


@pytest.mark.parametrize(("knots", "force"), [([1e-6, 2e-6], [10.0, 30.0]), ([2e-6, 1e-6], [10.0, 20.0])])
def test_knots_that_do_not_suit_are_refused(knots, force):
    with pytest.raises(FricError, match="knot"):
        blocks_from_knots(np.array(knots), np.array(force))


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_the_fit_finds_blocks_well_apart(count):
    true = Blocks(np.asarray(APART.k)[:count], APART.slip_displacements[:count])
    found = fit_blocks(exact(true, 3 * true.displacement[-1]), count)
    assert found.displacement == pytest.approx(true.displacement, rel=0.01)
    assert found.k == pytest.approx(true.k, rel=0.01)


def test_a_block_that_does_not_slip_within_the_curve_slips_where_the_level_is_reached():
    true = Blocks(np.array([4e6, 3e6]), np.array([2e-6, 40e-6]))
    found = fit_blocks(replace(exact(true, 10e-6), final_slope=0.8), 2)  # the curve ends at a quarter of the second
    assert found.displacement == pytest.approx(true.displacement, rel=0.01)
    assert found.k == pytest.approx(true.k, rel=0.01)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_the_criterion_finds_their_number(count):
    true = Blocks(np.asarray(APART.k)[:count], APART.slip_displacements[:count])
    choice = choose_blocks(exact(true, 3 * true.displacement[-1], noise=0.3), most=5)
    assert len(choice.blocks) == count
    assert choice.reason.startswith(f"{count} block")


@pytest.mark.parametrize(("worth", "count"), [(0.75, 2), (1.25, 3)])
def test_a_block_is_taken_where_it_explains_more_than_its_two_parameters_cost(worth, count):
    """By Schwarz's criterion a parameter costs ``ln n``, and a bare mention more decides.

    The third block is real and weak; the scatter says what it explains. With half the cost, or twice, one of the two
    choices is another.
    """
    true = Blocks(np.array([66e6, 4e6, 0.4e6]), np.array([1e-6, 20e-6, 50e-6]))
    curve = exact(true, 150e-6)
    missed = np.sum((curve.force - fit_blocks(curve, 2)(curve.displacement)) ** 2)
    cost = 2 * np.log(len(curve.force)) + STRONG
    scatter = np.sqrt(missed / (worth * cost))
    assert scatter > 10 * 0.005 * curve.level  # far above how well friction repeats
    noisy = replace(curve, band=np.full(len(curve.force), 2 * scatter))
    assert len(choose_blocks(noisy, most=4).blocks) == count


def test_the_criterion_gives_three_for_table_1_and_says_why():
    order = np.argsort(TABLE_1.slip_displacements)
    true = Blocks(np.asarray(TABLE_1.k)[order], TABLE_1.slip_displacements[order])
    choice = choose_blocks(exact(true, 450e-6))
    assert len(choice.blocks) == 3
    assert "blocks: another lowers" in choice.reason


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 1000))
def test_every_fit_is_concave_and_continuous(seed):
    rng = np.random.default_rng(seed)
    z = np.sort(rng.uniform(0.1e-6, 100e-6, 80))
    force = 100 * (1 - np.exp(-z / 10e-6)) + 5 * rng.standard_normal(80)
    curve = VirginCurve(z, force, np.ones(80), force[None], (("random", 1e-4),), 100.0)
    found = fit_blocks(curve, 3)
    assert (found.k > 0).all()
    assert (np.diff(found.displacement) >= 0).all()
    values = found(np.linspace(0, 1e-4, 301))
    assert (np.diff(values, 2) < 1e-9 * values.max()).all()
