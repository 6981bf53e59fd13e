"""Write each record of a log file as a CSV that needs no mapping: python data/as_csv.py LOG.h5 FOLDER."""

import sys
from pathlib import Path

import pandas as pd

from fric.io.hdf5 import read_logs

log_file, folder = Path(sys.argv[1]), Path(sys.argv[2])
folder.mkdir(exist_ok=True)
for log in read_logs(log_file):
    columns = {"time [ms]": 1e3 * log.time, "position [um]": 1e6 * log.position, "force [N]": log.force}
    pd.DataFrame(columns).to_csv(folder / f"{log.name}.csv", index=False, float_format="%.3f")
