"""The derivatives over the blocks of a GMS fit, from few replays."""

from dataclasses import replace

import numpy as np
import pytest

from fric.friction.gms import GMS
from fric.identify.replay.replay_search import Coordinates, Search, block_slopes, coordinates_of, search_ranges
from fric.records.prepared import prepared
from tests.identify.presliding import PAPER, TABLE_1, record


@pytest.mark.parametrize("negative", [None, replace(PAPER, F_c=95.0, F_s=150.0)])
def test_the_slopes_of_blocks_are_those_of_replays_that_are_moved(negative):
    logs = [record(40e-6, frequency=0.5, cycles=3, dt=4e-3, step=0.0)]
    held = {("static", name): getattr(PAPER, name) for name in ("F_c", "F_s", "v_s", "delta", "sigma")}
    ready = prepared(logs)
    free = Coordinates.of(GMS, search_ranges(ready), blocks=4, held=held, level=True, negative=negative)
    x, search = coordinates_of(free, replace(TABLE_1, C=4e3)), Search(free, ready)
    slopes = block_slopes(free, x, ready[0], both=True)
    assert len(slopes) == len(x)  # alpha, k, C and the level
    moved = 3e-5 * np.eye(len(x))
    plain = np.column_stack([(search.residual(x - one) - search.residual(x + one)) / 6e-5 for one in moved])
    found = search.projected([np.column_stack([slopes[n] for n in range(len(x))])])
    assert np.linalg.norm(found - plain, axis=0) == pytest.approx(0.0, abs=2e-3 * np.linalg.norm(plain, axis=0).min())
