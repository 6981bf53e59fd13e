"""Repeats within real logs: halves and windows agree within their intervals as often as those say."""

from itertools import combinations
from math import hypot
from pathlib import Path

import pytest

import fric
from fric.identify.plant.identify import identify_motion
from tests.chance import fewest

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data"

pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(not DATA.exists(), reason="the real logs are not here (../shared/data)"),
    pytest.mark.long(30),
]
FILES = {"screwdrive1": "screwdrive1/steady_state/0.096kg/*.csv", "emps": "emps/DATA_EMPS.mat"}


def logs(name: str, folder: Path):
    to = folder / f"{name}.h5"
    fric.ingest(*sorted(DATA.glob(FILES[name])), mapping=ROOT / f"configs/mappings/{name}.yaml", output=to)
    return fric.read(to)


def test_halves_of_real_records_agree_but_for_what_is_said_of_directions(tmp_path):
    """F_v of EMPS is 167 and 240, which `viscous-by-direction` says: of 17 values it alone differs."""
    found = [one for name in FILES for one in fric.compare(*logs(name, tmp_path), halves=True).halves.found]
    apart = [(one.by, one.parameter) for one in found if one.half_widths > 1.0]
    assert len(found) >= 16
    assert apart == [("direction", "F_v")]


def test_windows_of_a_real_motion_agree(tmp_path):
    """Thirds of EMPS: of M, F_v, F_c and the offset, 12 of 12 pairs."""
    (log,) = logs("emps", tmp_path)
    n = len(log)
    fits = [identify_motion([log.slice(k * n // 3, (k + 1) * n // 3)]).estimates for k in range(3)]
    near = [
        abs(float(a[name]) - float(b[name])) <= hypot(a[name].half_width, b[name].half_width)
        for a, b in combinations(fits, 2)
        for name in a
    ]
    assert len(near) == 12
    assert sum(near) >= fewest(len(near))
