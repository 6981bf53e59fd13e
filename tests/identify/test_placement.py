"""Where the blocks of a GMS fit are placed, where the machine has more of them than the model."""

from dataclasses import replace

import numpy as np
import pytest

from fric.friction.gms import GMS
from fric.identify.replay.replay_fit import placed
from fric.identify.replay.replay_search import Coordinates, Search, coordinates_of, search_ranges
from fric.records.prepared import prepared
from tests.identify.presliding import PAPER, identify_gms, pair, record

SLIP, SHARE = np.geomspace(0.6e-6, 85e-6, 10), np.array([20, 16, 13, 11, 10, 9, 8, 6, 4, 3]) / 100
TEN = GMS(PAPER, tuple(SHARE), tuple(SHARE * PAPER.F_s / SLIP), C=1e4)
STATIC = {("static", name): getattr(PAPER, name) for name in ("F_c", "F_s", "v_s", "delta", "sigma")}


@pytest.fixture(scope="module")
def ready():
    return [one.trimmed() for one in prepared(pair(TEN, dt=2e-2, step=0.0))]


def drawn(rng, count):
    """Return blocks anywhere, as a search might begin with."""
    slip, share = np.sort(np.exp(rng.uniform(np.log(0.3e-6), np.log(200e-6), count))), rng.dirichlet(np.full(count, 3))
    return GMS(PAPER, tuple(share), tuple(share * PAPER.F_s / slip), C=1e4)


@pytest.mark.parametrize("count", [6, pytest.param(20, marks=pytest.mark.long(5))])
def test_no_start_leads_to_a_better_place(ready, count):
    """Of so many least-squares points, each from blocks anywhere, most are worse, and none is better."""
    search = Search(Coordinates.of(GMS, search_ranges(ready), blocks=4, held=STATIC | {("gms", "C"): 1e4}), ready)
    rng = np.random.default_rng(1)
    starts = [coordinates_of(search.coordinates, drawn(rng, 4)) for _ in range(count)]
    plain = np.array([search.cost(search.fine(x)) for x in starts])
    found = [search.cost(search.fine(placed(search, x).better(x))) for x in starts[: 1 + count // 10]]
    assert max(found) < (1 + 1e-3) * plain.min()
    assert np.mean(plain > 1.02 * plain.min()) > 0.5


@pytest.mark.parametrize("step", [0.0, 0.5e-6])
def test_no_two_knots_are_nearer_than_four_steps_of_the_encoder(step: float) -> None:
    """Where the position is known the best places of seven blocks are nearer: the encoder moves them apart."""
    ready = [one.trimmed() for one in prepared(pair(TEN, dt=2e-2, step=step))]
    search = Search(Coordinates.of(GMS, search_ranges(ready), blocks=7, held=STATIC | {("gms", "C"): 1e4}), ready)
    x = coordinates_of(search.coordinates, drawn(np.random.default_rng(1), 7))
    gaps = np.diff(np.sort(PAPER.F_s * np.exp(-placed(search, x).places)), axis=1)
    assert len(gaps)
    assert (gaps.min() >= 4 * 0.5e-6) == bool(step)


def test_shares_stay_shares_where_records_hardly_tell_blocks_apart() -> None:
    """Kicks after reversals, as of a compensation left on: noise moved a share below zero, and the fit was refused."""
    log = record(20e-6, cycles=3, dt=1e-2, step=1e-7)
    half = np.floor(log.time / 5.0 + 0.5)  # of the sine, each with its reversal at the begin
    kick = -50.0 * np.where(half % 2 == 1, -1, 1) * np.exp(-(log.time - 5.0 * half + 2.5) / 0.5) * (half > 0)
    fit = identify_gms([replace(log, force=log.force + kick)], blocks=5)
    assert min(fit.alpha.value) >= 0.0
    assert sum(fit.alpha.value) == pytest.approx(1.0, abs=1e-5)
