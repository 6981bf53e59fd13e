"""What is particular to the GMS model; what holds for every model is in test_properties.py."""

import numpy as np
import pytest

from fric.errors import FricError
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap

STATIC = StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3, delta=1.0, sigma=40.0)
ALPHA = tuple(a / 1.002 for a in (0.566, 0.227, 0.170, 0.039))
TABLE_1 = GMS(STATIC, ALPHA, (99.94e6, 1.364e6, 1.081e6, 0.119e6), 1e4)


def test_table_1_slips_where_the_notes_say():
    np.testing.assert_allclose(TABLE_1.slip_displacements * 1e6, [0.93, 27.5, 25.9, 54.1], rtol=0.01)


def test_slow_pull_from_rest_follows_the_virgin_curve():
    time = np.linspace(0.0, 1000.0, 4001)
    position = 0.1e-6 * time  # at 0.1 um/s the level is F_s within 0.01 %
    force = TABLE_1.replay(time, position)
    np.testing.assert_allclose(force, TABLE_1.virgin_curve(position), atol=0.02)


@pytest.mark.parametrize(
    "fields",
    [{"alpha": (0.5, 0.6)}, {"alpha": (1.5, -0.5)}, {"alpha": (1.0,)}, {"k": (1e6, 0.0)}, {"C": 0.0}, {"C": -1.0}],
)
def test_parameters_without_physics_are_refused(fields):
    with pytest.raises(FricError):
        GMS(**{"static": STATIC, "alpha": (0.5, 0.5), "k": (1e6, 1e5), "C": 1e4} | fields)
