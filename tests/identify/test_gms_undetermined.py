"""What a sliding record does not tell is not invented."""

from dataclasses import replace
from pathlib import Path

import pytest

from fric.drive.plant import Plant
from fric.identify.gms.identify import ASSUMED_C, identify_gms
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked
from fric.io.hdf5 import read_logs

DATA = Path(__file__).parents[2] / "data"
PLANT = Plant(A=16.9, B=2.4, T_d=0.6e-3, K_f=150.0)  # of the rig


@pytest.mark.long(3)
def test_a_plant_that_is_not_the_log_s_leaves_C_assumed_and_says_so():
    wrong = Plant(A=16.9, B=2.4, T_d=0.6e-3, K_f=548.0)  # the rig's force constant is 150 N/V
    static = identify_static(read_logs(DATA / "constant-velocity.h5"), Asked(plant=wrong)).static.static_map
    logs = read_logs([DATA / "presliding-sine.h5", DATA / "sliding-sine.h5"])
    fit = identify_gms(logs, static=static, plant=wrong, blocks=3)
    assert fit.C.assumed
    assert float(fit.C) == ASSUMED_C
    assert "C-assumed" in {warning.code for warning in fit.warnings}


def test_sines_at_another_level_than_the_strokes_identify_no_C():
    """Of a machine that had warmed C was 64 (9 … 468) N/s, and 2500 is right."""
    static = identify_static(read_logs(DATA / "constant-velocity.h5"), Asked(plant=PLANT)).static.static_map
    colder = replace(static, F_c=1.5 * static.F_c, F_s=1.5 * static.F_s)
    logs = read_logs([DATA / "presliding-sine.h5", DATA / "sliding-sine.h5"])
    fit = identify_gms(logs, static=colder, plant=PLANT, blocks=3)
    assert fit.C.assumed
    assert {"C-assumed", "level-of-another"} <= {warning.code for warning in fit.warnings}
