"""A machine at two dates: documents, runs and logs, as files."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

import fric
from fric.control.scheme import choose_schemes
from fric.drive.plant import Plant
from fric.identify.halves import halves
from fric.io.circle import write_runs
from fric.log import Log
from fric.simulate.contour_run import run_circle

ROOT = Path(__file__).parents[2]
PAPER = ROOT / "configs" / "xy-table.yaml"
LOGS = ROOT / "data"

FRICTION = """
fric: friction/1
axis: x
motion: linear
static:
  F_c:    {{value: {F_c}, unit: N, ci95: [{F_c_low}, {F_c_high}]}}
  F_s:    {{value: 165.0, unit: N, ci95: [163.0, 167.0]}}
  v_s:    {{value: 1.0, unit: mm/s, ci95: [0.95, 1.06]}}
  delta:  {{value: 1.0, unit: "1", fixed: true}}
  sigma:  {{value: 40.0, unit: N*s/m, ci95: [30.0, 50.0]}}
{gms}
fit: {{rmse: {{value: 1.2, unit: N}}, r2: 0.998, points: 34, method: by hand}}
warnings: ["strokes <scatter> by 2.1 N beyond their own noise & more"]
provenance: {{fric: 0.1.0, created: '{created}', command: fric identify static, logs: [{{file: a.h5, sha256: abc}}]}}
"""
GMS = """gms:
  alpha:
    value: [0.566, 0.227, 0.168, 0.039]
    unit: "1"
    ci95: [[0.55, 0.58], [0.21, 0.24], [0.15, 0.18], [0.03, 0.05]]
  k: {value: [99.94, 1.364, 1.081, 0.119], unit: N/µm, ci95: [[95, 105], [1.3, 1.43], [1.0, 1.16], [0.11, 0.13]]}
  C: {value: 1.0e4, unit: N/s, ci95: [0.0, null]}
"""
OBSERVER = """
fric: observer/1
axis: x
filter: binomial2
cutoff: {value: 60, unit: Hz}
A: {value: 28.57, unit: 1/s}
B: {value: 4.526, unit: m/(s^2*V)}
reason: limited by the peak sensitivity of the whole loop, 6 dB
limits:
  robust: {cutoff: {value: 372.0, unit: Hz}, frequency: {value: 300.0, unit: Hz}, Delta: {value: 1.2, unit: "1"}}
  sensitive: {cutoff: {value: 60.0, unit: Hz}}
"""
PLANT = """
fric: plant/1
axis: x
A: {value: 28.57, unit: 1/s, ci95: [28.1, 29.0]}
B: {value: 4.526, unit: m/(s^2*V), ci95: [4.5, 4.55]}
T_d: {value: 0.65, unit: ms, ci95: [0.64, 0.66]}
K_f: {value: 548, unit: N/V}
"""


HALVES: dict[object, object] = {}


@pytest.fixture(scope="module", autouse=True)
def halved_once() -> Iterator[None]:
    """Fit halves of the same strokes once: it takes 2 s, and tests/identify/test_halves.py judges it."""

    def once(logs: Sequence[Log], plant: Plant | None = None) -> object:
        key = (*(values.tobytes() for log in logs for values in log.channels().values()), plant)
        if key not in HALVES:
            HALVES[key] = halves(logs, plant)
        return HALVES[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fric.report.plots.halves", once)
        yield


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """Documents and runs of the paper's table, in March and in September, when its friction had fallen by 9 %."""
    folder = tmp_path_factory.mktemp("report")
    machine = fric.read_machine(PAPER)
    schemes = choose_schemes("a,b,c,f")
    later = replace(
        machine,
        axes={n: replace(a, nominal_friction=replace(a.nominal_friction, gain=1.0)) for n, a in machine.axes.items()},
    )
    made = {"fric": "0.1.0", "machine": "xy feed table", "command": "fric simulate circle"}
    texts = {
        "march": FRICTION.format(F_c=105, F_c_low=104, F_c_high=106, gms=GMS, created="2026-03-01T08:00:00+00:00"),
        "september": FRICTION.format(F_c=96, F_c_low=95, F_c_high=97, gms=GMS, created="2026-09-01T08:00:00+00:00"),
        "static": FRICTION.format(F_c=105, F_c_low=104, F_c_high=106, gms="", created="2026-02-28T08:00:00+00:00"),
        "observer": OBSERVER,
        "plant": PLANT,
    }
    found = SimpleNamespace(folder=folder)
    for name, text in texts.items():
        path = folder / f"{name}.yaml"
        path.write_text(text, encoding="utf-8")
        setattr(found, name, path)
    for name, subject, date in (("run", machine, "2026-03-02"), ("later_run", later, "2026-09-02")):
        path = folder / f"{name}.h5"
        runs = [run_circle(subject, scheme) for scheme in schemes]
        write_runs(path, runs, json.dumps(made | {"created": f"{date}T08:00:00+00:00"}))
        setattr(found, name, path)
    return found
