"""`identify_gms` on a reciprocating contact: the first five loops, replayed over the rest."""

from pathlib import Path

import numpy as np
import pytest

from fric.documents.mapping import MappingDocument
from fric.documents.yaml import read_document
from fric.identify.gms.identify import identify_gms
from fric.io.hdf5 import read_logs
from fric.io.ingest import ingest

ROOT = Path(__file__).parents[2]
FILE = ROOT.parent / "shared/data/tribometer/reciprocating-first-75s.txt"

pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(not FILE.exists(), reason="the real logs are not here (../shared/data)"),
]


def test_five_loops_foretell_the_rest(tmp_path):
    mapping = read_document(ROOT / "configs/mappings/tribometer.yaml", MappingDocument)
    ingest(FILE, tmp_path / "log.h5", mapping=mapping)
    fit = identify_gms(read_logs(tmp_path / "log.h5"), blocks=4, cycles=(1, 5))
    (record,) = fit.records
    assert 2.0 < fit.static.F_s < 2.6
    assert record.held_out.sum() > 0.5 * len(record.record.force)
    assert record.rmse_held_out < 0.16
    curve = fit.curve
    assert len(fit.blocks) == 4
    assert np.sqrt(np.mean((curve.force - fit.blocks(curve.displacement)) ** 2)) < 0.022
    assert fit.curve_rmse < 0.022
    # the replay must be worth its parameters: a plain Coulomb level is ten times worse
    level = np.where(np.gradient(record.record.motion.position, record.record.motion.time) >= 0, 1, -1) * fit.static.F_s
    held = record.held_out
    assert np.std((record.record.force - level)[held]) > 5 * record.rmse_held_out
